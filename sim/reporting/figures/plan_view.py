"""The flight from above: route and track, turns, runway and wind, turned so that the final course runs to the right."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from typing import Any, NamedTuple

import numpy as np

from sim.flight.record import Flight
from sim.reporting.drawing.figure import Drawing, Panel
from sim.reporting.drawing.marks import PAPER
from sim.reporting.figures import style
from sim.reporting.figures.curves import by_phase, phase_key
from sim.reporting.text.labels import words
from sim.scenario.tables import Runway

RUNWAY_LENGTH = 2.5  # km, drawn only: the flight knows the threshold and the direction, not the far end
NEAR = 1.6  # the runway is shown when it lies within this many times the extent of the flight
TALLEST, LOWEST = 6.4, 1.7  # in, of the axes
KM = 1e-3
ARROWS = 62.0  # points between the north arrow and the wind arrow


def plan_view(
    flight: Flight,
    runway: Runway,
    wind: tuple[float, float] | None,
    events: Mapping[str, Any] | None = None,
    sensors: Mapping[str, Any] | None = None,
) -> Drawing:
    """Figure with equal axes, in km from the threshold along and to the right of the final course.

    ``wind`` is the steady one, the way the air moves, m/s (north, east), None = unknown; ``events`` and
    ``sensors`` are drawn by their outlines.
    """
    course = flight.route.legs[-1].course
    c, s = math.cos(course), math.sin(course)

    def turned(north: Any, east: Any) -> tuple[Any, Any]:
        return (north * c + east * s) * KM, (east * c - north * s) * KM

    x, y = turned(flight.state.north, flight.state.east)
    corners = [leg.start for leg in flight.route.legs] + [flight.route.legs[-1].end]
    corner_x, corner_y = turned(*np.array(corners).T)
    far_end = runway.to_local(RUNWAY_LENGTH / KM, 0.0)
    runway_x, runway_y = turned(np.array((0.0, far_end[0])), np.array((0.0, far_end[1])))

    bounds = extent((x, corner_x), (y, corner_y))
    shown = _inside(bounds, runway_x[0], runway_y[0])
    if shown:
        bounds = extent((x, corner_x, runway_x), (y, corner_y, runway_y))
    figure, axes = _equal_axes(bounds)

    axes.line(corner_x, corner_y, colour="#555555", width=0.8, dashes=(5, 3), order=1.5, label="route")
    axes.points(corner_x, corner_y, colour="#555555", marker="^", size=5.0, fill=PAPER, label="point of the route")
    if shown:
        axes.line(runway_x, runway_y, width=4.0, butt=True, alpha=0.75, label="runway")
    for name, event in (events or {}).items():
        edge = event.outline()
        if edge:
            _area(axes, name, *turned(*np.array(edge).T))
    for name, sensor in (sensors or {}).items():
        _sensor(figure, name, sensor, turned)
    by_phase(axes, flight, x, y)
    switched = np.flatnonzero(np.diff(flight.leg)) + 1
    if switched.size:
        axes.points(x[switched], y[switched], marker="D", size=4.5, fill=PAPER, order=4, label="turn begun")
    axes.points(x[:1], y[:1], marker="o", size=5.5, fill=PAPER, order=4, label="start")
    axes.points(x[-1:], y[-1:], marker="X", size=6.5, order=5, label=f"end: {words(flight.outcome)}")
    _compass(axes, course, wind, _points((x, corner_x, runway_x), (y, corner_y, runway_y)))
    figure.legend = [phase_key(flight), axes.labelled]  # the phases, then everything else
    axes.x.label = "along the final course, km past the threshold"
    axes.y.label = "right of the threshold, km"
    return figure


def _area(axes: Panel, name: str, x: np.ndarray, y: np.ndarray) -> None:
    """The inside of a closed line, named at its upper edge."""
    axes.area([np.column_stack((x, y))], style.SKY, alpha=0.25)
    axes.words(name, (x.min() + x.max()) / 2, y.min(), up=2.0, size=6.5, colour=style.BLUE)


def _sensor(figure: Drawing, name: str, sensor: Any, turned: Callable[[Any, Any], tuple[Any, Any]]) -> None:
    """The edge of what a sensor covers, and its antenna, named; what lies outside the frame is cut off."""
    (axes,) = figure.panels
    edge = sensor.outline()
    if edge:
        x, y = turned(*np.array((*edge, edge[0])).T)
        axes.line(x, y, colour=style.GREY, width=0.7, dashes=(1, 1.5), order=1.3)
    if sensor.antenna is not None:
        x, y = turned(*sensor.antenna[:2])
        axes.points(x, y, colour=style.GREY, marker="x", size=4.0, order=3)
        left, right = figure.limits(axes.x)
        anchor, away = ("start", 3.0) if x < right - 0.15 * (right - left) else ("end", -3.0)
        axes.words(words(name), x, y, right=away, up=3.0, size=6.5, colour=style.GREY, anchor=anchor)


def extent(xs: tuple[Any, ...], ys: tuple[Any, ...]) -> tuple[float, float, float, float]:
    """Bounds of all finite points with a margin."""
    x, y = np.concatenate(xs), np.concatenate(ys)
    finite = np.isfinite(x) & np.isfinite(y)
    left, right, low, high = x[finite].min(), x[finite].max(), y[finite].min(), y[finite].max()
    margin = 0.06 * max(right - left, high - low, 0.5)
    return left - margin, right + margin, low - margin, high + margin


def _points(xs: tuple[Any, ...], ys: tuple[Any, ...]) -> np.ndarray:
    """Points along the track and along the straight lines of route and runway, shape (n, 2)."""
    track, *lines = zip(xs, ys, strict=True)
    thin = max(1, len(track[0]) // 400)
    found = [np.column_stack((track[0][::thin], track[1][::thin]))]
    for x, y in lines:
        at = np.linspace(0.0, len(x) - 1.0, 40 * (len(x) - 1))
        found.append(np.column_stack((np.interp(at, np.arange(len(x)), x), np.interp(at, np.arange(len(x)), y))))
    return np.concatenate(found)


def _inside(extent: tuple[float, float, float, float], x: float, y: float) -> bool:
    left, right, low, high = extent
    reach = NEAR * max(right - left, high - low) / 2
    return abs(x - (left + right) / 2) < reach and abs(y - (low + high) / 2) < reach


def _equal_axes(extent: tuple[float, float, float, float]) -> tuple[Drawing, Panel]:
    """Axes that fill the width where they can; the shorter side is given more room, never another scale."""
    left, right, low, high = extent
    width = style.WIDTH - style.LEFT - style.RIGHT
    height = min(max(width * (high - low) / (right - left), LOWEST), TALLEST)
    scale = max((right - left) / width, (high - low) / height)  # km per inch
    spare_x, spare_y = width * scale - (right - left), height * scale - (high - low)
    figure, (axes,) = style.panels(height)
    axes.x.limits = left - spare_x / 2, right + spare_x / 2
    axes.y.limits = high + spare_y / 2, low - spare_y / 2  # right is down, as on a map that is turned and not mirrored
    return figure, axes


def _compass(axes: Panel, course: float, wind: tuple[float, float] | None, busy: np.ndarray) -> None:
    """North and wind as arrows of fixed size where the figure is emptiest; ``busy`` is what they must not cover."""
    window = Window(axes.x.limits, axes.y.limits, (axes.box.width, axes.box.height))
    across, up = _emptiest(window, busy)
    left, right = (across - ARROWS / 2, up), (across + ARROWS / 2, up)
    _arrow(axes, window, left, (math.cos(course), math.sin(course)), "north", style.BLACK)
    if wind is None:
        return
    speed = math.hypot(*wind)
    if speed == 0.0:
        axes.words("calm", *window.values(right), above=0.5, colour=style.BLUE)
        return
    along = (wind[0] * math.cos(course) + wind[1] * math.sin(course)) / speed
    beside = (wind[1] * math.cos(course) - wind[0] * math.sin(course)) / speed
    comes_from = math.degrees(math.atan2(-wind[1], -wind[0])) % 360
    _arrow(axes, window, right, (along, -beside), f"wind {comes_from:03.0f}°, {speed:.0f} m/s", style.BLUE)


class Window(NamedTuple):
    """Linear axes: values, and points from their lower left corner."""

    x: tuple[Any, Any]
    y: tuple[Any, Any]
    size: tuple[float, float]  # points

    def points(self, values: np.ndarray) -> np.ndarray:
        """(n, 2) points of values."""
        low, high = np.array((self.x, self.y), float).T
        return np.asarray((values - low) / (high - low) * self.size)

    def values(self, points: tuple[float, float]) -> tuple[float, float]:
        """Values at a place."""
        low, high = np.array((self.x, self.y), float).T
        x, y = low + np.array(points) / self.size * (high - low)
        return float(x), float(y)


def _arrow(
    axes: Panel, window: Window, centre: tuple[float, float], direction: tuple[float, float], text: str, colour: str
) -> None:
    """An arrow of 32 points about ``centre`` (points from the lower left corner of the axes), its name below."""
    dx, dy = 16 * direction[0], 16 * direction[1]
    x, y = window.values((centre[0] - dx, centre[1] - dy))
    axes.arrows(x, y, 2 * dx, 2 * dy, colour=colour, width=1.5, head=7.0)
    x, y = window.values((centre[0], centre[1] - 9 - abs(dy)))
    axes.words(text, x, y, above=0.5, colour=colour)


def _emptiest(window: Window, busy: np.ndarray) -> tuple[float, float]:
    """Where, in points from the lower left corner, a box of arrows is farthest from all ``busy`` points."""
    size, points = np.array(window.size), window.points(busy)
    half = np.array((ARROWS, 30.0))
    best, place = -math.inf, size / 2
    for across in np.linspace(half[0] + 10, size[0] - half[0] - 10, 15):
        for up in np.linspace(half[1] + 6, size[1] - half[1], 9):
            apart = np.maximum(np.abs(points - (across, up - 8)) - half, 0.0)
            room = min(float(np.hypot(*apart.T).min()), 40.0)  # beyond this, higher and more to the right is as good
            score = room + 1e-3 * (across / size[0] + up / size[1])
            if score > best:
                best, place = score, np.array((across, up))
    return float(place[0]), float(place[1])
