"""What a figure shows, as numbers: the page draws it."""

from __future__ import annotations

from typing import Any, NamedTuple


class Curve(NamedTuple):
    """One line of a figure."""

    label: str
    x: Any
    y: Any
    look: str = "line"  # or "dashed", "dots", "places", "marks"
    names: tuple[str, ...] = ()  # beside the points


class Plot(NamedTuple):
    """A figure of a paper, redrawn from our own runs."""

    figure: str  # as the paper calls it
    title: str
    caption: str
    x: str
    y: str
    curves: tuple[Curve, ...]
    logarithmic: bool = False
    equal: bool = False  # a map
