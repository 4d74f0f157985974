"""A figure as a plain value: panels with axes and marks, made by the functions that draw and read by the writers.

Lengths are points; boxes lie in the space of the panels, from its upper left corner. Rows of legend come above it.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, NamedTuple

import numpy as np

from sim.reporting.drawing import marks
from sim.reporting.drawing.marks import Mark, numbers
from sim.reporting.drawing.scales import LINEAR, Scale, named

MARGIN = 0.05  # of an axis, beyond the data at either side
NUMBERS, NAMES = 7.5, 8.0  # sizes of text


class Box(NamedTuple):
    """A rectangle."""

    left: float
    top: float
    width: float
    height: float


class Legend(NamedTuple):
    """Where a panel names its labelled marks."""

    corner: str  # "upper left" and so on, or "left": half way up
    columns: int = 1
    size: float = 7.5
    boxed: bool = False
    reverse: bool = False


class Axis:
    """One axis; panels may share it."""

    def __init__(self) -> None:
        self.label = ""
        self.limits: tuple[float | None, float | None] = (None, None)  # None = by the data; low may be the greater
        self.scale: Scale = LINEAR
        self.ticks: Sequence[tuple[float, str]] | None = None  # None = round numbers
        self.most: int | None = None  # ticks; None = as many as have room
        self.size = NUMBERS
        self.label_size = NAMES


class Panel:
    """Axes with what lies in them."""

    def __init__(self, box: Box, x: Axis | None = None, y: Axis | None = None) -> None:
        self.box, self.x, self.y = box, x or Axis(), y or Axis()
        self.marks: list[Mark] = []
        self.title, self.title_size = "", NAMES
        self.grid = "xy"  # the axes whose ticks are drawn across
        self.framed = True  # False = bare, without axes
        self.background = ""
        self.numbered = (True, True)  # whether numbers and name of x and y are written
        self.y_right = False  # the y axis stands at the right
        self.legend: Legend | None = None

    def line(self, x: Any, y: Any, **look: Any) -> None:
        """Add a `Line`."""
        self.marks.append(marks.Line(numbers(x), numbers(y), **look))

    def points(self, x: Any, y: Any, **look: Any) -> None:
        """Add `Points`."""
        self.marks.append(marks.Points(numbers(x), numbers(y), **look))

    def band(self, x: Any, low: Any, high: Any, colour: str, **look: Any) -> None:
        """Add a `Band`; either curve may be one number."""
        x = numbers(x)
        low, high = (np.broadcast_to(numbers(one), x.shape) for one in (low, high))
        self.marks.append(marks.Band(x, low, high, colour, **look))

    def blocks(self, left: Any, right: Any, low: Any, high: Any, colour: str | Sequence[str], **look: Any) -> None:
        """Add `Blocks`; a side that is one number is that of all."""
        x0, x1, y0, y1 = np.broadcast_arrays(*map(numbers, (left, right, low, high)))
        colours = (colour,) if isinstance(colour, str) else tuple(colour)
        self.marks.append(marks.Blocks(x0, x1, y0, y1, colours, **look))

    def area(self, rings: Sequence[np.ndarray], colour: str, **look: Any) -> None:
        """Add an `Area`."""
        self.marks.append(marks.Area(tuple(rings), colour, **look))

    def rule(self, *, x: float | None = None, y: float | None = None, **look: Any) -> None:
        """Add a `Rule`."""
        self.marks.append(marks.Rule(x, y, **look))

    def words(self, text: str, x: float, y: float, **look: Any) -> None:
        """Add `Words`."""
        self.marks.append(marks.Words(text, float(x), float(y), **look))

    def arrows(self, x: Any, y: Any, right: Any, up: Any, **look: Any) -> None:
        """Add `Arrows`."""
        self.marks.append(marks.Arrows(numbers(x), numbers(y), numbers(right), numbers(up), **look))

    @property
    def lines(self) -> list[marks.Line]:
        """Those among the marks."""
        return [mark for mark in self.marks if isinstance(mark, marks.Line)]

    @property
    def labelled(self) -> list[Mark]:
        """Marks with a label, once each."""
        found: dict[str, Mark] = {}
        for mark in self.marks:
            if mark.label:
                found.setdefault(mark.label, mark)
        return [*found.values()]

    def y_range(self) -> tuple[float, float]:
        """Least and greatest y of what was drawn; infinite ends, the greater first, for nothing."""
        return _range([mark.reach()[1] for mark in self.marks], self.y.scale)


class Drawing:
    """A figure: panels, and rows of labelled marks that name them."""

    def __init__(self, width: float, height: float, panels: Sequence[Panel]) -> None:
        self.width, self.height, self.panels = width, height, list(panels)  # height without the rows of the legend
        self.legend: list[Sequence[Mark]] = []

    def limits(self, axis: Axis) -> tuple[float, float]:
        """Both ends of an axis; those that are not given are a little beyond the data of all panels that share it."""
        low, high = axis.limits
        if low is not None and high is not None:
            room = (MARGIN * abs(low) or MARGIN) if low == high else 0.0
            return low - room, high + room
        reaches = [
            mark.reach()[side]
            for panel in self.panels
            for side, own in enumerate((panel.x, panel.y))
            if own is axis
            for mark in panel.marks
        ]
        return _with_margin(*_range(reaches, axis.scale), low, high, axis.scale)

    def ticks(self, axis: Axis, length: float, upright: bool) -> list[tuple[float, str]]:
        """Values with their names along an axis of a length in points."""
        low, high = self.limits(axis)
        if axis.ticks is not None:
            least, most = min(low, high), max(low, high)
            beyond = 1e-9 * (most - least)
            return [tick for tick in axis.ticks if least - beyond <= tick[0] <= most + beyond]
        room = int(length / (axis.size * (2.0 if upright else 4.0)))
        found = axis.scale.ticks(low, high, min(axis.most or 9, max(room, 1), 9))
        return list(zip(found, named(found, axis.scale), strict=True))


def _range(reaches: Sequence[np.ndarray], scale: Scale) -> tuple[float, float]:
    values = np.concatenate([np.ravel(one) for one in reaches]) if reaches else marks.NONE
    values = values[np.isfinite(values) & ((values > 0.0) | (scale.kind != "log"))]
    return (float(values.min()), float(values.max())) if values.size else (np.inf, -np.inf)


def _with_margin(least: float, most: float, low: float | None, high: float | None, scale: Scale) -> tuple[float, float]:
    """The given ends, else those of the data with a margin."""
    if least > most:
        least, most = (0.1, 10.0) if scale.kind == "log" else (0.0, 1.0)
    if scale.kind == "log":
        room = max((most / least) ** MARGIN, 1.1)
        return least / room if low is None else low, most * room if high is None else high
    if low is not None and low >= most:
        most = low + 1.0
    if high is not None and high <= least:
        least = high - 1.0
    span = (most if high is None else high) - (least if low is None else low)
    room = MARGIN * span if span > 0.0 else max(MARGIN * abs(most), MARGIN)
    return least - room if low is None else low, most + room if high is None else high
