"""The ratios of a contrast over the cells of a study, as plain values, beside the borders that theory gives."""

from __future__ import annotations

import itertools
from collections.abc import Mapping, Sequence
from typing import Any, NamedTuple

import numpy as np

from sim.reporting.text.labels import words
from sim.scenario.model import Scenario
from sim.studies.figures import Scale, edges, label, scale, short
from sim.studies.limits.prediction import Prediction, predict

FINE = 33  # points of a border of theory along each axis
MOST_PANELS = 6
ACROSS, PLACE, AHEAD = "cross_track_m", "position_m", "60_s"


class Border(NamedTuple):
    """Drawn where ``height`` (y, x) is 0, in the units of the axes; along one axis its shape is (1, x)."""

    label: str
    x: np.ndarray
    y: np.ndarray
    height: np.ndarray


class Panel(NamedTuple):
    """The cells of two axes at one value of the others; arrays (values of y, values of x), NaN where there is none."""

    title: str
    ratio: np.ndarray  # with its interval of 95 %
    low: np.ndarray
    high: np.ndarray
    at_limits: np.ndarray | None  # s, by theory
    predicted: np.ndarray | None  # ratio by theory
    borders: tuple[Border, ...]


class RatioMap(NamedTuple):
    """By how much the errors of one tracker exceed those of another, over a study's axes."""

    of: str
    against: str
    what: str  # whose RMSE
    x: Scale
    y: Scale | None  # None = there is one axis
    panels: tuple[Panel, ...]


def undecided(panel: Panel) -> np.ndarray:
    """Cells with a ratio whose interval does not tell on which side of 1 it is."""
    return np.asarray(np.isfinite(panel.ratio) & ~((panel.low > 1.0) | (panel.high < 1.0)))


def ratio_maps(scenario: Scenario, metrics: Mapping[str, Any]) -> list[RatioMap]:
    """Those of the first contrast: over the whole flight, and of looking 60 s ahead; none without a chosen axis."""
    listed = [address for address, axis in metrics["axes"].items() if "values" in axis]
    if not scenario.contrasts or not listed:
        return []
    first, rows = scenario.contrasts[0], metrics["rows"]
    entries = [next(one for one in row["contrasts"] if _is(one, first)) for row in rows]
    overall = [entry["overall"] for entry in entries]
    ahead = [entry["look_ahead"].get(AHEAD, {}) for entry in entries]
    wanted = (
        (overall, (ACROSS, PLACE), "over the flight"),
        (ahead, (PLACE, ACROSS), f"{AHEAD.removesuffix('_s')} s ahead"),
    )
    axes = {address: metrics["axes"][address]["values"] for address in listed}
    x, y = listed[0], listed[1] if len(listed) > 1 else None
    theory = _theory(scenario, axes, x, y)
    maps = []
    for number, (tables, order, when) in enumerate(wanted):
        channel = _channel(tables, order)
        if channel is None:
            continue
        figures = {_key(axes, row): table.get(channel) for row, table in zip(rows, tables, strict=True)}
        panels = tuple(_panel(axes, x, y, others, figures, theory, number == 0) for others in _others(axes, x, y))
        what = f"{words(channel.removesuffix('_m').removesuffix('_deg'))} {when}"
        maps.append(RatioMap(first.of, first.against, what, scale(x, axes[x]), y and scale(y, axes[y]), panels))
    return maps


def _is(entry: Mapping[str, Any], asked: Any) -> bool:
    return (entry["of"], entry["against"]) == (asked.of, asked.against)


def _channel(tables: Sequence[Mapping[str, Any]], order: Sequence[str]) -> str | None:
    """What is compared in any cell: the first of those wanted, else the first there is."""
    found = list(dict.fromkeys(channel for table in tables for channel in table))
    return next((channel for channel in (*order, *found) if channel in found), None)


