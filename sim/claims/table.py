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


def runs(row: Row, measured: Measured) -> str:
    """Independent runs, flights times the draws of each, or a dash where nothing is random."""
    if measured.runs <= 1:
        return "-"
    return f"{measured.runs} x {row.claim.draws}" if row.claim.draws > 1 else str(measured.runs)


def judged(row: Row) -> str:
    """The verdict, and whether other draws may judge otherwise."""
    if row.verdict is None:
        return "measured"
    return f"{row.verdict}, borderline" if row.borderline else row.verdict


def table(rows: Sequence[Row]) -> str:
    """One line per claim, its other readings below it."""
    lines: list[tuple[str, ...]] = [HEADS]
    for row in rows:
        claim = row.claim
        printed = "-" if claim.printed is None else claim.printed.text
        unit = f" {claim.unit}" if claim.unit else ""
        if not row.measured:
            lines.append((row.paper, claim.name, printed, "-", "-", "-", "-", judged(row)))
        for place, m in enumerate(row.measured):
            first = place == 0
            name = claim.name if first else f"  {m.reading}"
            lead = (row.paper, name, printed + unit if claim.printed else "-") if first else ("", name, "")
            lines.append(
                (
                    *lead,
                    figure(m.value) + unit,
                    interval(m),
                    runs(row, m),
                    claim.truth if first else "",
                    judged(row) if first else "",
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
        six = "" if beside is None else f"{_first(beside, unit=False)}: {judged(beside)}"
        printed = "-" if claim.printed is None else f"{claim.printed.text} {claim.unit}".strip()
        lines.append(f"| {row.paper} | {claim.words} | {printed} | {_first(row)} | {judged(row)} | {six} |")
    return "\n".join(lines)


def _first(row: Row, unit: bool = True) -> str:
    """The reading that a row quotes."""
    if not row.measured:
        return "-"
    m = row.measured[0]
    value = f"{figure(m.value)} {row.claim.unit}".strip() if unit else figure(m.value)
    return f"{value} ({interval(m)})" if m.low != m.high else value
