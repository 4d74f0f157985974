"""One sentence that says what happened."""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from aircraft.state import parts
from sim.flight.record import Flight
from sim.reporting.text.labels import duration, number

NARROW = 0.05  # m; nearer to a line than this is on it
REPEATING = ("at ", "flown ", "still flying")  # reasons that say no more than the time


def what_happened(flight: Flight, figures: dict[str, Any], checks: list[dict[str, Any]]) -> str:
    """How the flight ended, where and how it touched down, and whether the checks held.

    ``figures`` and ``checks`` are those of metrics.json.
    """
    return f"{how_it_ended(flight, figures)}; {_verdict(checks)}."


def how_it_ended(flight: Flight, figures: dict[str, Any]) -> str:
    """When the flight ended, where and how it touched down; without a full stop. Of an unknown one there is no more
    than how long its plots are."""
    if not flight.known:
        return f"{duration(figures['duration_s'])} of recorded plots, {flight.reason}"
    ending = _ending(flight, figures.get("touchdown")) + _rollout(flight, figures.get("rollout"))
    return f"After {duration(figures['duration_s'])} {ending}"


def _ending(flight: Flight, touchdown: dict[str, float] | None) -> str:
    outcome, reason = flight.outcome, first_clause(flight.reason)
    if touchdown and outcome in ("landed", "ground"):
        if outcome == "landed":
            return f"the aircraft landed {_touchdown(touchdown)}{_first(flight)}"
        return f"the aircraft did not land: it {reason or f'touched down {_touchdown(touchdown)}'}"
    told = {
        "ground": "the aircraft hit the ground",
        "orbit": "the flight was ended because the aircraft orbits instead of reaching its leg",
        "diverged": "the flight diverged",
        "envelope": "the aircraft left its flight envelope",
        "go_around": "the aircraft had gone around and climbed away",
        "completed": "the flight was complete",
        "landed": "the aircraft landed",
        "time_limit": "the flight was ended by the time limit",
    }.get(outcome, f"the flight ended as '{outcome}'")
    if reason and not reason.startswith(REPEATING):
        return f"{told} ({reason})"
    return told + _beside_its_leg(flight)


def _rollout(flight: Flight, rollout: dict[str, float] | None) -> str:
    """Where it came to a stop after a landing, or what happened instead; nothing where there was no roll-out."""
    if flight.rollout is None or flight.is_recorded:
        return ""
    if not rollout or rollout["distance_m"] is None:
        return f"; in the roll-out it was not brought to a stop on the runway ({first_clause(flight.rollout.reason)})"
    return f" and came to a stop {rollout['distance_m']:.0f} m later"


def _beside_its_leg(flight: Flight) -> str:
    """Where the flight ended relative to the leg it was on; nothing where that is not known."""
    across = float(flight.deviation.cross_track[-1])
    if not math.isfinite(across):
        return ""
    return f" with the aircraft {_side(across, 'its leg')}"


def _side(across: float, line: str) -> str:
    if abs(across) < NARROW:
        return f"on {line}"
    return f"{number(abs(across), 1)} m {'right' if across > 0 else 'left'} of {line}"


def _touchdown(touchdown: dict[str, float]) -> str:
    past, across = touchdown["past_threshold_m"], touchdown["cross_track_m"]
    where = f"{abs(past):.0f} m {'past' if past >= 0 else 'before'} the threshold"
    return f"{where}, {_side(across, 'the centreline')}, sinking at {number(touchdown['sink_mps'], 2)} m/s"


def _first(flight: Flight) -> str:
    """What touched the ground first; nothing where the record does not tell."""
    first = np.max(flight.state.first_contact)
    return f", {parts(first)} first" if first else ""


def _verdict(checks: list[dict[str, Any]]) -> str:
    judged = [check for check in checks if check["passed"] is not None]
    failed = [check["name"] for check in judged if not check["passed"]]
    if not judged:
        return "the scenario has no checks" if not checks else "no check could be judged"
    over = f"over all {checks[0]['flights']} flights " if checks[0]["flights"] > 1 else ""
    if failed:
        return f"{over}{len(failed)} of {len(judged)} checks failed"
    held = {1: "its one check held", 2: "both checks held"}.get(len(judged), f"all {len(judged)} checks held")
    return over + held


def first_clause(reason: str) -> str:
    """The reason without the dump of a last state that may follow it."""
    return reason.partition("; last state")[0]
