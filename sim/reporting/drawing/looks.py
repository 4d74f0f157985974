"""How a mark looks: attributes of strokes and insides, markers, texts, and what a legend shows of a mark."""

from __future__ import annotations

import html
import math

from sim.reporting.drawing.marks import INK, PAPER, Area, Band, Blocks, Line, Mark, Points, Rule
from sim.reporting.drawing.paths import UNIT


def paint(colour: str) -> str:
    """A colour as an attribute has it: ink is what the page writes with."""
    return "currentColor" if colour == INK else colour


def stroke(colour: str, width: float, dashes: tuple[float, ...] = (), butt: bool = False) -> str:
    """Attributes of a stroke; dashes are in widths of the line."""
    text = f' stroke="{paint(colour)}" stroke-width="{UNIT * width:.3g}"'
    if dashes:
        text += f' stroke-dasharray="{" ".join(f"{UNIT * width * dash:.3g}" for dash in dashes)}"'
    return text + (' stroke-linecap="butt"' if dashes or butt else "")


def fill(colour: str) -> str:
    """Attributes of an inside; the colour of paper may be exchanged in the dark."""
    return f' class="paper" fill="{colour}"' if colour in (PAPER, "white") else f' fill="{paint(colour)}"'


def faint(alpha: float) -> str:
    """Attribute of what shines through."""
    return f' opacity="{alpha:g}"' if alpha != 1.0 else ""


def named(label: str) -> str:
    """Attribute by which a script finds what a mark shows."""
    return f' data-name="{escaped(label)}"' if label else ""


def escaped(text: str) -> str:
    """A text that is nothing but text."""
    return html.escape("".join(letter for letter in text if letter >= " " or letter == "\n"), quote=True)


def look_of(mark: Points) -> str:
    """Attributes of markers."""
    if mark.marker in ".o" and not mark.fill:
        return stroke(mark.colour, mark.size * (0.5 if mark.marker == "." else 1.0) + mark.stroke) + named(mark.label)
    inside = fill(mark.fill or mark.colour) if mark.marker not in "x|" else ""
    return inside + stroke(mark.colour, mark.stroke) + named(mark.label)


def shape_of(marker: str, size: float) -> str:
    """A marker about the point where its path begins."""
    h = round(UNIT * size / 2)
    q, s, d = round(h / 2), 2 * h, round(UNIT * size / math.sqrt(2))
    cross = f"{q} {-q} {q} {q} {-q} {q} {q} {q} {-q} {q} {-q} {-q} {-q} {q} {-q} {-q} {q} {-q} {-q} {-q}"
    return {
        "x": f"m{-h} {-h}l{s} {s}m{-s} 0l{s} {-s}",
        "|": f"m0 {-h}v{s}",
        "s": f"m{-h} {-h}h{s}v{s}h{-s}z",
        "D": f"m0 {-d}l{d} {d}l{-d} {d}l{-d} {-d}z",
        "^": f"m0 {-h}l{h} {s}h{-s}z",
        "v": f"m0 {h}l{h} {-s}h{-s}z",
        ">": f"m{h} 0l{-s} {h}v{-s}z",
        "X": f"m0 {-q}l{cross} {q} {-q}z",
    }.get(marker, f"m{-h} 0a{h} {h} 0 1 0 {s} 0a{h} {h} 0 1 0 {-s} 0z")


def text_at(
    text: str,
    x: float,
    y: float,
    size: float,
    anchor: str = "start",
    above: float = 0.0,
    colour: str = INK,
    turn: float = 0.0,
) -> str:
    """A text at a place in points."""
    px, py = round(UNIT * x), round(UNIT * (y + 0.72 * above * size))
    look = f' font-size="{UNIT * size:g}"'
    look += f' text-anchor="{anchor}"' if anchor != "start" else ""
    look += f' fill="{paint(colour)}"' if colour != INK else ""
    look += f' transform="rotate({turn:g} {px} {py})"' if turn else ""
    return f'<text x="{px}" y="{py}"{look}>{escaped(text)}</text>'


def sample(mark: Mark, x: float, y: float, length: float) -> str:
    """What a legend shows of a mark, ``length`` points to the right of a place in points."""
    px, py, pl = round(UNIT * x), round(UNIT * y), round(UNIT * length)
    if isinstance(mark, Line | Rule):
        width = mark.width
        return f'<path d="M{px} {py}h{pl}"{stroke(mark.colour, width, mark.dashes, True)} fill="none"/>'
    if isinstance(mark, Points):
        plain = mark.marker in ".o" and not mark.fill
        shown = mark._replace(size=min(max(mark.size, 7.0 if mark.marker == "." else 4.0), 8.0), label="")
        d = f"M{px + pl // 2} {py}" + ("h0" if plain else shape_of(shown.marker, shown.size))
        return f'<path d="{d}"{look_of(shown)}/>'
    d = f"M{px} {py - 25}h{pl}v50h{-pl}z"
    colour = mark.colours[0] if isinstance(mark, Blocks) else mark.colour
    alpha = mark.alpha if isinstance(mark, Band | Area | Blocks) else 1.0
    return f'<path d="{d}"{fill(colour)}{faint(alpha)}/>'
