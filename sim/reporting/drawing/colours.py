"""Numbers as colours, and the scale beside a map that names them."""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from sim.reporting.drawing.figure import Axis, Box, Drawing, Panel

STEPS = 64  # colours of a scale
ROOM, APART, WIDTH = 58.0, 8.0, 10.0  # points: of a scale with its name, from the panels to its colours, of these


class Colours(NamedTuple):
    """A map of the numbers from ``low`` to ``high`` to colours that change evenly between some."""

    between: Sequence[str]
    low: float
    high: float

    def of(self, values: np.ndarray) -> list[str]:
        """The colour of each number; "" for one that is not finite."""
        known = np.array([[int(one[i : i + 2], 16) for i in (1, 3, 5)] for one in self.between], float)
        flat = np.ravel(values)
        share = np.clip((flat - self.low) / ((self.high - self.low) or 1.0), 0.0, 1.0) * (len(known) - 1)
        seen = np.isfinite(flat)
        parts = [np.interp(np.where(seen, share, 0.0), np.arange(len(known)), known[:, i]) for i in range(3)]
        red, green, blue = np.round(parts).astype(int).tolist()
        found = zip(red, green, blue, seen.tolist(), strict=True)
        return [f"#{r:02X}{g:02X}{b:02X}" if finite else "" for r, g, b, finite in found]


# Brewer's diverging set of blue and red; the perceptual set of van der Walt and Smith, every sixteenth
BLUE_RED = (
    "#053061", "#2166AC", "#4393C3", "#92C5DE", "#D1E5F0", "#F7F7F7", "#FDDBC7", "#F4A582", "#D6604D", "#B2182B",
    "#67001F",
)  # fmt: skip
VIRIDIS = (
    "#440154", "#481A6C", "#472F7D", "#414487", "#39568C", "#31688E", "#2A788E", "#23888E", "#1F988B", "#22A884",
    "#35B779", "#54C568", "#7AD151", "#A5DB36", "#D2E21B", "#FDE725",
)  # fmt: skip


def mixed(colour: str, share: float) -> str:
    """A colour thinned by paper."""
    parts = (int(colour[i : i + 2], 16) for i in (1, 3, 5))
    return "#" + "".join(f"{round(255 + share * (part - 255)):02X}" for part in parts)


def cells(panel: Panel, x: np.ndarray, y: np.ndarray, colours: Sequence[str]) -> None:
    """Fill the cells between the edges ``x`` and ``y`` (row by row over x) with colours; "" leaves one out."""
    left, low = np.meshgrid(x[:-1], y[:-1])
    right, high = np.meshgrid(x[1:], y[1:])
    kept = np.array([bool(colour) for colour in colours])
    x0, x1, y0, y1 = (side.ravel()[kept] for side in (left, right, low, high))
    panel.blocks(x0, x1, y0, y1, [*filter(None, colours)])


def add_scale(
    drawing: Drawing,
    colours: Colours,
    label: str,
    ticks: Sequence[tuple[float, str]] | None = None,
) -> None:
    """Name the colours at the right of all panels, which give up the room for it."""
    first = min(panel.box.left for panel in drawing.panels)
    last = max(panel.box.left + panel.box.width for panel in drawing.panels)
    kept = (drawing.width - ROOM - first) / (last - first)
    for panel in drawing.panels:
        left, top, width, height = panel.box
        panel.box = Box(first + (left - first) * kept, top, width * kept, height)
    top = min(panel.box.top for panel in drawing.panels)
    bottom = max(panel.box.top + panel.box.height for panel in drawing.panels)
    y = Axis()
    y.label, y.ticks, y.limits = label, ticks, (colours.low, colours.high)
    x = Axis()
    x.limits, x.ticks = (0.0, 1.0), ()
    scale = Panel(Box(drawing.width - ROOM + APART, top, WIDTH, bottom - top), x, y)
    scale.grid, scale.y_right = "", True
    edges = np.linspace(colours.low, colours.high, STEPS + 1)
    cells(scale, np.array([0.0, 1.0]), edges, colours.of((edges[:-1] + edges[1:]) / 2))
    drawing.panels.append(scale)
