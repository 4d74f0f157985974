"""The marks of a panel as elements of SVG."""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Any, NamedTuple

import numpy as np

from sim.reporting.drawing import paths
from sim.reporting.drawing.figure import Panel
from sim.reporting.drawing.looks import faint, fill, look_of, named, shape_of, stroke, text_at
from sim.reporting.drawing.marks import INK, Area, Arrows, Band, Blocks, Line, Points, Rule, Words
from sim.reporting.drawing.paths import UNIT
from sim.reporting.drawing.scales import Scale

CLOSE, WIDE = 34, 68  # units between two strokes of a hatching, of narrow and of wide blocks


class Frame(NamedTuple):
    """A panel's window: values to points from its upper left corner."""

    x: tuple[float, float]
    y: tuple[float, float]
    x_scale: Scale
    y_scale: Scale
    size: tuple[float, float]  # points

    def across(self, values: Any) -> np.ndarray:
        """Points from the left; an infinite value is an edge."""
        return _placed(values, self.x, self.x_scale, self.size[0])

    def down(self, values: Any) -> np.ndarray:
        """Points from the top."""
        return self.size[1] - _placed(values, self.y, self.y_scale, self.size[1])


def _placed(values: Any, ends: tuple[float, float], scale: Scale, length: float) -> np.ndarray:
    low, high = scale.forward(np.array(ends, float))
    return np.asarray((scale.forward(np.asarray(values, float)) - low) / (high - low) * length)


def elements(panel: Panel, frame: Frame) -> tuple[str, str]:
    """All marks in their order: those within the panel, and those that may reach beyond it."""
    within: list[str] = []
    free: list[str] = []
    for mark in sorted(panel.marks, key=lambda mark: mark.order):
        text = _WRITERS[type(mark)](mark, frame)
        (free if isinstance(mark, Points | Words) and mark.free else within).append(text)
    return "".join(within), "".join(free)


def _line(mark: Line, frame: Frame) -> str:
    d = paths.path(frame.across(mark.x), frame.down(mark.y), frame.size)
    look = stroke(mark.colour, mark.width, mark.dashes, mark.butt) + faint(mark.alpha) + named(mark.label)
    return f'<path d="{d}"{look}/>' if d else ""


def _rule(mark: Rule, frame: Frame) -> str:
    width, height = (round(UNIT * side) for side in frame.size)
    if mark.x is not None:
        at = paths.whole(frame.across(mark.x))
        d = f"M{at:.0f} 0v{height}"
    else:
        at = paths.whole(frame.down(mark.y))
        d = f"M0 {at:.0f}h{width}"
    look = stroke(mark.colour, mark.width, mark.dashes, True) + named(mark.label)
    return f'<path d="{d}"{look}/>' if math.isfinite(at) else ""


def _points(mark: Points, frame: Frame) -> str:
    x, y = frame.across(mark.x), frame.down(mark.y)
    plain = mark.marker in ".o" and not mark.fill
    d = paths.dots(x, y) if plain else paths.each(x, y, shape_of(mark.marker, mark.size))
    return f'<path d="{d}"{look_of(mark)}/>' if d else ""


def _band(mark: Band, frame: Frame) -> str:
    x, low, high = frame.across(mark.x), frame.down(mark.low), frame.down(mark.high)
    if frame.y_scale.kind == "log":  # what is not above nothing reaches to the lower edge
        low = np.where(mark.low <= 0.0, frame.size[1] + 1.0, low)
    d = ""
    there = np.isfinite(x) & np.isfinite(low) & np.isfinite(high)
    borders = np.flatnonzero(np.diff(np.concatenate(([False], there, [False])).astype(np.int8)))
    for first, last in borders.reshape(-1, 2).tolist():
        part = slice(first, last)
        there_and_back = np.concatenate((x[part], x[part][::-1])), np.concatenate((high[part], low[part][::-1]))
        d += paths.closed(*_unbent(*there_and_back))
    edge = stroke(mark.colour, mark.edge) if mark.edge else ""
    return f'<path d="{d}"{fill(mark.colour)}{edge}{faint(mark.alpha)}{named(mark.label)}/>' if d else ""


