"""Motion between two records: cubic Hermite in position, so that velocity agrees at both ends."""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np

from aircraft.state import AircraftState
from sim.flight.record import Flight
from tracking.measurement import wrap


def position_at(before: AircraftState, after: AircraftState, time: float) -> np.ndarray:
    """(north, east, height) in m at a time between two records, shape (3,)."""
    place: np.ndarray = hermite(
        before.time,
        after.time,
        np.array((before.north, before.east, before.height)),
        np.array((after.north, after.east, after.height)),
        np.array((before.velocity_north, before.velocity_east, before.velocity_up)),
        np.array((after.velocity_north, after.velocity_east, after.velocity_up)),
        time,
    )
    return place


ATTITUDE = tuple(AircraftState._fields.index(name) for name in ("bank", "pitch", "heading"))  # the shorter way round


def state_at(before: AircraftState, after: AircraftState, time: float) -> AircraftState:
    """The motion at a time between two records: the place as `position_at`, all else linear."""
    north, east, height = position_at(before, after, time)
    share = (time - before.time) / (after.time - before.time)
    return _linear(before, after, share)._replace(time=time, north=north, east=east, height=height)


def _linear(before: AircraftState, after: AircraftState, share: Any) -> AircraftState:
    values = [first + share * (last - first) for first, last in zip(before, after, strict=True)]
    for index in ATTITUDE:
        first = before[index]
        values[index] = first + share * wrap(after[index] - first)
    return AircraftState(*values)


def hermite(t0: Any, t1: Any, p0: Any, p1: Any, v0: Any, v1: Any, time: Any) -> Any:
    """Cubic through two points with given slopes; arguments broadcast."""
    h = t1 - t0
    s = (time - t0) / h
    return (
        (2 * s**3 - 3 * s**2 + 1) * p0
        + (s**3 - 2 * s**2 + s) * h * v0
        + (-2 * s**3 + 3 * s**2) * p1
        + (s**3 - s**2) * h * v1
    )


class Truth(NamedTuple):
    """The flight at the epochs of a tracker; k instants."""

    time: np.ndarray  # (k,)
    state: AircraftState  # of (k,) arrays, what sensors are asked for their truth of
    position: np.ndarray  # (3, k) m
    velocity: np.ndarray  # (3, k) m/s
    leg: np.ndarray  # (k,) leg active in truth
    phase: np.ndarray  # (k,) index into the flight's phases


def truth_at(flight: Flight, time: np.ndarray) -> Truth:
    """The flight interpolated at ``time`` (k,), cubic between its records."""
    s = flight.state
    after = np.clip(np.searchsorted(s.time, time), 1, len(s.time) - 1)
    before = after - 1
    position = np.array((s.north, s.east, s.height))
    velocity = np.array((s.velocity_north, s.velocity_east, s.velocity_up))
    t0, t1 = s.time[before], s.time[after]
    share = (time - t0) / (t1 - t0)
    place = hermite(t0, t1, position[:, before], position[:, after], velocity[:, before], velocity[:, after], time)
    linear = _linear(AircraftState(*(c[before] for c in s)), AircraftState(*(c[after] for c in s)), share)
    return Truth(
        time,
        linear._replace(time=time, north=place[0], east=place[1], height=place[2]),
        place,
        velocity[:, before] * (1 - share) + velocity[:, after] * share,
        flight.leg[before],
        flight.phase[before],
    )
