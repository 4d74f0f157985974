"""The rule that turns what was printed and what was measured into a verdict: nobody writes one by hand."""

from __future__ import annotations

import math
from collections.abc import Sequence
from decimal import Decimal
from typing import NamedTuple

REPRODUCED, QUALIFIED, EXCEEDED = "reproduced", "qualified", "exceeded"
REFUTED, NOT_REPRODUCIBLE, NOT_TESTABLE = "refuted", "not reproducible", "not testable here"


class Printed(NamedTuple):
    """All values that agree with the print, both ends included, and on which side of them is better than printed."""

    text: str
    low: float
    high: float
    good: int = 0  # +1 above, -1 below, 0 neither

    def side(self, value: float) -> int:
        """-1 below what is printed, 0 within, +1 above."""
        return (value > self.high) - (value < self.low)

    def settled(self, low: float, high: float) -> bool:
        """Whether an interval is narrow enough: a tenth of the range, or clear of its ends by its own width.

        The second serves what lies far from the range, and ranges that are open.
        """
        width = high - low
        narrow = math.isfinite(self.high - self.low) and width <= 0.1 * (self.high - self.low)
        apart = low - width > self.high or high + width < self.low
        within = math.isinf(self.high - self.low) and self.side(low - width) == self.side(high + width) == 0
        return narrow or apart or within


def between(low: str, high: str, good: int = 0) -> Printed:
    """A printed range, as it stands."""
    return Printed(f"{low} to {high}", float(low), float(high), good)


def number(text: str, good: int = 0) -> Printed:
    """A single number: all that rounds or truncates to its digits."""
    value = Decimal(text)
    digit = Decimal((0, (1,), int(value.as_tuple().exponent)))
    low, high = value - digit / 2, value + digit
    if value < 0:
        low, high = value - digit, value + digit / 2
    return Printed(text, float(low), math.nextafter(float(high), -math.inf), good)


def above(threshold: float, text: str = "") -> Printed:
    """A claim of order, such as better or worse: a ratio above 1, or a share above 0."""
    return Printed(text or f"> {threshold:g}", math.nextafter(threshold, math.inf), math.inf)


def at_most(limit: float) -> Printed:
    """A claim that something suffices."""
    return Printed(f"<= {limit:g}", -math.inf, limit)


def verdict(values: Sequence[float], printed: Printed | None) -> str:
    """Judge the point estimates of all readings of the text."""
    sides = [] if printed is None else [printed.side(value) for value in values if math.isfinite(value)]
    if printed is None or not sides:
        return NOT_TESTABLE
    if 0 in sides:
        return QUALIFIED if any(sides) else REPRODUCED
    if len(set(sides)) > 1:
        return NOT_REPRODUCIBLE
    return EXCEEDED if sides[0] == printed.good else REFUTED
