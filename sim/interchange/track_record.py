"""A recorded track: what a receiver wrote down of one flight, as plain arrays in SI."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np


class TrackRecord(NamedTuple):
    """One flight as it was recorded, k rows in the order of their time; NaN = not known in that row, None = nowhere."""

    name: str  # what the file calls the flight
    time: np.ndarray  # (k,) s, UTC, since 1970 as Unix counts it
    latitude: np.ndarray  # (k,) rad, WGS 84
    longitude: np.ndarray  # (k,) rad
    pressure_altitude: np.ndarray | None = None  # (k,) m above 1013.25 hPa, as a transponder tells it
    height: np.ndarray | None = None  # (k,) m above the WGS 84 ellipsoid or the sea, as the file says it
    ground_speed: np.ndarray | None = None  # (k,) m/s
    course: np.ndarray | None = None  # (k,) rad, over the ground, clockwise from true north
    vertical_rate: np.ndarray | None = None  # (k,) m/s, + up
    remarks: tuple[str, ...] = ()  # what of the file could not be taken as it stands, in sentences
