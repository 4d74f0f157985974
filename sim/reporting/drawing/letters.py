"""How wide a text is, about, before a browser sets it: by the widths of Helvetica, and somewhat wider."""

from __future__ import annotations

NARROW = {**dict.fromkeys("ijl'|.,:;!", 0.26), **dict.fromkeys("tfrI()[]/- ", 0.33)}
WIDE = {**dict.fromkeys("mwMW%", 0.88), **dict.fromkeys("ABCDEFGHJKLNOPQRSTUVXYZ", 0.70)}
WIDTHS = NARROW | WIDE
OTHERS = 0.57
SPARE = 1.08  # the letters of another machine


def width(text: str, size: float) -> float:
    """Points across, at a size in points."""
    return SPARE * size * sum(WIDTHS.get(letter, OTHERS) for letter in text)
