"""A flight as a receiver would have recorded it: rows in latitude and longitude, exact or with a sensor's errors."""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from aircraft.air import Air
from aircraft.runway import ECCENTRICITY
from aircraft.runway import Runway as Place
from aircraft.state import AircraftState
from sim.flight.interpolation import hermite
from sim.interchange.track_record import TrackRecord
from sim.observation.record import SensorRecord
from sim.scenario.tables import Runway

PERIOD = 1.0  # s between rows of an exact record
SAID = ("north", "east", "pressure_altitude")  # what a sensor must say to be recorded as traffic is
HEIGHTS = np.arange(-1000.0, 20000.0, 25.0)  # m above the threshold, at which a pressure altitude is looked up
NEAR = 100.0  # m, over which a direction is taken


def records_traffic(sensor: Any) -> bool:
    """Whether what a sensor measures is what recordings of traffic hold."""
    return {*SAID} <= {*sensor.channels}


def exact(name: str, state: AircraftState, runway: Runway, air: Air, begins: float) -> TrackRecord:
    """A row each second of a flight (k,), without any error.

    Parameters
    ----------
    begins : s since 1970, when the time of the flight is 0
    """
    time = np.arange(state.time[0], state.time[-1] + 1e-6, PERIOD)
    after = np.clip(np.searchsorted(state.time, time), 1, len(state.time) - 1)
    before, h = after - 1, state.time[after] - state.time[after - 1]
    share = (time - state.time[before]) / h
    velocity = np.array((state.velocity_north, state.velocity_east, state.velocity_up))
    place = np.array((state.north, state.east, state.height))
    ends = (place[:, before], place[:, after], velocity[:, before], velocity[:, after])
    north, east, height = hermite(state.time[before], state.time[after], *ends, time)
    along, aside, up = velocity[:, before] + share * (velocity[:, after] - velocity[:, before])
    altitude = air.pressure_altitude(height)
    return _rows(
        name,
        begins + time,
        (north, east, height),
        altitude,
        (np.hypot(along, aside), np.arctan2(aside, along), up),
        runway,
    )


def as_seen(name: str, seen: SensorRecord, runway: Runway, air: Air, begins: float, draw: int = 0) -> TrackRecord:
    """The rows of a sensor that `records_traffic` in one of its draws; rows in a gap are not there.

    A recording has no height but that of the transponder, so the height above the ellipsoid is left out. That which
    the place is turned with into latitude and longitude follows from the pressure altitude, as a reader has it.
    """
    column = {name: seen.z[:, row, draw] for row, name in enumerate(seen.channels)}
    there = np.isfinite(np.sum([column[name] for name in SAID], axis=0))
    column = {name: values[there] for name, values in column.items()}
    altitude = column["pressure_altitude"]
    height = np.interp(altitude, air.pressure_altitude(HEIGHTS), HEIGHTS)
    nothing = np.full(len(altitude), np.nan)
    motion = tuple(column.get(name, nothing) for name in ("ground_speed", "course", "vertical_rate"))
    found = _rows(name, begins + seen.time[there], (column["north"], column["east"], height), altitude, motion, runway)
    return found._replace(height=None)


def _rows(name: str, time: Any, position: Any, altitude: Any, motion: Any, runway: Runway) -> TrackRecord:
    """The record of positions in the frame of the runway; of the motion the course is turned to true north there."""
    north, east, height = position
    speed, course, up = motion
    place = Place(runway.latitude, runway.longitude, runway.elevation, runway.heading)
    latitude, longitude = place.geodetic(north, east, height)
    ahead = place.geodetic(north + NEAR * np.cos(course), east + NEAR * np.sin(course), height)
    true = _bearing(latitude, longitude, *ahead)
    true = np.where(speed > 0.0, true, course) % (2.0 * math.pi)
    return TrackRecord(name, time, latitude, longitude, altitude, runway.elevation + height, speed, true, up)


def _bearing(latitude: Any, longitude: Any, to_latitude: Any, to_longitude: Any) -> Any:
    """Course from a place to one that is near, rad clockwise from true north, by the radii of curvature in between."""
    middle = 0.5 * (latitude + to_latitude)
    meridian_over_parallel = (1.0 - ECCENTRICITY) / (1.0 - ECCENTRICITY * np.sin(middle) ** 2)
    return np.arctan2((to_longitude - longitude) * np.cos(middle), (to_latitude - latitude) * meridian_over_parallel)
