"""The law as a map: where its limits act, where it asks for wings level, and the way the flight took through it."""

from __future__ import annotations

import dataclasses
from typing import Any, NamedTuple

import numpy as np

from autopilot.route import PathDeviation
from sim.flight import Flight
from sim.reporting import style
from sim.reporting.curves import by_phase
from sim.reporting.thinning import runs

GRID = 121  # points a side; the law is piecewise linear, so its edges are exact but for the corners
UNLIMITED = 1e6  # rad, a bank limit that no command reaches


class Plane(NamedTuple):
    """The two deviations that a law looks at."""

    x: str  # fields of PathDeviation
    y: str
    x_limit: str  # fields of the law
    y_limit: str | None
    x_label: str
    y_label: str
    scale: float  # from SI to what is shown


PLANES = (
    Plane(
        "cross_track", "cross_track_rate", "cross_track_limit", "cross_track_rate_limit",
        "cross-track, m (+ right)", "cross-track rate, m/s", 1.0,
    ),
    Plane(
        "bearing_error", "track_error", "bearing_limit", None,
        "bearing error, deg", "course error, deg", float(np.degrees(1.0)),
    ),
)  # fmt: skip


def phase_portrait(flight: Flight, law: Any) -> Any:
    """Figure of the flown path in the plane of the law's inputs: the whole, and near the leg.

    The saturation regions are those of the law itself, evaluated on a grid [Vasylyev 2003, eq. (4), (5)].
    """
    from matplotlib.figure import Figure

    plane = next((plane for plane in PLANES if hasattr(law, plane.x_limit)), PLANES[0])
    height = 3.35
    figure = Figure((style.WIDTH, height))
    width = (style.WIDTH - 2 * style.LEFT - style.RIGHT) / 2
    bounds = (_whole(flight, law, plane), _near(law, plane))
    for i, bound in enumerate(bounds):
        left = style.LEFT + i * (width + style.LEFT)
        axes = figure.add_axes((left / style.WIDTH, 0.42 / height, width / style.WIDTH, (height - 0.95) / height))
        _law_regions(axes, law, plane, *bound)
        _path(axes, flight, plane)
        axes.set_xlim(-bound[0], bound[0])
        axes.set_ylim(-bound[1], bound[1])
        axes.set_xlabel(plane.x_label)
        axes.locator_params(axis="x", nbins=5)
        axes.set_title(("whole flight", "near the leg")[i], pad=3)
        if i == 0:
            axes.set_ylabel(plane.y_label)
    _legend(figure, law, plane)
    return figure


def _values(flight: Flight, plane: Plane) -> tuple[np.ndarray, np.ndarray]:
    deviation = flight.deviation
    return getattr(deviation, plane.x) * plane.scale, getattr(deviation, plane.y) * plane.scale


def _limit(law: Any, field: str | None, plane: Plane) -> float | None:
    value = getattr(law, field, None) if field else None
    return None if value is None or not np.isfinite(value) else float(value) * plane.scale


def _whole(flight: Flight, law: Any, plane: Plane) -> tuple[float, float]:
    """Half widths that hold the whole path and all limits of the law."""
    x, y = _values(flight, plane)
    x_limit, y_limit = _limit(law, plane.x_limit, plane) or 0.0, _limit(law, plane.y_limit, plane) or 0.0
    far_x, far_y = np.nanmax(np.abs(x), initial=1.0), np.nanmax(np.abs(y), initial=1.0)
    return 1.06 * max(float(far_x), 1.15 * x_limit), 1.06 * max(float(far_y), 1.05 * y_limit)


def _near(law: Any, plane: Plane) -> tuple[float, float]:
    """Half widths of the region in which the law is linear in x."""
    x_limit = _limit(law, plane.x_limit, plane) or 100.0
    ratio = getattr(law, "k1", None), getattr(law, "k2", None)
    if None not in ratio:
        return 1.35 * x_limit, 1.8 * float(law.k1 / law.k2) * x_limit
    return 1.35 * x_limit, 1.8 * float(getattr(law, "k3", 1.0) / getattr(law, "k4", 1.0)) * x_limit


def _command(law: Any, plane: Plane, x: np.ndarray, y: np.ndarray) -> np.ndarray:
    """The law's bank for given deviations, all others zero and the end of the leg far away."""
    nothing = np.zeros(np.broadcast_shapes(x.shape, y.shape))
    fields = dict.fromkeys(PathDeviation._fields, nothing) | {"distance_to_go": nothing + 1e9}
    fields |= {plane.x: nothing + x / plane.scale, plane.y: nothing + y / plane.scale}
    if plane.y == "track_error":
        fields["heading_error"] = fields["track_error"]
    return np.asarray(law(PathDeviation(**fields)))


def _law_regions(axes: Any, law: Any, plane: Plane, half_x: float, half_y: float) -> None:
    """Shade where the bank command stands at its limit, hatch where the inputs do, draw the line of wings level."""
    if not hasattr(law, plane.x_limit):
        return
    x, y = np.linspace(-half_x, half_x, GRID)[None, :], np.linspace(-half_y, half_y, GRID)[:, None]
    # without its bank limit the law is continuous and the contours fall between the grid points
    share = _command(dataclasses.replace(law, bank_limit=UNLIMITED), plane, x, y) / law.bank_limit
    colours = ["#F7DFB0", "#FFFFFF", "#CFE7F7"]
    axes.contourf(x[0], y[:, 0], share, levels=[-1e9, -1.0, 1.0, 1e9], colors=colours)
    axes.contour(x[0], y[:, 0], share, levels=[0.0], colors=[style.BLACK], linewidths=1.0, linestyles=["dashed"])
    for field, line in ((plane.x_limit, axes.axvline), (plane.y_limit, axes.axhline)):
        limit = _limit(law, field, plane)
        for side in (-1, 1) if limit is not None else ():
            line(side * limit, color=style.VERMILION, linewidth=0.8, dashes=(1.5, 1.5))


def _path(axes: Any, flight: Flight, plane: Plane) -> None:
    x, y = _values(flight, plane)
    by_phase(axes, flight, x, y)
    starts = [first for first, _ in runs(flight.leg)]
    axes.plot(x[starts], y[starts], "o", color="white", markeredgecolor=style.BLACK, markersize=4.5, zorder=4)


def _legend(figure: Any, law: Any, plane: Plane) -> None:
    from matplotlib.lines import Line2D
    from matplotlib.patches import Patch

    start = Line2D([], [], linestyle="", marker="o", color="white", markeredgecolor=style.BLACK, markersize=4.5)
    entries: list[tuple[Any, str]] = [(start, "leg begun")]
    if hasattr(law, plane.x_limit):
        level = "wings level"
        if hasattr(law, "intercept_speed"):
            level += f" (intercept at {float(law.intercept_speed):.1f} m/s)"
        entries += [
            (Patch(color="#CFE7F7"), "bank limit, right"),
            (Patch(color="#F7DFB0"), "bank limit, left"),
            (Line2D([], [], color=style.BLACK, linestyle="--", linewidth=1.0), level),
            (Line2D([], [], color=style.VERMILION, dashes=(1.5, 1.5), linewidth=0.8), "limits of inputs"),
        ]
    handles, labels = zip(*entries, strict=True)
    figure.legend(
        handles, labels, loc="upper left", ncols=len(entries), columnspacing=1.1, handletextpad=0.4,
        bbox_to_anchor=(style.LEFT / style.WIDTH, 1.0),
    )  # fmt: skip
