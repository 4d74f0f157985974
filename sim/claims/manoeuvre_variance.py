"""Variance of the angular acceleration by the recipe that two of the papers state, and the slips that give its print.

Four values are printed: 3.6e-8 at 10 km, 7e-4 and 17e-4 at 5 km, 11.5e-4 at 1 km. The recipe gives none of them. Each
digit string comes out of one slip in it, and of no other: no single slip gives two of the four.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from functools import partial

from sim.claims.ledger import Claim, Reading, counted
from sim.claims.verdict import number
from tracking.trackers.elevation import elevation_of, manoeuvre_variance

GRAVITY = 9.81  # m/s2, of the papers
SHARE_LARGEST, SHARE_NONE = 0.1, 0.5  # the example of Volovyk 2018
LARGEST = 0.2 * GRAVITY
PRINTED = (("3.6e-8", 10000.0), ("7e-4", 5000.0), ("17e-4", 5000.0), ("11.5e-4", 1000.0))  # and the distance, m


def sum_of_squares(gravity: float) -> float:
    """a_max^2 (1 + 4 q_max - q_0), m2/s4: three times the variance of the manoeuvre acceleration."""
    return 3.0 * manoeuvre_variance(0.2 * gravity, SHARE_LARGEST, SHARE_NONE)


SLIPS: dict[str, Callable[[float], float]] = {
    "the sum of squares over D, as an angle in degrees, squared (g = 10)": lambda distance: (
        math.degrees(sum_of_squares(10.0) / distance) ** 2
    ),
    "the sum of squares over D squared, in radians (g = 10)": lambda distance: sum_of_squares(10.0) / distance**2,
    "the sum of squares over D (g = 9.81)": lambda distance: sum_of_squares(GRAVITY) / distance,
    "the variance, a third of it, over D (g = 9.81)": lambda distance: sum_of_squares(GRAVITY) / 3.0 / distance,
}


def speed(distance: float) -> float:
    """Of the printed profile (m/s): 150 to 100 from 15 to 5 km, 80 at 750 m, uniformly slower in between."""
    far, near, first, last = (15e3, 5e3, 150.0, 100.0) if distance >= 5e3 else (5e3, 750.0, 100.0, 80.0)
    return math.sqrt(last**2 + (first**2 - last**2) * (distance - near) / (far - near))


def angular_variance(distance: float, height: float, across: bool = False, moving: bool = False) -> float:
    """Variance of the angular acceleration (deg/s^2)^2 that the manoeuvre acceleration causes.

    ``across`` = it acts vertically, otherwise along the distance; ``moving`` = the square of the whole of (1), with
    the speed of the printed profile in level flight beside it.
    """
    deviation = math.sqrt(manoeuvre_variance(LARGEST, SHARE_LARGEST, SHARE_NONE))
    pushed = (0.0, deviation) if across else (deviation, 0.0)
    motion = elevation_of(distance, height, -speed(distance) if moving else 0.0, 0.0, *pushed)
    return float(math.degrees(motion.acceleration) ** 2)


def slips_that_give(values: Callable[[float], float]) -> float:
    """How many of the four printed values a formula of the distance gives."""
    return float(sum(number(text).side(values(distance)) == 0 for text, distance in PRINTED))


def noise_claim(
    name: str,
    words: str,
    where: str,
    printed: str,
    distance: float,
    candidate: str,
    heights: tuple[float, ...] = (200.0,),
) -> Claim:
    """A printed variance of the angular acceleration; ``candidate`` is the slip that gives its digits."""
    readings: dict[str, Callable[[], float]] = {}
    for height in heights:
        for text, across in (("along the distance", False), ("vertical", True)):
            readings[f"acceleration {text}, {height:g} m up"] = partial(angular_variance, distance, height, across)
    readings["all of (1) squared, level at the speed of fig. 1, 200 m up"] = partial(
        angular_variance, distance, 200.0, moving=True
    )
    return Claim(
        name,
        words,
        where,
        number(printed),
        tuple(Reading(text, counted(function)) for text, function in readings.items()),
        "(deg/s^2)^2",
        geometry_by="paper",
        note=f"By the recipe of the print. The printed digits are those of {candidate}: a slip, not a reading. "
        "Each of the four printed values has such a slip, and no single slip gives two of them.",
    )
