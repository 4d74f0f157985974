"""What a reader sees first: what was flown, what happened, the key figures."""

from __future__ import annotations

from typing import Any

import numpy as np

from aircraft.data import data
from sim.flight import weather
from sim.flight.record import Flight
from sim.reporting.text.best_tracker import who_won
from sim.reporting.text.labels import decimals, number, split, words
from sim.reporting.text.outcome_sentence import what_happened
from sim.reporting.text.rows import check_name
from sim.reporting.tracker_figures.error_curves import Followed

KEY_FIGURES = (
    ("duration_s", "flight time"),
    ("bank_max_deg", "greatest bank"),
    ("time_saturated_s", "at the bank limit"),
    ("base_overshoot_m", "overshoot of base"),
    ("overshoot_m", "overshoot of the last leg"),
    ("settling_s", "settled after"),
    ("cross_track_rms_final_m", "cross-track RMS, final"),
    ("height_error_rms_final_m", "height error RMS, glide path"),
    ("touchdown.past_threshold_m", "touchdown past the threshold"),
    ("touchdown.cross_track_m", "touchdown right of centreline"),
    ("touchdown.sink_mps", "sink at touchdown"),
    ("touchdown.crab_deg", "crab at touchdown"),
)
TENTHS = ("duration_s", "time_saturated_s", "settling_s")


def first_screen(scenario: Any, flight: Flight, metrics: dict[str, Any], followed: list[Followed]) -> dict[str, Any]:
    """What the head of the page is filled with."""
    checks = metrics.get("checks", [])
    failed = [check_name(check) for check in checks if check["passed"] is False]
    return {
        "name": scenario.name,
        "subtitle": _subtitle(scenario, metrics),
        "sentence": what_happened(flight, metrics["flight"], checks),
        "why": (metrics["flight"].get("navigated") or {}).get("why"),
        "winner": who_won(flight, metrics.get("trackers") or {}, followed),
        "good": not failed and metrics["flight"]["outcome"] in ("landed", "completed"),
        "failed": failed,
        "others": _outcomes(metrics.get("flights_summary", {}).get("outcomes", {})),
        "warnings": metrics.get("warnings", []),
        "key_figures": _key_figures(metrics["flight"]),
    }


def _subtitle(scenario: Any, metrics: dict[str, Any]) -> list[str]:
    """What was flown: aircraft, law, air, seed."""
    aircraft = scenario.aircraft
    parts = ["point mass" if aircraft.model == "point_mass" else data(aircraft.model).title]
    if aircraft.mass is not None:
        parts.append(f"{aircraft.mass / 1000:.1f} t")
    parts.append(f"law {words(scenario.mode)}, bank limit {np.degrees(scenario.autopilot.bank_limit):.0f} deg")
    parts += weather.words(scenario.wind)
    parts.append(f"seed {metrics.get('seed', scenario.seed)}")
    if metrics.get("flights", 1) > 1:
        parts.append(f"first of {metrics['flights']} flights")
    return parts


def _outcomes(counts: dict[str, int]) -> str:
    """How all flights ended, where there are several."""
    ends = ", ".join(f"{count} {words(name)}" for name, count in sorted(counts.items(), key=lambda end: -end[1]))
    return f"Outcomes of all {sum(counts.values())} flights: {ends}." if sum(counts.values()) > 1 else ""


def _key_figures(flight: dict[str, Any]) -> list[tuple[str, str, str]]:
    """(label, number, unit) of the figures that this flight has."""
    shown = []
    for key, label in KEY_FIGURES:
        value: Any = flight
        for part in key.split("."):
            value = value.get(part) if isinstance(value, dict) else None
        if value is not None:
            places = 1 if key in TENTHS else min(decimals(value), 2)
            shown.append((label, number(float(value), places), split(key)[1]))
    return shown
