"""Captures by formula: a point that banks by a law or by hand, its ADS-B rows, and the record smoothed from them."""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from aircraft.state import STANDARD_GRAVITY, AircraftState, Command
from autopilot.modes.lateral_navigation import LateralNavigation
from autopilot.route import Leg, PathDeviation, Route
from sim.flight.record import Flight
from tracking.gaussian import Gaussian
from tracking.measurement import LinearMeasurement
from tracking.motion import Transition, van_loan
from tracking.smoothing import smooth
from tracking.track import Measurements, track
from tracking.trackers.kalman import Kalman

STEP = 1.0 / 50.0  # s
ROLL_RATE = math.radians(5.0)
ACROSS, ALONG = 2.8, 31.0  # m, residuals of recorded tracks about the smoothed ones
JERK = 0.3  # m2/s5, of the smoother
# quantiles 5, 25, 50, 75, 95 % of laws identified from airliners: deg/m, m, deg, s; damping 1
SHARES = (0.05, 0.25, 0.5, 0.75, 0.95)
LAWS = {
    "k1": (0.014, 0.037, 0.055, 0.079, 0.127),
    "damping": (0.58, 0.74, 0.82, 0.89, 1.33),
    "cross_track_limit": (93.0, 769.0, 976.0, 1323.0, 2222.0),
    "bank_limit": (11.0, 17.0, 24.0, 28.0, 33.0),
    "lag": (0.2, 0.6, 2.5, 5.7, 8.0),
}


class Flown(NamedTuple):
    """A path north of a leg's start, (k,) each."""

    time: np.ndarray
    along: np.ndarray  # m, to the end of the leg it is negative
    cross_track: np.ndarray
    course: np.ndarray  # rad, minus that of the leg
    speed: np.ndarray  # m/s


class Truth(NamedTuple):
    """What a capture was flown by."""

    law: LateralNavigation
    lag: float


def route_law(k1, k2, cross_track_limit, bank_limit):
    """In degrees, as pages print them; its rate limit never acts."""
    k1, k2, bank_limit = map(math.radians, (k1, k2, bank_limit))
    return LateralNavigation(k1, k2, bank_limit, cross_track_limit, 1.1 * (k1 * cross_track_limit + bank_limit) / k2)


def fly(bank_of, lag, cross_track, course, speed=100.0, slowing=0.25, slowest=70.0, until=240.0, to_go=4000.0):
    """Fly a path by ``bank_of(time, cross_track, course, speed)`` behind a lag; slowing in m/s2 from 30 s on."""
    rows, bank, along = [], 0.0, 0.0
    for k in range(int(until / STEP)):
        time = k * STEP
        v = max(speed - slowing * max(time - 30.0, 0.0), slowest)
        rows.append((time, along, cross_track, course, v))
        wanted = bank_of(time, cross_track, course, v)
        change = (wanted - bank) * (1.0 - math.exp(-STEP / lag))
        bank += max(-ROLL_RATE * STEP, min(ROLL_RATE * STEP, change))
        turn = STEP * STANDARD_GRAVITY * math.tan(bank) / v
        along += STEP * v * math.cos(course + 0.5 * turn)
        cross_track += STEP * v * math.sin(course + 0.5 * turn)
        course += turn
    flown = Flown(*np.array(rows).T)
    return flown._replace(along=flown.along - flown.along[-1] - to_go)


def by_law(law):
    """Bank as a law commands it, at once and without error."""

    def bank(time, cross_track, course, speed):
        return float(law(PathDeviation(cross_track, speed * math.sin(course), math.nan, 0.0, course, course)))

    return bank


