"""When the monitor of innovations alarms: a row for each tracker, the share of its draws over time."""

from __future__ import annotations

import textwrap

import numpy as np

from sim.flight.record import Flight
from sim.metrics.alarms.monitoring import AlarmShare
from sim.reporting.drawing.figure import Drawing
from sim.reporting.figures import style
from sim.reporting.figures.curves import phase_strip
from sim.reporting.figures.histories import STRIP, TIME
from sim.reporting.text.labels import words

ROW = 0.27  # in
FULL = 0.8  # of a row is all draws
LINE = 15  # characters left of the axes
WRONG = ("departure", "sensor_fault")  # events that no tracker is told


def monitor_strip(
    flight: Flight, shares: dict[str, AlarmShare], rates: dict[str, float | None], colours: dict[str, str]
) -> Drawing:
    """Figure of the alarmed share of the draws of each tracker; ``rates`` are alarmed looks in 1000."""
    figure, (strip, axes) = style.panels(STRIP, ROW * len(shares))
    phase_strip(strip, flight)
    places = [len(shares) - 1.0 - row for row in range(len(shares))]
    for place, (name, shown) in zip(places, shares.items(), strict=True):
        axes.rule(y=place, colour=style.LIGHT, order=0.5)
        kept = _corners(shown.share)
        top = place + FULL * shown.share[kept]
        axes.band(shown.time[kept], place, top, colours.get(name, style.GREY), edge=0.4)
    wrong = [event for event in flight.events if event.name in WRONG]
    for event in wrong:
        axes.rule(x=event.time, colour=style.VERMILION, width=0.8)
    for event in wrong[:1]:
        axes.words(
            words(event.name), event.time, len(shares), right=-3.0, up=-1.0, above=1.0, size=6.0,
            colour=style.VERMILION, anchor="end", free=True,
        )  # fmt: skip
    labels = [textwrap.fill(f"{words(name)} {_rate(rates[name])}", LINE) for name in shares]
    axes.y.ticks = [(place + 0.5 * FULL, name) for place, name in zip(places, labels, strict=True)]
    axes.y.size = 5.0
    axes.y.limits = -0.1, len(shares)
    axes.grid = "x"
    axes.x.label = TIME
    return figure


def _corners(values: np.ndarray) -> np.ndarray:
    """(w,) bool: where a curve is not level on both sides, and its ends; mostly nothing alarms."""
    changes = np.concatenate(([True], values[1:] != values[:-1], [True]))
    return np.asarray(changes[1:] | changes[:-1])


def _rate(rate: float | None) -> str:
    if rate is None:
        return ""
    return f"{rate:.0f}\N{NO-BREAK SPACE}‰" if rate >= 10.0 else f"{rate:.2g}\N{NO-BREAK SPACE}‰"
