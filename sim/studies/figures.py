"""Figures of a study: maps over two chosen axes, curves over one, exceedances where everything is drawn."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, NamedTuple

import numpy as np

from sim.metrics import table
from sim.metrics.checks import OF_CONTRASTS, OF_TRACKERS, RATIOS, unit_of
from sim.metrics.contrasts.pairing import TABLES
from sim.metrics.ensemble.exceedance import Distribution, distribution
from sim.reporting.drawing import contours
from sim.reporting.drawing.colours import BLUE_RED, VIRIDIS, Colours, add_scale, cells
from sim.reporting.drawing.figure import Axis, Panel
from sim.reporting.drawing.marks import NONE, Points
from sim.reporting.drawing.scales import LOGARITHMIC
from sim.reporting.figures import style
from sim.reporting.figures.style import Chart
from sim.reporting.text.labels import named, split, words
from sim.reporting.text.labels import unit as unit_words
from sim.studies.theory import THEORIES, Line

MOST_LINES = 6
FINE = 101  # points of a line of theory over x
LINES = (style.SOLID, style.BROKEN, style.DOTTED)  # of theory, in their order
SECTIONS = 4  # lines of a map that are drawn beside theory
OUTCOME_COLOURS = {
    "completed": style.SKY,
    "landed": style.GREEN,
    "orbit": style.VERMILION,
    "diverged": style.BLACK,
    "envelope": style.PURPLE,
    "go_around": style.ORANGE,
    "ground": style.GREY,
    "time_limit": style.LIGHT,
    "crashed": "#FFFFFF",
    "refused": "#F0E442",
}


class Scale(NamedTuple):
    """An axis of a figure: positions of its values and their labels."""

    label: str
    at: np.ndarray
    ticks: tuple[str, ...] | None  # words instead of numbers


def study_charts(
    scenario: Any, metrics: dict[str, Any], records: Sequence[dict[str, Any]], shown: Sequence[str]
) -> list[Chart]:
    """One chart for each shown figure, and one of outcomes where they differ over a map."""
    listed = [address for address, axis in metrics["axes"].items() if "values" in axis]
    if not listed:
        return _exceedances([distribution(name, records, scenario.checks) for name in shown])
    if len(listed) == 1:
        return [_curves(name, listed[0], None, metrics) for name in shown]
    fewest = min(len(metrics["axes"][address]["values"]) for address in listed[:2])
    if fewest <= MOST_LINES and scenario.study.theory is None:
        few, many = sorted(listed[:2], key=lambda address: len(metrics["axes"][address]["values"]))
        return [_curves(name, many, few, metrics) for name in shown]
    lines = _lines(scenario, metrics, listed[0], listed[1])
    charts = [_outcome_map(listed[0], listed[1], metrics, lines)] if len(metrics["outcomes"]) > 1 else []
    charts += [_map(name, listed[0], listed[1], metrics, lines) for name in shown]
    return charts + _sections(scenario, metrics, listed[0], listed[1], shown)


def _lines(scenario: Any, metrics: dict[str, Any], x: str, y: str) -> tuple[Line, ...]:
    """What theory says about a map."""
    if scenario.study.theory is None:
        return ()
    across, up = (np.array(metrics["axes"][address]["values"], float) for address in (x, y))
    outer = edges(across)  # not the values, which lie within their cells
    fine = np.linspace(outer[0], outer[-1], FINE)
    return THEORIES[scenario.study.theory].lines(scenario, fine, np.unique([*edges(up)[[0, -1]], *up]))


def _draw(axes: Panel, lines: Sequence[Line]) -> None:
    """Borders over a map, which keeps its own extent."""
    for line, dashes in zip(lines, LINES, strict=False):
        axes.line(line.x, line.y, width=1.6, dashes=dashes, label=line.label)


def scale(address: str, values: Sequence[Any]) -> Scale:
    """Numbers at their value, words evenly spaced."""
    if all(isinstance(value, int | float) and not isinstance(value, bool) for value in values):
        return Scale(label(address), np.array(values, float), None)
    return Scale(label(address), np.arange(len(values), dtype=float), tuple(map(str, values)))


def figure_of(row: dict[str, Any], name: str) -> dict[str, Any] | None:
    """The spread of a figure in a cell; of ``A / B`` the ratio of their medians."""
    above, slash, below = name.partition(" / ")
    if not slash:
        found: dict[str, Any] | None = row.get(name)
        return found
    one, other = row.get(above), row.get(below)
    ratio = one["p50"] / other["p50"] if one and other and other["p50"] else None
    return None if ratio is None else {"n": 1, "p50": ratio}


def label(name: str) -> str:
    """A dotted name with its unit, for people."""
    above, slash, below = name.partition(" / ")
    if slash:
        return f"{label(above)} / {label(below)}"
    text, unit = _parts(name)
    return f"{text}, {unit}" if unit else text


def short(address: str) -> str:
    """An axis within a sentence: without its unit, and without the tables that its words imply."""
    return _parts(address)[0].removeprefix("autopilot ").removeprefix("law ")


def _parts(name: str) -> tuple[str, str]:
    """(words, printed unit) of a dotted name; the channel of a ratio has no unit."""
    if name.startswith((OF_TRACKERS, OF_CONTRASTS)) and any(f".{part}." in name for part in TABLES):
        parts = [part for part in name.split(".")[1:] if part != "overall"]
        plain = (words(part) if part[0].isdigit() else split(part)[0] for part in parts)
        suffix = unit_of(name)
        return " ".join(plain), "" if suffix in RATIOS else unit_words(suffix)
    own = name.removeprefix(OF_TRACKERS).removeprefix("wind.events.")
    return named(name) if table.find(name) else split(own.replace(".", " "))


def set_scale(axis: Axis, scale: Scale) -> None:
    """The label of a scale and its words, where it has any."""
    axis.label = scale.label
    if scale.ticks is not None:
        axis.ticks = list(zip(scale.at.tolist(), scale.ticks, strict=True))


def _first_of_the_rest(metrics: dict[str, Any], kept: Sequence[str]) -> list[dict[str, Any]]:
    """Rows over the kept axes, at the first value of every other one."""
    fixed = _fixed(metrics, kept)
    return [row for row in metrics["rows"] if all(row[address] == value for address, value in fixed.items())]


def _fixed(metrics: dict[str, Any], kept: Sequence[str]) -> dict[str, Any]:
    """The first value of every chosen axis that is not kept."""
    return {
        address: axis["values"][0]
        for address, axis in metrics["axes"].items()
        if "values" in axis and address not in kept
    }


def _at_fixed(metrics: dict[str, Any], kept: Sequence[str]) -> str:
    """A caption's last sentence: which cells are left out of the figure."""
    fixed = ", ".join(f"{label(address)} = {value}" for address, value in _fixed(metrics, kept).items())
    return f" Cells of {fixed}; the others are in the table." if fixed else ""


