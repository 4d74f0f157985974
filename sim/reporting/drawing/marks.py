"""What can lie in a panel: plain values in the units of its axes; widths and sizes are in points.

Of a ``label`` a legend is made. What has the greater ``order`` lies above.
"""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np

INK, PAPER = "#000000", "#FFFFFF"  # a page may exchange them in the dark
NONE = np.empty(0)

Values = np.ndarray
Reach = tuple[np.ndarray, np.ndarray]  # x and y that the axes must hold


class Line(NamedTuple):
    """A line through points, broken where one is not finite."""

    x: Values
    y: Values
    colour: str = INK
    width: float = 1.1
    dashes: tuple[float, ...] = ()  # dash, gap, ... in widths of the line
    alpha: float = 1.0
    butt: bool = False  # ends at its last point, not half a width beyond
    label: str = ""
    order: float = 2.0

    def reach(self) -> Reach:
        """All points."""
        return self.x, self.y


class Points(NamedTuple):
    """A marker at each point that is finite."""

    x: Values
    y: Values
    colour: str = INK  # of the edge, and of the inside where that has none
    marker: str = "."  # "." "o" "s" "D" "^" "v" ">" "X", or of strokes "x" "|"
    size: float = 3.0
    fill: str = ""
    stroke: float = 1.0  # width of the edge
    free: bool = False  # may reach beyond the panel
    label: str = ""
    order: float = 2.0

    def reach(self) -> Reach:
        """All points."""
        return self.x, self.y


class Band(NamedTuple):
    """What lies between two curves."""

    x: Values
    low: Values
    high: Values
    colour: str
    alpha: float = 1.0
    edge: float = 0.0  # width
    label: str = ""
    order: float = 1.0

    def reach(self) -> Reach:
        """Both curves."""
        return np.concatenate((self.x, self.x)), np.concatenate((self.low, self.high))


class Blocks(NamedTuple):
    """Rectangles with sides along the axes; an infinite side is the edge of the panel."""

    left: Values
    right: Values
    low: Values
    high: Values
    colours: tuple[str, ...]  # of each, or one for all; "" = not filled
    alpha: float = 1.0
    edge: str = ""  # colour of the border
    hatch: str = ""  # colour of the hatching
    label: str = ""
    order: float = 1.0

    def reach(self) -> Reach:
        """The sides that are finite."""
        return np.concatenate((self.left, self.right)), np.concatenate((self.low, self.high))


class Area(NamedTuple):
    """The inside of closed rings (n, 2); a ring within another is a hole."""

    rings: tuple[Values, ...]
    colour: str
    alpha: float = 1.0
    label: str = ""
    order: float = 1.0

    def reach(self) -> Reach:
        """All corners."""
        x, y = np.concatenate(self.rings).T if self.rings else (NONE, NONE)
        return x, y


class Rule(NamedTuple):
    """A line right across the panel at a value of x or of y."""

    x: float | None = None
    y: float | None = None
    colour: str = INK
    width: float = 0.5
    dashes: tuple[float, ...] = ()
    label: str = ""
    order: float = 2.0

    def reach(self) -> Reach:
        """Its value."""
        x = NONE if self.x is None else np.array([self.x], float)
        return x, NONE if self.y is None else np.array([self.y], float)


class Words(NamedTuple):
    """A text at a point of the data, moved by some points to the right and up."""

    text: str
    x: float
    y: float
    right: float = 0.0
    up: float = 0.0
    colour: str = INK
    size: float = 7.0
    anchor: str = "middle"  # of the text along its line: "start", "middle", "end"
    above: float = 0.0  # which height of its letters is at the point: 0 the foot, 0.5 the middle, 1 the head
    turn: float = 0.0  # deg, clockwise
    free: bool = False  # may reach beyond the panel
    label: str = ""
    order: float = 3.0

    def reach(self) -> Reach:
        """Nothing: words make no room for themselves."""
        return NONE, NONE


class Arrows(NamedTuple):
    """Arrows from points of the data, so many points long to the right and up."""

    x: Values
    y: Values
    right: Values
    up: Values
    colour: str = INK
    width: float = 1.0
    head: float = 5.0  # length of the head, at most half of the arrow
    label: str = ""
    order: float = 2.5

    def reach(self) -> Reach:
        """Where they begin."""
        return self.x, self.y


Mark = Line | Points | Band | Blocks | Area | Rule | Words | Arrows


def numbers(values: Any) -> Values:
    """An array of floats from one number or many."""
    return np.atleast_1d(np.asarray(values, float))
