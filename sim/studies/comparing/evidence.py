"""What one metric says of a change, in the arrangement at hand and in others: a difference of means and its error."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

ROUNDING = 1e-9  # of the size of the values; two processors differ by no more
LEAST = 1e-300  # probability, of a difference without any spread


class Evidence(NamedTuple):
    """Of each arrangement, shape (arrangements,)."""

    difference: np.ndarray  # of the means, b less a
    variance: np.ndarray  # of that difference; NaN where too few flights tell
    freedom: np.ndarray  # degrees of Student's distribution; infinite = normal
    middle: np.ndarray  # of an interval; the difference, but for answers

    @property
    def probability(self) -> np.ndarray:
        """Two-sided, of a middle so far from 0 by chance; 1 where nothing is known, or nothing differs."""
        from scipy.special import stdtr

        with np.errstate(divide="ignore", invalid="ignore"):
            ratio = np.abs(self.middle) / np.sqrt(self.variance)
            found = np.maximum(2.0 * stdtr(self.freedom, -ratio), LEAST)
        return np.where(np.isnan(ratio), 1.0, found)


def of_pairs(sides: np.ndarray, a: np.ndarray, b: np.ndarray) -> Evidence:
    """Student's, of the mean of the differences of n pairs.

    Parameters
    ----------
    sides : (arrangements, n) of the flights of B
    a, b : (n,) of A and of B
    """
    n = len(a)
    apart = np.where(np.abs(b - a) <= ROUNDING * np.maximum(np.abs(a), np.abs(b)), 0.0, b - a)
    mean = sides @ apart / n
    square = float(np.mean(apart**2))
    variance = np.maximum(square - mean**2, 0.0) / (n - 1) if n > 1 else np.full(len(mean), np.nan)
    return Evidence(mean, _rounded(variance, square), np.full(len(mean), n - 1.0), mean)


def of_sides(sides: np.ndarray, values: np.ndarray) -> Evidence:
    """Welch's, of the means of independent flights.

    Parameters
    ----------
    sides : (arrangements, flights)
    values : (flights,); NaN where a flight does not say
    """
    said = ~np.isnan(values)
    centre = float(np.mean(values[said]))
    known = np.where(said, values - centre, 0.0)
    size = float(np.max(np.abs(values[said])))
    counts, means, parts = [], [], []
    for of_side in (sides < 0, sides > 0):
        n = of_side @ said.astype(float)
        mean = of_side @ known / np.maximum(n, 1.0)
        spread = np.maximum(of_side @ known**2 / np.maximum(n, 1.0) - mean**2, 0.0)
        parts.append(np.where(n > 1.0, _rounded(spread, size**2) / np.maximum(n - 1.0, 1.0), np.nan))
        counts.append(n)
        means.append(mean)
    apart = np.where(np.abs(means[1] - means[0]) <= ROUNDING * size, 0.0, means[1] - means[0])
    variance = parts[0] + parts[1]
    with np.errstate(divide="ignore", invalid="ignore"):
        freedom = variance**2 / sum(part**2 / (n - 1.0) for part, n in zip(parts, counts, strict=True))
    return Evidence(apart, variance, np.where(np.isfinite(freedom), freedom, 1.0), apart)


def of_answers(sides: np.ndarray, values: np.ndarray) -> Evidence:
    """Of answers of yes (1) or no (0): Agresti and Caffo's, as of independent flights; arguments as ``of_sides``.

    They add a success and a failure to each side [The American Statistician 54, 2000], since the variance of a share
    of which all flights agree is not nothing.
    """
    said = ~np.isnan(values)
    yes = np.where(said, values, 0.0)
    plain, shares, variance = [], [], np.zeros(len(sides))
    for of_side in (sides < 0, sides > 0):
        n, count = of_side @ said.astype(float), of_side @ yes
        share = (count + 1.0) / (n + 2.0)
        plain.append(count / np.maximum(n, 1.0))
        shares.append(share)
        variance += share * (1.0 - share) / (n + 2.0)
    return Evidence(plain[1] - plain[0], variance, np.full(len(sides), np.inf), shares[1] - shares[0])


def _rounded(variance: np.ndarray, square: float) -> np.ndarray:
    """A variance without what rounding leaves of one that is nothing."""
    return np.where(variance <= ROUNDING**2 * square, 0.0, variance)
