"""Curves that several figures share: paths coloured by phase, the strip that names the phases."""

from __future__ import annotations

from typing import Any

import numpy as np

from sim.flight.record import Flight, runs
from sim.reporting.drawing.figure import Panel
from sim.reporting.drawing.marks import NONE, Line, Mark
from sim.reporting.figures import style
from sim.reporting.figures.thinning import peaks
from sim.reporting.text.labels import words

CHARACTER = 0.047  # in, width of a character of the strip's text
COLUMNS = 1500  # across the strip of phases


def by_phase(
    panel: Panel, flight: Flight, x: np.ndarray, y: np.ndarray, among: np.ndarray | None = None, joined: bool = True
) -> None:
    """Draw y over x in the colours of the phases, where ``among`` is True.

    The path is broken where the leg changes, and between phases unless ``joined``.
    """
    wanted = np.ones(len(x), bool) if among is None else among
    for leg, phase in dict.fromkeys(zip(flight.leg[wanted].tolist(), flight.phase[wanted].tolist(), strict=True)):
        mine = wanted & (flight.leg == leg) & (flight.phase == phase)
        if joined:
            mine[1:] |= mine[:-1] & wanted[1:] & (flight.leg[1:] == leg)
        first, last = np.flatnonzero(mine)[[0, -1]]
        shown = np.where(mine, y, np.nan)[first : last + 1]
        chosen = first + peaks(shown)
        colour = style.phase_colour(flight.phases[phase])
        panel.line(x[chosen], np.where(mine, y, np.nan)[chosen], colour=colour, width=1.5)


def over_time(panel: Panel, flight: Flight, y: np.ndarray, **look: Any) -> None:
    """Draw a record over time with all its peaks."""
    chosen = peaks(y)
    panel.line(flight.time[chosen], y[chosen], **look)


def phase_strip(panel: Panel, flight: Flight) -> None:
    """A band over the time axis in the colours of the phases, named where the name has room."""
    panel.framed = False
    panel.y.limits = 0.0, 1.0
    time, span = flight.time, max(float(flight.time[-1] - flight.time[0]), 1e-6)
    columns = np.unique(np.linspace(0, len(time) - 1, COLUMNS).astype(int))
    shown = flight.phase[columns]
    spans: dict[str, list[tuple[float, float]]] = {}
    for first, last in runs(shown):
        name = flight.phases[int(shown[first])]
        since, until = float(time[columns[first]]), float(time[columns[min(last, len(columns) - 1)]])
        spans.setdefault(name, []).append((since, until))
        if (until - since) / span * (style.WIDTH - style.LEFT - style.RIGHT) > CHARACTER * len(name) + 0.02:
            colour = "white" if style.phase_colour(name) in style.DARK else "black"  # on paper of any colour
            panel.words(words(name), (since + until) / 2, 0.5, above=0.5, size=6.5, colour=colour)
    for name, places in spans.items():
        begin, end = np.transpose(places)
        panel.blocks(begin, end, 0.0, 1.0, style.phase_colour(name))
    panel.x.limits = float(time[0]), float(time[0]) + span


def phase_key(flight: Flight) -> list[Mark]:
    """What a legend shows of the phases that were flown."""
    names = dict.fromkeys(flight.phases[int(i)] for i in flight.phase)
    return [Line(NONE, NONE, style.phase_colour(name), 2.5, label=words(name)) for name in names]


def pad(panel: Panel, least: float, share: float = 0.08) -> None:
    """Room above and below the data, and a span of at least ``least``, so that noise does not look like motion."""
    low, high = panel.y_range()
    if low > high:
        low, high = -least / 2, least / 2
    span = max(high - low, least)
    middle = (low + high) / 2
    panel.y.limits = middle - span * (0.5 + share), middle + span * (0.5 + share)
