"""The result of a run in a few lines of plain text."""

from __future__ import annotations

from typing import Any


def summary(metrics: dict[str, Any]) -> str:
    """One sentence on what happened, the trackers, then the checks as an aligned table."""
    flight = metrics["flight"]
    lines = [f"{metrics['scenario']}: {flight['reason']} ({flight['duration_s']:.0f} s, seed {metrics['seed']})"]
    if metrics["flights"] > 1:
        outcomes = metrics["flights_summary"]["outcomes"]
        lines.append(
            f"{metrics['flights']} flights: " + ", ".join(f"{n} {name}" for name, n in sorted(outcomes.items()))
        )
    rows = [
        (name, channel, figure["rmse"], figure["raw"], figure["gain"])
        for name, tracker in metrics["trackers"].items()
        for channel, figure in tracker["overall"].items()
    ]
    if rows:
        table = [("tracker", "channel", "rmse", "raw", "gain"), *([*r[:2], *map(_number, r[2:])] for r in rows)]
        lines += ["", *_table(table, 2)]
    if metrics["checks"]:
        header = ("check", "value", "limit", "margin", "")
        table = [
            header,
            *(
                [c["name"], *map(_number, (c["value"], c["limit"], c["margin"])), _verdict(c)]
                for c in metrics["checks"]
            ),
        ]
        lines += ["", *_table(table, 1)]
    return "\n".join(lines)


def _verdict(check: dict[str, Any]) -> str:
    if check["passed"] is None:
        return "not flown"
    return "passed" if check["passed"] else "FAILED"


def _number(value: float | None) -> str:
    return "-" if value is None else f"{value:.4g}"


def _table(rows: list[Any], words: int) -> list[str]:
    """Aligned columns: the first ``words`` and the last of a table of verdicts to the left, numbers to the right."""
    widths = [max(len(str(row[i])) for row in rows) for i in range(len(rows[0]))]
    lines = []
    for row in rows:
        cells = [f"{c:<{w}}" if i < words else f"{c:>{w}}" for i, (c, w) in enumerate(zip(row, widths, strict=True))]
        lines.append("  ".join(cells).rstrip())
    return lines
