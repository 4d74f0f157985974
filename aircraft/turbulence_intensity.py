"""How strong and how long turbulence is at a height, by MIL-F-8785C: near the ground, aloft, and between."""

from __future__ import annotations

from bisect import bisect_right
from typing import NamedTuple

FOOT = 0.3048  # m; the forms of the specification are in feet
KNOT = 1852.0 / 3600.0  # m/s
LOWEST, LOW, ALOFT = 10.0, 1000.0, 2000.0  # ft above the ground: of the low-altitude forms, their end, the free air
LENGTH_ALOFT = 1750.0 * FOOT  # m, of all three components
INTENSITIES = {"light": 15.0 * KNOT, "moderate": 30.0 * KNOT, "severe": 45.0 * KNOT}  # m/s, wind at 20 ft

# Aloft the intensity is read over height at a probability of exceedance, 1e-2, 1e-3, 1e-5 for light, moderate, severe
# [MIL-F-8785C, fig. 7]: ft, then ft/s.
HEIGHTS = (500.0, 1750.0, 3750.0, 7500.0, 15000.0, 25000.0, 35000.0, 45000.0, 55000.0, 65000.0, 75000.0, 80000.0)
SIGMAS = (
    (6.6, 6.9, 7.4, 6.7, 4.6, 2.7, 0.4, 0.0, 0.0, 0.0, 0.0, 0.0),
    (8.6, 9.6, 10.6, 10.1, 8.0, 6.6, 5.0, 4.2, 2.7, 0.0, 0.0, 0.0),
    (15.6, 17.6, 23.0, 23.6, 22.1, 20.0, 16.0, 15.1, 12.1, 7.9, 6.2, 5.1),
)


class Intensity(NamedTuple):
    """Standard deviations and scale lengths of turbulence at one height."""

    sigma_along: float  # m/s, also across
    sigma_up: float
    length_along: float  # m, also across
    length_up: float


def intensity(height: float, wind_at_20_ft: float) -> Intensity:
    """Turbulence at ``height`` (m above the ground) [MIL-F-8785C, 3.7.3].

    Between 1000 and 2000 ft all four values go linearly from those near the ground to those aloft, which are the same
    in every direction.
    """
    feet = height / FOOT
    if feet <= LOW:
        return _near_the_ground(max(feet, LOWEST), wind_at_20_ft)
    aloft = sigma_aloft(max(feet, ALOFT), wind_at_20_ft)
    if feet >= ALOFT:
        return Intensity(aloft, aloft, LENGTH_ALOFT, LENGTH_ALOFT)
    below, share = _near_the_ground(LOW, wind_at_20_ft), (feet - LOW) / (ALOFT - LOW)
    above = (aloft, aloft, LENGTH_ALOFT, LENGTH_ALOFT)
    return Intensity._make((1.0 - share) * low + share * high for low, high in zip(below, above, strict=True))


def sigma_aloft(feet: float, wind_at_20_ft: float) -> float:
    """Standard deviation, m/s, at a height above 2000 ft [MIL-F-8785C, fig. 7].

    The specification knows three severities; the wind at 20 ft that stands for them near the ground leads from one to
    the next linearly, from none in calm air and on along the last line beyond severe.
    """
    winds = (0.0, *INTENSITIES.values())
    sigmas = (0.0, *(_interpolated(feet, HEIGHTS, row) * FOOT for row in SIGMAS))
    at = min(max(bisect_right(winds, wind_at_20_ft) - 1, 0), len(winds) - 2)
    share = (wind_at_20_ft - winds[at]) / (winds[at + 1] - winds[at])
    return sigmas[at] + share * (sigmas[at + 1] - sigmas[at])


def _near_the_ground(feet: float, wind_at_20_ft: float) -> Intensity:
    shape = 0.177 + 0.000823 * feet
    sigma_up = 0.1 * wind_at_20_ft
    return Intensity(sigma_up / shape**0.4, sigma_up, feet * FOOT / shape**1.2, feet * FOOT)


def _interpolated(x: float, xs: tuple[float, ...], ys: tuple[float, ...]) -> float:
    at = min(max(bisect_right(xs, x) - 1, 0), len(xs) - 2)
    share = min(max((x - xs[at]) / (xs[at + 1] - xs[at]), 0.0), 1.0)
    return ys[at] + share * (ys[at + 1] - ys[at])
