"""A drawing as SVG within a page: text stays text, the same drawing gives the same bytes.

Each panel is an ``svg`` of its own that clips what lies outside it, in tenths of a point. It carries its window in the
units of its axes (``data-x0``, ``data-x1`` from left to right, ``data-y0``, ``data-y1`` from below to above, and
``data-x-scale`` and ``data-y-scale`` where they are not linear), and labelled marks carry their name, so that a script
can turn a place into values. ``data-time`` says that x is the time of the flight, ``data-fixed`` that the ticks of x
are names and not numbers. Ink is ``currentColor``; paper, grid, axes, their numbers, the legend within and what may lie
beyond the panel have classes.
"""

from __future__ import annotations

from sim.reporting.drawing import legends
from sim.reporting.drawing.figure import NAMES, Axis, Drawing, Panel
from sim.reporting.drawing.looks import escaped, faint, fill, sample, text_at
from sim.reporting.drawing.marks import PAPER
from sim.reporting.drawing.paths import UNIT
from sim.reporting.drawing.scales import Scale
from sim.reporting.drawing.shapes import Frame, elements

FAMILY = "'Helvetica Neue',Helvetica,Arial,'Liberation Sans','DejaVu Sans',sans-serif"
GRID = "#E4E4E4"
NAME_LEFT, NAME_BELOW = 41.0, 26.0  # points from a panel to the foot of the names of its axes
NAME_RIGHT = 34.0
TIME = "time, s"  # the name of an axis of time
TITLE, NUMBER = 4.0, 6.0  # points between a panel and its title, and its numbers
LINE = 1.05  # of the size, from line to line of one name


def written(drawing: Drawing, title: str) -> str:
    """The element ``svg`` of a drawing; ``title`` is what a screen reader says of it."""
    entries, top = legends.above(drawing)
    wide, high = round(UNIT * drawing.width), round(UNIT * (top + drawing.height))
    pixels = 96 / 72 / UNIT  # of a file that stands alone; a page gives it its own width
    head = (
        f'<svg class="drawing" xmlns="http://www.w3.org/2000/svg" width="{wide * pixels:.0f}" '
        f'height="{high * pixels:.0f}" viewBox="0 0 {wide} {high}" '
        f'role="img" aria-label="{escaped(title)}" font-family="{FAMILY}" fill="currentColor" '
        'stroke-linejoin="round" stroke-linecap="round">'
    )
    return head + _legend(entries) + "".join(_panel(drawing, panel, top) for panel in drawing.panels) + "</svg>"


def _legend(entries: list[legends.Entry]) -> str:
    return "".join(
        sample(one.mark, one.x, one.y, legends.SAMPLE)
        + text_at(one.mark.label, one.x + legends.SAMPLE + legends.AFTER, one.y, one.size, above=0.5)
        for one in entries
    )


def _panel(drawing: Drawing, panel: Panel, top: float) -> str:
    left, above, width, height = panel.box
    x, y = drawing.limits(panel.x), drawing.limits(panel.y)
    frame = Frame(x, y, panel.x.scale, panel.y.scale, (width, height))
    within, free = elements(panel, frame)
    place = f'x="{round(UNIT * left)}" y="{round(UNIT * (top + above))}"'
    size = f'width="{round(UNIT * width)}" height="{round(UNIT * height)}"'
    view = f'viewBox="0 0 {round(UNIT * width)} {round(UNIT * height)}"'
    window = f'data-x0="{x[0]:.7g}" data-x1="{x[1]:.7g}" data-y0="{y[0]:.7g}" data-y1="{y[1]:.7g}"'
    scales = "".join(
        f' data-{name}-scale="{_scale(axis.scale)}"'
        for name, axis in (("x", panel.x), ("y", panel.y))
        if axis.scale.kind != "linear"
    )
    kind = ' data-time=""' if panel.x.label == TIME else ' data-fixed=""' if panel.x.ticks is not None else ""
    text = f'<svg class="panel" {place} {size} {view} preserveAspectRatio="none" {window}{scales}{kind} fill="none">'
    if panel.background:
        text += f'<path d="M0 0h{round(UNIT * width)}v{round(UNIT * height)}H0z"{fill(panel.background)}/>'
    x_ticks = drawing.ticks(panel.x, width, False)
    y_ticks = drawing.ticks(panel.y, height, True)
    if panel.framed:
        text += _grid(panel, frame, x_ticks, y_ticks)
    text += within
    if panel.legend is not None:
        text += _inner_legend(panel)
    text += "</svg>"
    moved = f'<g transform="translate({round(UNIT * left)} {round(UNIT * (top + above))})">'
    outside = _axes(panel, frame, x_ticks, y_ticks) if panel.framed else ""
    if free:
        outside += f'<g class="free">{free}</g>'
    if panel.title:
        outside += text_at(panel.title, 0.0, -TITLE, panel.title_size)
    return text + (f"{moved}{outside}</g>" if outside else "")


