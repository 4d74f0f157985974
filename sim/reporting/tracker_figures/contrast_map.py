"""Some trackers, two where they part: what was flown, and where each believes the aircraft at the same instants."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, NamedTuple

import numpy as np

from sim.flight.interpolation import truth_at
from sim.flight.record import Flight
from sim.reporting.drawing.figure import Drawing
from sim.reporting.drawing.marks import PAPER
from sim.reporting.figures import style
from sim.reporting.figures.plan_view import extent
from sim.reporting.text.labels import words
from sim.reporting.tracker_figures.error_curves import Shown
from sim.reporting.tracker_figures.parting import Parting

KM = 1e-3
BEFORE, AFTER = 20.0, 90.0  # s, that are shown before and after they part
TIES = 12  # instants, at most, whose places are joined
FARTHEST = 2.0  # of the length of what was flown: what an estimate is farther off leaves the frame
WIDTH, TALLEST, LOWEST = 4.4, 2.8, 1.3  # in, of the axes: it is to stand on a first screen, beside the answer


class Believed(NamedTuple):
    """Where one tracker believes the aircraft, in draw 0."""

    name: str  # in words
    look: dict[str, Any]
    path: np.ndarray  # (2, n) km
    ties: np.ndarray  # (t, 2, 2) km: at some instants (flown, believed)


class ContrastMap(NamedTuple):
    """All that the figure shows, in km from the threshold along and to the right of the final course."""

    flown: np.ndarray  # (2, m) km
    route: np.ndarray  # (2, corners) km
    believed: tuple[Believed, ...]
    parted: np.ndarray | None  # (2,) km, where the aircraft was when they parted; None = they do not part
    time: tuple[float, float]  # s, first and last instant shown


def contrast_map(flight: Flight, shown: Sequence[Shown], parted: Parting | None) -> ContrastMap | None:
    """The stretch of the flight about the parting, the whole flight where there is none; None where one knows no
    place."""
    begin, end = float(flight.time[0]), float(flight.time[-1])
    if parted is not None:
        begin, end = max(begin, parted.start - BEFORE), min(end, parted.start + AFTER)
    course = flight.route.legs[-1].course
    turn = np.array(((np.cos(course), np.sin(course)), (-np.sin(course), np.cos(course)))) * KM
    believed = []
    for one in shown:
        path = one.curves.path
        known = (path.time >= begin) & (path.time <= end) & np.isfinite(path.place).all(axis=1)
        if not known.any():
            return None
        place = turn @ path.place[known].T
        some = np.unique(np.linspace(0, place.shape[1] - 1, min(TIES, place.shape[1])).astype(int))
        flown = turn @ truth_at(flight, path.time[known][some]).position[:2]
        ties = np.stack((flown, place[:, some])).transpose(2, 0, 1)
        believed.append(Believed(words(one.name), one.look, place, ties))
    during = (flight.time >= begin) & (flight.time <= end)
    corners = np.array([leg.start for leg in flight.route.legs] + [flight.route.legs[-1].end]).T
    return ContrastMap(
        turn @ np.array((flight.state.north, flight.state.east))[:, during],
        turn @ corners,
        tuple(believed),
        None if parted is None else turn @ truth_at(flight, np.array([parted.start])).position[:2, 0],
        (begin, end),
    )


def drawn(it: ContrastMap) -> Drawing:
    """Figure with equal axes; right of the course is down, as in the plan view."""
    reach = max(np.ptp(it.flown[0]), np.ptp(it.flown[1]), 1.0)
    off = [np.linalg.norm(one.path - it.flown.mean(axis=1, keepdims=True), axis=0) for one in it.believed]
    near = [np.where(away < FARTHEST * reach, one.path, np.nan) for one, away in zip(it.believed, off, strict=True)]
    left, right, low, high = extent((it.flown[0], *(x for x, _ in near)), (it.flown[1], *(y for _, y in near)))
    width = WIDTH
    height = min(max(width * (high - low) / (right - left), LOWEST), TALLEST)
    figure, (axes,) = style.panels(height)
    axes.box = axes.box._replace(width=width * style.INCH)
    figure.width = (style.LEFT + width + style.RIGHT) * style.INCH
    scale = max((right - left) / width, (high - low) / height)
    middle = (left + right) / 2, (low + high) / 2
    style.frame(axes, middle, scale)
    axes.line(*it.route, colour="#777777", width=0.8, dashes=(5, 3), order=1.2)
    for one in it.believed:
        joined = np.concatenate((one.ties, np.full((len(one.ties), 1, 2), np.nan)), axis=1).reshape(-1, 2)
        axes.line(*joined.T, colour=one.look["colour"], width=0.5, alpha=0.6, order=1.4)
        axes.points(*one.ties[:, 1].T, colour=one.look["colour"], size=4.0, order=2.2)
        axes.line(*one.path, width=1.3, order=2.0, label=one.name, **one.look)
    axes.line(*it.flown, colour=style.BLACK, width=2.0, label="flown", order=1.8)
    if it.parted is not None:
        axes.points(*it.parted, marker="o", size=7.0, fill=PAPER, order=3)
        ahead = it.flown[0, -1] >= it.parted[0]
        away, anchor = (-6.0, "end") if ahead else (6.0, "start")
        axes.words("they part", *it.parted, right=away, up=8.0, size=8.0, anchor=anchor, order=4)
    axes.x.label = "along the final course, km past the threshold"
    axes.y.label = "right of it, km"
    return figure
