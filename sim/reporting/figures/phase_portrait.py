"""The law as a map: where its limits act, where it commands wings level, and the path of the flight through it."""

from __future__ import annotations

import dataclasses
from typing import Any, NamedTuple

import numpy as np

from autopilot.mode import LimitedInput, Mode
from autopilot.route import PathDeviation
from sim.flight.record import Flight, runs
from sim.reporting.figures import style
from sim.reporting.figures.curves import by_phase
from sim.reporting.figures.deviations import COMPONENTS

GRID = 121  # points a side; the law is piecewise linear, so its edges are exact but for the corners
UNLIMITED = 1e6  # rad, a bank limit that no command reaches
RIGHT_LIMIT, LEFT_LIMIT = "#CFE7F7", "#F7DFB0"
HEIGHT, BELOW, ABOVE = 3.35, 0.42, 0.53  # in, of the figure and of its margins
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


def phase_portrait(flight: Flight, law: Mode) -> Any:
    """Figure of the flown path in the plane of the law's inputs: the whole, and near the leg.

    The saturation regions are those of the law itself, evaluated on a grid [Vasylyev 2003, eq. (4), (5)].
    """
    from matplotlib.figure import Figure

    plane = plane_of(law)
    figure = Figure((style.WIDTH, HEIGHT))
    width = (style.WIDTH - 2 * style.LEFT - style.RIGHT) / 2
    x, y = _values(flight, plane)
    for i, (half_x, half_y) in enumerate((_whole(x, y, plane), _near(plane))):
        left = style.LEFT + i * (width + style.LEFT)
        box = (left / style.WIDTH, BELOW / HEIGHT, width / style.WIDTH, (HEIGHT - BELOW - ABOVE) / HEIGHT)
        axes = figure.add_axes(box)
        _law_regions(axes, law, plane, half_x, half_y)
        by_phase(axes, flight, x, y)
        begun = [first for first, _ in runs(flight.leg)]
        axes.plot(x[begun], y[begun], "o", color="white", markeredgecolor=style.BLACK, markersize=4.5, zorder=4)
        axes.set_xlim(-half_x, half_x)
        axes.set_ylim(-half_y, half_y)
        axes.set_xlabel(COMPONENTS[plane.x.of].label)
        axes.set_ylabel(COMPONENTS[plane.y.of].label if i == 0 else "")
        axes.locator_params(axis="x", nbins=5)
        axes.set_title(TITLES[i], pad=3)
    _legend(figure, plane)
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


def _law_regions(axes: Any, law: Any, plane: Plane, half_x: float, half_y: float) -> None:
    """Shade where the bank command is at its limit, draw the limits of the inputs and the line of wings level."""
    if not np.isfinite(plane.ratio):
        return
    x, y = np.linspace(-half_x, half_x, GRID), np.linspace(-half_y, half_y, GRID)
    # without its bank limit the law is continuous and the contours fall between the grid points
    share = _command(dataclasses.replace(law, bank_limit=UNLIMITED), plane, x[None, :], y[:, None]) / law.bank_limit
    axes.contourf(x, y, share, levels=[-1e9, -1.0, 1.0, 1e9], colors=[LEFT_LIMIT, "#FFFFFF", RIGHT_LIMIT])
    axes.contour(x, y, share, levels=[0.0], colors=[style.BLACK], linewidths=1.0, linestyles=["dashed"])
    for limit, line in ((plane.x_limit, axes.axvline), (plane.y_limit, axes.axhline)):
        for side in (-1, 1) if np.isfinite(limit) else ():
            line(side * limit, color=style.VERMILION, linewidth=0.8, dashes=(1.5, 1.5))


def _legend(figure: Any, plane: Plane) -> None:
    from matplotlib.lines import Line2D
    from matplotlib.patches import Patch

    start = Line2D([], [], linestyle="", marker="o", color="white", markeredgecolor=style.BLACK, markersize=4.5)
    entries: list[tuple[Any, str]] = [(start, "leg begun")]
    if np.isfinite(plane.ratio):
        level = "wings level"
        if np.isfinite(plane.intercept):
            level += f" (intercept at {plane.intercept:.1f} {COMPONENTS[plane.y.of].unit})"
        entries += [
            (Patch(color=RIGHT_LIMIT), "bank limit, right"),
            (Patch(color=LEFT_LIMIT), "bank limit, left"),
            (Line2D([], [], color=style.BLACK, linestyle="--", linewidth=1.0), level),
            (Line2D([], [], color=style.VERMILION, dashes=(1.5, 1.5), linewidth=0.8), "limits of inputs"),
        ]
    handles, labels = zip(*entries, strict=True)
    figure.legend(
        handles, labels, loc="upper left", ncols=len(entries), columnspacing=1.1, handletextpad=0.4,
        bbox_to_anchor=(style.LEFT / style.WIDTH, 1.0),
    )  # fmt: skip
