"""Maps of ratios drawn: cells by their ratio, hatched where it may be 1, with the borders flown and of theory."""

from __future__ import annotations

import math

import numpy as np

from sim.reporting.drawing import contours
from sim.reporting.drawing.colours import BLUE_RED, Colours, add_scale, cells
from sim.reporting.drawing.figure import Panel
from sim.reporting.drawing.marks import NONE, Line
from sim.reporting.drawing.scales import LOGARITHMIC
from sim.reporting.figures import style
from sim.reporting.figures.style import Chart
from sim.reporting.text.labels import words
from sim.studies.figures import edges, set_scale
from sim.studies.limits.maps import Border, RatioMap, undecided

COLUMNS = 3
HEIGHT = 2.1  # in, of a panel among several
TICKS = (0.01, 0.02, 0.05, 0.1, 0.2, 0.5, 1, 2, 5, 10, 20, 50, 100, 200, 500, 1000)
LOOKS = ((style.GREEN, style.DOTTED), (style.BLACK, style.BROKEN))  # of the borders of theory


def ratio_chart(one: RatioMap) -> Chart:
    """The chart of a map, or of curves where there is one axis."""
    title = f"{words(one.of)} over {words(one.against)}: ratio of RMSE, {one.what}"
    return _curve(one, title) if one.y is None else _map(one, title)


def _map(one: RatioMap, title: str) -> Chart:
    assert one.y is not None
    columns = min(COLUMNS, len(one.panels))
    if len(one.panels) == 1:
        figure, axes = style.panels(3.2)
    else:
        figure, axes = style.grid(math.ceil(len(one.panels) / columns), columns, HEIGHT)
        style.end_columns(figure, len(one.panels), columns)
    outer_x, outer_y = edges(one.x.at), edges(one.y.at)
    sizes = [np.abs(np.log10(panel.ratio[np.isfinite(panel.ratio)])) for panel in one.panels]
    most = max(float(np.concatenate(sizes).max(initial=0.0)), math.log10(1.5))
    colours = Colours(BLUE_RED, -most, most)
    for place, panel in zip(axes, one.panels, strict=False):
        place.grid, place.background, place.title = "", style.LIGHT, panel.title
        height = np.log10(panel.ratio)
        cells(place, outer_x, outer_y, colours.of(height))
        up, across = np.nonzero(undecided(panel))
        if up.size:
            sides = outer_x[across], outer_x[across + 1], outer_y[up], outer_y[up + 1]
            place.blocks(*sides, "", hatch=style.GREY)
        if min(height.shape) > 1:
            inner = _to_the_edges(one.x.at, outer_x), _to_the_edges(one.y.at, outer_y)
            _contour(place, *inner, np.pad(height, 1, "edge"), "ratio 1, flown")
        for border, (colour, dashes) in zip(panel.borders, LOOKS, strict=False):
            _contour(place, border.x, border.y, border.height, border.label, colour, dashes)
    axes[0].x.limits = float(outer_x[0]), float(outer_x[-1])
    axes[0].y.limits = float(outer_y[0]), float(outer_y[-1])
    axes[0].x.most = 4 if columns > 1 else None
    set_scale(axes[0].x, one.x)
    set_scale(axes[0].y, one.y)
    figure.legend = [_key(one)]
    ticks = [(math.log10(ratio), f"{ratio:g}") for ratio in TICKS if abs(math.log10(ratio)) <= most]
    add_scale(figure, colours, "ratio", ticks)
    return Chart(title, figure, _caption(one))


def _to_the_edges(at: np.ndarray, outer: np.ndarray) -> np.ndarray:
    return np.concatenate((outer[:1], at, outer[-1:]))


def _contour(
    axes: Panel,
    x: np.ndarray,
    y: np.ndarray,
    height: np.ndarray,
    label: str,
    colour: str = style.BLACK,
    dashes: tuple[float, ...] = style.SOLID,
) -> None:
    """The line on which a height is 0, if it has any."""
    if np.isfinite(height).any() and np.nanmin(height) < 0.0 < np.nanmax(height):
        axes.line(*contours.lines(x, y, height, 0.0), colour=colour, width=1.5, dashes=dashes, label=label)


def _borders(one: RatioMap) -> tuple[Border, ...]:
    return one.panels[0].borders if one.panels else ()


def _key(one: RatioMap) -> list[Line]:
    """What the legend names, whether or not every panel has it."""
    looks = ((style.BLACK, style.SOLID), *LOOKS)
    labels = ("ratio 1, flown", *(border.label for border in _borders(one)))
    return [
        Line(NONE, NONE, colour, 1.5, dashes, label=label)
        for label, (colour, dashes) in zip(labels, looks, strict=False)
    ]


def _caption(one: RatioMap) -> str:
    text = f"Red: {words(one.of)} errs more, blue: less; hatched: the interval of 95 % holds 1; grey: no ratio."
    if _borders(one):
        text += " Borders of theory follow from the law alone, before anything is flown."
    return text


def _curve(one: RatioMap, title: str) -> Chart:
    figure, (axes,) = style.panels(2.6)
    for number, panel in enumerate(one.panels):
        colour = style.TRACKERS[number]
        axes.line(one.x.at, panel.ratio[0], colour=colour, label=panel.title or "flown")
        axes.points(one.x.at, panel.ratio[0], colour=colour, marker="o", size=2.5)
        axes.band(one.x.at, panel.low[0], panel.high[0], colour, alpha=0.2)
        if panel.predicted is not None:
            axes.line(one.x.at, panel.predicted[0], dashes=style.BROKEN, label="by theory")
        for border, (shade, dashes) in zip(panel.borders, LOOKS, strict=False):
            for place in _zeros(border):
                axes.rule(x=place, colour=shade, width=1.1, dashes=dashes, label=border.label)
    axes.rule(y=1.0, colour=style.GREY, width=0.8)
    axes.y.scale = LOGARITHMIC
    figure.legend = [axes.labelled]
    set_scale(axes.x, one.x)
    axes.y.label = "ratio"
    return Chart(title, figure, "Line: ratio of the RMSE of both; band: its interval of 95 %.")


def _zeros(border: Border) -> list[float]:
    """Where a height along one axis passes 0."""
    height = border.height[0]
    sides = np.flatnonzero(np.diff(np.signbit(height)))
    step = border.x[1] - border.x[0]
    return [float(border.x[k] + step * height[k] / (height[k] - height[k + 1])) for k in sides]
