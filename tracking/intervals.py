"""Values measured on independent runs, with their confidence intervals, and the bands of what is consistent.

Errors of one run are correlated in time, runs are not: every interval here is over runs.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Any, NamedTuple

import numpy as np
from scipy import special

Array = Any


class Interval(NamedTuple):
    """A measured value with its confidence interval; the ends are NaN where one run says nothing about them."""

    value: float
    low: float
    high: float
    runs: int  # independent samples behind it

    def contains(self, value: float) -> bool:
        """Whether the interval holds ``value``."""
        return self.low <= value <= self.high


def mean_interval(samples: Array, level: float = 0.95) -> Interval:
    """Mean of independent samples (N,) with Student's interval."""
    samples = _finite(samples)
    count = len(samples)
    if count == 0:
        return Interval(math.nan, math.nan, math.nan, 0)
    mean = float(samples.mean())
    if count == 1:
        return Interval(mean, math.nan, math.nan, 1)
    half = float(special.stdtrit(count - 1, 0.5 + 0.5 * level) * samples.std(ddof=1) / math.sqrt(count))
    return Interval(mean, mean - half, mean + half, count)


def rmse(mean_squares: Array, level: float = 0.95) -> Interval:
    """Root mean square error from the mean squared error of each run (N,), with a chi-square interval.

    The degrees of freedom are Satterthwaite's, ``2 N mean^2 / variance``: N d for one epoch of d independent Gaussian
    components of equal variance, fewer where errors are correlated, unequal or heavy-tailed.
    """
    samples = _finite(mean_squares)
    count = len(samples)
    if count == 0:
        return Interval(math.nan, math.nan, math.nan, 0)
    mean = float(samples.mean())
    value = math.sqrt(mean)
    if count == 1:
        return Interval(value, math.nan, math.nan, 1)
    spread = float(samples.var(ddof=1))
    if spread <= 1e-24 * mean * mean:  # all runs alike
        return Interval(value, value, value, count)
    freedom = 2.0 * mean * mean * count / spread
    low, high = (chi_square(0.5 + side * level, freedom) for side in (-0.5, 0.5))
    return Interval(value, math.sqrt(mean * freedom / high), math.sqrt(mean * freedom / low), count)


def gain(reference: Array, improved: Array, level: float = 0.95) -> Interval:
    """Ratio of the RMSE of ``reference`` to that of ``improved`` on common noise, with a paired interval.

    Both are mean squared errors per run (N,) of the same runs. The interval is Student's, for the logarithm of the
    ratio linearised in the two means: the noise that both share cancels.
    """
    reference, improved = np.asarray(reference, dtype=float), np.asarray(improved, dtype=float)
    both = np.isfinite(reference) & np.isfinite(improved)
    reference, improved = reference[both], improved[both]
    count = len(reference)
    if count == 0:
        return Interval(math.nan, math.nan, math.nan, 0)
    top, bottom = float(reference.mean()), float(improved.mean())
    if bottom == 0.0:
        return Interval(math.inf if top > 0.0 else math.nan, math.nan, math.nan, count)
    ratio = math.sqrt(top / bottom)
    if count == 1 or top == 0.0:
        return Interval(ratio, math.nan, math.nan, count)
    influence = 0.5 * (reference / top - improved / bottom)
    half = float(special.stdtrit(count - 1, 0.5 + 0.5 * level) * influence.std(ddof=1) / math.sqrt(count))
    return Interval(ratio, ratio * math.exp(-half), ratio * math.exp(half), count)


def paired_difference(one: Array, other: Array, level: float = 0.95) -> Interval:
    """Mean of ``one - other`` over common runs (N,): log scores, or any value per run."""
    return mean_interval(np.asarray(one, dtype=float) - np.asarray(other, dtype=float), level)


def proportion(count: int, trials: int, level: float = 0.95) -> Interval:
    """Share of independent trials with Wilson's interval, which also holds at none and at all."""
    if trials == 0:
        return Interval(math.nan, math.nan, math.nan, 0)
    share = count / trials
    z = float(special.ndtri(0.5 + 0.5 * level))
    denominator = 1.0 + z * z / trials
    centre = (share + 0.5 * z * z / trials) / denominator
    half = z / denominator * math.sqrt(share * (1.0 - share) / trials + 0.25 * z * z / trials**2)
    return Interval(share, max(centre - half, 0.0), min(centre + half, 1.0), trials)


def bootstrap(
    statistic: Callable[..., Array],
    samples: tuple[Array, ...],
    generator: np.random.Generator,
    level: float = 0.95,
    resamples: int = 1000,
) -> Interval:
    """Percentile interval of any statistic by resampling runs with replacement, common to all samples.

    Parameters
    ----------
    statistic : takes as many arrays as there are samples and reduces their last axis.
    samples : arrays (..., N) of the same N runs (or flights).
    """
    count = np.shape(samples[0])[-1]
    value = float(statistic(*samples))
    if count < 2:
        return Interval(value, math.nan, math.nan, count)
    draws = np.empty(resamples)
    for i in range(resamples):
        chosen = generator.integers(0, count, count)
        draws[i] = statistic(*(np.asarray(sample)[..., chosen] for sample in samples))
    low, high = np.quantile(draws, [0.5 - 0.5 * level, 0.5 + 0.5 * level])
    return Interval(value, float(low), float(high), count)


def chi_square(probability: float, degrees: float) -> float:
    """Value below which a chi-square variable stays with this probability."""
    return float(2.0 * special.gammaincinv(0.5 * degrees, probability))


def mean_square_band(degrees: int, runs: int, level: float = 0.95) -> tuple[float, float]:
    """Band of ANEES / n or ANIS / m at one epoch: chi-square with ``degrees`` = n or m per run, over its mean."""
    freedom = degrees * runs
    return chi_square(0.5 - 0.5 * level, freedom) / freedom, chi_square(0.5 + 0.5 * level, freedom) / freedom


def rmse_band(runs: int, level: float = 0.95) -> tuple[float, float]:
    """Band of RMSE / standard deviation of one component at one epoch."""
    low, high = mean_square_band(1, runs, level)
    return math.sqrt(low), math.sqrt(high)


def correlation_band(samples: int, level: float = 0.95) -> float:
    """Largest correlation of white innovations over so many runs, or over so many epochs of one run."""
    return float(special.ndtri(0.5 + 0.5 * level) / math.sqrt(samples))


def _finite(samples: Array) -> Array:
    samples = np.asarray(samples, dtype=float).ravel()
    return samples[np.isfinite(samples)]
