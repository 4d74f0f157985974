"""Drawings as a page holds them, and what lies in their panels, for tests that read what is drawn."""

from __future__ import annotations

import re
from typing import Any

from sim.reporting.drawing.figure import Panel

DRAWING = re.compile(r'<svg class="drawing".*?</svg>(?=\s*<figcaption)', re.DOTALL)


def drawings(page: str) -> list[str]:
    """Every drawing of a page: each stands before its caption."""
    return DRAWING.findall(page)


def marks(panel: Panel, kind: type) -> list[Any]:
    """The marks of one kind in a panel."""
    return [mark for mark in panel.marks if isinstance(mark, kind)]
