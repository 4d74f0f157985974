"""The result of a study in a few lines of plain text."""

from __future__ import annotations

from typing import Any

from sim.cli.run_summary import table
from sim.metrics.check_words import broken_in_study


def study_summary(metrics: dict[str, Any]) -> str:
    """How all flights ended, then the checks as an aligned table."""
    ended = ", ".join(f"{count} {name}" for name, count in sorted(metrics["outcomes"].items()))
    lines = [f"{metrics['scenario']}: {metrics['flights']} flights in {len(metrics['rows'])} cells: {ended}"]
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