def drawn_law(rng):
    """A law of `LAWS` that turns onto the leg by 25 to 80 degrees at 95 m/s, with its lag and its intercept course."""
    while True:
        k1, damping, reach, limit, lag = (float(np.interp(rng.uniform(0.05, 0.95), SHARES, LAWS[k])) for k in LAWS)
        k2 = 2.0 * damping * math.degrees(math.sqrt(math.radians(k1) / STANDARD_GRAVITY))
        course = k1 * reach / k2 / 95.0
        settles = lag < 0.5 * k2 / k1  # half of what makes it weave without end (Routh)
        if math.sin(math.radians(25.0)) < course < math.sin(math.radians(80.0)) and settles:
            return Truth(route_law(k1, k2, reach, limit), lag), math.asin(course)


def drawn_capture(rng):
    """A capture by a drawn law, from its own intercept course; from either side, slowing by up to 30 m/s."""
    truth, course = drawn_law(rng)
    side = rng.choice([-1.0, 1.0])
    speed = rng.uniform(85.0, 110.0)
    offset = truth.law.cross_track_limit + rng.uniform(25.0, 60.0) * speed * math.sin(course)
    course *= rng.uniform(0.9, 1.1)
    slowing = rng.uniform(0.1, 0.4)
    return truth, fly(by_law(truth.law), truth.lag, -side * offset, side * course, speed, slowing, until=260.0)


def drawn_late_capture(rng):
    """A capture from a heading of 25 to 60 degrees that is held until 0 to 5 s after the law would turn in."""
    truth, _ = drawn_law(rng)
    side, speed = rng.choice([-1.0, 1.0]), rng.uniform(85.0, 105.0)
    course = math.radians(rng.uniform(25.0, 60.0))
    turn_in = truth.law.k2 * speed * math.sin(course) / truth.law.k1  # m, where the law balances the heading
    offset = min(turn_in, truth.law.cross_track_limit) - rng.uniform(0.0, 5.0) * speed * math.sin(course)
    if offset < 150.0:  # past the line before it is armed
        return drawn_late_capture(rng)
    flown_by, armed = by_law(truth.law), []

    def bank(time, cross_track, course, speed):
        if abs(cross_track) < offset:
            armed.append(time)
        return flown_by(time, cross_track, course, speed) if armed else 0.0

    start = offset + 40.0 * speed * math.sin(course)
    return truth, fly(bank, truth.lag, -side * start, side * course, speed, rng.uniform(0.1, 0.4), until=240.0)


def drawn_by_hand(rng):
    """A pilot: a heading, one bank at a time onto others short of the leg's and beyond, each held for a while."""
    side, speed = rng.choice([-1.0, 1.0]), rng.uniform(85.0, 105.0)
    first = math.radians(rng.uniform(30.0, 70.0))
    steps = [first]
    while steps[-1] > math.radians(8.0):
        steps.append(steps[-1] * rng.uniform(0.2, 0.6))
    steps += [math.radians(rng.uniform(-8.0, 8.0)) for _ in range(12)]
    times = 40.0 + np.cumsum([0.0, *(rng.uniform(12.0, 25.0) for _ in steps[1:])])
    banks = [math.radians(rng.uniform(10.0, 25.0)) for _ in steps]

    def bank(time, cross_track, course, speed):
        k = int(np.searchsorted(times, time))
        wanted = side * steps[min(k, len(steps) - 1)]
        return max(-banks[0], min(banks[0], math.copysign(banks[min(k, len(banks) - 1)], wanted - course))) * min(
            1.0, abs(wanted - course) / math.radians(3.0)
        )

    return fly(bank, 1.0, -side * rng.uniform(3000.0, 5000.0), side * first, speed, rng.uniform(0.1, 0.3), until=260.0)


