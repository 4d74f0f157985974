"""Curves that several figures share: paths coloured by phase, the strip that names the phases."""

from __future__ import annotations

from typing import Any

import numpy as np

from sim.flight import Flight
from sim.reporting import style
from sim.reporting.quantities import words
from sim.reporting.thinning import peaks, runs

CHARACTER = 0.047  # in, width of a character of the strip's text


def by_phase(
    axes: Any, flight: Flight, x: np.ndarray, y: np.ndarray, among: np.ndarray | None = None, joined: bool = True
) -> None:
    """Draw y over x in the colours of the phases, where ``among`` is True.

    The path is broken where the leg changes, and between phases unless ``joined``.
    """
    wanted = np.ones(len(x), bool) if among is None else among
    key = np.where(wanted, flight.leg * len(flight.phases) + flight.phase, -1)
    for first, last in runs(key):
        if not wanted[first]:
            continue
        onward = joined and last < len(x) and wanted[last] and flight.leg[last] == flight.leg[first]
        chosen = first + peaks(y[first : last + int(onward)])
        name = flight.phases[int(flight.phase[first])]
        axes.plot(x[chosen], y[chosen], color=style.phase_colour(name), linewidth=1.5)


def over_time(axes: Any, flight: Flight, y: np.ndarray, **look: Any) -> None:
    """Draw a record over time with all its peaks."""
    chosen = peaks(y)
    axes.plot(flight.time[chosen], y[chosen], **look)


def phase_strip(axes: Any, flight: Flight) -> None:
    """A band over the time axis in the colours of the phases, named where the name has room."""
    axes.set_axis_off()
    axes.set_ylim(0, 1)
    time, span = flight.time, max(float(flight.time[-1] - flight.time[0]), 1e-6)
    room = style.WIDTH - style.LEFT - style.RIGHT
    for first, last in runs(flight.phase):
        name = flight.phases[int(flight.phase[first])]
        begin, end = float(time[first]), float(time[min(last, len(time) - 1)])
        axes.axvspan(begin, end, color=style.phase_colour(name), linewidth=0)
        if (end - begin) / span * room > CHARACTER * len(name) + 0.02:
            dark = style.phase_colour(name) in (style.BLACK, style.BLUE, style.VERMILION, style.GREEN)
            axes.text(
                (begin + end) / 2, 0.46, words(name), ha="center", va="center", fontsize=6.5,
                color="white" if dark else "black",
            )  # fmt: skip
    axes.set_xlim(float(time[0]), float(time[0]) + span)


def phases_flown(flight: Flight) -> list[str]:
    """Names of the phases in the order in which they were first flown."""
    return list(dict.fromkeys(flight.phases[int(i)] for i in flight.phase))


def phase_legend(axes: Any, flight: Flight, **place: Any) -> Any:
    """A legend of the phases that were flown."""
    from matplotlib.lines import Line2D

    names = phases_flown(flight)
    handles = [Line2D([], [], color=style.phase_colour(name), linewidth=2.5) for name in names]
    return axes.legend(handles, [words(name) for name in names], **place)


def pad(axes: Any, least: float, share: float = 0.08) -> None:
    """Room above and below the data, and a span of at least ``least``, so that noise does not look like motion."""
    low, high = axes.dataLim.intervaly
    if not np.isfinite(low + high) or low > high:
        low, high = -least / 2, least / 2
    span = max(high - low, least)
    middle = (low + high) / 2
    axes.set_ylim(middle - span * (0.5 + share), middle + span * (0.5 + share))
