"""Figures of trackers over several flights, each of which counts once, with intervals over flights.

Noise draws of one flight share its path and its air; flights do not, so they are the independent samples.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any

from tracking.intervals import mean_interval, rmse

FIRST = ("lost_time_s", "first_s")  # the earliest of all flights
COUNTS = ("looks", "of_looks")  # of all flights together
ROOTS = ("look_ahead",)  # tables of plain root mean squares


def over_flights(records: Sequence[dict[str, Any]]) -> dict[str, Any]:
    """The table ``trackers`` of metrics.json over all flights; its keys are those of one flight.

    Errors are root mean squares over flights, with chi-square intervals over flights; ``gain`` is the ratio of two of
    them. ``anees`` is the mean with Student's interval, ``lost_time_s`` the earliest, looks that were ``skipped`` are
    counted, any other number is the mean of the flights that have it.
    """
    each = [record["metrics"]["trackers"] for record in records if "trackers" in record["metrics"]]
    return {name: _tracker([one[name] for one in each if name in one]) for name in _keys(each)}


def _keys(tables: Sequence[dict[str, Any]]) -> list[str]:
    return list(dict.fromkeys(key for table in tables for key in table))


def _tracker(flights: list[dict[str, Any]]) -> dict[str, Any]:
    found: dict[str, Any] = {key: _pooled(key, [one.get(key) for one in flights]) for key in _keys(flights)}
    values = [one["anees"] for one in flights if one.get("anees") is not None]
    if values:
        anees = mean_interval(values)
        found |= {"anees": anees.value, "anees_low": _real(anees.low), "anees_high": _real(anees.high)}
    return found


def _pooled(key: str, values: Sequence[Any], roots: bool = False) -> Any:
    """One entry of all flights; None where no flight has it."""
    known = [value for value in values if value is not None]
    if not known or isinstance(known[0], str):
        return known[0] if known else None
    if isinstance(known[0], dict):
        if "rmse" in known[0]:
            return _channel(known)
        within = roots or key in ROOTS
        return {inner: _pooled(inner, [table.get(inner) for table in known], within) for inner in _keys(known)}
    if roots:
        return _root(known)
    if key in FIRST:
        return min(known)
    return sum(known) if key in COUNTS else sum(known) / len(known)


def _channel(figures: Sequence[dict[str, Any]]) -> dict[str, float | None]:
    """Errors in one channel. The gain is over the epochs with a measurement, so its own errors follow from it."""
    own = rmse([one["rmse"] ** 2 for one in figures if one["rmse"] is not None])
    found = {"rmse": _real(own.value), "low": _real(own.low), "high": _real(own.high), "raw": None, "gain": None}
    measured = [one for one in figures if one.get("raw") is not None]
    if measured:
        found["raw"] = _root([one["raw"] for one in measured])
    gained = [one for one in measured if one.get("gain")]
    if gained:
        found["gain"] = _root([one["raw"] for one in gained]) / _root([one["raw"] / one["gain"] for one in gained])
    return found


def _root(values: Sequence[float]) -> float:
    return math.sqrt(sum(value * value for value in values) / len(values))


def _real(value: float) -> float | None:
    """None for what a number of flights does not say."""
    return value if math.isfinite(value) else None
