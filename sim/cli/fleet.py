"""The fleet: every aircraft of JSBSim through the same design, each in a worker process that it may crash.

``python -m sim.cli.fleet`` writes two tables that travel with the package: what stock models say of their own speeds
(``aircraft/models/stock.toml``) and how each of them flew (``sim/cli/fleet.toml``); with names it renews their rows.
``python -m sim.cli.fleet --root DIR`` flies every aircraft in a folder of others into ``out/fleet.toml``, with repairs.
"""

from __future__ import annotations

import math
import os
import sys
import time
import tomllib
from collections.abc import Callable, Iterator, Sequence
from pathlib import Path
from typing import Any

from aircraft.errors import FlightError, ModelError, TrimError
from sim.cli.doctor import reason
from sim.errors import ScenarioError, did_you_mean
from sim.scenario import toml_writer as toml
from sim.workers.executors import LocalExecutor, Lost

TABLE = Path(__file__).parent / "fleet.toml"
DEEPEST = 4  # folders in one another where aircraft of others are sought
OTHERS = Path("out") / "fleet.toml"
AIRCRAFT_TIME_LIMIT = 600.0  # s of one aircraft
OFFSET = 3000.0  # m, from which the line is captured
SPEED_MARGIN = 1.02  # of the manoeuvring speed over the least for which the flaps are set
TURN_ROOM = 2.5  # radii of the turns between downwind and final
RESERVE = 1500.0  # m of final between the last turn and the glide path
HEAD = (
    "# Written by `make fleet`: stock aircraft of JSBSim through the recipe of the An-26, nothing set by hand.\n"
    "# Speeds are indicated; they follow from the slowest level flight of each model. Measured under these versions.\n"
)


# ---- what an aircraft is asked to fly ----------------------------------------------------------------------------


