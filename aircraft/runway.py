"""The runway whose threshold is the origin of every position."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Annotated, Any


@dataclass(frozen=True)
class Runway:
    """Where the threshold lies; only the elevation acts on the flight, the rest serves routes, maps and exports."""

    latitude: Annotated[float, "rad"] = 0.0
    longitude: Annotated[float, "rad"] = 0.0
    elevation: Annotated[float, "m"] = 0.0
    heading: Annotated[float, "rad"] = 0.0

    def __post_init__(self) -> None:
        if not abs(self.latitude) <= math.radians(85.0):
            raise ValueError("latitude must lie within 85 deg of the equator")
        if not abs(self.longitude) <= math.pi:
            raise ValueError("longitude must lie between -180 and 180 deg")
        if not -500.0 <= self.elevation <= 5000.0:
            raise ValueError("elevation must lie between -500 and 5000 m")
        if not abs(self.heading) <= 2.0 * math.pi:
            raise ValueError("heading must lie between -360 and 360 deg")

    def geodetic(self, north: Any, east: Any) -> tuple[Any, Any]:
        """(latitude, longitude), rad, by the radii of curvature of WGS 84 at the threshold."""
        sine = math.sin(self.latitude)
        root = math.sqrt(1.0 - 6.69437999014e-3 * sine * sine)
        meridian = 6378137.0 * (1.0 - 6.69437999014e-3) / root**3
        return self.latitude + north / meridian, self.longitude + east * root / (6378137.0 * math.cos(self.latitude))
