"""The runway whose threshold is the origin of every position."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Annotated, Any

import numpy as np

EQUATOR, ECCENTRICITY = 6378137.0, 6.69437999014e-3  # m, radius; square of the eccentricity [WGS 84]
ROUNDS = 8  # of the iteration; below a micrometre within 200 km at the highest latitude that is allowed


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

    def local(self, latitude: Any, longitude: Any, height: Any = 0.0) -> tuple[Any, Any]:
        """(north, east), m, of a place on WGS 84 in the plane that touches the earth at the threshold.

        ``latitude`` and ``longitude`` are in rad, ``height`` in m above the threshold along the curved earth: level
        flight keeps it. Distances and bearings from the threshold are true, and the extended centreline is straight.
        """
        points = _earth_centred(latitude, longitude, self.elevation + height)
        x, y, z = (
            one - own
            for one, own in zip(points, _earth_centred(self.latitude, self.longitude, self.elevation), strict=True)
        )
        sine, cosine = math.sin(self.latitude), math.cos(self.latitude)
        outwards = math.cos(self.longitude) * x + math.sin(self.longitude) * y
        return cosine * z - sine * outwards, math.cos(self.longitude) * y - math.sin(self.longitude) * x

    def geodetic(self, north: Any, east: Any, height: Any = 0.0) -> tuple[Any, Any]:
        """(latitude, longitude), rad on WGS 84, of a point as `local` gives it, by Newton's iteration.

        The slopes are the radii of curvature at the threshold, so each round leaves the share distance / earth radius.
        """
        root = math.sqrt(1.0 - ECCENTRICITY * math.sin(self.latitude) ** 2)
        meridian = EQUATOR * (1.0 - ECCENTRICITY) / root**3
        parallel = EQUATOR / root * math.cos(self.latitude)
        latitude, longitude = self.latitude, self.longitude
        for _ in range(ROUNDS):
            near_north, near_east = self.local(latitude, longitude, height)
            latitude = latitude + (north - near_north) / meridian
            longitude = longitude + (east - near_east) / parallel
        return latitude, longitude


def _earth_centred(latitude: Any, longitude: Any, height: Any) -> tuple[Any, Any, Any]:
    """(x, y, z), m, of a place at a height above the ellipsoid; x to the meridian of Greenwich, z to the north pole."""
    sine = np.sin(latitude)
    normal = EQUATOR / np.sqrt(1.0 - ECCENTRICITY * sine * sine)
    ring = (normal + height) * np.cos(latitude)
    return ring * np.cos(longitude), ring * np.sin(longitude), (normal * (1.0 - ECCENTRICITY) + height) * sine