def speeds(settings: Sequence[Any]) -> tuple[float, float]:
    """(manoeuvring, approach) indicated airspeed, m/s, from the flap settings of an aircraft."""
    from autopilot.landing import REFERENCE_MARGIN
    from sim.flight.airspeeds import MANOEUVRE_MARGIN, REFERENCE_ADDITION

    ordered = sorted(settings, key=lambda setting: setting.flaps)
    approach = REFERENCE_MARGIN * ordered[-1].stall_speed + REFERENCE_ADDITION
    return max(SPEED_MARGIN * MANOEUVRE_MARGIN * ordered[len(ordered) // 2].stall_speed, approach), approach


def _aircraft(model: str, repaired: bool) -> dict[str, Any]:
    return {"model": model, "repairs": True} if repaired else {"model": model}


def route_capture(model: str, speed: float, repaired: bool = False) -> dict[str, Any]:
    """Tables of a scenario that captures one line from ``OFFSET``, as ``route_capture`` does with the An-26."""
    duration = 120.0 + 3.0 * OFFSET / speed
    leg = {"from_m": [0, 0], "to_m": [speed * (duration + 60.0), 0], "indicated_speed_mps": speed, "height_m": 600}
    return {
        "name": "fleet_route_capture",
        "until_s": duration,
        "draws": 1,
        "aircraft": _aircraft(model, repaired),
        "start": {"leg": 0, "cross_track_m": OFFSET},
        "route": {"kind": "legs", "legs": [leg]},
    }


def straight_in(model: str, speed: float, approach: float, repaired: bool = False) -> dict[str, Any]:
    """Tables of a scenario that begins on a long final and lands; distances grow with the radius of the turns."""
    from aircraft.air import Air
    from aircraft.state import STANDARD_GRAVITY
    from autopilot.landing import Landing
    from sim.scenario.tables import AutopilotTable, PatternTable, Runway

    pattern, slope = PatternTable(), math.tan(Runway().glide_path)
    true = speed / Air().equivalent_share(pattern.height)
    radius = true * true / (STANDARD_GRAVITY * math.tan(AutopilotTable().bank_limit))
    bend = true * true * slope / (Landing.capture_load_factor * STANDARD_GRAVITY)
    straight = pattern.height / slope + 0.5 * bend + RESERVE
    return {
        "name": "fleet_straight_in",
        "draws": 1,
        "aircraft": _aircraft(model, repaired),
        "start": {"phase": "final", "distance_m": straight},
        "route": {
            "kind": "pattern",
            "downwind_abeam_m": max(pattern.downwind_abeam, TURN_ROOM * radius),
            "base_distance_m": straight + radius,
            "indicated_downwind_speed_mps": speed,
            "indicated_turn_speed_mps": speed,
            "indicated_approach_speed_mps": approach,
        },
    }


# ---- what it answers, in its worker process ----------------------------------------------------------------------


def described(model: str, repaired: bool = False) -> dict[str, Any]:
    """Flap settings and slowest speeds of a model by trims, or the reason why there are none."""
    from aircraft.airframe import load
    from aircraft.slowest import flap_settings as measured
    from aircraft.slowest import why_not

    try:
        settings = measured(model, repaired)
        told = {"repairs": list(load(model, repaired=repaired).repairs)}
        if not settings:
            return told | {"reason": why_not(load(model, repaired=repaired))}
    except (ModelError, FlightError, TrimError) as error:
        return {"reason": reason(error)}
    return told | {
        "flap_settings": [
            {"flaps_deg": round(math.degrees(s.flaps), 2), "slowest_mps": round(s.stall_speed, 2)} for s in settings
        ]
    }


def converged(model: str) -> dict[str, Any]:
    """The rate of the equations of motion of an aircraft, and how far lower ones are from the finest."""
    from aircraft.slowest import complete
    from sim.studies.convergence import converged_rate

    try:
        rate, found = converged_rate(straight_in(model, *_rounded(*speeds(complete(model).flap_settings))))
    except (ModelError, FlightError, TrimError, ScenarioError, ValueError) as error:
        return {"reason": reason(error)}
    far = {f"at_{one.rate:.0f}_hz": [round(one.difference, 4), one.figure, one.air] for one in found}
    return {"rate_hz": rate} | far


def _rounded(manoeuvre: float, approach: float) -> tuple[float, float]:
    return max(round(manoeuvre, 1), math.ceil(10.0 * approach) / 10.0), round(approach, 1)


def flown(model: str, repaired: bool = False) -> dict[str, Any]:
    """The capture of a line and the straight-in approach of an aircraft, and its modes, as a plain table."""
    from aircraft.airframe import load
    from aircraft.slowest import complete

    try:
        airframe, known = load(model, repaired=repaired), complete(model, repaired)
        manoeuvre, approach = _rounded(*speeds(known.flap_settings))
    except (ModelError, FlightError, TrimError) as error:
        return {"reason": reason(error)}
    told: dict[str, Any] = {
        "mass_kg": round(airframe.mass),
        "speed_mps": manoeuvre,
        "approach_speed_mps": approach,
    }
    for name, tables in (
        ("route_capture", route_capture(model, manoeuvre, repaired)),
        ("straight_in", straight_in(model, manoeuvre, approach, repaired)),
    ):
        try:
            told |= _flight(name, tables)
        except (ScenarioError, ValueError, FlightError) as error:
            told[name] = {"outcome": "refused", "reason": reason(error)}
    return told


def _flight(name: str, tables: dict[str, Any]) -> dict[str, Any]:
    from sim.experiment import fly, read
    from sim.flight.preparation import prepare
    from sim.metrics.flight import flight_metrics

    prepared = prepare(read(tables))
    flight = fly(prepared, 0)
    m = flight_metrics(flight, prepared.scenario.runway, prepared.law.bank_limit)
    told = {key: m[key] for key in ("outcome", "reason", "bank_max_deg", "overshoot_m", "height_error_rms_final_m")}
    touchdown = (
        {f"touchdown_{key}": m["touchdown"][key] for key in ("sink_mps", "past_threshold_m")} if m["touchdown"] else {}
    )
    modes = _modes(prepared) if name == "route_capture" else {}
    return {name: {key: round(v, 2) if isinstance(v, float) else v for key, v in (told | touchdown).items()}} | modes


def _modes(prepared: Any) -> dict[str, Any]:
    """Natural frequency and damping of the oscillations, time constants of the rest, on the leg of the capture."""
    from aircraft.airframe import load
    from aircraft.linearise import linearise
    from aircraft.modes import modes
    from aircraft.trim import trim

    leg = prepared.route.legs[0]
    airframe = load(prepared.scenario.aircraft.model, repaired=prepared.scenario.aircraft.repairs)
    try:
        found = modes(linearise(airframe, trim(airframe, leg.speed, 0.0, leg.height, prepared.autopilot.flaps)))
    except (ValueError, TrimError) as error:
        return {"modes": {"reason": str(error)}}
    return {
        "modes": {
            each.name.lower().replace(" ", "_"): [round(each.natural_frequency, 3), round(each.damping, 3)]
            if each.root.imag
            else [round(each.time_constant, 2)]
            for each in found
        }
    }


# ---- all of them -------------------------------------------------------------------------------------------------


def answers(
    ask: Callable[[str], dict[str, Any]],
    models: Sequence[str],
    workers: int = 1,
    time_limit: float = AIRCRAFT_TIME_LIMIT,
) -> Iterator[tuple[str, dict[str, Any]]]:
    """Each aircraft and its answer, as they end; one that kills its process or hangs gets an answer too."""
    executor = LocalExecutor(workers, time_limit=time_limit)
    for number, model in enumerate(models):
        executor.submit(number, ask, model)
    try:
        for number, told in executor.finished():
            yield models[number], {"reason": told.reason} if isinstance(told, Lost) else told
    finally:
        executor.close()


def write(models: Sequence[str], workers: int = 1) -> None:
    """Measure stock aircraft and write both tables; rows of others stay while the versions are the same."""
    from aircraft.stock import STOCK_TABLE
    from sim.versions import versions

    under = {"versions": {key: versions()[key] for key in ("shortfinal", "jsbsim")}}
    facts = dict(_shown(answers(described, models, workers), len(models)))
    known = {name: {"flap_settings": facts[name]["flap_settings"]} for name in models if "flap_settings" in facts[name]}
    others = {name: row for name, row in _kept(STOCK_TABLE, under).items() if name not in facts}
    STOCK_TABLE.write_text(HEAD + toml.dumps(under | dict(sorted((others | known).items()))), encoding="utf-8")
    rates = dict(_shown(answers(converged, list(known), workers), len(known)))
    known = {name: _with_rate(row, rates.get(name, {})) for name, row in known.items()}
    STOCK_TABLE.write_text(HEAD + toml.dumps(under | dict(sorted((others | known).items()))), encoding="utf-8")
    results = dict(_shown(answers(flown, list(known), workers), len(known)))
    rows = {name: _row(facts[name], results.get(name, {}), rates.get(name)) for name in models}
    others = _kept(TABLE, under).get("aircraft", {})
    TABLE.write_text(HEAD + toml.dumps(under | {"aircraft": dict(sorted((others | rows).items()))}), encoding="utf-8")


def _kept(path: Path, under: dict[str, Any]) -> dict[str, Any]:
    """Rows of a table, without its versions; none where the versions differ."""
    table = tomllib.loads(path.read_text(encoding="utf-8")) if path.is_file() else {}
    return table if table.pop("versions", None) == under["versions"] else {}


def _with_rate(row: dict[str, Any], converged: dict[str, Any]) -> dict[str, Any]:
    return ({"rate_hz": converged["rate_hz"]} if "rate_hz" in converged else {}) | row


def _row(facts: dict[str, Any], result: dict[str, Any], converged: dict[str, Any] | None) -> dict[str, Any]:
    reason = facts.get("reason") or result.get("reason")
    return {"reason": reason, "repairs": facts.get("repairs") or None} | result | {"converged": converged}


def _shown(found: Iterator[tuple[str, dict[str, Any]]], total: int) -> Iterator[tuple[str, dict[str, Any]]]:
    started = time.monotonic()
    for number, (name, told) in enumerate(found, 1):
        capture = told.get("route_capture", {})
        end = told.get("reason") or capture.get("outcome") or f"{len(told.get('flap_settings', []))} flap settings"
        print(f"{time.monotonic() - started:6.0f} s  {number}/{total}  {name}: {end}", file=sys.stderr, flush=True)
        yield name, told


def found_in(root: Path) -> list[str]:
    """Every aircraft of a folder and what lies in it, as a scenario names it; links are left alone."""
    from aircraft.model_files import candidates

    found: list[str] = []
    for place, inside, _ in os.walk(root.absolute()):
        found += map(str, candidates(Path(place)))
        if len(Path(place).relative_to(root.absolute()).parts) == DEEPEST:
            inside.clear()
    return sorted(found)


def of_others(models: Sequence[str]) -> Iterator[tuple[str, dict[str, Any]]]:
    """What each aircraft says and how it flew, with repairs; one that aborts or hangs is answered by what it did."""
    from sim.scenario.reading import read
    from sim.workers.isolation import run_isolated

    for model in models:
        told: dict[str, Any] = {}
        try:
            scenario = read({"name": "fleet", "aircraft": _aircraft(model, True)})
            for ask in (described, flown):
                told |= run_isolated(scenario, AIRCRAFT_TIME_LIMIT, ask, model, True)
                if "reason" in told:
                    break
        except ScenarioError as error:
            told["reason"] = reason(error)
        yield model, told


def fly_others(root: Path, to: Path) -> None:
    """Fly every aircraft of a folder and write what each answered."""
    models = found_in(root)
    if not models:
        raise SystemExit(f"no aircraft in '{root}'")
    rows = {}
    for model, told in _shown(of_others(models), len(models)):
        rows[str(Path(model).relative_to(root.absolute()))] = {key: value for key, value in told.items() if value}
        to.parent.mkdir(parents=True, exist_ok=True)
        to.write_text(toml.dumps({"aircraft": rows}), encoding="utf-8")


def main(names: Sequence[str]) -> None:
    """Measure the named stock aircraft, or all, into the tables; or those of a folder of others."""
    from aircraft.model_files import available

    if len(names) == 2 and names[0] == "--root":
        return fly_others(Path(names[1]), OTHERS)
    stock = [name for name, origin in available().items() if origin.startswith("stock")]
    unknown = [name for name in names if name not in stock]
    if unknown:
        raise SystemExit(f"no stock aircraft '{unknown[0]}'; {did_you_mean(unknown[0], stock)}")
    write(names or stock)


if __name__ == "__main__":
    from sim.cli import fleet  # workers find its functions by this name

    fleet.main(sys.argv[1:])
