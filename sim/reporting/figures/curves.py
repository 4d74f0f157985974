"""Curves that several figures share: paths coloured by phase, the strip that names the phases."""

from __future__ import annotations

from typing import Any

import numpy as np

from sim.flight.record import Flight, runs
from sim.reporting.figures import style
from sim.reporting.figures.thinning import peaks
from sim.reporting.text.labels import words

CHARACTER = 0.047  # in, width of a character of the strip's text
COLUMNS = 1500  # across the strip of phases


def by_phase(
    axes: Any, flight: Flight, x: np.ndarray, y: np.ndarray, among: np.ndarray | None = None, joined: bool = True
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
        axes.plot(x[chosen], np.where(mine, y, np.nan)[chosen], color=colour, linewidth=1.5)


def over_time(axes: Any, flight: Flight, y: np.ndarray, **look: Any) -> None:
    """Draw a record over time with all its peaks."""
    chosen = peaks(y)
    axes.plot(flight.time[chosen], y[chosen], **look)


def phase_strip(axes: Any, flight: Flight) -> None:
    """A band over the time axis in the colours of the phases, named where the name has room."""
    axes.set_axis_off()
    axes.set_ylim(0, 1)
    time, span = flight.time, max(float(flight.time[-1] - flight.time[0]), 1e-6)
    columns = np.unique(np.linspace(0, len(time) - 1, COLUMNS).astype(int))
    shown = flight.phase[columns]
    spans: dict[str, list[tuple[float, float]]] = {}
    for first, last in runs(shown):
        name = flight.phases[int(shown[first])]
        begin, end = float(time[columns[first]]), float(time[columns[min(last, len(columns) - 1)]])
        spans.setdefault(name, []).append((begin, end - begin))
        if (end - begin) / span * (style.WIDTH - style.LEFT - style.RIGHT) > CHARACTER * len(name) + 0.02:
            colour = "white" if style.phase_colour(name) in style.DARK else "black"
            axes.text(
                (begin + end) / 2, 0.46, words(name), ha="center", va="center", fontsize=6.5, color=colour, clip_on=True
            )
    for name, places in spans.items():
        axes.broken_barh(places, (0, 1), color=style.phase_colour(name), linewidth=0)
    axes.set_xlim(float(time[0]), float(time[0]) + span)


def phase_handles(flight: Flight) -> tuple[list[Any], list[str]]:
    """Handles and labels of a legend of the phases that were flown."""
    from matplotlib.lines import Line2D

    names = list(dict.fromkeys(flight.phases[int(i)] for i in flight.phase))
    return [Line2D([], [], color=style.phase_colour(name), linewidth=2.5) for name in names], [words(n) for n in names]


def pad(axes: Any, least: float, share: float = 0.08) -> None:
    """Room above and below the data, and a span of at least ``least``, so that noise does not look like motion."""
    low, high = axes.dataLim.intervaly
    if not np.isfinite(low + high) or low > high:
        low, high = -least / 2, least / 2
    span = max(high - low, least)
    middle = (low + high) / 2
    axes.set_ylim(middle - span * (0.5 + share), middle + span * (0.5 + share))
