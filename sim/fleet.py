"""The fleet: every aircraft of JSBSim through the one recipe, each in a child process of its own.

Writes what the models say of themselves into ``aircraft/models/stock.toml`` and how they flew into ``sim/fleet.toml``.
"""

from __future__ import annotations

import math
import sys
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import Any

from sim.errors import ScenarioError
from sim.executors import LocalExecutor, Lost

TIME_LIMIT = 300.0  # s of one aircraft
OFFSET = 3000.0  # m, from which the line is captured
SPEED_MARGIN = 1.02  # of the manoeuvring speed over the least that the flaps are set for
TURN_ROOM = 2.5  # radii of the turn between downwind and final
RESERVE = 1500.0  # m of final between the last turn and the glide path


def speeds(settings: Sequence[Any]) -> tuple[float, float]:
    """(manoeuvring, approach) speed, m/s, from the flap settings of an aircraft."""
    from sim.preparation import MANOEUVRE_MARGIN, REFERENCE_ADDITION, REFERENCE_MARGIN

    ordered = sorted(settings, key=lambda setting: setting.flaps)
    approach = REFERENCE_MARGIN * ordered[-1].stall_speed + REFERENCE_ADDITION
    manoeuvre = SPEED_MARGIN * MANOEUVRE_MARGIN * ordered[len(ordered) // 2].stall_speed
    return max(manoeuvre, approach), approach


def capture(model: str, speed: float) -> dict[str, Any]:
    """Tables of a scenario that captures one line from ``OFFSET``."""
    duration = 120.0 + 3.0 * OFFSET / speed
    return {
        "name": f"{_word(model)}_capture",
        "until_s": duration,
        "draws": 1,
        "aircraft": {"model": model},
        "start": {"leg": 0, "cross_track_m": OFFSET},
        "route": {
            "kind": "legs",
            "legs": [{"from_m": [0, 0], "to_m": [speed * (duration + 60.0), 0], "speed_mps": speed, "height_m": 600}],
        },
    }


def straight_in(model: str, speed: float, approach: float, bank_limit: float = math.radians(15.0)) -> dict[str, Any]:
    """Tables of a scenario that begins on a long final and lands."""
    from sim.tables import PatternTable, Runway

    height, slope = PatternTable().height, math.tan(Runway().glide_path)
    radius = speed * speed / (9.80665 * math.tan(bank_limit))
    bend = speed * speed * slope / (0.05 * 9.80665)
    base = height / slope + 0.5 * bend + radius + RESERVE
    return {
        "name": f"{_word(model)}_straight_in",
        "draws": 1,
        "aircraft": {"model": model},
        "start": {"phase": "final", "distance_m": base - radius},
        "route": {
            "kind": "pattern",
            "downwind_abeam_m": max(PatternTable().downwind_abeam, TURN_ROOM * radius),
            "base_distance_m": base,
            "downwind_speed_mps": speed,
            "turn_speed_mps": speed,
            "approach_speed_mps": approach,
        },
    }


def _word(model: str) -> str:
    return "fly_" + "".join(c if c.isalnum() else "_" for c in Path(model).name)


def answer(model: str) -> dict[str, Any]:
    """What one aircraft does: a plain table; everything that can be refused ends in its ``reason``."""
    from aircraft.errors import FlightError, ModelError, TrimError
    from aircraft.slowest import flap_settings

    try:
        settings = flap_settings(model)
    except (ModelError, FlightError, TrimError) as error:
        return {"reason": str(error)}
    if not settings:
        return {"reason": _untrimmed(model)}
    known = {"flap_settings": [{"flaps_deg": math.degrees(s.flaps), "slowest_mps": s.stall_speed} for s in settings]}
    manoeuvre, approach = speeds(settings)
    known |= {"speed_mps": manoeuvre, "approach_speed_mps": approach}
    try:
        known["capture"] = _flown(capture(model, manoeuvre))
        known["straight_in"] = _flown(straight_in(model, manoeuvre, approach))
    except ScenarioError as error:
        known["reason"] = str(error)
    return known


def _untrimmed(model: str) -> str:
    return "no trim"


def _flown(tables: dict[str, Any]) -> dict[str, Any]:
    from sim.experiment import fly
    from sim.metrics import flight_metrics
    from sim.preparation import prepare
    from sim.scenario import read

    prepared = prepare(read(tables))
    flight = fly(prepared, 0)
    m = flight_metrics(flight, prepared.scenario.runway, prepared.law.bank_limit)
    return {k: m[k] for k in ("outcome", "overshoot_m", "bank_max_deg", "settling_s") if m.get(k) is not None} | {
        "reason": flight.reason,
        "touchdown": m.get("touchdown"),
        "herr": m.get("height_error_rms_final_m"),
    }


def measured(models: Sequence[str], workers: int = 1) -> Iterator[tuple[str, dict[str, Any]]]:
    """Each aircraft and its answer, as they end; one that kills its process or hangs is answered too."""
    executor = LocalExecutor(workers, time_limit=TIME_LIMIT)
    for number, model in enumerate(models):
        executor.submit(number, answer, model)
    try:
        for number, told in executor.finished():
            yield models[number], {"reason": told.reason} if isinstance(told, Lost) else told
    finally:
        executor.close()


if __name__ == "__main__":
    import json

    for name, told in measured(sys.argv[1:]):
        print(name, json.dumps(told), flush=True)
