"""Legs, routes and the deviations from them; (north, east) in metres from the runway threshold."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np

Real = Any


class PathDeviation(NamedTuple):
    """Where a point is relative to one leg; floats or arrays, + right of the course."""

    cross_track: Real  # m
    cross_track_rate: Real  # m/s
    distance_to_go: Real  # m along the leg to its end
    bearing_error: Real  # rad, bearing to the leg's end minus course: negative when right of the leg
    track_error: Real  # rad, ground track minus course
    heading_error: Real  # rad, heading minus course; equals track_error where no heading is known


@dataclass(frozen=True)
class Leg:
    """A straight leg between two points, flown at a speed and a height."""

    start: tuple[float, float]  # m, (north, east)
    end: tuple[float, float]
    speed: float  # m/s, airspeed
    height: float  # m above the threshold

    @property
    def course(self) -> float:
        """rad, clockwise from north."""
        return float(np.arctan2(self.end[1] - self.start[1], self.end[0] - self.start[0]))

    @property
    def length(self) -> float:
        """m."""
        return float(np.hypot(self.end[0] - self.start[0], self.end[1] - self.start[1]))


@dataclass(frozen=True)
class Route:
    """Legs in the order in which they are flown, and the wind for which the turns are planned."""

    legs: tuple[Leg, ...]
    wind: tuple[float, float] = (0.0, 0.0)  # m/s, the way the air moves, (north, east)
    time_to_roll: float = 2.2  # s, from the turn command to the mean of the bank

    def deviation(self, leg: Any, position: Any, velocity: Any, heading: Any = None) -> PathDeviation:
        """Deviation from ``leg`` (an int, or an int array with one leg per run)."""
        raise NotImplementedError

    def sequence(self, leg: Any, position: Any, velocity: Any, bank_limit: Any) -> Any:
        """The leg to fly next: ``leg``, or ``leg + 1`` once its turn is due."""
        raise NotImplementedError