def _table(metrics: dict[str, Any], x: str, y: str, get: Any) -> np.ndarray:
    """(values of y, values of x) of something of each row."""
    xs, ys = metrics["axes"][x]["values"], metrics["axes"][y]["values"]
    table = np.full((len(ys), len(xs)), np.nan)
    for row in _first_of_the_rest(metrics, (x, y)):
        table[ys.index(row[y]), xs.index(row[x])] = get(row)
    return table


def edges(at: np.ndarray) -> np.ndarray:
    """Borders of the cells about the values; those of values above 0 do not come to 0, where no law is designed."""
    if len(at) == 1:
        return np.array([at[0] - 0.5, at[0] + 0.5])
    middle = (at[1:] + at[:-1]) / 2
    first, last = 2 * at[0] - middle[0], 2 * at[-1] - middle[-1]
    return np.concatenate(([at[0] / 2 if first <= 0 < at[0] else first], middle, [last]))


def _map(name: str, x: str, y: str, metrics: dict[str, Any], lines: Sequence[Line]) -> Chart:
    table = _table(metrics, x, y, lambda row: (figure_of(row, name) or {}).get("p50", np.nan))
    across, up = (scale(address, metrics["axes"][address]["values"]) for address in (x, y))
    figure, (axes,) = style.panels(3.4)
    ratio = " / " in name
    scaled = np.log10(table) if ratio else table
    seen = scaled[np.isfinite(scaled)]
    least, most = (float(seen.min()), float(seen.max())) if seen.size else (0.0, 1.0)
    if ratio:
        least, most = -max(abs(least), abs(most)), max(abs(least), abs(most))
    colours = Colours(BLUE_RED if ratio else VIRIDIS, least, most)
    _cells(axes, across, up, colours.of(scaled))
    _draw(axes, lines)
    if ratio and seen.size and seen.min() < 0 < seen.max() and min(table.shape) > 1:
        axes.line(*contours.lines(across.at, up.at, scaled, 0.0), width=1.4)
    figure.legend = [axes.labelled]
    add_scale(figure, colours, "log10 of the ratio" if ratio else label(name))
    caption = "Median of the flights of each cell; grey where no flight has the figure."
    if ratio:
        caption = "Ratio of medians, logarithmic; the black line is where the two are equal."
    return Chart(label(name), figure, caption + _at_fixed(metrics, (x, y)))


