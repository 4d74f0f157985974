"""Aligned tables of plain text."""

from __future__ import annotations

from typing import Any


def table(rows: list[Any], words: int) -> list[str]:
    """Aligned columns: the first ``words`` and the last of a table of verdicts to the left, numbers to the right."""
    widths = [max(len(str(row[i])) for row in rows) for i in range(len(rows[0]))]
    lines = []
    for row in rows:
        cells = [f"{c:<{w}}" if i < words else f"{c:>{w}}" for i, (c, w) in enumerate(zip(row, widths, strict=True))]
        lines.append("  ".join(cells).rstrip())
    return lines
