"""Figures of a study from the records of its flights: one row for each cell, and checks over all flights.

Quantiles carry distribution-free intervals from order statistics, shares exact binomial ones (Clopper and Pearson), so
nothing is assumed of how a figure is distributed; where the flights are too few for a bound, the bound is null.
"""

from __future__ import annotations

import functools
import math
from collections.abc import Iterator, Sequence
from typing import Any

import numpy as np

from sim.metrics.checks import unit_of
from sim.scenario.axes import Axis, Listed
from sim.scenario.tables import Check, StudyCheck

CONFIDENCE = 0.95  # of every interval, two-sided
PERCENTILES = (5, 50, 95)


def study_metrics(
    axes: Sequence[Axis],
    records: Sequence[dict[str, Any]],
    checks: Sequence[Check],
    study_checks: Sequence[StudyCheck],
) -> dict[str, Any]:
    """Axes, rows and checks, as in metrics.json; ``records`` sorted by cell, sample and flight."""
    why = {"crashes": reasons(records, "crashed"), "refusals": reasons(records, "refused")}
    cells: dict[int, list[dict[str, Any]]] = {}
    for record in records:
        cells.setdefault(record["cell"], []).append(record)
    return {
        "axes": {one.address: describe(one) for one in axes},
        "outcomes": outcomes(records),
        **{name: said for name, said in why.items() if said},
        "rows": [row(axes, cells[number]) for number in sorted(cells)],
        "checks": [
            *(share_check(check, records) for check in study_checks),
            *(every_flight(check, i, records) for i, check in enumerate(checks)),
        ],
    }


def reasons(records: Sequence[dict[str, Any]], outcome: str) -> list[str]:
    """Why flights ended like that, each reason once."""
    return list(dict.fromkeys(r["metrics"]["reason"] for r in records if r["metrics"]["outcome"] == outcome))


def describe(axis: Axis) -> dict[str, Any]:
    """An axis as in metrics.json."""
    if isinstance(axis, Listed):
        return {"values": list(axis.values)}
    return {axis.distribution: [axis.first, axis.second]}


def outcomes(records: Sequence[dict[str, Any]]) -> dict[str, int]:
    """Number of flights for each outcome."""
    counts: dict[str, int] = {}
    for record in records:
        outcome = record["metrics"]["outcome"]
        counts[outcome] = counts.get(outcome, 0) + 1
    return counts


def row(axes: Sequence[Axis], records: Sequence[dict[str, Any]]) -> dict[str, Any]:
    """One cell: its chosen values, the spread of its drawn ones, and that of every figure over its flights."""
    found: dict[str, Any] = {"outcomes": outcomes(records)}
    for one in axes:
        values = [record["values"][one.address] for record in records]
        found[one.address] = values[0] if isinstance(one, Listed) else spread(values)
    columns: dict[str, list[float]] = {}
    for record in records:
        for name, value in scalars(record["metrics"]):
            columns.setdefault(name, []).append(value)
    return found | {name: spread(values) for name, values in columns.items()}


def scalars(metrics: dict[str, Any], above: str = "") -> Iterator[tuple[str, float]]:
    """Every number of a flight's metrics by its dotted name."""
    for name, value in metrics.items():
        if isinstance(value, dict):
            yield from scalars(value, f"{above}{name}.")
        elif isinstance(value, int | float) and not isinstance(value, bool):
            yield above + name, float(value)


def spread(values: Sequence[float]) -> dict[str, float | int | None]:
    """Count and percentiles, each with its distribution-free interval."""
    ordered = np.sort(np.asarray(values, float))
    found: dict[str, float | int | None] = {"n": len(ordered)}
    for percentile in PERCENTILES:
        low, high = quantile_ranks(len(ordered), percentile / 100)
        found[f"p{percentile}"] = float(np.percentile(ordered, percentile))
        found[f"p{percentile}_low"] = None if low is None else float(ordered[low - 1])
        found[f"p{percentile}_high"] = None if high is None else float(ordered[high - 1])
    return found


@functools.cache
def quantile_ranks(count: int, quantile: float) -> tuple[int | None, int | None]:
    """Ranks (1 is the smallest of ``count``) between which a quantile lies with the confidence; None = too few."""
    from scipy.stats import binom

    tail = (1 - CONFIDENCE) / 2
    low, high = int(binom.ppf(tail, count, quantile)), int(binom.ppf(1 - tail, count, quantile)) + 1
    return (low if low >= 1 else None), (high if high <= count else None)


def share_interval(within: int, count: int, confidence: float = CONFIDENCE) -> tuple[float, float]:
    """Exact two-sided interval of a share."""
    from scipy.stats import beta

    tail = (1 - confidence) / 2
    low = float(beta.ppf(tail, within, count - within + 1)) if within else 0.0
    high = float(beta.ppf(1 - tail, within + 1, count - within)) if within < count else 1.0
    return low, high


def fewest_flights(share: float, confidence: float) -> int:
    """How many good flights show a share with a confidence: the least n with share^n <= 1 - confidence."""
    return math.ceil(math.log(1 - confidence) / math.log(share))


def tolerance_rank(count: int, share: float, confidence: float) -> int | None:
    """Rank of the value below which the share lies with the confidence; None where the flights are too few."""
    from scipy.stats import binom

    rank = int(binom.ppf(confidence, count, share)) + 1
    return rank if rank <= count else None


def share_check(check: StudyCheck, records: Sequence[dict[str, Any]]) -> dict[str, Any]:
    """Whether a share of all flights keeps a limit; a flight without the figure does not keep it.

    ``value`` is the bound within which the share lies with the confidence, so it can be set against the limit.
    """
    upper = check.max is not None
    limit = check.max if check.max is not None else check.min
    assert limit is not None
    sign = 1.0 if upper else -1.0
    figures = [dict(scalars(record["metrics"])).get(check.metric) for record in records]
    ordered = sorted(math.inf if figure is None else sign * figure for figure in figures)
    rank = tolerance_rank(len(ordered), check.share, check.confidence)
    bound = ordered[rank - 1] if rank is not None else math.inf
    value = sign * bound if math.isfinite(bound) else None
    return {
        "name": check.name or check.metric,
        "metric": check.metric,
        "limit": limit,
        "value": value,
        "unit": unit_of(check.metric),
        "margin": None if value is None else sign * (limit - value) + 0.0,
        "flights": len(ordered),
        "within": sum(figure <= sign * limit for figure in ordered),
        "share": check.share,
        "confidence": check.confidence,
        "passed": bound <= sign * limit,
        "source": check.source,
    }


def every_flight(check: Check, index: int, records: Sequence[dict[str, Any]]) -> dict[str, Any]:
    """A check of the scenario over all flights: how many kept it, and the one that came nearest to breaking it."""
    judged = [(record, record["checks"][index]) for record in records if record["checks"]]
    failed = sum(result["passed"] is False for _, result in judged)
    kept = sum(result["passed"] is True for _, result in judged)
    with_margin = [(result["margin"], i) for i, (_, result) in enumerate(judged) if result["margin"] is not None]
    nearest = judged[min(with_margin)[1]] if with_margin else None
    return {
        "name": check.name or check.metric,
        "metric": check.metric,
        "limit": check.max if check.max is not None else check.min,
        "value": nearest[1]["value"] if nearest else None,
        "unit": unit_of(check.metric),
        "margin": nearest[1]["margin"] if nearest else None,
        "at": {**nearest[0]["values"], "flight": nearest[0]["flight"]} if nearest else None,
        "flights": len(judged),
        "within": kept,
        "share": 1.0,
        "passed": None if not failed + kept else not failed,
        "source": check.source,
    }
