"""The ledger as an aligned table for a terminal, and its summary for Markdown."""

from __future__ import annotations

import math
from collections.abc import Sequence

from sim.claims.ledger import Measured, Row

HEADS = ("paper", "claim", "printed", "measured", "95 % interval", "n", "truth", "verdict")


def figure(value: float) -> str:
    """Four significant digits."""
    if not math.isfinite(value):
        return "-"
    return f"{value:.4g}" if abs(value) < 1e4 else f"{value:.3e}"


def interval(measured: Measured) -> str:
    """Its ends, or a dash where nothing is random."""
    return "-" if measured.low == measured.high else f"{figure(measured.low)} to {figure(measured.high)}"


def table(rows: Sequence[Row]) -> str:
    """One line per claim, its other readings below it."""
    lines: list[tuple[str, ...]] = [HEADS]
    for row in rows:
        claim = row.claim
        printed = "-" if claim.printed is None else claim.printed.text
        judged = row.verdict or "measured"
        unit = f" {claim.unit}" if claim.unit else ""
        if not row.measured:
            lines.append((row.paper, claim.name, printed, "-", "-", "-", "-", judged))
        for place, m in enumerate(row.measured):
            first = place == 0
            name = claim.name if first else f"  {m.reading}"
            lead = (row.paper, name, printed + unit if claim.printed else "-") if first else ("", name, "")
            runs = str(m.runs) if m.low != m.high else "-"
            lines.append(
                (
                    *lead,
                    figure(m.value) + unit,
                    interval(m),
                    runs,
                    claim.truth if first else "",
                    judged if first else "",
                )
            )
    widths = [max(len(line[i]) for line in lines) for i in range(len(HEADS))]
    return "\n".join(
        "  ".join(cell.ljust(width) for cell, width in zip(line, widths, strict=True)).rstrip() for line in lines
    )


def summary(rows: Sequence[Row]) -> str:
    """The judged claims as a Markdown table."""
    lines = ["| paper | claim | printed | measured | verdict |", "|---|---|---|---|---|"]
    for row in rows:
        if row.verdict is None:
            continue
        claim, m = row.claim, row.measured[0] if row.measured else None
        value = "-" if m is None else f"{figure(m.value)} {claim.unit}".strip()
        if m is not None and m.low != m.high:
            value += f" ({interval(m)})"
        printed = "-" if claim.printed is None else f"{claim.printed.text} {claim.unit}".strip()
        lines.append(f"| {row.paper} | {claim.words} | {printed} | {value} | {row.verdict} |")
    return "\n".join(lines)