def _cells(axes: Panel, across: Scale, up: Scale, colours: Sequence[str]) -> None:
    """A map of cells that fills its panel; grey where there is no colour."""
    x, y = edges(across.at), edges(up.at)
    axes.grid, axes.background = "", style.LIGHT
    axes.x.limits, axes.y.limits = (float(x[0]), float(x[-1])), (float(y[0]), float(y[-1]))
    cells(axes, x, y, colours)
    set_scale(axes.x, across)
    set_scale(axes.y, up)


def _outcome_map(x: str, y: str, metrics: dict[str, Any], lines: Sequence[Line]) -> Chart:
    names = sorted(metrics["outcomes"])
    table = _table(metrics, x, y, lambda row: names.index(max(sorted(row["outcomes"]), key=row["outcomes"].get)))
    across, up = (scale(address, metrics["axes"][address]["values"]) for address in (x, y))
    colours = {name: OUTCOME_COLOURS.get(name, style.GREY) for name in names}
    figure, (axes,) = style.panels(3.4)
    _cells(axes, across, up, [colours[names[int(one)]] if np.isfinite(one) else "" for one in table.ravel()])
    _draw(axes, lines)
    key = [Points(NONE, NONE, colour, "s", size=6.0, label=words(name)) for name, colour in colours.items()]
    figure.legend = [[*key, *axes.labelled]]
    caption = "The commonest outcome of each cell." + _at_fixed(metrics, (x, y))
    return Chart("Outcomes", figure, caption)


def _sections(scenario: Any, metrics: dict[str, Any], x: str, y: str, shown: Sequence[str]) -> list[Chart]:
    """Lines through a map at some values of y, with the figures that theory predicts along them."""
    theory = THEORIES.get(scenario.study.theory)
    if theory is None or theory.figures is None:
        return []
    values_x, values = (metrics["axes"][address]["values"] for address in (x, y))
    across = scale(x, values_x)
    chosen = [values[i] for i in np.unique(np.linspace(0, len(values) - 1, SECTIONS).round().astype(int))]
    fine = np.linspace(across.at.min(), across.at.max(), FINE)
    known = theory.figures(scenario, [{x: values_x[0], y: values[0]}])
    names = [name for name in shown if name in known]
    if not names:
        return []
    predicted = {value: theory.figures(scenario, [{x: float(at), y: value} for at in fine]) for value in chosen}
    charts = []
    for name in names:
        figure, (axes,) = style.panels(2.8)
        for i, value in enumerate(chosen):
            rows = [row for row in _first_of_the_rest(metrics, (x, y)) if row[y] == value]
            flown = [(figure_of(row, name) or {}).get("p50", np.nan) for row in rows]
            theirs = [np.nan if one is None else one for one in predicted[value][name]]
            axes.points([row[x] for row in rows], flown, colour=style.TRACKERS[i], marker="o", size=3.5)
            axes.line(fine, theirs, colour=style.TRACKERS[i], label=f"{label(y)} = {value:g}")
        figure.legend = [axes.labelled]
        set_scale(axes.x, across)
        axes.y.label = label(name)
        text = (
            "Dots: medians of the flights at their end; lines: the cycle that theory predicts, where it predicts one. "
            "A flight that ends while its swings still fade lies off the line."
        )
        charts.append(Chart(f"{label(name)}: theory and flights", figure, text))
    return charts


