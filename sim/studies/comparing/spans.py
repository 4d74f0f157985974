"""The difference of two means with an interval, and the probability of one so large by chance."""

from __future__ import annotations

import math
from typing import NamedTuple

from sim.studies.comparing.evidence import Evidence


class Span(NamedTuple):
    """A difference, b less a, and where it lies; NaN where too few flights say nothing of it."""

    difference: float
    low: float
    high: float
    probability: float  # that chance alone makes any of all metrics stand out so far

    @property
    def known(self) -> bool:
        """Whether there is an interval."""
        return math.isfinite(self.low) and math.isfinite(self.high)

    @property
    def changed(self) -> bool:
        """Whether it is beyond noise."""
        return self.known and not self.low <= 0.0 <= self.high


def span(found: Evidence, error: float, probability: float) -> Span:
    """Of the arrangement at hand, with an interval that misses with a probability of ``error``."""
    from scipy.special import stdtrit

    difference, variance, freedom, middle = (float(part[0]) for part in found)
    if math.isnan(variance):
        return Span(difference, math.nan, math.nan, math.nan)
    half = -float(stdtrit(freedom, 0.5 * error)) * math.sqrt(variance)
    low, high = middle - half, middle + half
    if math.isinf(freedom):  # of shares
        low, high = max(low, -1.0), min(high, 1.0)
    return Span(difference, low, high, probability)
