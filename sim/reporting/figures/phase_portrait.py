"""The law as a map: where its limits act, where it commands wings level, and the path of the flight through it."""

from __future__ import annotations

import dataclasses
from typing import Any, NamedTuple

import numpy as np

from autopilot.mode import LimitedInput, Mode
from autopilot.route import PathDeviation
from sim.flight.record import Flight, runs
from sim.reporting.drawing import contours
from sim.reporting.drawing.figure import Box, Drawing, Panel
from sim.reporting.drawing.marks import PAPER
from sim.reporting.figures import style
from sim.reporting.figures.curves import by_phase
from sim.reporting.figures.deviations import COMPONENTS

GRID = 121  # points a side; the law is piecewise linear, so its edges are exact but for the corners
UNLIMITED = 1e6  # rad, a bank limit that no command reaches
RIGHT_LIMIT, LEFT_LIMIT = "#CFE7F7", "#F7DFB0"
HEIGHT, TOP = 2.4, 16.0  # in, of the panels; points, of their titles
TITLES = ("whole flight", "near the leg")


class Plane(NamedTuple):
    """The two deviations that a law uses, as they are shown."""

    x: LimitedInput
    y: LimitedInput

    @property
    def x_limit(self) -> float:
        """As shown; infinite = none."""
        return float(self.x.limit) * COMPONENTS[self.x.of].scale

    @property
    def y_limit(self) -> float:
        """As shown; infinite = none."""
        return float(self.y.limit) * COMPONENTS[self.y.of].scale

    @property
    def ratio(self) -> float:
        """Of the gains: the size of y per x, both as shown, that keeps the wings level; NaN = there is none."""
        scale = COMPONENTS[self.y.of].scale / COMPONENTS[self.x.of].scale
        return abs(float(self.x.gain) / float(self.y.gain)) * scale if self.y.gain else np.nan

    @property
    def intercept(self) -> float:
        """Size of y at which wings are level far out."""
        return self.ratio * self.x_limit


def plane_of(law: Mode) -> Plane:
    """The plane of a law's first two inputs; cross-track and its rate, without limits, for what it does not name."""
    inputs = law.limits()
    named = {one.of for one in inputs}
    more = [LimitedInput(of) for of in ("cross_track", "cross_track_rate") if of not in named]
    return Plane(*(*inputs, *more)[:2])


def phase_portrait(flight: Flight, law: Mode) -> Drawing:
    """Figure of the flown path in the plane of the law's inputs: the whole, and near the leg.

    The saturation regions are those of the law itself, evaluated on a grid [Vasylyev 2003, eq. (4), (5)].
    """
    plane = plane_of(law)
    width, height = (style.WIDTH - 2 * style.LEFT - style.RIGHT) / 2 * style.INCH, HEIGHT * style.INCH
    boxes = [Box(style.LEFT * style.INCH + i * (width + style.LEFT * style.INCH), TOP, width, height) for i in (0, 1)]
    panels = [Panel(box) for box in boxes]
    figure = Drawing(style.WIDTH * style.INCH, TOP + height + style.BOTTOM * style.INCH, panels)
    x, y = _values(flight, plane)
    begun = [first for first, _ in runs(flight.leg)]
    for axes, (half_x, half_y), title in zip(panels, (_whole(x, y, plane), _near(plane)), TITLES, strict=True):
        _law_regions(axes, law, plane, half_x, half_y)
        by_phase(axes, flight, x, y)
        axes.points(x[begun], y[begun], marker="o", size=4.5, fill=PAPER, order=4, label="leg begun")
        axes.x.limits, axes.y.limits = (-half_x, half_x), (-half_y, half_y)
        axes.x.label = COMPONENTS[plane.x.of].label
        axes.x.most, axes.grid = 5, ""
        axes.title = title
    panels[0].y.label = COMPONENTS[plane.y.of].label
    figure.legend = [panels[0].labelled]
    return figure


def _values(flight: Flight, plane: Plane) -> tuple[np.ndarray, np.ndarray]:
    """The flown deviations as shown, NaN where they mean nothing."""
    deviation = flight.deviation
    x, y = (
        np.where(deviation.distance_to_go > one.blind, getattr(deviation, one.of) * COMPONENTS[one.of].scale, np.nan)
        for one in plane
    )
    return x, y


def _whole(x: np.ndarray, y: np.ndarray, plane: Plane) -> tuple[float, float]:
    """Half widths that hold the whole path and all limits of the law."""
    halves = []
    for values, limit in ((x, plane.x_limit), (y, plane.y_limit)):
        far = float(np.nanmax(np.abs(values), initial=1.0))
        halves.append(1.06 * max(far, 1.1 * limit if np.isfinite(limit) else 0.0))
    return halves[0], halves[1]


def _near(plane: Plane) -> tuple[float, float]:
    """Half widths of the region in which the law is linear in x."""
    x = 1.35 * plane.x_limit if np.isfinite(plane.x_limit) else 100.0
    return x, 1.35 * x * (plane.ratio if np.isfinite(plane.ratio) else 0.1)


def _command(law: Any, plane: Plane, x: np.ndarray, y: np.ndarray) -> np.ndarray:
    """The law's bank for deviations as shown, all others zero and the end of the leg far away."""
    nothing = np.zeros(np.broadcast_shapes(x.shape, y.shape))
    fields = dict.fromkeys(PathDeviation._fields, nothing) | {"distance_to_go": nothing + 1e9}
    fields |= {one.of: nothing + shown / COMPONENTS[one.of].scale for one, shown in ((plane.x, x), (plane.y, y))}
    return np.asarray(law(PathDeviation(**fields)))


def _law_regions(axes: Panel, law: Any, plane: Plane, half_x: float, half_y: float) -> None:
    """Shade where the bank command is at its limit, draw the limits of the inputs and the line of wings level."""
    if not np.isfinite(plane.ratio):
        return
    x, y = np.linspace(-half_x, half_x, GRID), np.linspace(-half_y, half_y, GRID)
    # without its bank limit the law is continuous and the contours fall between the grid points
    share = _command(dataclasses.replace(law, bank_limit=UNLIMITED), plane, x[None, :], y[:, None]) / law.bank_limit
    for side, colour, name in ((1.0, RIGHT_LIMIT, "right"), (-1.0, LEFT_LIMIT, "left")):
        axes.area(contours.regions(x, y, side * share, 1.0, 1e9), colour, label=f"bank limit, {name}")
    level = "wings level"
    if np.isfinite(plane.intercept):
        level += f" (intercept at {plane.intercept:.1f} {COMPONENTS[plane.y.of].unit})"
    axes.line(*contours.lines(x, y, share, 0.0), width=1.0, dashes=(3.7, 1.6), order=1.5, label=level)
    look: dict[str, Any] = {"colour": style.VERMILION, "width": 0.8, "dashes": (1.5, 1.5), "label": "limits of inputs"}
    for side in (-1.0, 1.0):
        if np.isfinite(plane.x_limit):
            axes.rule(x=side * plane.x_limit, **look)
        if np.isfinite(plane.y_limit):
            axes.rule(y=side * plane.y_limit, **look)
