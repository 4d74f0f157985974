"""How several flights ended, and where each of their figures lies.

Quantiles carry distribution-free intervals from order statistics, so nothing is assumed of how a figure is distributed;
where the flights are too few for a bound, the bound is null.
"""

from __future__ import annotations

import functools
from collections.abc import Iterator, Sequence
from typing import Any

import numpy as np

CONFIDENCE = 0.95  # of every interval, two-sided
PERCENTILES = (5, 50, 95)


def outcomes(records: Sequence[dict[str, Any]]) -> dict[str, int]:
    """Number of flights for each outcome."""
    counts: dict[str, int] = {}
    for record in records:
        outcome = record["metrics"]["outcome"]
        counts[outcome] = counts.get(outcome, 0) + 1
    return counts


def summary(records: Sequence[dict[str, Any]]) -> dict[str, Any]:
    """The table ``flights_summary`` of metrics.json: outcomes, and the spread of every figure, also of trackers.

    One flight has no spread; its own figures stand there as percentiles, those of its trackers only where they belong.
    """
    found: dict[str, Any] = {"outcomes": outcomes(records)}
    if len(records) == 1:
        metrics = {key: figure for key, figure in records[0]["metrics"].items() if key not in ("trackers", "navigated")}
        return found | {name: {f"p{p}": value for p in PERCENTILES} for name, value in scalars(metrics)}
    return found | spreads(records)


def spreads(records: Sequence[dict[str, Any]]) -> dict[str, dict[str, float | int | None]]:
    """The spread of every figure over the flights that have it."""
    columns: dict[str, list[float]] = {}
    for record in records:
        for name, value in scalars(record["metrics"]):
            columns.setdefault(name, []).append(value)
    return {name: spread(values) for name, values in columns.items()}


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
