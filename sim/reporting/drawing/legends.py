"""Where the entries of a legend stand: in rows above the panels, or in a corner of one.

How wide a text is, before a browser sets it, is told by the widths of Helvetica, and somewhat more.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

from sim.reporting.drawing.figure import NUMBERS, Box, Drawing, Legend, Panel
from sim.reporting.drawing.marks import Mark

SAMPLE, AFTER, BETWEEN = 13.0, 4.0, 10.0  # points: a sample, the room behind it, and between two entries
LINE = 1.35  # of the size of the text: from one row to the next
SQUEEZED = 0.85  # least share of the size of text that is made smaller to fit one row
ROOM, EDGE = 3.0, 3.0  # points: below the rows above the panels, and about a legend within

NARROW = {**dict.fromkeys("ijl'|.,:;!", 0.26), **dict.fromkeys("tfrI()[]/- ", 0.33)}
WIDE = {**dict.fromkeys("mwMW%", 0.88), **dict.fromkeys("ABCDEFGHJKLNOPQRSTUVXYZ", 0.70)}
WIDTHS = NARROW | WIDE
OTHERS = 0.57
SPARE = 1.08  # the letters of another machine


class Entry(NamedTuple):
    """One labelled mark of a legend, in points: the left end of its sample and the middle of its row."""

    mark: Mark
    x: float
    y: float
    size: float


def above(drawing: Drawing) -> tuple[list[Entry], float]:
    """Entries of the rows above the panels, from the left edge of those, and the height that they take."""
    left = min(panel.box.left for panel in drawing.panels)
    most = drawing.width - left - 2.0
    found: list[Entry] = []
    y = EDGE
    for row in drawing.legend:
        if not row:
            continue
        size = NUMBERS
        text = sum(width(mark.label, size) for mark in row)
        room = most - (sum(_room(mark, size) for mark in row) - BETWEEN - text)  # for the text alone
        if SQUEEZED * text <= room < text:
            size *= room / text
        x = left
        for mark in row:
            if x > left and x + _room(mark, size) - BETWEEN > left + most + 0.1:
                x, y = left, y + LINE * size
            found.append(Entry(mark, x, y + LINE * size / 2, size))
            x += _room(mark, size)
        y += LINE * size
    return found, y + ROOM if found else 0.0


def _room(mark: Mark, size: float) -> float:
    return SAMPLE + AFTER + width(mark.label, size) + BETWEEN


def within(panel: Panel, legend: Legend) -> tuple[list[Entry], Box | None]:
    """Entries of a legend in a panel, and the box about them, from the upper left corner of the panel."""
    shown = panel.labelled
    if not shown:
        return [], None
    shown = shown[::-1] if legend.reverse else shown
    columns = min(legend.columns, len(shown))
    deep = -(-len(shown) // columns)
    table = [shown[place : place + deep] for place in range(0, len(shown), deep)]
    widths = [max(_room(mark, legend.size) for mark in column) for column in table]
    line = LINE * legend.size if not legend.boxed else 1.2 * legend.size
    total, high = sum(widths) - BETWEEN, deep * line
    left = panel.box.width - EDGE - total if "right" in legend.corner else EDGE
    top = EDGE if "upper" in legend.corner else panel.box.height - EDGE - high
    if legend.corner == "left":
        top = (panel.box.height - high) / 2
    found, x = [], left
    for column, wide in zip(table, widths, strict=True):
        found += [Entry(mark, x, top + (row + 0.5) * line, legend.size) for row, mark in enumerate(column)]
        x += wide
    return found, Box(left - 2.0, top - 1.0, total + 4.0, high + 2.0)


def entries_of(panels: Sequence[Panel]) -> list[Mark]:
    """Labelled marks of several panels, each label once."""
    found: dict[str, Mark] = {}
    for panel in panels:
        for mark in panel.labelled:
            found.setdefault(mark.label, mark)
    return [*found.values()]


def width(text: str, size: float) -> float:
    """Points across, at a size in points."""
    return SPARE * size * sum(WIDTHS.get(letter, OTHERS) for letter in text)
