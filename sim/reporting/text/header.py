"""What a reader sees first: what was flown, what happened, the key figures."""

from __future__ import annotations

from datetime import UTC, datetime
from pathlib import Path
from typing import Any

import numpy as np

from aircraft.data import data
from sim.flight import weather
from sim.flight.record import UNKNOWN, Flight
from sim.metrics import table
from sim.metrics.flight import figure
from sim.reporting.text.best_tracker import best_tracker
from sim.reporting.text.labels import number as digits
from sim.reporting.text.labels import unit, words
from sim.reporting.text.outcome_sentence import how_it_ended, what_happened
from sim.reporting.text.rows import check_name
from sim.reporting.tracker_figures.error_curves import Shown

MOST_FIGURES = 6  # on the first screen


def first_screen(
    scenario: Any,
    flight: Flight,
    metrics: dict[str, Any],
    followed: list[Shown],
    number: int = 0,
    contrasted: list[str] | None = None,
) -> dict[str, Any]:
    """What the head of the page is filled with, about one flight; verdicts and ``contrasted``, its contrasts, about
    all."""
    checks = metrics.get("checks", [])
    failed = [check_name(check) for check in checks if check["passed"] is False]
    return {
        "name": scenario.name,
        "number": number,
        "subtitle": _subtitle(scenario, flight, metrics, number),
        "ended": how_it_ended(flight, metrics["flight"]),
        "sentence": what_happened(flight, metrics["flight"], checks),
        "why": (metrics["flight"].get("navigated") or {}).get("why"),
        "contrasted": contrasted or [],
        "winner": best_tracker(flight, metrics.get("trackers") or {}, followed, short=bool(contrasted)),
        "good": not failed and metrics["flight"]["outcome"] in ("landed", "completed", UNKNOWN),
        "failed": failed,
        "outcomes": _outcomes(metrics.get("flights_summary", {}).get("outcomes", {})),
        "warnings": metrics.get("warnings", []),
        "key_figures": _key_figures(metrics["flight"]),
    }


def _subtitle(scenario: Any, flight: Flight, metrics: dict[str, Any], number: int) -> list[str]:
    """What was flown: aircraft, law, air, seed."""
    aircraft, record = scenario.aircraft, scenario.record
    if record is not None and record.file is None:
        parts = ["recorded plots"]
    elif record is not None and record.file is not None:
        begun = datetime.fromtimestamp(flight.utc or 0.0, UTC)
        parts = [f"recorded flight {record.flight or Path(record.file).stem}", f"{begun:%Y-%m-%d %H:%M:%S} UTC"]
    else:
        parts = ["point mass" if aircraft.model == "point_mass" else data(aircraft.model).title]
    if aircraft.mass is not None:
        parts.append(f"{aircraft.mass / 1000:.1f} t")
    whose = "law" if record is None else "trackers assume the law"
    parts.append(f"{whose} {words(scenario.mode)}, bank limit {np.degrees(scenario.autopilot.bank_limit):.0f} deg")
    parts += weather.words(scenario)
    parts.append(f"seed {metrics.get('seed', scenario.seed)}")
    if metrics.get("flights", 1) > 1 or number > 0:
        parts.append(f"flight {number}")
    return parts


def _outcomes(counts: dict[str, int]) -> str:
    """How all flights ended, where there are several."""
    ends = ", ".join(f"{count} {words(name)}" for name, count in sorted(counts.items(), key=lambda end: -end[1]))
    return f"Outcomes of all {sum(counts.values())} flights: {ends}." if sum(counts.values()) > 1 else ""


def _key_figures(flight: dict[str, Any]) -> list[tuple[str, str, str]]:
    """(label, number, unit) of the first figures that this flight has and that are not printed as 0."""
    found = [
        (row.label, digits(float(value), row.digits), unit(row.unit))
        for row in table.METRICS
        if row.headline and (value := figure(flight, row.name)) is not None
    ]
    return [one for one in found if set(one[1]) & {*"123456789"}][:MOST_FIGURES]
