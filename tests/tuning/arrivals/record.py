"""What a generator of arrivals gives, in the coordinates of the final approach."""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np


class Arrivals(NamedTuple):
    """n aircraft, k instants one second apart."""

    along: Any  # (k, n) m, from the threshold in the direction of landing: negative before it
    across: Any  # (k, n) m, + right
    height: Any  # (k, n) m above the threshold
    bank: Any  # (k, n) rad, + right
    heading: Any  # (k, n) rad, relative to the final course
    airspeed: Any  # (k, n) m/s, true
    along_rate: Any  # (k, n) m/s over the ground
    across_rate: Any  # (k, n) m/s
    flying: Any  # (k, n) bool: until its record ends
    engaged: Any  # (n,) s, when the law took over
    departed: Any  # (n,) s, when the law was left; NaN = never


def drawn(generator: np.random.Generator, count: int, quantiles: tuple[float, float, float, float, float]) -> Any:
    """(count,) values whose 5, 25, 50, 75 and 95 per cent quantiles are given, linear in between.

    Beyond the outer two the density of the part beside it goes on, as far as the share of 5 per cent needs.
    """
    p5, p25, p50, p75, p95 = quantiles
    low, high = p5 - 0.25 * (p25 - p5), p95 + 0.25 * (p95 - p75)
    places = (0.0, 0.05, 0.25, 0.5, 0.75, 0.95, 1.0)
    return np.interp(generator.random(count), places, (low, p5, p25, p50, p75, p95, high))


def between(generator: np.random.Generator, count: int, low: float, high: float) -> Any:
    """(count,) uniform values."""
    return generator.uniform(low, high, count)


def by_distance(distance: Any, knots: Any, values: Any) -> Any:
    """(n,) values at distances (n,), linear between knots (m, n) that increase, and constant beyond."""
    found = values[0]
    for first, last, start, end in zip(knots[:-1], knots[1:], values[:-1], values[1:], strict=True):
        share = np.clip((distance - first) / np.maximum(last - first, 1.0), 0.0, 1.0)
        found = found + share * (end - start)
    return found
