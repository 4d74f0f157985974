"""The result of a run, or of a study, in a few lines of plain text."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

from sim.cli.text_table import table
from sim.metrics.checks import broken, broken_in_study
from sim.metrics.conformance import conformance_sentence
from sim.metrics.navigation import beside

MOST_REASONS = 3  # of flights that crashed, or were refused
SHOWN = {"position_m", "cross_track_m"}  # where a tracker has them; the report has every channel


def summary(metrics: dict[str, Any], said: Sequence[str] = ()) -> str:
    """One sentence on what happened, the trackers, the checks as an aligned table, warnings that are not yet said."""
    flight = metrics["flight"]
    lines = [f"{metrics['scenario']}: {flight['reason']} ({flight['duration_s']:.0f} s, seed {metrics['seed']})"]
    why = (flight.get("navigated") or {}).get("why")
    lines += [f"why: {why}"] if why else []
    if metrics["flights"] > 1:
        outcomes = metrics["flights_summary"]["outcomes"]
        lines.append(
            f"{metrics['flights']} flights: " + ", ".join(f"{n} {name}" for name, n in sorted(outcomes.items()))
        )
    rows = [
        (name, channel, figure["rmse"], figure["raw"], figure["gain"])
        for name, tracker in metrics["trackers"].items()
        for channel, figure in tracker["overall"].items()
        if channel in SHOWN or not SHOWN & set(tracker["overall"])
    ]
    if rows:
        header = ["tracker", "channel", "rmse", "raw", "gain"]
        lines += ["", *table([header, *([*row[:2], *map(_number, row[2:])] for row in rows)], 2)]
    twin = beside(flight)
    if twin:
        header = ["beside the same approach", "on the estimate", "on the truth"]
        lines += ["", *table([header, *([name, *map(_number, values)] for name, *values in twin)], 1)]
    alerts = {name: tracker.get("conformance") for name, tracker in metrics["trackers"].items()}
    if any(alerts.values()):
        lines += ["", *(conformance_sentence(name, found) for name, found in alerts.items() if found)]
    if metrics["checks"]:
        header = ["check", "value", "limit", "margin", ""]
        shown = [
            [check["name"], *(_number(check[key]) for key in ("value", "limit", "margin")), _verdict(check)]
            for check in metrics["checks"]
        ]
        lines += ["", *table([header, *shown], 1)]
    failed = [check for check in metrics["checks"] if check["passed"] is False]
    if failed:
        lines += ["", *map(broken, failed)]
    lines += [f"warning: {warning}" for warning in metrics["warnings"] if warning not in said]
    return "\n".join(lines)


def _verdict(check: dict[str, Any]) -> str:
    if check["passed"] is None:
        return "not flown"
    return "passed" if check["passed"] else "FAILED"


def _number(value: float | str | None) -> str:
    if isinstance(value, str):
        return value
    return "-" if value is None else f"{value:.4g}"


def study_summary(metrics: dict[str, Any]) -> str:
    """How all flights ended, then the checks as an aligned table."""
    ended = ", ".join(f"{count} {name}" for name, count in sorted(metrics["outcomes"].items()))
    lines = [f"{metrics['scenario']}: {metrics['flights']} flights in {len(metrics['rows'])} cells: {ended}"]
    for outcome, name in (("crashed", "crashes"), ("refused", "refusals")):
        lines += [f"{outcome}: {reason}" for reason in metrics.get(name, ())[:MOST_REASONS]]
    if metrics["checks"]:
        header = ["check", "flights", "within", "value", "limit", "margin", ""]
        lines += ["", *table([header, *map(_shown, metrics["checks"])], 1)]
    failed = [check for check in metrics["checks"] if check["passed"] is False]
    if failed:
        lines += ["", *map(broken_in_study, failed)]
    return "\n".join(lines)


def _shown(check: dict[str, Any]) -> list[Any]:
    numbers = ["-" if check[key] is None else f"{check[key]:.4g}" for key in ("value", "limit", "margin")]
    verdict = {None: "not flown", True: "passed", False: "FAILED"}[check["passed"]]
    return [check["name"], check["flights"], check["within"], *numbers, verdict]
