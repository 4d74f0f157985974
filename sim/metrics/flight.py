"""Figures of flights as in metrics.json: units in the names, null where a figure does not apply."""

from __future__ import annotations

import math
from typing import Any

from sim.flight.record import Flight
from sim.metrics import table
from sim.metrics.figures import Context
from sim.scenario.tables import Runway

DURATION = "duration_s"
NAVIGATED = "navigated"  # the table of figures of the estimate that it was flown on


def flight_metrics(
    flight: Flight, runway: Runway, bank_limit: float, stall_speed: float | None = None
) -> dict[str, Any]:
    """How one flight ended and every figure of the metric table; a nested table without any value is null.

    ``bank_limit`` (rad) is that of the law that flew, ``stall_speed`` (m/s, equivalent) that of the landing. Figures of
    the estimate that it was flown on are not among them: ``sim.metrics.navigation`` adds them, since only a flight that
    trackers watched has them. Of a flight that only plots tell of there is no figure but how long they do.
    """
    context = Context(runway, bank_limit, stall_speed=stall_speed)
    rows = [row for row in table.METRICS if not row.name.startswith(f"{NAVIGATED}.")]
    found: dict[str, Any] = {"outcome": flight.outcome, "reason": flight.reason}
    for row in rows:
        nested, _, own = row.name.rpartition(".")
        known = flight.known or row.name == DURATION
        (found.setdefault(nested, {}) if nested else found)[own] = value(row, flight, context) if known else None
    nothing = [name for name, inner in found.items() if isinstance(inner, dict) and not any_value(inner)]
    return found | dict.fromkeys(nothing)


def navigated_figures(flight: Flight, context: Context) -> dict[str, float | None]:
    """The figures of the estimate that a flight was flown on, by their names within the table ``navigated``."""
    rows = [row for row in table.METRICS if row.name.startswith(f"{NAVIGATED}.")]
    return {row.name.removeprefix(f"{NAVIGATED}."): value(row, flight, context) for row in rows}


def value(row: table.Metric, flight: Flight, context: Context) -> float | None:
    """A row's figure of a flight; None where it is not finite."""
    found = row.of(flight, context)
    return float(found) if found is not None and math.isfinite(found) else None


def any_value(figures: dict[str, float | None]) -> bool:
    """Whether a nested table has any value."""
    return any(figure is not None for figure in figures.values())


def figure(figures: dict[str, Any] | None, name: str) -> Any:
    """A figure by its name in the metric table, from the ``flight`` part of metrics.json; None = absent."""
    nested, _, own = name.rpartition(".")
    inner = (figures or {}).get(nested) if nested else figures
    return (inner or {}).get(own)