def flight_of(time, north, east, velocity_north, velocity_east, heading=0.0, utc=1.7e9):
    """A record of places and velocities alone, as one made from a recording; its leg ends at the threshold."""
    c, s = math.cos(heading), math.sin(heading)

    def turned(a, b):
        return c * a - s * b, s * a + c * b

    columns = {name: np.full(len(time), math.nan) for name in AircraftState._fields}
    columns["time"], columns["height"] = time, np.full(len(time), 600.0)
    columns["north"], columns["east"] = turned(north, east)
    columns["velocity_north"], columns["velocity_east"] = turned(velocity_north, velocity_east)
    columns["velocity_up"] = np.zeros(len(time))
    command = Command(*(np.full(len(time), math.nan) for _ in Command._fields))
    route = Route((Leg((-60e3 * c, -60e3 * s), (0.0, 0.0), 75.0, 600.0),))
    zero = np.zeros(len(time), int)
    return Flight(route, AircraftState(**columns), command, zero, zero, ("vectors",), (), "completed", "", utc=utc)


def exact(flown, heading=0.0):
    """The path as a record without errors, at 10 Hz."""
    every = slice(None, None, 5)
    time, along, cross_track, course, speed = (values[every] for values in flown)
    return flight_of(time, along, cross_track, speed * np.cos(course), speed * np.sin(course), heading, None)


class Rows(NamedTuple):
    """What a receiver of ADS-B writes down, (k,) each."""

    time: np.ndarray
    north: np.ndarray
    east: np.ndarray
    course: np.ndarray


def adsb_rows(flown, rng, across=2.0):
    """Rows at 1 Hz: stamps that jitter by .2 s, 3 % of stale places, a velocity that is renewed every 2.5 rows."""
    stamps = np.arange(flown.time[0], flown.time[-1], 1.0)
    when = np.clip(stamps + 0.2 * rng.standard_normal(len(stamps)), flown.time[0], flown.time[-1])
    north, east = (np.interp(when, flown.time, values) for values in (flown.along, flown.cross_track))
    north, east = north + across * rng.standard_normal(len(when)), east + across * rng.standard_normal(len(when))
    course = np.round(np.degrees(np.interp(when, flown.time, flown.course)))
    for k in range(1, len(when)):
        if rng.random() < 0.03:
            north[k], east[k] = north[k - 1], east[k - 1]
        if rng.random() < 0.6:
            course[k] = course[k - 1]
    return Rows(stamps, north, east, np.radians(course))


class WhiteJerk:
    """Acceleration that wanders, north and east apart."""

    depends_on_state = False
    channels = ("north", "north_rate", "north_acceleration", "east", "east_rate", "east_acceleration")

    def transition(self, dt, mean):
        F, Q = van_loan(np.eye(3, k=1), np.diag([0.0, 0.0, JERK]), dt)
        zero = np.zeros((3, 3))
        return Transition(np.block([[F, zero], [zero, F]]), np.block([[Q, zero], [zero, Q]]))


def smoothed(rows, heading=0.0):
    """The record of the rows, as recordings are made into flights: stale ones dropped, Rauch-Tung-Striebel."""
    fresh = np.r_[True, (np.diff(rows.north) != 0.0) | (np.diff(rows.east) != 0.0)]
    time, north, east, course = (values[fresh] for values in rows)
    z = np.stack((north, east), axis=1)
    c, s = np.cos(course), np.sin(course)
    turn = np.moveaxis(np.array([[c, -s], [s, c]]), -1, 0)
    R = turn @ np.diag([ALONG**2, ACROSS**2]) @ turn.swapaxes(1, 2)
    pick = np.zeros((2, 6))
    pick[0, 0] = pick[1, 3] = 1.0
    filter_ = Kalman(LinearMeasurement(tuple(map(tuple, pick))), WhiteJerk())
    rates = (z[10] - z[0]) / (time[10] - time[0])
    prior = Gaussian(
        np.array([z[0, 0], rates[0], 0.0, z[0, 1], rates[1], 0.0]), np.diag([900.0, 400.0, 4.0, 900.0, 400.0, 4.0])
    )
    measured = Measurements(("a", "b"), time, time, z[:, :, None], R)
    mean = smooth(track(filter_, measured, prior), WhiteJerk()).mean[..., 0]
    return flight_of(time, mean[:, 0], mean[:, 3], mean[:, 1], mean[:, 4], heading)
