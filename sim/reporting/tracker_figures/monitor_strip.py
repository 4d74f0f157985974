"""When the monitor of innovations alarms: a row for each tracker, the share of its draws over time."""

from __future__ import annotations

from typing import Any

from sim.flight.record import Flight
from sim.metrics.alarms.monitoring import AlarmShare
from sim.reporting.figures import style
from sim.reporting.figures.curves import phase_strip
from sim.reporting.figures.histories import STRIP, TIME
from sim.reporting.text.labels import words

ROW = 0.24  # in
FULL = 0.8  # of a row is all draws
LONGEST = 86.0  # points of the font times characters, left of the axes
WRONG = ("departure", "sensor_fault")  # events that no tracker is told


def monitor_strip(
    flight: Flight, shares: dict[str, AlarmShare], rates: dict[str, float | None], colours: dict[str, str]
) -> Any:
    """Figure of the alarmed share of the draws of each tracker; ``rates`` are alarmed looks in 1000."""
    figure, (strip, axes) = style.panels(STRIP, ROW * len(shares))
    phase_strip(strip, flight)
    places = [len(shares) - 1.0 - row for row in range(len(shares))]
    for place, (name, shown) in zip(places, shares.items(), strict=True):
        axes.axhline(place, color=style.LIGHT, linewidth=0.5)
        top = place + FULL * shown.share
        axes.fill_between(shown.time, place, top, color=colours.get(name, style.GREY), linewidth=0.4)
    wrong = [event for event in flight.events if event.name in WRONG]
    for event in wrong:
        axes.axvline(event.time, color=style.VERMILION, linewidth=0.8)
    for event in wrong[:1]:
        axes.annotate(
            words(event.name), (event.time, len(shares)), (-3, -1), textcoords="offset points", ha="right", va="top",
            fontsize=6, color=style.VERMILION,
        )  # fmt: skip
    labels = [words(name) if (rate := rates[name]) is None else f"{words(name)}\n{rate:.2g} ‰" for name in shares]
    axes.set_yticks([place + 0.5 * FULL for place in places], labels, linespacing=1.0)
    for label, name in zip(axes.get_yticklabels(), shares, strict=True):
        label.set_fontsize(min(6.0, LONGEST / len(name)))
    axes.set_ylim(-0.1, len(shares))
    axes.grid(False, axis="y")
    axes.set_xlabel(TIME)
    axes.xaxis.set_label_coords(0.5, -0.28 / (ROW * len(shares)))
    return figure
