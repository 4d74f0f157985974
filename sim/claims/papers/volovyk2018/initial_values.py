"""Where the printed initial values of the angle, its rate and its acceleration can hold."""

from __future__ import annotations

from collections.abc import Callable
from functools import lru_cache
from typing import Any

import numpy as np

from sim.claims.manoeuvre_variance import GRAVITY
from tracking.trackers.elevation import elevation_of

INITIAL = np.array([0.7, 0.0122, 0.0002])  # deg, deg/s, deg/s2
# distance (m), speed (m/s) and deceleration (m/s2) of an approach, as printed: 5-25 km, 200-500 km/h, up to 0.25 g
RANGES = ((5e3, 25e3), (200.0 / 3.6, 500.0 / 3.6), (0.0, 0.25 * GRAVITY))
LEVEL, APPROACH = (200.0, 200.0), (30.0, 200.0)  # m: the height of the level leg; from there to the decision height
TOGETHER = (0, 1, 2)


def angles(distance: float, speed: float, deceleration: float, height: float) -> Any:
    """(3,) angle, rate and acceleration in degrees and seconds, in level flight towards the beacon."""
    return np.degrees(elevation_of(distance, height, -speed, 0.0, deceleration))


def where_the_leg_begins(derivative: int) -> Callable[[], float]:
    """The angle or a derivative of it where the level leg of fig. 1 begins: 15 km, 150 m/s, 200 m up."""
    return lambda: float(angles(15e3, 150.0, 0.625, 200.0)[derivative])


@lru_cache(maxsize=16)
def nearest_place(wanted: tuple[int, ...], heights: tuple[float, float]) -> tuple[float, float, float, float]:
    """Distance, speed, deceleration and height in the printed ranges where ``wanted`` is nearest to the print.

    Nearest in the squares of the relative differences.
    """
    from scipy.optimize import least_squares

    low, high = np.array([*RANGES, heights]).T

    def apart(share: Any) -> Any:
        return (angles(*(low + share * (high - low))) / INITIAL - 1.0)[list(wanted)]

    exact = {"xtol": 1e-14, "ftol": 1e-14, "gtol": 1e-14}
    share = least_squares(apart, np.full(4, 0.5), bounds=(0.0, 1.0), **exact).x
    distance, speed, deceleration, height = low + share * (high - low)
    return float(distance), float(speed), float(deceleration), float(height)


def nearest(derivative: int, heights: tuple[float, float], together: bool = False) -> Callable[[], float]:
    """The value of the printed ranges that is nearest to the printed one, alone or with the other two at one place."""
    wanted = TOGETHER if together else (derivative,)
    return lambda: float(angles(*nearest_place(wanted, heights))[derivative])
