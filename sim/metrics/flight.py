"""Figures of a flight, as they stand in metrics.json: units in the names, null where there is nothing to say."""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from aircraft.state import STANDARD_GRAVITY
from sim.flight.record import RECORD_STEP, Flight
from sim.metrics.signals import bank_rate, crab, height_error
from sim.scenario.tables import Runway

SETTLED = 0.02  # of the deviation at the start of the leg
SETTLED_LEAST = 5.0  # m; nothing smaller is asked of a capture that starts close
GLIDE_CAPTURE = 40.0  # s after glide entry that belong to the capture, not to the glide
DECISION_HEIGHT = 60.0  # m


def flight_metrics(flight: Flight, runway: Runway, bank_limit: float) -> dict[str, Any]:
    """Scalars of one flight."""
    state, z = flight.state, flight.deviation.cross_track
    last = int(flight.leg.max())
    on_final = flight.during(("final", "glide")) if len(flight.route.legs) > 1 else flight.leg == last
    error = height_error(flight, runway)
    glide = flight.during("glide")
    if glide.any():
        glide &= flight.time >= flight.time[np.argmax(glide)] + GLIDE_CAPTURE
    saturated = np.abs(flight.command.bank) >= bank_limit * (1 - 1e-6)
    return {
        "outcome": flight.outcome,
        "reason": flight.reason,
        "landed": float(flight.outcome == "landed"),
        "duration_s": float(flight.time[-1]),
        "bank_max_deg": float(np.degrees(np.abs(state.bank).max())),
        "bank_rate_max_degps": float(np.degrees(np.abs(bank_rate(flight)).max())),
        "time_saturated_s": float(saturated.sum() * RECORD_STEP),
        **oscillation(flight),
        "overshoot_m": _overshoot(flight, z, last),
        "base_overshoot_m": _overshoot(flight, z, last - 1) if last > 0 and flight.leg.min() < last else None,
        "settling_s": _settling(flight, z, last),
        "cross_track_rms_final_m": _rms(z[glide]) if glide.any() else _rms(z[on_final]) if on_final.any() else None,
        "cross_track_at_30_m_m": _at_height(flight, z, 30.0),
        "cross_track_at_decision_height_m": _at_height(flight, z, DECISION_HEIGHT),
        "height_error_rms_final_m": _rms(error[glide]) if glide.any() else None,
        "height_error_at_decision_height_m": _at_height(flight, error, DECISION_HEIGHT),
        "normal_acceleration_rms_final_mps2": _rms(_normal_acceleration(flight)[glide]) if glide.any() else None,
        "bank_rate_rms_final_degps": _rms(np.degrees(bank_rate(flight)[glide])) if glide.any() else None,
        "touchdown": _touchdown(flight, runway),
    }


def _rms(values: np.ndarray) -> float | None:
    values = values[np.isfinite(values)]
    return float(np.sqrt(np.mean(values**2))) if values.size else None


def _normal_acceleration(flight: Flight) -> np.ndarray:
    """Acceleration along the lift beyond what carries the weight, m/s2."""
    return np.asarray(STANDARD_GRAVITY * (flight.state.load_factor[2] - 1.0))


def _overshoot(flight: Flight, z: np.ndarray, leg: int) -> float | None:
    """How far the aircraft went to the other side of a leg that it came to from one side, m."""
    on = flight.leg == leg
    if not on.any():
        return None
    side = np.sign(z[on][0])
    return float(max(0.0, (-side * z[on]).max()))


def _settling(flight: Flight, z: np.ndarray, leg: int) -> float | None:
    """Seconds from the start of a leg until the deviation stays small."""
    on = np.flatnonzero(flight.leg == leg)
    if not on.size:
        return None
    band = max(SETTLED * abs(z[on[0]]), SETTLED_LEAST)
    outside = on[np.abs(z[on]) > band]
    if not outside.size:
        return 0.0
    return float(flight.time[outside[-1]] - flight.time[on[0]]) if outside[-1] != on[-1] else None


def _at_height(flight: Flight, values: np.ndarray, height: float) -> float | None:
    """The value when the final approach passes a height downwards."""
    low = np.flatnonzero((flight.state.height <= height) & flight.during(("glide", "flare")))
    return float(values[low[0]]) if low.size and np.isfinite(values[low[0]]) else None


def _touchdown(flight: Flight, runway: Runway) -> dict[str, float] | None:
    """The first contact of a main wheel; sink and drift are those of the last instant before it."""
    contact = np.flatnonzero(flight.state.main_wheels > 0)
    if not contact.size or contact[0] == 0:
        return None
    at, before = contact[0], contact[0] - 1
    s = flight.state
    past, across = runway.from_local(s.north[at], s.east[at])
    along = np.cos(runway.heading), np.sin(runway.heading)
    drift = s.velocity_east[before] * along[0] - s.velocity_north[before] * along[1]
    return {
        "time_s": float(s.time[at]),
        "past_threshold_m": float(past),
        "cross_track_m": float(across),
        "sink_mps": float(-s.velocity_up[before]),
        "drift_mps": float(drift),
        "crab_deg": float(np.degrees(np.remainder(s.heading[before] - runway.heading + np.pi, 2 * np.pi) - np.pi)),
        "track_crab_deg": float(np.degrees(crab(flight)[before])),
        "bank_deg": float(np.degrees(s.bank[before])),
        "airspeed_mps": float(s.airspeed[before]),
    }


def summarise(flights: list[dict[str, Any]]) -> dict[str, Any]:
    """Outcome counts and percentiles of every scalar over several flights."""
    outcomes: dict[str, int] = {}
    columns: dict[str, list[float]] = {}
    for flight in flights:
        outcomes[flight["outcome"]] = outcomes.get(flight["outcome"], 0) + 1
        nested = flight.get("touchdown") or {}
        scalars = {**flight, **{f"touchdown.{name}": value for name, value in nested.items()}}
        for name, value in scalars.items():
            if isinstance(value, float):
                columns.setdefault(name, []).append(value)
    percentiles = {
        name: {f"p{p}": float(np.percentile(values, p)) for p in (5, 50, 95)} for name, values in columns.items()
    }
    return {"outcomes": outcomes, **percentiles}


LASTING = 60.0  # s; twice at the end of a flight
WATCHED = 180.0  # s, at the end; for periods of up to two minutes
LEAST = math.radians(1.0)  # of bank; less is no oscillation


def oscillation(flight: Flight) -> dict[str, float | None]:
    """Amplitude of the bank that persisted for the last minute, and its period, null without an oscillation.

    The amplitude is half the way from peak to peak, in that one of the last two minutes in which it is smaller: what
    fades does not persist.
    """
    left, bank = flight.time[-1] - flight.time, flight.state.bank
    minutes = [bank[left < LASTING], bank[(left >= LASTING) & (left <= 2.0 * LASTING)]]
    amplitude = min(0.5 * float(np.ptp(minute)) if minute.size else 0.0 for minute in minutes)
    last = left <= WATCHED
    period = _period(flight.time[last], bank[last]) if amplitude >= LEAST else None
    return {"bank_cycle_deg": math.degrees(amplitude), "bank_cycle_period_s": period}


def _period(time: Any, bank: Any) -> float | None:
    """Mean time between every other passage through the middle; None with less than three of them."""
    level = bank - 0.5 * (bank.max() + bank.min())
    at = np.flatnonzero((level[:-1] < 0.0) != (level[1:] < 0.0))
    if len(at) < 3:
        return None
    passed = time[at] + (time[at + 1] - time[at]) * level[at] / (level[at] - level[at + 1])
    return float((passed[2:] - passed[:-2]).mean())
