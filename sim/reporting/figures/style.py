"""How figures look: colours that the colour-blind can tell apart, text that prints on A4, one way to embed."""

from __future__ import annotations

import base64
import contextlib
import gc
import io
import logging
import os
import sys
import tempfile
from collections.abc import Iterator
from pathlib import Path
from typing import TYPE_CHECKING, Any, NamedTuple

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

WIDTH = 7.2  # in, of every figure: the text width of an A4 page
LEFT, RIGHT, TOP, BOTTOM, GAP = 0.68, 0.12, 0.10, 0.40, 0.10  # in, so that the time axes of all figures agree

# Okabe and Ito's set, without the yellow that vanishes on white
BLACK, ORANGE, SKY, GREEN = "#000000", "#E69F00", "#56B4E9", "#009E73"
BLUE, VERMILION, PURPLE, GREY = "#0072B2", "#D55E00", "#CC79A7", "#8A8A8A"
LIGHT = "#E4E4E4"
SHADE = "#DFE6EC"
TRACKERS = (BLUE, VERMILION, GREEN, ORANGE, PURPLE, SKY, "#332288", "#7A5230", "#999933", "#444444")
SOLID, DASHED = (None, None), (3.2, 1.6)
DARK = (BLACK, BLUE, VERMILION, GREEN)  # on which text is white

PHASE_COLOURS = {
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
    "vectors": BLUE,
    "capture": VERMILION,
}

_STYLE: dict[Any, object] = {  # by the keys of matplotlib, which not all of its versions type
    "font.family": "sans-serif",
    "font.size": 8.0,
    "axes.labelsize": 8.0,
    "axes.titlesize": 8.0,
    "axes.titlelocation": "left",
    "axes.linewidth": 0.6,
    "axes.spines.top": False,
    "axes.spines.right": False,
    "axes.grid": True,
    "axes.axisbelow": True,
    "axes.formatter.useoffset": False,
    "grid.color": LIGHT,
    "grid.linewidth": 0.5,
    "lines.linewidth": 1.1,
    "lines.solid_capstyle": "round",
    "xtick.labelsize": 7.5,
    "ytick.labelsize": 7.5,
    "xtick.bottom": False,  # the grid marks the places; a mark less is a tenth of a second less
    "ytick.left": False,
    "legend.fontsize": 7.5,
    "legend.frameon": False,
    "legend.handlelength": 1.6,
    "legend.borderaxespad": 0.2,
    "legend.borderpad": 0.2,
    "svg.fonttype": "none",  # text stays text: smaller, sharper, readable by a screen reader
    "svg.hashsalt": "shortfinal",
    "path.simplify": True,
    "text.parse_math": False,
}


class Chart(NamedTuple):
    """A figure with what the reader should see in it."""

    title: str
    image: str  # data URI
    caption: str
    keys: tuple[tuple[str, str, bool], ...] = ()  # (name, colour, whether dashed) of its lines, named by the page


def phase_colour(name: str) -> str:
    """The colour of a phase, the same in every figure."""
    return PHASE_COLOURS.get(name, GREY)


def import_matplotlib() -> None:
    """Import matplotlib so that it leaves nothing in the user's home: its list of fonts is made in a temporary folder.

    A list that an earlier use of matplotlib left is read, which is faster and writes nothing.
    """
    if "matplotlib.font_manager" in sys.modules or "MPLCONFIGDIR" in os.environ:
        return
    cache = Path(os.environ.get("XDG_CACHE_HOME") or Path.home() / ".cache") / "matplotlib"
    if any(cache.glob("fontlist-*.json")):
        return
    with tempfile.TemporaryDirectory() as place:
        os.environ["MPLCONFIGDIR"] = place
        try:
            import matplotlib.font_manager  # noqa: F401 (for what it writes)
        finally:
            del os.environ["MPLCONFIGDIR"]


def get_ready() -> None:
    """Import now what the first figure would import."""
    import_matplotlib()
    import matplotlib.backends.backend_svg
    import matplotlib.figure  # noqa: F401


@contextlib.contextmanager
def drawing() -> Iterator[None]:
    """Within, matplotlib draws in this style without its messages about fonts; afterwards the user's settings hold."""
    logger = logging.getLogger("matplotlib")
    level = logger.level
    logger.setLevel(logging.ERROR)
    gc.freeze()  # what a run left need not be searched for garbage again and again while figures come and go
    try:
        import_matplotlib()
        import matplotlib

        with matplotlib.rc_context():
            matplotlib.rcdefaults()
            matplotlib.rcParams.update(_STYLE)
            yield
    finally:
        gc.unfreeze()
        logger.setLevel(level)


def panels(
    *heights: float, share: bool = True, top: float = TOP, bottom: float = BOTTOM, gap: float = GAP
) -> tuple[Figure, list[Axes]]:
    """A figure of the page's width with axes of the given heights (in) below each other on one x axis."""
    from matplotlib.figure import Figure

    height = top + sum(heights) + gap * (len(heights) - 1) + bottom
    figure, edge = Figure((WIDTH, height)), height - top
    axes: list[Axes] = []
    for panel in heights:
        edge -= panel
        box = (LEFT / WIDTH, edge / height, (WIDTH - LEFT - RIGHT) / WIDTH, panel / height)
        axes.append(figure.add_axes(box, sharex=axes[0] if share and axes else None))
        axes[-1].yaxis.set_label_coords(-0.56 / (WIDTH - LEFT - RIGHT), 0.5)  # fixed places align and cost nothing
        axes[-1].xaxis.set_label_coords(0.5, -0.28 / panel)
        edge -= gap
    for upper in axes[:-1] if share else ():
        upper.tick_params(labelbottom=False)
    return figure, axes


def grid(
    rows: int, columns: int, height: float, top: float = TOP, own_scales: bool = False
) -> tuple[Figure, list[Axes]]:
    """A figure of small axes of one height (in) in rows and columns, all on the scales of the first.

    With ``own_scales`` only the time is shared, and each has room for the numbers at its left.
    """
    from matplotlib.figure import Figure

    row = height + 0.22  # room for a title
    total = top + rows * row + BOTTOM
    figure = Figure((WIDTH, total))
    axes: list[Axes] = []
    gap = LEFT - RIGHT if own_scales else GAP
    width = (WIDTH - LEFT - RIGHT - gap * (columns - 1)) / columns
    for place in range(rows * columns):
        down, across = divmod(place, columns)
        left, bottom = LEFT + across * (width + gap), total - top - (down + 1) * row
        box = (left / WIDTH, bottom / total, width / WIDTH, height / total)
        first = axes[0] if axes else None
        axes.append(figure.add_axes(box, sharex=first, sharey=None if own_scales else first))
        axes[-1].tick_params(labelleft=own_scales or across == 0, labelbottom=down == rows - 1)
        axes[-1].yaxis.set_label_coords(-0.56 / width, 0.5)
        axes[-1].xaxis.set_label_coords(0.5, -0.28 / height)
    return figure, axes


def data_uri(figure: Figure) -> str:
    """The figure as an SVG data URI; the same figure gives the same bytes."""
    buffer = io.BytesIO()
    figure.savefig(buffer, format="svg", metadata={"Date": None, "Creator": None})
    return "data:image/svg+xml;base64," + base64.b64encode(buffer.getvalue()).decode()
