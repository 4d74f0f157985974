"""The rule that turns what was printed and what was measured into a verdict: nobody writes one by hand.

Each reading of a text is judged by its point estimate, inside what is printed, above it or below it:

- all inside: reproduced; some inside: qualified;
- none inside, all on the side that is better than printed: exceeded;
- none inside, all on a side that is not: refuted; of a neutral number neither side is better;
- none inside, some above and some below: not reproducible, since what lies between may have been meant;
- nothing printed, or nothing measured: not testable here.

Of several printed values each has its own claim. A row is borderline where the interval of a reading reaches across an
end of what is printed and the verdict hangs on it: other draws may judge otherwise.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from decimal import Decimal
from typing import NamedTuple

RESOLUTION = 0.01  # of its natural scale: as far as a figure is read, or a sentence that something is nothing
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
    """A single number: all that rounds or truncates to its digits; raises ``ValueError`` for a zero, see `zero`."""
    value = Decimal(text)
    if not value:
        raise ValueError(f"'{text}' has no digits that say how small is small: give the scale of what is nothing")
    digit = Decimal((0, (1,), int(value.as_tuple().exponent)))
    low, high = value - digit / 2, value + digit
    if value < 0:
        low, high = value - digit, value + digit / 2
    return Printed(text, float(low), math.nextafter(float(high), -math.inf), good)


def zero(scale: float, good: int = 0) -> Printed:
    """A printed 0, or a sentence such as "both are the same": within a hundredth of the natural scale of the quantity.

    What rounds to a bare 0 hangs on the unit: 0.4 is 0 in per cent and 40 per cent is 0 as a share. So the row names
    the ``scale``, in its own unit: 1 (or 100 %) for a probability, what an excess is relative to for an excess.
    """
    return Printed("0", -RESOLUTION * scale, RESOLUTION * scale, good)


def above(threshold: float, text: str = "") -> Printed:
    """A claim of order, such as better or worse: a ratio above 1, or a share above 0."""
    return Printed(text or f"> {threshold:g}", math.nextafter(threshold, math.inf), math.inf)


def at_most(limit: float) -> Printed:
    """A claim that something suffices."""
    return Printed(f"<= {limit:g}", -math.inf, limit)


def verdict(values: Sequence[float], printed: Printed | None) -> str:
    """Judge the point estimates of all readings of the text; NaN is a reading that nothing was measured of."""
    sides = [] if printed is None else [printed.side(value) for value in values if not math.isnan(value)]
    if printed is None or not sides:
        return NOT_TESTABLE
    if 0 in sides:
        return QUALIFIED if any(sides) else REPRODUCED
    if len(set(sides)) > 1:
        return NOT_REPRODUCIBLE
    return EXCEEDED if sides[0] == printed.good else REFUTED


def borderline(intervals: Sequence[tuple[float, float, float]], printed: Printed | None) -> bool:
    """Whether the verdict hangs on where in its interval a reading lies; intervals are (value, low, high)."""
    values = [value for value, _, _ in intervals]
    judged = verdict(values, printed)
    return any(
        verdict([*values[:place], end, *values[place + 1 :]], printed) != judged
        for place, (_, *ends) in enumerate(intervals)
        for end in ends
        if not math.isnan(end)
    )
