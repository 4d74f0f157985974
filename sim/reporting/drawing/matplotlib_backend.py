"""A drawing as a figure of matplotlib, for files of any format: ``figure(chart.figure).savefig("plan.pdf")``.

The only place that knows matplotlib. The user's own settings stay as they are, and nothing is left in the user's home.
"""

from __future__ import annotations

import logging
import os
import sys
import tempfile
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from sim.reporting.drawing import legends, svg
from sim.reporting.drawing.figure import Axis, Drawing, Panel
from sim.reporting.drawing.marks import Area, Arrows, Band, Blocks, Line, Points, Rule, Words

if TYPE_CHECKING:
    from matplotlib.figure import Figure

INCH = 72.0  # points
STYLE: dict[Any, object] = {  # by the keys of matplotlib, which not all of its versions type
    "font.family": "sans-serif",
    "axes.linewidth": 0.6,
    "axes.axisbelow": True,
    "lines.solid_capstyle": "round",
    "lines.scale_dashes": True,
    "hatch.linewidth": 0.7,
    "svg.fonttype": "none",
    "svg.hashsalt": "shortfinal",
    "text.parse_math": False,
}


def import_matplotlib() -> None:
    """Import matplotlib so that it leaves nothing in the user's home: its list of fonts is made in a temporary folder.

    A list that an earlier use of matplotlib left is read, which is faster and writes nothing.
    """
    if "matplotlib.font_manager" in sys.modules or "MPLCONFIGDIR" in os.environ:
        return
    cache = Path(os.environ.get("XDG_CACHE_HOME") or Path.home() / ".cache") / "matplotlib"
    if any(cache.glob("fontlist-*.json")):
        return
    with tempfile.TemporaryDirectory() as place:
        os.environ["MPLCONFIGDIR"] = place
        try:
            import matplotlib.font_manager  # noqa: F401 (for what it writes)
        finally:
            del os.environ["MPLCONFIGDIR"]


@contextmanager
def _own_style() -> Iterator[None]:
    logger = logging.getLogger("matplotlib")
    level = logger.level
    logger.setLevel(logging.ERROR)  # its messages about fonts
    try:
        import_matplotlib()
        import matplotlib

        with matplotlib.rc_context():
            matplotlib.rcdefaults()
            matplotlib.rcParams.update(STYLE)
            yield
    finally:
        logger.setLevel(level)


def figure(drawing: Drawing) -> Figure:
    """The same panels, marks and legends at the same places."""
    with _own_style():
        from matplotlib.figure import Figure

        entries, top = legends.above(drawing)
        high = top + drawing.height
        made = Figure((drawing.width / INCH, high / INCH))
        for panel in drawing.panels:
            left, above, width, height = panel.box
            box = (left / drawing.width, 1 - (top + above + height) / high, width / drawing.width, height / high)
            axes = made.add_axes(box)
            _axes(axes, drawing, panel)
            for mark in sorted(panel.marks, key=lambda mark: mark.order):
                _DRAWERS[type(mark)](axes, mark)
            axes.set_xlim(drawing.limits(panel.x))  # again: a mark may have moved them
            axes.set_ylim(drawing.limits(panel.y))
            if panel.legend is not None:
                inner, _ = legends.within(panel, panel.legend)
                _legend(made, inner, (left, top + above), high)
        _legend(made, entries, (0.0, 0.0), high)
        return made


def _axes(axes: Any, drawing: Drawing, panel: Panel) -> None:
    axes.set_xlim(drawing.limits(panel.x))
    axes.set_ylim(drawing.limits(panel.y))
    for name, axis in (("x", panel.x), ("y", panel.y)):
        scale = axis.scale
        more = {"linthresh": scale.linear_to, "linscale": 0.9 * scale.decades} if scale.kind == "symmetric" else {}
        getattr(axes, f"set_{name}scale")({"symmetric": "symlog"}.get(scale.kind, scale.kind), **more)
    if panel.background:
        axes.set_facecolor(panel.background)
    if panel.title:
        axes.set_title(panel.title, loc="left", fontsize=panel.title_size, pad=svg.TITLE)
    if not panel.framed:
        axes.set_axis_off()
        return
    for side in ("top", "left" if panel.y_right else "right"):
        axes.spines[side].set_visible(False)
    if panel.y_right:
        axes.yaxis.tick_right()
        axes.yaxis.set_label_position("right")
    for name, which, axis, numbered in (
        ("x", axes.xaxis, panel.x, panel.numbered[0]),
        ("y", axes.yaxis, panel.y, panel.numbered[1]),
    ):
        _ticks(which, drawing.ticks(axis, panel.box.height if name == "y" else panel.box.width, name == "y"), axis)
        axes.tick_params(axis=name, which="both", length=0, pad=svg.NUMBER)
        which.set_tick_params(labelbottom=numbered, labelleft=numbered and not panel.y_right)
        if numbered and axis.label:
            which.set_label_text(axis.label, fontsize=axis.label_size)
        away = svg.NAME_RIGHT / panel.box.width + 1.0 if panel.y_right else -svg.NAME_LEFT / panel.box.width
        which.set_label_coords(
            *((0.5, -(svg.NAME_BELOW - 0.72 * axis.label_size) / panel.box.height) if name == "x" else (away, 0.5))
        )
        if name in panel.grid:
            axes.grid(True, axis=name, which="major", color=svg.GRID, linewidth=0.5)


def _ticks(which: Any, ticks: list[tuple[float, str]], axis: Axis) -> None:
    which.set_ticks([value for value, _ in ticks], [name for _, name in ticks], fontsize=axis.size)
    which.set_ticks([], minor=True)


def _dashes(dashes: tuple[float, ...]) -> Any:
    return (0, dashes) if dashes else "solid"


