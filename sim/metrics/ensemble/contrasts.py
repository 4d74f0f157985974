"""Contrasts of trackers over several flights, each of which counts once, with intervals over flights."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any

import numpy as np

from sim.metrics.contrasts.pairing import TABLES, Entry, entry, figure
from sim.scenario.tables import Contrast


def contrasts_over_flights(asked: Sequence[Contrast], records: Sequence[dict[str, Any]]) -> list[Entry]:
    """The list ``contrasts`` of metrics.json over all flights; its keys are those of one flight.

    An RMSE is the root mean square over the flights that have it, the ratio that of the two, ``n`` those flights. One
    flight alone has its own figures, with intervals over its draws.
    """
    each = [record["metrics"].get("contrasts", {}) for record in records]
    if len(each) == 1:
        return [each[0].get(one.pair, entry(one, {})) for one in asked]
    return [entry(one, _pooled([_tables(flight[one.pair]) for flight in each if one.pair in flight])) for one in asked]


def _tables(flight: Entry) -> dict[str, Any]:
    return {name: flight[name] for name in TABLES}


def _pooled(tables: Sequence[dict[str, Any]]) -> dict[str, Any]:
    if tables and "ratio" in tables[0]:
        return figure(*(np.array([_square(one[side]) for one in tables]) for side in ("of", "against")))
    names = dict.fromkeys(name for table in tables for name in table)
    return {name: _pooled([table[name] for table in tables if name in table]) for name in names}


def _square(value: float | None) -> float:
    return math.nan if value is None else value * value
