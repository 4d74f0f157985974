"""Air in motion: a steady wind, and several movements of the air at once.

Directions are the way the air moves, (north, east, up), unless a name says "from". Every kind of movement answers
``velocity(time, position, airspeed)``; the others have a file each: ``wind_shear``, ``turbulence``, ``wind_events``.
"""

from __future__ import annotations

import math
from typing import Annotated, Any, NamedTuple


class SteadyWind(NamedTuple):
    """The same wind everywhere and always."""

    north: float = 0.0  # m/s
    east: float = 0.0
    up: float = 0.0

    def velocity(
        self, time: float, position: tuple[float, float, float], airspeed: float
    ) -> tuple[float, float, float]:
        """(north, east, up), m/s."""
        return self.north, self.east, self.up


def steady_wind(from_direction: Annotated[float, "rad"], speed: Annotated[float, "m/s"]) -> SteadyWind:
    """Horizontal wind that blows FROM a direction, rad clockwise from north."""
    return SteadyWind(-speed * math.cos(from_direction), -speed * math.sin(from_direction))


class Together(NamedTuple):
    """Several movements of the air at once; their velocities add."""

    parts: tuple[Any, ...]

    def velocity(
        self, time: float, position: tuple[float, float, float], airspeed: float
    ) -> tuple[float, float, float]:
        """(north, east, up), m/s."""
        north = east = up = 0.0
        for part in self.parts:
            n, e, u = part.velocity(time, position, airspeed)
            north += n
            east += e
            up += u
        return north, east, up
