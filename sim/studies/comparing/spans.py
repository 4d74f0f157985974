"""The difference of two means with an interval, so wide that it covers at a level given for one of many."""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

ROUNDING = 1e-9  # of the size of the values; two processors differ by no more


class Span(NamedTuple):
    """A difference, b less a, and where it lies; NaN where too few flights say nothing of it."""

    difference: float
    low: float
    high: float

    @property
    def known(self) -> bool:
        """Whether there is an interval."""
        return math.isfinite(self.low) and math.isfinite(self.high)

    @property
    def changed(self) -> bool:
        """Whether it is beyond noise."""
        return self.known and not self.low <= 0.0 <= self.high


def paired(a: np.ndarray, b: np.ndarray, level: float) -> Span:
    """Of the same n flights: Student's interval of the mean of their differences."""
    apart = np.where(_equal(a, b), 0.0, b - a)
    return _student(
        float(np.mean(apart)), float(np.var(apart, ddof=1)) / len(a) if len(a) > 1 else math.nan, len(a) - 1, level
    )


def unpaired(a: np.ndarray, b: np.ndarray, level: float) -> Span:
    """Of n and m independent flights: Welch's interval; of answers of yes or no that of Agresti and Caffo.

    The latter adds a success and a failure to each side [The American Statistician 54, 2000], since the variance of a
    share of which all flights agree is not nothing.
    """
    if set(np.unique(np.concatenate((a, b)))) <= {0.0, 1.0}:
        return _shares(a, b, level)
    if len(a) < 2 or len(b) < 2:
        return Span(float(np.mean(b) - np.mean(a)), math.nan, math.nan)
    parts = [float(np.var(one, ddof=1)) / len(one) for one in (a, b)]
    squares = sum(part**2 / (len(one) - 1) for part, one in zip(parts, (a, b), strict=True))
    freedom = sum(parts) ** 2 / squares if squares > 0.0 else 1.0
    difference = 0.0 if _equal(np.mean(a), np.mean(b)).all() else float(np.mean(b) - np.mean(a))
    return _student(difference, sum(parts), freedom, level)


def _shares(a: np.ndarray, b: np.ndarray, level: float) -> Span:
    from scipy.stats import norm

    shares = [(float(np.sum(one)) + 1.0) / (len(one) + 2.0) for one in (a, b)]
    variance = sum(p * (1.0 - p) / (len(one) + 2.0) for p, one in zip(shares, (a, b), strict=True))
    half = float(norm.ppf(0.5 + 0.5 * level)) * math.sqrt(variance)
    middle = shares[1] - shares[0]
    return Span(float(np.mean(b) - np.mean(a)), max(middle - half, -1.0), min(middle + half, 1.0))


def _student(difference: float, variance: float, freedom: float, level: float) -> Span:
    from scipy.stats import t

    if math.isnan(variance):
        return Span(difference, math.nan, math.nan)
    half = float(t.ppf(0.5 + 0.5 * level, freedom)) * math.sqrt(variance)
    return Span(difference, difference - half, difference + half)


def _equal(a: np.ndarray, b: np.ndarray) -> np.ndarray:
    return np.asarray(np.abs(b - a) <= ROUNDING * np.maximum(np.abs(a), np.abs(b)))