def _scale(scale: Scale) -> str:
    return scale.kind if scale.kind == "log" else f"{scale.kind} {scale.linear_to:g} {scale.decades:g}"


def _inner_legend(panel: Panel) -> str:
    assert panel.legend is not None
    entries, box = legends.within(panel, panel.legend)
    if box is None:
        return ""
    left, top, width, height = (round(UNIT * side) for side in box)
    look = fill(PAPER) + faint(0.8 if panel.legend.boxed else 0.6)
    behind = f'<path d="M{left} {top}h{width}v{height}h{-width}z"{look}/>'
    return f'<g class="legend" fill="currentColor">{behind}{_legend(entries)}</g>'


def _grid(panel: Panel, frame: Frame, x_ticks: list[tuple[float, str]], y_ticks: list[tuple[float, str]]) -> str:
    width, height = (round(UNIT * side) for side in frame.size)
    d = ""
    if "x" in panel.grid:
        d += "".join(f"M{UNIT * frame.across(value):.0f} 0v{height}" for value, _ in x_ticks)
    if "y" in panel.grid:
        d += "".join(f"M0 {UNIT * frame.down(value):.0f}h{width}" for value, _ in y_ticks)
    return f'<path class="grid" d="{d}" stroke="{GRID}" stroke-width="5"/>' if d else ""


def _axes(panel: Panel, frame: Frame, x_ticks: list[tuple[float, str]], y_ticks: list[tuple[float, str]]) -> str:
    """The two lines of the axes, their numbers and their names."""
    width, height = frame.size
    across, down = round(UNIT * width), round(UNIT * height)
    d = f"M{across if panel.y_right else 0} 0V{down}M0 {down}h{across}"
    text = f'<path class="axis" d="{d}" fill="none" stroke="currentColor" stroke-width="6"/>'
    with_x, with_y = panel.numbered
    if with_x:
        size = panel.x.size
        text += _group("x-numbers", "middle", size, [
            (float(frame.across(value)), height + NUMBER + 0.72 * size, name) for value, name in x_ticks
        ])  # fmt: skip
        text += _name(panel.x, width / 2, height + NAME_BELOW, 0.0)
    if with_y:
        size, side = panel.y.size, width + NUMBER if panel.y_right else -NUMBER
        text += _group("y-numbers", "start" if panel.y_right else "end", size, [
            (side, float(frame.down(value)) + 0.36 * size, name) for value, name in y_ticks
        ])  # fmt: skip
        text += _name(panel.y, width + NAME_RIGHT if panel.y_right else -NAME_LEFT, height / 2, -90.0)
    return text


def _group(name: str, anchor: str, size: float, places: list[tuple[float, float, str]]) -> str:
    """Numbers of one axis; a name of several lines stands about its place."""
    texts = ""
    for x, y, told in places:
        lines = told.split("\n")
        for row, line in enumerate(lines):
            down = y + (row - (len(lines) - 1) / 2) * LINE * size
            texts += f'<text x="{UNIT * x:.0f}" y="{UNIT * down:.0f}">{escaped(line)}</text>'
    look = f' text-anchor="{anchor}"' if anchor != "start" else ""
    return f'<g class="{name}" font-size="{UNIT * size:g}"{look}>{texts}</g>' if texts else ""


def _name(axis: Axis, x: float, y: float, turn: float) -> str:
    return text_at(axis.label, x, y, axis.label_size or NAMES, "middle", turn=turn) if axis.label else ""
