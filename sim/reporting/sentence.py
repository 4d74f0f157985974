"""One sentence that says what happened."""

from __future__ import annotations

from typing import Any

from sim.reporting.quantities import duration, number

NARROW = 0.05  # m; nearer the centreline than this is on it


def what_happened(flight: dict[str, Any], checks: list[dict[str, Any]]) -> str:
    """How the flight ended, where and how it touched down, and whether the checks held."""
    return f"{_ending(flight)}; {_verdict(checks)}."


def _ending(flight: dict[str, Any]) -> str:
    span, reason = duration(flight["duration_s"]), _first_clause(flight.get("reason", ""))
    outcome, touchdown = flight["outcome"], flight.get("touchdown")
    if outcome in ("landed", "ground") and touchdown:
        verb = "landed" if outcome == "landed" else "touched the ground, but did not land:"
        return f"After {span} the aircraft {verb} {_touchdown(touchdown)}"
    told = {
        "landed": "the aircraft landed",
        "ground": "the aircraft hit the ground",
        "orbit": "the flight was ended because the aircraft orbits instead of reaching its leg",
        "diverged": "the flight diverged",
        "envelope": "the aircraft left its flight envelope",
        "go_around": "the aircraft had gone around and climbed away",
        "completed": "the aircraft had flown what the scenario asks for",
        "time_limit": "the flight was ended by the time limit",
    }.get(outcome, f"the flight ended as '{outcome}'")
    return f"After {span} {told}{f' ({reason})' if reason and _adds(reason) else ''}"


def _touchdown(touchdown: dict[str, float]) -> str:
    past, across = touchdown["past_threshold_m"], touchdown["cross_track_m"]
    where = f"{abs(past):.0f} m {'past' if past >= 0 else 'before'} the threshold"
    if abs(across) < NARROW:
        beside = "on the centreline"
    else:
        beside = f"{number(abs(across), 1)} m {'right' if across > 0 else 'left'} of the centreline"
    return f"{where}, {beside}, sinking at {number(touchdown['sink_mps'], 2)} m/s"


def _verdict(checks: list[dict[str, Any]]) -> str:
    judged = [check for check in checks if check["passed"] is not None]
    failed = [check["name"] for check in judged if not check["passed"]]
    if not judged:
        return "the scenario has no checks" if not checks else "no check could be judged"
    if failed:
        return f"{len(failed)} of {len(judged)} checks failed"
    return "its one check held" if len(judged) == 1 else f"all {len(judged)} checks held"


def _first_clause(reason: str) -> str:
    """The reason without the dump of a last state that may follow it."""
    return reason.partition("; last state")[0]


def _adds(reason: str) -> bool:
    """Whether the reason says more than the time, which the sentence has already."""
    return not reason.startswith(("at ", "flown until", "still flying"))