def _curves(name: str, x: str, lines: str | None, metrics: dict[str, Any]) -> Chart:
    across = scale(x, metrics["axes"][x]["values"])
    figure, (axes,) = style.panels(2.6)
    kept = (x,) if lines is None else (x, lines)
    rows = _first_of_the_rest(metrics, kept)
    for i, value in enumerate(metrics["axes"][lines]["values"] if lines else [None]):
        chosen = [row for row in rows if lines is None or row[lines] == value]
        spread = [figure_of(row, name) or {} for row in chosen]
        low, mid, high = (np.array([one.get(p, np.nan) for one in spread]) for p in ("p5", "p50", "p95"))
        colour = style.TRACKERS[i]
        text = "" if lines is None else f"{label(lines)} = {value:g}" if isinstance(value, int | float) else str(value)
        axes.line(across.at, mid, colour=colour, label=text)
        axes.points(across.at, mid, colour=colour, marker="o", size=2.5)
        axes.band(across.at, low, high, colour, alpha=0.15)
    _limits(axes, name, metrics["checks"])
    figure.legend = [axes.labelled]
    set_scale(axes.x, across)
    axes.y.label = label(name)
    caption = "Line: median of the flights; band: 5 % to 95 % of them." + _at_fixed(metrics, kept)
    return Chart(label(name), figure, caption)


def _exceedances(found: Sequence[Distribution]) -> list[Chart]:
    """A chart of each figure that is more than a yes or no; the first says how they are read."""
    charts = [_exceedance(one) for one in found if one.distinct > 2]
    how = (
        "Share of the flights beyond a value, from the median outwards, on a logarithmic scale; bands: 95 % at each "
        "value by itself. Dashed: limits of the checks, with a diamond at the share that may be beyond. "
    )
    return [charts[0]._replace(caption=how + charts[0].caption), *charts[1:]] if charts else []


def _exceedance(found: Distribution) -> Chart:
    """Both tails of a figure on a logarithmic scale; of a figure with limits only the tails that are limited.

    The values of a tail run outwards, and so do its steps.
    """
    figure, (axes,) = style.panels(2.2)
    limited = found.limits_below or found.limits_above
    for tail, limits, colour, text in (
        (found.below, found.limits_below, style.SKY, "below the value"),
        (found.above, found.limits_above, style.BLUE, "above the value"),
    ):
        if limited and not limits:
            continue
        share, low, high = (_stairs(one) for one in (tail.share, tail.low, tail.high))
        value = np.repeat(tail.value, 2)[1:]
        axes.line(value, np.where(share > 0, share, np.nan), colour=colour, label=text)
        axes.band(value, low, high, colour, alpha=0.2)
        for limit in limits:
            axes.rule(x=limit.value, colour=style.VERMILION, width=0.8, dashes=style.BROKEN)
            if limit.probability is not None:
                look = {"colour": style.VERMILION, "marker": "D", "size": 4.0, "free": True}
                axes.points(limit.value, limit.probability, **look)
    least = 0.3 / max(found.flights, 1)
    axes.y.scale, axes.y.limits = LOGARITHMIC, (least, 1.0)
    axes.y.ticks = [(share, f"{100 * share:g} %") for share in LOGARITHMIC.ticks(least, 1.0, 9)]
    axes.x.label = label(found.name)
    axes.y.label = "share of flights"
    figure.legend = [axes.labelled]
    lacking = f"{found.without} flights without the figure count as beyond every value." if found.without else ""
    return Chart(label(found.name), figure, lacking)


def _stairs(values: np.ndarray) -> np.ndarray:
    """Each value held up to the next, over places that are all but the first taken twice."""
    return np.repeat(values, 2)[:-1]


def _limits(axes: Panel, name: str, checks: Sequence[dict[str, Any]]) -> None:
    for check in checks:
        if check["metric"] == name:
            axes.rule(y=check["limit"], colour=style.VERMILION, width=0.8, dashes=style.BROKEN)