def _unbent(x: np.ndarray, y: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """A ring without corners on straight sides."""
    points = paths.unbent(np.column_stack((paths.whole(x), paths.whole(y))))
    return points[:, 0] / UNIT, points[:, 1] / UNIT


def _blocks(mark: Blocks, frame: Frame) -> str:
    width, height = frame.size
    x0, x1 = (
        _side(frame.across(values), values, far, frame) for values, far in ((mark.left, 0.0), (mark.right, width))
    )
    low = np.where(mark.low <= 0.0, -np.inf, mark.low) if frame.y_scale.kind == "log" else mark.low
    y0, y1 = (_side(frame.down(values), values, far, frame) for values, far in ((low, height), (mark.high, 0.0)))
    seen = np.isfinite(x0 + x1 + y0 + y1)
    colours = mark.colours * len(x0) if len(mark.colours) == 1 else mark.colours
    by_colour: dict[str, list[str]] = {}
    corners = np.column_stack((x0, y1, x1 - x0, y0 - y1))
    for colour, corner, there in zip(colours, corners, seen, strict=True):
        if there:
            left, top, wide, high = corner.astype(int).tolist()
            by_colour.setdefault(colour, []).append(f"M{left} {top}h{wide}v{high}h{-wide}z")
    more = faint(mark.alpha) + named(mark.label)
    edge = stroke(mark.edge, 0.6) if mark.edge else ' shape-rendering="crispEdges"'
    text = "".join(
        f'<path d="{"".join(d)}"{fill(colour) if colour else ""}{edge}{more}/>' for colour, d in by_colour.items()
    )
    if mark.hatch:
        d = "".join(
            hatching(*corner.astype(int).tolist()) for corner, there in zip(corners, seen, strict=True) if there
        )
        text += f'<path class="hatch" d="{d}"{stroke(mark.hatch, 0.7)}/>' if d else ""
    return text


def _side(at: np.ndarray, values: np.ndarray, edge: float, frame: Frame) -> np.ndarray:
    """Units of one side of blocks, not far beyond the panel."""
    far = UNIT * (max(frame.size) + 50)
    return np.asarray(np.clip(paths.whole(np.where(np.isinf(values), edge, at)), -far, far))


def hatching(left: int, top: int, wide: int, high: int) -> str:
    """Strokes that rise to the right, within a rectangle; those of neighbours continue each other."""
    if wide < 0:
        left, wide = left + wide, -wide
    if high < 0:
        top, high = top + high, -high
    d = ""
    apart = CLOSE if min(wide, high) < 4 * CLOSE else WIDE
    first = (left + top) // apart + 1
    for place in range(first * apart, left + top + wide + high, apart):  # x + y of a stroke
        x0 = max(left, place - top - high)
        x1 = min(left + wide, place - top)
        if x1 > x0:
            d += f"M{x0} {place - x0}l{x1 - x0} {x0 - x1}"
    return d


def _area(mark: Area, frame: Frame) -> str:
    d = "".join(paths.closed(frame.across(ring[:, 0]), frame.down(ring[:, 1])) for ring in mark.rings)
    return f'<path d="{d}"{fill(mark.colour)} fill-rule="evenodd"{faint(mark.alpha)}{named(mark.label)}/>' if d else ""


def _words(mark: Words, frame: Frame) -> str:
    x, y = float(frame.across(mark.x)) + mark.right, float(frame.down(mark.y)) - mark.up
    if not (math.isfinite(x + y) and -1.0 <= x - mark.right <= frame.size[0] + 1.0):
        return ""
    colour = "currentColor" if mark.colour == INK else mark.colour  # a panel fills nothing by itself
    return text_at(mark.text, x, y, mark.size, mark.anchor, mark.above, colour, mark.turn)


def _arrows(mark: Arrows, frame: Frame) -> str:
    x, y = frame.across(mark.x), frame.down(mark.y)
    ends = np.column_stack((x, y, mark.right, -mark.up))
    shafts, heads = "", ""
    for px, py, dx, dy in (UNIT * ends[np.isfinite(ends).all(axis=1)]).tolist():
        length = math.hypot(dx, dy)
        if length < 1.0:
            continue
        head = min(UNIT * mark.head, 0.5 * length)
        ux, uy = dx / length, dy / length
        shafts += f"M{px:.0f} {py:.0f}l{dx - ux * head:.0f} {dy - uy * head:.0f}"
        back, side = (-head * ux, -head * uy), (-0.38 * head * uy, 0.38 * head * ux)
        corner, across = (back[0] + side[0], back[1] + side[1]), (-2 * side[0], -2 * side[1])
        heads += f"M{px + dx:.0f} {py + dy:.0f}l{corner[0]:.0f} {corner[1]:.0f} {across[0]:.0f} {across[1]:.0f}z"
    return f'<path d="{shafts}"{stroke(mark.colour, mark.width, butt=True)}/><path d="{heads}"{fill(mark.colour)}/>'


_WRITERS: dict[type, Callable[[Any, Frame], str]] = {
    Line: _line, Points: _points, Band: _band, Blocks: _blocks, Area: _area, Rule: _rule, Words: _words,
    Arrows: _arrows,
}  # fmt: skip
