"""How figures look: colours that the colour-blind can tell apart, text that prints on A4, places of their panels."""

from __future__ import annotations

from typing import NamedTuple

from sim.reporting.drawing.figure import Axis, Box, Drawing, Panel
from sim.reporting.drawing.marks import INK

INCH = 72.0  # points
WIDTH = 7.2  # in, of every figure: the text width of an A4 page
LEFT, RIGHT, TOP, BOTTOM, GAP = 0.68, 0.12, 0.10, 0.40, 0.10  # in, so that the time axes of all figures agree
TITLE = 0.22  # in, room for the title of a small panel

# Okabe and Ito's set, without the yellow that vanishes on white
BLACK, ORANGE, SKY, GREEN = INK, "#E69F00", "#56B4E9", "#009E73"
BLUE, VERMILION, PURPLE, GREY = "#0072B2", "#D55E00", "#CC79A7", "#8A8A8A"
LIGHT = "#E4E4E4"
SHADE = "#DFE6EC"
TRACKERS = (BLUE, VERMILION, GREEN, ORANGE, PURPLE, SKY, "#332288", "#7A5230", "#999933", "#444444")
SOLID: tuple[float, ...] = ()
BROKEN, DOTTED = (3.7, 1.6), (1.0, 1.65)  # in widths of the line, of theory and limits
DASHES = ((3.2, 1.6), (1.5, 1.1), (6.5, 1.6))  # in widths of the line, of mismatched laws
DOT_DASHES = (SOLID, (7.0, 1.5, 1.2, 1.5), (7.0, 1.5, 1.2, 1.5, 1.2, 1.5))  # once all colours are taken, once more
SHARES = ((0.0, "0"), (0.5, "0.5"), (1.0, "1"))  # ticks of a probability
DARK = (BLACK, BLUE, VERMILION, GREEN)  # on which text is white

PHASE_COLOURS = {
    "vectors": BLUE,
    "capture": VERMILION,
    "established": GREEN,
    "intercept": GREY,
    "downwind": BLUE,
    "base_turn": ORANGE,
    "base": SKY,
    "final_turn": VERMILION,
    "final": GREEN,
    "glide": PURPLE,
    "flare": BLACK,
    "ground": GREY,
    "go_around": VERMILION,
    "rollout": ORANGE,
}


class Key(NamedTuple):
    """A line that the page names beside a figure, where a reader of a telephone can read it."""

    name: str
    colour: str
    dashes: tuple[float, ...] = SOLID  # in widths of the line


class Chart(NamedTuple):
    """A figure with what the reader should see in it."""

    title: str
    figure: Drawing
    caption: str
    keys: tuple[Key, ...] = ()


def phase_colour(name: str) -> str:
    """The colour of a phase, the same in every figure."""
    return PHASE_COLOURS.get(name, GREY)


def panels(
    *heights: float, share: bool = True, top: float = TOP, bottom: float = BOTTOM, gap: float = GAP
) -> tuple[Drawing, list[Panel]]:
    """A figure of the page's width with panels of the given heights (in) below each other on one x axis."""
    total = top + sum(heights) + gap * (len(heights) - 1) + bottom
    found: list[Panel] = []
    edge, x = top, Axis()
    for height in heights:
        box = Box(LEFT * INCH, edge * INCH, (WIDTH - LEFT - RIGHT) * INCH, height * INCH)
        found.append(Panel(box, x if share else None))
        edge += height + gap
    for upper in found[:-1] if share else ():
        upper.numbered = False, True
    return Drawing(WIDTH * INCH, total * INCH, found), found


def grid(
    rows: int, columns: int, height: float, top: float = 0.0, own_scales: bool = False
) -> tuple[Drawing, list[Panel]]:
    """A figure of small panels of one height (in) in rows and columns with titles, all on the same axes.

    With ``own_scales`` only the time is shared, and each has room for the numbers at its left.
    """
    row = height + TITLE
    found: list[Panel] = []
    gap = LEFT - RIGHT if own_scales else GAP
    width = (WIDTH - LEFT - RIGHT - gap * (columns - 1)) / columns
    x, y = Axis(), Axis()
    for place in range(rows * columns):
        down, across = divmod(place, columns)
        left, upper = LEFT + across * (width + gap), top + down * row + TITLE
        box = Box(left * INCH, upper * INCH, width * INCH, height * INCH)
        found.append(Panel(box, x, None if own_scales else y))
        found[-1].numbered = down == rows - 1, own_scales or across == 0
    return Drawing(WIDTH * INCH, (top + rows * row + BOTTOM) * INCH, found), found


def frame(panel: Panel, middle: tuple[float, float], scale: float) -> None:
    """A map about ``middle`` at so many of its units per inch; right of the course is down, as in the plan view."""
    across, down = (scale * side / INCH / 2 for side in (panel.box.width, panel.box.height))
    panel.x.limits = middle[0] - across, middle[0] + across
    panel.y.limits = middle[1] + down, middle[1] - down


def end_columns(figure: Drawing, count: int, columns: int) -> None:
    """Keep the first panels of a grid; the last of each column has the numbers of x."""
    figure.panels = figure.panels[:count]
    for panel in figure.panels[-columns:]:
        panel.numbered = True, panel.numbered[1]