def _line(axes: Any, mark: Line) -> None:
    axes.plot(
        mark.x, mark.y, color=mark.colour, linewidth=mark.width, linestyle=_dashes(mark.dashes), alpha=mark.alpha,
        solid_capstyle="butt" if mark.butt else "round", label=mark.label or None, zorder=mark.order,
    )  # fmt: skip


def _points(axes: Any, mark: Points) -> None:
    axes.plot(
        mark.x, mark.y, linestyle="", marker=mark.marker, markersize=mark.size, color=mark.fill or mark.colour,
        markeredgecolor=mark.colour, markeredgewidth=mark.stroke, clip_on=not mark.free, label=mark.label or None,
        zorder=mark.order,
    )  # fmt: skip


def _band(axes: Any, mark: Band) -> None:
    axes.fill_between(
        mark.x, mark.low, mark.high, color=mark.colour, alpha=mark.alpha, linewidth=mark.edge,
        label=mark.label or None, zorder=mark.order,
    )  # fmt: skip


def _blocks(axes: Any, mark: Blocks) -> None:
    from matplotlib.collections import PolyCollection

    (left, right), (low, high) = sorted(axes.get_xlim()), sorted(axes.get_ylim())
    x0, x1 = (np.where(np.isinf(side), end, side) for side, end in ((mark.left, left), (mark.right, right)))
    y0, y1 = (np.where(np.isinf(side), end, side) for side, end in ((mark.low, low), (mark.high, high)))
    if axes.get_yscale() == "log":
        y0 = np.maximum(y0, 1e-3 * low)
    corners = np.stack((np.stack((x0, x0, x1, x1)), np.stack((y0, y1, y1, y0)))).T
    collection = PolyCollection(
        list(corners), facecolor=[colour or "none" for colour in mark.colours], alpha=mark.alpha, zorder=mark.order,
        edgecolor=mark.edge or mark.hatch or "none", linewidth=0.6 if mark.edge else 0.0,
        hatch="//////" if mark.hatch else None,
    )  # fmt: skip
    axes.add_collection(collection, autolim=False)


def _area(axes: Any, mark: Area) -> None:
    from matplotlib.patches import PathPatch
    from matplotlib.path import Path as Outline

    rings = [Outline(np.concatenate((ring, ring[:1])), closed=True) for ring in mark.rings]
    if rings:
        whole = Outline.make_compound_path(*rings)
        axes.add_patch(PathPatch(whole, color=mark.colour, alpha=mark.alpha, linewidth=0, zorder=mark.order))


def _rule(axes: Any, mark: Rule) -> None:
    look = {"color": mark.colour, "linewidth": mark.width, "linestyle": _dashes(mark.dashes), "zorder": mark.order}
    if mark.x is not None:
        axes.axvline(mark.x, **look)
    if mark.y is not None:
        axes.axhline(mark.y, **look)


def _words(axes: Any, mark: Words) -> None:
    axes.annotate(
        mark.text, (mark.x, mark.y), (mark.right, mark.up), textcoords="offset points", color=mark.colour,
        fontsize=mark.size, ha={"start": "left", "middle": "center", "end": "right"}[mark.anchor],
        va={0.0: "baseline", 0.5: "center", 1.0: "top"}[mark.above], rotation=-mark.turn, rotation_mode="anchor",
        annotation_clip=True, clip_on=not mark.free, zorder=mark.order,
    )  # fmt: skip


def _arrows(axes: Any, mark: Arrows) -> None:
    look = {"color": mark.colour, "linewidth": mark.width, "shrinkA": 0, "shrinkB": 0, "mutation_scale": mark.head}
    for x, y, *ahead in zip(mark.x, mark.y, mark.right, mark.up, strict=True):
        axes.annotate(  # from the place of a text without letters to the point; the head is where it begins
            "", (x, y), ahead, textcoords="offset points", arrowprops={"arrowstyle": "<|-", **look}, zorder=mark.order
        )


_DRAWERS: dict[type, Callable[[Any, Any], None]] = {
    Line: _line, Points: _points, Band: _band, Blocks: _blocks, Area: _area, Rule: _rule, Words: _words,
    Arrows: _arrows,
}  # fmt: skip


def _legend(made: Any, entries: list[legends.Entry], corner: tuple[float, float], high: float) -> None:
    """Samples and names at the places that the layout gives them, in points from a corner of the figure."""
    from matplotlib.lines import Line2D
    from matplotlib.patches import Rectangle
    from matplotlib.transforms import Affine2D

    points = Affine2D().scale(1 / INCH) + made.dpi_scale_trans
    for mark, x, y, size in entries:
        left, middle = corner[0] + x, high - corner[1] - y
        end = left + legends.SAMPLE
        artist: Any
        look: dict[str, Any]
        if isinstance(mark, Line | Rule):
            look = {"color": mark.colour, "linewidth": mark.width, "linestyle": _dashes(mark.dashes)}
            artist = Line2D([left, end], [middle, middle], transform=points, solid_capstyle="butt", **look)
        elif isinstance(mark, Points):
            look = {"marker": mark.marker, "markersize": min(max(mark.size, 4.0), 8.0), "markeredgecolor": mark.colour}
            artist = Line2D([(left + end) / 2], [middle], color=mark.fill or mark.colour, transform=points, **look)
        else:
            colour = mark.colours[0] if isinstance(mark, Blocks) else mark.colour
            artist = Rectangle((left, middle - 2.5), legends.SAMPLE, 5.0, color=colour, linewidth=0, transform=points)
        made.add_artist(artist)
        made.text(end + legends.AFTER, middle, mark.label, fontsize=size, va="center", transform=points)
