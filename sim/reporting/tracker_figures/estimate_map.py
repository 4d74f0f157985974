"""Estimated positions: plots, estimates and ellipses of draw 0, whole and the last turn."""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from sim.flight.record import Flight
from sim.reporting.drawing.figure import Drawing, Panel
from sim.reporting.figures import style
from sim.reporting.figures.plan_view import extent
from sim.reporting.replay import ellipse, false_plots, place_of_plots
from sim.reporting.text.labels import words
from sim.reporting.tracker_figures.error_curves import Shown
from sim.reporting.tracker_figures.tracking_errors import legend
from tracking.height_profile import Charted

KM = 1e-3
WINDOW = 4.2  # km, across the enlarged part
ELLIPSES = 7  # of each tracker in one picture
TALLEST, LOWEST, ENLARGED = 3.6, 1.5, 3.2  # in, of the axes


def estimate_map(
    flight: Flight,
    scenario: Any,
    followed: list[Shown],
    records: dict[str, Any],
    chart: Charted | None = None,
) -> Drawing | None:
    """Figure with equal axes of the whole flight and of its last turn; None where no tracker knows a place.

    In km from the threshold along and to the right of the final course. Of an unknown flight there are its plots, and
    the middle of them.
    """
    shown = [one for one in followed if np.isfinite(one.curves.path.place).any()]
    if not shown:
        return None
    course = flight.route.legs[-1].course
    c, s = math.cos(course), math.sin(course)
    turn = np.array(((c, s), (-s, c))) * KM
    x, y = turn @ np.array((flight.state.north, flight.state.east))
    plots = {
        label: [
            turn @ place
            for name, record in seen.items()
            if record is not None and (place := place_of_plots(scenario.sensors[name], record, chart)) is not None
        ]
        for label, seen in (("false plots", {n: false_plots(r) for n, r in records.items()}), ("plots", records))
    }
    width = style.WIDTH - style.LEFT - style.RIGHT
    if not flight.known:
        x, y = np.concatenate([turn @ shown[0].curves.path.place.T, *plots["plots"]], axis=1)
    left, right, low, high = extent((x,), (y,))
    height = min(max(width * (high - low) / (right - left), LOWEST), TALLEST)
    figure, (whole, near) = style.panels(height, ENLARGED, share=False, gap=0.34)
    scale = max((right - left) / width, (high - low) / height)
    style.frame(whole, ((left + right) / 2, (low + high) / 2), scale)
    at = _turned(flight) if flight.known else len(shown[0].curves.path.time) // 2
    style.frame(near, (float(x[at]), float(y[at])), WINDOW / width)
    for axes, between in ((whole, (flight.time[0], flight.time[-1])), (near, None)):
        _draw(axes, shown, (x, y) if flight.known else None, plots, turn, between)
        axes.y.label = "right of the threshold, km"
    near.x.label = "along the final course, km past the threshold"
    legend(figure, whole, shown)
    return figure


def _turned(flight: Flight) -> int:
    """Record in the middle of the last turn onto a leg; of the whole flight where it made none."""
    switched = np.flatnonzero(np.diff(flight.leg)) + 1
    if not switched.size:
        return len(flight.time) // 2
    legs = flight.route.legs
    turn = abs(math.remainder(legs[-1].course - legs[max(len(legs) - 2, 0)].course, 2 * math.pi))
    heading = np.unwrap(flight.state.heading[switched[-1] :])
    half = np.flatnonzero(np.abs(heading - heading[0]) >= turn / 2)
    return int(switched[-1] + (half[0] if half.size else 0))


def _draw(
    axes: Panel,
    shown: list[Shown],
    flown: tuple[np.ndarray, np.ndarray] | None,
    plots: dict[str, list[np.ndarray]],
    turn: np.ndarray,
    between: tuple[float, float] | None,
) -> None:
    """The same things in either frame; in the enlarged one with ellipses."""
    (left, right), (high, low) = axes.x.limits, axes.y.limits

    def inside(x: np.ndarray, y: np.ndarray) -> np.ndarray:
        return np.asarray((x > left) & (x < right) & (y > low) & (y < high))

    for what, colour, size in (("false plots", "#D6D6D6", 1.6), ("plots", "#A8A8A8", 2.2)):
        for index, (x, y) in enumerate(plots[what]):
            among = np.flatnonzero(inside(x, y))
            among = among[:: max(1, len(among) // 400)]
            label = what if index == 0 else ""
            axes.points(x[among], y[among], colour=colour, size=size, label=label, order=1.2)
    if flown is not None:
        thin = max(1, len(flown[0]) // 600)
        axes.line(flown[0][::thin], flown[1][::thin], colour=style.BLACK, width=1.6, label="flown", order=1.5)
    for one in shown:
        x, y = turn @ one.curves.path.place.T
        if between is None:
            among = inside(x, y)
            x, y = np.where(among, x, np.nan), np.where(among, y, np.nan)
            _ellipses(axes, one, x, y, turn, np.flatnonzero(among))
        axes.line(x, y, width=0.9, label=words(one.name), **one.look)


def _ellipses(axes: Panel, one: Shown, x: np.ndarray, y: np.ndarray, turn: np.ndarray, among: np.ndarray) -> None:
    """Ellipses of two standard deviations as one broken line."""
    if not among.size:
        return
    chosen = among[np.unique(np.linspace(0, len(among) - 1, ELLIPSES).astype(int))]
    long, short, direction = ellipse(np.einsum("ij,kjl,ml->kim", turn, one.curves.path.spread[chosen], turn))
    angle = np.append(np.linspace(0.0, 2 * np.pi, 33), np.nan)
    a, b = 2 * long[:, None] * np.cos(angle), 2 * short[:, None] * np.sin(angle)
    c, s = np.cos(direction)[:, None], np.sin(direction)[:, None]
    axes.line(
        (x[chosen, None] + a * c - b * s).ravel(), (y[chosen, None] + a * s + b * c).ravel(), width=0.6, **one.look
    )
