"""The deviations that a law uses: their names and scales in figures, and where their limits act on a flight."""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from autopilot.mode import Mode
from sim.flight.record import Flight

BANK = "bank"  # the name of the limit of the command among those of the inputs


class Component(NamedTuple):
    """One field of ``PathDeviation`` on a page."""

    label: str  # of an axis
    short: str  # of a row
    scale: float = 1.0  # from SI to what is shown

    @property
    def unit(self) -> str:
        """As shown."""
        return self.label.rpartition(", ")[2]


DEGREES = math.degrees(1.0)
COMPONENTS = {
    "cross_track": Component("cross-track, m (+ right)", "offset"),
    "cross_track_rate": Component("cross-track rate, m/s", "rate"),
    "distance_to_go": Component("distance to go, m", "distance"),
    "bearing_error": Component("bearing error, deg", "bearing", DEGREES),
    "track_error": Component("track error, deg", "track", DEGREES),
    "heading_error": Component("heading error, deg", "heading", DEGREES),
}


def acting_limits(flight: Flight, law: Mode, bank_limit: float) -> dict[str, np.ndarray]:
    """(k,) bool by name: where the command is at its limit (`BANK`), and where each limited input is beyond its own.

    Inputs are named as the fields of ``PathDeviation`` that they are; inputs without a limit are left out.
    ``bank_limit`` is that of the command, rad.
    """
    deviation = flight.deviation
    acting = {BANK: np.abs(flight.command.bank) >= bank_limit * (1 - 1e-6)}
    for one in law.limits():
        if np.isfinite(one.limit):
            seen = deviation.distance_to_go > one.blind
            acting[one.of] = seen & (np.abs(getattr(deviation, one.of)) >= one.limit)
    return acting
