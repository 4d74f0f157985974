"""Figures of a study from the records of its flights: one row for each cell, and the verdict on every check."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

from sim.metrics.ensemble.spread import outcomes, spread, spreads
from sim.metrics.ensemble.verdict import CRASHED, REFUSED, verdicts
from sim.scenario.axes import Axis, Listed
from sim.scenario.tables import Check


def study_metrics(
    axes: Sequence[Axis],
    records: Sequence[dict[str, Any]],
    checks: Sequence[Check],
) -> dict[str, Any]:
    """Axes, rows and checks, as in metrics.json; ``records`` sorted by cell, sample and flight."""
    why = {"crashes": reasons(records, CRASHED), "refusals": reasons(records, REFUSED)}
    cells: dict[int, list[dict[str, Any]]] = {}
    for record in records:
        cells.setdefault(record["cell"], []).append(record)
    return {
        "axes": {one.address: describe(one) for one in axes},
        "outcomes": outcomes(records),
        **{name: said for name, said in why.items() if said},
        "rows": [row(axes, cells[number]) for number in sorted(cells)],
        "checks": verdicts(checks, records),
    }


def reasons(records: Sequence[dict[str, Any]], outcome: str) -> list[str]:
    """Why flights ended like that, each reason once."""
    return list(dict.fromkeys(r["metrics"]["reason"] for r in records if r["metrics"]["outcome"] == outcome))


def describe(axis: Axis) -> dict[str, Any]:
    """An axis as in metrics.json."""
    if isinstance(axis, Listed):
        return {"values": list(axis.values)}
    return {axis.distribution: [*axis.numbers]}


def row(axes: Sequence[Axis], records: Sequence[dict[str, Any]]) -> dict[str, Any]:
    """One cell: its chosen values, the spread of its drawn ones, and that of every figure over its flights."""
    found: dict[str, Any] = {"outcomes": outcomes(records)}
    for one in axes:
        values = [record["values"][one.address] for record in records]
        found[one.address] = values[0] if isinstance(one, Listed) else spread(values)
    return found | spreads(records)
