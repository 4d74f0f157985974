"""Maps of ratios drawn: cells by their ratio, hatched where it may be 1, with the borders flown and of theory."""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from sim.reporting.figures import style
from sim.reporting.figures.style import Chart
from sim.reporting.text.labels import words
from sim.studies.figures import edges, set_scale
from sim.studies.limits.maps import Border, RatioMap, undecided

COLUMNS = 3
HEIGHT = 2.1  # in, of a panel among several
SCALE_ROOM, SCALE_WIDTH = 0.62, 0.14  # in, of the scale of colours with its numbers, and of its colours
TICKS = np.array([0.01, 0.02, 0.05, 0.1, 0.2, 0.5, 1, 2, 5, 10, 20, 50, 100, 200, 500, 1000])
LOOKS = ((style.GREEN, ":"), (style.BLACK, "--"))  # of the borders of theory


def ratio_chart(one: RatioMap) -> Chart:
    """The chart of a map, or of curves where there is one axis."""
    title = f"{words(one.of)} over {words(one.against)}: ratio of RMSE, {one.what}"
    return _curve(one, title) if one.y is None else _map(one, title)


def _map(one: RatioMap, title: str) -> Chart:
    assert one.y is not None
    alone = len(one.panels) == 1
    columns = min(COLUMNS, len(one.panels))
    if alone:
        figure, axes = style.panels(3.2, top=0.3)
    else:
        figure, axes = style.grid(math.ceil(len(one.panels) / columns), columns, HEIGHT, top=0.3)
    outer_x, outer_y = edges(one.x.at), edges(one.y.at)
    sizes = [np.abs(np.log10(panel.ratio[np.isfinite(panel.ratio)])) for panel in one.panels]
    most = max(float(np.concatenate(sizes).max(initial=0.0)), math.log10(1.5))
    mesh: Any = None
    for place, panel in zip(axes, one.panels, strict=False):
        place.grid(False)
        place.set_facecolor(style.LIGHT)
        height = np.log10(panel.ratio)
        mesh = place.pcolormesh(outer_x, outer_y, height, cmap="RdBu_r", vmin=-most, vmax=most, linewidth=0)
        for up, across in np.argwhere(undecided(panel)):
            (left, right), (low, high) = outer_x[across : across + 2], outer_y[up : up + 2]
            corners = [left, right, right, left], [low, low, high, high]
            place.fill(*corners, facecolor="none", edgecolor=style.GREY, hatch="////", linewidth=0)
        if min(height.shape) > 1:
            _contour(
                place, _to_the_edges(one.x.at, outer_x), _to_the_edges(one.y.at, outer_y), np.pad(height, 1, "edge")
            )
        for border, (colour, dashes) in zip(panel.borders, LOOKS, strict=False):
            _contour(place, border.x, border.y, border.height, colour, dashes)
        place.set_xlim(outer_x[0], outer_x[-1])
        place.set_ylim(outer_y[0], outer_y[-1])
        if panel.title:
            place.set_title(panel.title)
        if not alone and one.x.ticks is None:
            place.locator_params(axis="x", nbins=4)
    for unused in axes[len(one.panels) :]:
        unused.set_visible(False)
    _legend(axes[0], one, raised=0.0 if alone else 0.1)
    for number, place in enumerate(axes[: len(one.panels)]):
        if number + columns >= len(one.panels):
            set_scale(place.xaxis, one.x)
            place.tick_params(labelbottom=True)
        if number % columns == 0:
            set_scale(place.yaxis, one.y)
    bar = figure.colorbar(mesh, cax=_beside(figure, axes), label="ratio")
    ticks = np.log10(TICKS)
    shown = np.abs(ticks) <= most
    bar.set_ticks(ticks[shown], labels=[f"{ratio:g}" for ratio in TICKS[shown]])
    return Chart(title, style.data_uri(figure), _caption(one))


def _beside(figure: Any, axes: list[Any]) -> Any:
    """Axes for the scale of colours, in room that the others give up at the right."""
    kept = 1.0 - SCALE_ROOM / style.WIDTH
    for place in axes:
        box = place.get_position()
        place.set_position((box.x0 * kept, box.y0, box.width * kept, box.height))
    low, high = (
        edge([getattr(place.get_position(), side) for place in axes]) for edge, side in ((min, "y0"), (max, "y1"))
    )
    return figure.add_axes((kept, low, SCALE_WIDTH / style.WIDTH, high - low))


def _to_the_edges(at: np.ndarray, outer: np.ndarray) -> np.ndarray:
    return np.concatenate((outer[:1], at, outer[-1:]))


def _contour(
    axes: Any, x: np.ndarray, y: np.ndarray, height: np.ndarray, colour: str = style.BLACK, dashes: str = "-"
) -> None:
    """The line on which a height is 0, if it has any."""
    if np.isfinite(height).any() and np.nanmin(height) < 0.0 < np.nanmax(height):
        axes.contour(x, y, height, levels=[0.0], colors=colour, linestyles=dashes, linewidths=1.5)


def _borders(one: RatioMap) -> tuple[Border, ...]:
    return one.panels[0].borders if one.panels else ()


def _legend(axes: Any, one: RatioMap, raised: float) -> None:
    axes.plot([], [], color=style.BLACK, linewidth=1.5, label="ratio 1, flown")
    for border, (colour, dashes) in zip(_borders(one), LOOKS, strict=False):
        axes.plot([], [], color=colour, linestyle=dashes, linewidth=1.5, label=border.label)
    axes.legend(loc="lower left", bbox_to_anchor=(0, 1 + raised), ncols=1 + len(_borders(one)))


def _caption(one: RatioMap) -> str:
    text = f"Red: {words(one.of)} errs more, blue: less; hatched: the interval of 95 % holds 1; grey: no ratio."
    if _borders(one):
        text += " Borders of theory follow from the law alone, before anything is flown."
    return text


def _curve(one: RatioMap, title: str) -> Chart:
    figure, (axes,) = style.panels(2.6, top=0.3)
    for number, panel in enumerate(one.panels):
        colour = style.TRACKERS[number]
        axes.plot(one.x.at, panel.ratio[0], color=colour, marker="o", markersize=2.5, label=panel.title or "flown")
        axes.fill_between(one.x.at, panel.low[0], panel.high[0], color=colour, alpha=0.2, linewidth=0)
        if panel.predicted is not None:
            axes.plot(one.x.at, panel.predicted[0], color=style.BLACK, linestyle="--", label="by theory")
        for border, (shade, dashes) in zip(panel.borders, LOOKS, strict=False):
            for place in _zeros(border):
                axes.axvline(place, color=shade, linestyle=dashes, label=border.label)
    axes.axhline(1.0, color=style.GREY, linewidth=0.8)
    axes.set_yscale("log")
    axes.legend(loc="lower left", bbox_to_anchor=(0, 1), ncols=4)
    set_scale(axes.xaxis, one.x)
    axes.set_ylabel("ratio")
    return Chart(title, style.data_uri(figure), "Line: ratio of the RMSE of both; band: its interval of 95 %.")


def _zeros(border: Border) -> list[float]:
    """Where a height along one axis passes 0."""
    height = border.height[0]
    sides = np.flatnonzero(np.diff(np.signbit(height)))
    step = border.x[1] - border.x[0]
    return [float(border.x[k] + step * height[k] / (height[k] - height[k + 1])) for k in sides]
