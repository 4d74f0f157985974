"""Variance of the angular acceleration by the recipe that two of the papers state."""

from __future__ import annotations

import math
from functools import partial

from sim.claims.ledger import Claim, Reading, counted
from sim.claims.verdict import number
from tracking.trackers.elevation import elevation_of, manoeuvre_variance

GRAVITY = 9.81  # m/s2, of the papers
LARGEST, SHARE_LARGEST, SHARE_NONE = 0.2 * GRAVITY, 0.1, 0.5  # the example of Volovyk 2018


def angular_variance(distance: float, height: float, across: bool) -> float:
    """Variance of the angular acceleration (deg/s^2)^2 that the manoeuvre acceleration causes.

    ``across`` = it acts vertically; otherwise along the distance.
    """
    deviation = math.sqrt(manoeuvre_variance(LARGEST, SHARE_LARGEST, SHARE_NONE))
    pushed = (0.0, deviation) if across else (deviation, 0.0)
    acceleration = elevation_of(distance, height, 0.0, 0.0, *pushed).acceleration
    return float(math.degrees(acceleration) ** 2)


def noise_claim(name: str, words: str, where: str, printed: str, distance: float, height: float = 200.0) -> Claim:
    """A printed variance of the angular acceleration."""
    return Claim(
        name,
        words,
        where,
        number(printed),
        tuple(
            Reading(text, counted(partial(angular_variance, distance, height, across)))
            for text, across in (("acceleration along the distance", False), ("acceleration vertical", True))
        ),
        "(deg/s^2)^2",
        geometry_by="paper",
        note="By the recipe of the print; no recipe was found that gives the printed values.",
    )
