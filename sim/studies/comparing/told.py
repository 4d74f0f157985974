"""A comparison as text: what moved, then the method."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from sim.studies.comparing.comparison import Comparison, Row

HEAD = ("metric", "a", "b", "difference", "low", "high", "")
Aligned = Callable[[list[Any], int], list[str]]


def told(found: Comparison, aligned: Aligned, every: bool = False) -> list[str]:
    """Lines of the rows that changed or are beyond tolerance, or of ``every`` row; ``aligned`` makes a table."""
    shown = [row for row in found.rows if every or row.changed or row.beyond]
    lines = aligned([HEAD, *map(_cells, shown)], 1) if shown else []
    return [*lines, *([""] if shown else []), *(f"warning: {remark}" for remark in found.remarks), found.method]


def verdict(found: Comparison, judged: bool) -> str:
    """The last line: how many metrics changed, and how many are beyond their tolerance."""
    known = sum(row.span is not None and row.span.known for row in found.rows)
    words = f"{len(found.changed)} of {known} metrics changed beyond noise"
    return f"{words}; {len(found.beyond)} beyond tolerance" if judged else words


def _cells(row: Row) -> tuple[str, ...]:
    name = row.metric if not row.cell else f"{row.metric} (cell {row.cell})"
    span = ("-",) * 3 if row.span is None else tuple(_number(x) if x == x else "-" for x in row.span)
    words = "BEYOND" if row.beyond else "changed" if row.changed else ""
    return name, _number(row.a), _number(row.b), *span, words


def _number(value: float | None) -> str:
    return "-" if value is None else f"{value:.4g}"
