"""The ledger as an aligned table for a terminal, and its summary for Markdown."""

from __future__ import annotations

import math
from collections.abc import Sequence

from sim.claims.ledger import Measured, Row

FLOWN = "_jsbsim"  # ends the names of claims that are measured on JSBSim flights too
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
    """The judged claims as a Markdown table, a claim on JSBSim flights beside the same on its own truth."""
    flown = {(row.paper, row.claim.name.removesuffix(FLOWN)): row for row in rows if row.claim.name.endswith(FLOWN)}
    lines = ["| paper | claim | printed | measured | verdict | on JSBSim |", "|---|---|---|---|---|---|"]
    for row in rows:
        claim = row.claim
        if row.verdict is None or claim.name.endswith(FLOWN):
            continue
        beside = flown.get((row.paper, claim.name))
        six = "" if beside is None else f"{_first(beside, ends=False)}: {beside.verdict}"
        printed = "-" if claim.printed is None else f"{claim.printed.text} {claim.unit}".strip()
        lines.append(f"| {row.paper} | {claim.words} | {printed} | {_first(row)} | {row.verdict} | {six} |")
    return "\n".join(lines)


def _first(row: Row, ends: bool = True) -> str:
    """The reading that a row quotes."""
    if not row.measured:
        return "-"
    m = row.measured[0]
    value = f"{figure(m.value)} {row.claim.unit}".strip() if ends else figure(m.value)
    return f"{value} ({interval(m)})" if ends and m.low != m.high else value
