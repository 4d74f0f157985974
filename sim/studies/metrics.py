"""Figures of a study from the records of its flights: one row for each cell, and the verdict on every check."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

from sim.metrics.ensemble.contrasts import contrasts_over_flights
from sim.metrics.ensemble.exceedance import any_beyond, exceedances
from sim.metrics.ensemble.spread import outcomes, spread, spreads
from sim.metrics.ensemble.verdict import CRASHED, REFUSED, verdicts, worst_first
from sim.reporting.text.broken_checks import Again
from sim.scenario.axes import Axis, Listed
from sim.scenario.tables import Check, Contrast


def study_metrics(
    axes: Sequence[Axis],
    records: Sequence[dict[str, Any]],
    checks: Sequence[Check],
    again: Again,
    contrasts: Sequence[Contrast] = (),
) -> dict[str, Any]:
    """Axes, rows and checks, as in metrics.json; ``records`` sorted by cell, sample and flight.

    A study of one cell also has how often its flights break each check, and any. ``again`` is how one of them is flown
    again.
    """
    why = {"crashes": reasons(records, CRASHED), "refusals": reasons(records, REFUSED)}
    cells: dict[int, list[dict[str, Any]]] = {}
    for record in records:
        cells.setdefault(record["cell"], []).append(record)
    worst = worst_first(records)[0]
    judged = verdicts(checks, records)
    alone = len(cells) == 1 and len(records) > 1
    beyond = {"any_beyond": any_beyond(records), "exceedances": exceedances(judged)} if alone and checks else {}
    return {
        "axes": {one.address: describe(one) for one in axes},
        "outcomes": outcomes(records),
        **{name: said for name, said in why.items() if said},
        "rows": [row(axes, cells[number], again, contrasts) for number in sorted(cells)],
        "worst": {name: worst[name] for name in ("flight", "values")},
        "checks": judged,
        **beyond,
    }


def reasons(records: Sequence[dict[str, Any]], outcome: str) -> list[str]:
    """Why flights ended like that, each reason once."""
    return list(dict.fromkeys(r["metrics"]["reason"] for r in records if r["metrics"]["outcome"] == outcome))


def describe(axis: Axis) -> dict[str, Any]:
    """An axis as in metrics.json."""
    if isinstance(axis, Listed):
        return {"values": list(axis.values)}
    return {axis.distribution: [*axis.numbers]}


def named(record: dict[str, Any], axes: Sequence[Axis], again: Again) -> dict[str, Any]:
    """A record with the command that flies it again."""
    values = {one.address: record["values"][one.address] for one in axes if isinstance(one, Listed)}
    return {**record, "again": again(record["flight"], values)}


def row(
    axes: Sequence[Axis], records: Sequence[dict[str, Any]], again: Again, contrasts: Sequence[Contrast] = ()
) -> dict[str, Any]:
    """One cell: its chosen values, the spread of its drawn ones, that of every figure, and its worst flight.

    ``contrasts`` are pooled over its flights; their figures of single flights are spread as all others.
    """
    worst = named(worst_first(records)[0], axes, again)
    found: dict[str, Any] = {"outcomes": outcomes(records), "worst": {key: worst[key] for key in ("flight", "again")}}
    for one in axes:
        values = [record["values"][one.address] for record in records]
        found[one.address] = values[0] if isinstance(one, Listed) else spread(values)
    found["contrasts"] = contrasts_over_flights(contrasts, records)
    return found | spreads(records)