def _key(axes: Mapping[str, Sequence[Any]], row: Mapping[str, Any]) -> tuple[int, ...]:
    return tuple(values.index(row[address]) for address, values in axes.items())


def _others(axes: Mapping[str, Sequence[Any]], x: str, y: str | None) -> list[dict[str, Any]]:
    """Values of the axes that are not drawn, one for each panel: those of the third, at the first of any more."""
    rest = [address for address in axes if address not in (x, y)]
    if not rest:
        return [{}]
    third, more = rest[0], {address: axes[address][0] for address in rest[1:]}
    count = len(axes[third])
    chosen = np.unique(np.linspace(0, count - 1, min(count, MOST_PANELS)).round().astype(int))
    return [{third: axes[third][place], **more} for place in chosen]


class _Theory(NamedTuple):
    """What theory says of a study: for each combination of the axes that are not drawn, by their values."""

    cells: dict[tuple[Any, ...], Prediction]
    fine: dict[tuple[Any, ...], Prediction]
    x: np.ndarray
    y: np.ndarray


def _theory(scenario: Scenario, axes: Mapping[str, Sequence[Any]], x: str, y: str | None) -> _Theory | None:
    if scenario.study is None or scenario.study.theory != "limits":
        return None
    fine_x = _fine(axes[x])
    fine_y = _fine(axes[y]) if y else np.zeros(1)
    cells: dict[tuple[Any, ...], Prediction] = {}
    fine: dict[tuple[Any, ...], Prediction] = {}
    for others in _others(axes, x, y):
        for found, across, up in ((cells, axes[x], axes[y] if y else [0.0]), (fine, fine_x, fine_y)):
            values: dict[str, Any] = {x: np.asarray(across, float)[None, :]}
            values |= {y: np.asarray(up, float)[:, None]} if y else {}
            found[tuple(others.values())] = predict(scenario, {**values, **others})
    return _Theory(cells, fine, fine_x, fine_y)


def _fine(values: Sequence[float]) -> np.ndarray:
    """Points over whole cells, to their outer edges."""
    outer = edges(np.asarray(values, float))
    return np.linspace(outer[0], outer[-1], FINE)


def _panel(
    axes: Mapping[str, Sequence[Any]],
    x: str,
    y: str | None,
    others: Mapping[str, Any],
    figures: Mapping[tuple[int, ...], Mapping[str, Any] | None],
    theory: _Theory | None,
    of_flight: bool,
) -> Panel:
    shape = (len(axes[y]) if y else 1, len(axes[x]))
    ratio, low, high = (np.full(shape, np.nan) for _ in range(3))
    for up, across in itertools.product(*map(range, shape)):
        place = {address: axes[address].index(value) for address, value in others.items()}
        place |= {x: across} | ({y: up} if y else {})
        found = figures.get(tuple(place[address] for address in axes)) or {}
        for table, name in ((ratio, "ratio"), (low, "low"), (high, "high")):
            if found.get(name) is not None:
                table[up, across] = found[name]
    title = ", ".join(_said(address, value) for address, value in others.items())
    if theory is None:
        return Panel(title, ratio, low, high, None, None, ())
    cells, fine = (one[tuple(others.values())] for one in (theory.cells, theory.fine))
    borders = [Border("a limit acts, by theory", theory.x, theory.y, np.log(np.reshape(fine.contact, (-1, FINE))))]
    predicted = None
    if of_flight and fine.ratio is not None:
        borders.append(Border("ratio 1 by theory", theory.x, theory.y, np.log(np.reshape(fine.ratio, (-1, FINE)))))
        predicted = np.reshape(np.asarray(cells.ratio), shape)
    return Panel(title, ratio, low, high, np.reshape(cells.at_limits, shape), predicted, tuple(borders))


def _said(address: str, value: Any) -> str:
    """An axis with its value and unit."""
    shown = f"{value:g}" if isinstance(value, int | float) else str(value)
    return f"{short(address)} {shown} {label(address).partition(', ')[2]}".rstrip()
