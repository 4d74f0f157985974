"""A comparison as text: what moved, then the method."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from sim.studies.comparing.comparison import Comparison, Row

HEAD = ("metric", "a", "b", "difference", "low", "high", "")
FEW = 3  # metrics that are shown where all together differ and none by itself
Aligned = Callable[[list[Any], int], list[str]]


def told(found: Comparison, aligned: Aligned, every: bool = False) -> list[str]:
    """Lines of the rows that changed or are beyond tolerance, or of ``every`` row; ``aligned`` makes a table."""
    shown = [row for row in found.rows if every or row.changed or row.beyond]
    if found.differs and not found.changed and not every:
        shown = [row for row in found.rows if row in shown or row in _foremost(found)]
    lines = aligned([HEAD, *map(_cells, shown)], 1) if shown else []
    return [*lines, *([""] if shown else []), *(f"warning: {remark}" for remark in found.remarks), found.method]


def verdict(found: Comparison, judged: bool) -> str:
    """The last line: how many metrics changed, and how many are beyond their tolerance."""
    known = sum(row.span is not None and row.span.known for row in found.rows)
    words = f"{len(found.changed)} of {known} metrics changed beyond noise"
    if found.differs and not found.changed:
        words = f"all {known} metrics together differ beyond noise, though none by itself"
    if known:
        words += f" (p = {found.probability:.2g})"
    return f"{words}; {len(found.beyond)} beyond tolerance" if judged else words


def _foremost(found: Comparison) -> list[Row]:
    """The metrics that chance explains least."""
    known = [row for row in found.rows if row.span is not None and row.span.known]
    return sorted(known, key=lambda row: row.span.probability if row.span is not None else 1.0)[:FEW]


def _cells(row: Row) -> tuple[str, ...]:
    name = row.metric if not row.cell else f"{row.metric} (cell {row.cell})"
    span = ("-",) * 3 if row.span is None else tuple(_number(x) if x == x else "-" for x in row.span[:3])
    words = "BEYOND" if row.beyond else "changed" if row.changed else ""
    return name, _number(row.a), _number(row.b), *span, words


def _number(value: float | None) -> str:
    return "-" if value is None else f"{value:.4g}"
