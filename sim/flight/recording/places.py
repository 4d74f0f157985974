"""A recorded track in the frame of the runway: metres north, east and up of the threshold."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from aircraft.air import Air
from aircraft.runway import Runway as Place
from sim.interchange.track_record import TrackRecord
from sim.scenario.tables import Runway

LOWEST, HIGHEST, STEP = -1000.0, 20000.0, 25.0  # m above the threshold: heights for which an altimeter is looked up


class Rows(NamedTuple):
    """A track in the frame of the runway, k rows in the order of their time; NaN = not known."""

    time: np.ndarray  # (k,) s since 1970
    north: np.ndarray  # (k,) m
    east: np.ndarray  # (k,) m
    height: np.ndarray  # (k,) m above the threshold

    def some(self, which: np.ndarray) -> Rows:
        """Those of a mask or of indices."""
        return Rows(*(column[which] for column in self))


def placed(track: TrackRecord, runway: Runway, air: Air) -> tuple[Rows, list[str]]:
    """The rows of a track in the frame of the runway, and what was assumed of their heights.

    A pressure altitude becomes a height by the QNH and the temperature of ``air``: at the threshold an altimeter set to
    that QNH shows the elevation. A track without any has the height that it says itself, less the elevation.

    Raises ``ValueError`` for a track without any height.
    """
    told = []
    if track.pressure_altitude is not None and np.isfinite(track.pressure_altitude).any():
        heights = np.arange(LOWEST, HIGHEST, STEP)
        height = np.interp(track.pressure_altitude, air.pressure_altitude(heights), heights, left=np.nan, right=np.nan)
    elif track.height is not None and np.isfinite(track.height).any():
        height = track.height - runway.elevation
        told.append(
            "heights are geometric ones, for want of a pressure altitude: counted from the ellipsoid, as GPS does, "
            "they are off by the height of the geoid, up to 100 m"
        )
    else:
        raise ValueError("it has no altitude, neither a pressure altitude nor a geometric one")
    if not np.isfinite(height).any():
        raise ValueError(f"its altitudes lie beyond {LOWEST:g} to {HIGHEST:g} m above the threshold")
    threshold = Place(runway.latitude, runway.longitude, runway.elevation, runway.heading)
    level = np.where(np.isfinite(height), height, np.nanmedian(height))
    with np.errstate(invalid="ignore"):
        inside = (np.abs(track.latitude) <= np.pi / 2.0) & (np.abs(track.longitude) <= 2.0 * np.pi)
        north, east = threshold.local(track.latitude, track.longitude, level)
    return Rows(track.time, np.where(inside, north, np.nan), np.where(inside, east, np.nan), height), told
