"""The last turn onto final of one flight, flown or recorded, from its position and velocity over the ground alone.

All is worked out once a second, so that a flight of ours and one that a surveillance sensor saw are measured alike.
The bank is that of the turn (`autopilot.last_turn`); its slope is that of the straight line through 11 s. What counts
as a turn is wider here than for a capture that is to be identified: the flights are compared with those of others.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from autopilot.last_turn import bank_of_turn, turn_rate
from sim.flight.record import Flight
from tracking.measurement import wrap

WINDOW = 11  # s, of the lines whose slope is the roll rate
TURNING = math.radians(0.3)  # rad/s, of the turn rate averaged over 5 s: 2 deg of bank at 110 m/s
AVERAGED = 5  # s
LEAST_TURN = math.radians(8.0)  # rad, of the course ...
LEAST_ANGLE = math.radians(15.0)  # rad, from the final course where it begins; less is a correction
LARGEST_TURN = math.radians(115.0)
SETTLED = math.radians(3.0)  # rad, of the course to the final; the capture is over when it stays within
FINAL_AFTER = 20.0  # s; final begins so long after the end of the turn, or of the settling where that is later
FINAL_LEAST = 30.0  # s, of final; less says nothing
LOWEST = 60.0  # m above the threshold; the flare and the de-crab are no part of it
UNSETTLED = 120.0  # s after the turn; what is not settled by then counts as this
BEFORE, AFTER = 10.0, 60.0  # s before the turn and after it, between which the speed falls


class LastTurn(NamedTuple):
    """What is compared; SI, None where the flight does not show it."""

    angle: float  # rad, of the course to the final course where the turn begins
    speed: float  # m/s over the ground, there
    slowed: float  # m/s, by which that falls through the capture
    height: float  # m, there
    overshoot: float  # m, to the other side of the final
    bank: float  # rad, the largest of the turn
    duration: float  # s
    roll_rate: float  # rad/s, the largest slope of a line through 11 s of bank
    settling: float  # s, from the end of the turn until the course stays that of the final, within 3 deg
    cross_track_sd: float | None  # m, about its mean, on final
    bank_rms: float | None  # rad, on final


def last_turn(flight: Flight) -> LastTurn | None:
    """The last turn onto the last leg of a flight, which it flies to its end; None where there is none below 115 deg.

    The turn is the last stretch of at least 8 deg in which the turn rate, averaged over 5 s, exceeds 0.3 deg/s, and
    which begins at 15 deg or more to the final course, the angle of the turn.
    Needs a position, a velocity and a height.
    """
    s, leg = flight.state, flight.route.legs[-1]
    ended = np.flatnonzero(flight.during("go_around"))
    end = flight.time[ended[0]] if ended.size else flight.time[-1]
    time = np.arange(flight.time[0], end, 1.0)
    if len(time) < 2 * WINDOW:
        return None
    north, east, height, velocity_north, velocity_east = (
        np.interp(time, flight.time, column)
        for column in (s.north, s.east, s.height, s.velocity_north, s.velocity_east)
    )
    airborne = height > LOWEST
    if not airborne.any():
        return None
    last = int(np.flatnonzero(airborne)[-1]) + 1
    time, height, north, east = time[:last], height[:last], north[:last], east[:last]
    speed = np.hypot(velocity_north, velocity_east)[:last]
    course = np.unwrap(np.arctan2(velocity_east, velocity_north)[:last])
    along_north, along_east = leg.direction
    z = (east - leg.end[1]) * along_north - (north - leg.end[0]) * along_east
    rate = turn_rate(time, course)
    bank = bank_of_turn(speed, rate)
    slope = _slopes(bank)
    error = np.asarray(wrap(course - leg.course))
    found = _turn(error, course, rate)
    if found is None:
        return None
    begin, over = found
    angle = abs(float(error[begin]))
    if not angle < LARGEST_TURN:
        return None
    side = np.sign(z[begin])
    beyond = np.flatnonzero(np.abs(error[begin:]) > SETTLED)
    settled = begin + (int(beyond[-1]) + 1 if beyond.size else 0)
    final = slice(int(max(over, min(settled, over + UNSETTLED)) + FINAL_AFTER), None)
    enough = len(z[final]) >= FINAL_LEAST
    after = min(over + int(AFTER), len(time) - 1)
    return LastTurn(
        angle,
        float(speed[begin]),
        float(speed[max(begin - int(BEFORE), 0)] - speed[after]),
        float(height[begin]),
        float(max((-side * z[begin:]).max(), 0.0)),
        float(np.abs(bank[begin : over + 1]).max()),
        float(over - begin),
        float(np.abs(slope[max(begin - WINDOW, 0) : over + WINDOW]).max()),
        float(min(settled - over, UNSETTLED)),
        float(np.std(z[final])) if enough else None,
        float(np.sqrt(np.mean(bank[final] ** 2))) if enough else None,
    )


def _turn(error: np.ndarray, course: np.ndarray, rate: np.ndarray) -> tuple[int, int] | None:
    """First and last second of the last turn."""
    turning = np.abs(np.convolve(rate, np.full(AVERAGED, 1.0 / AVERAGED), "same")) > TURNING
    edges = np.flatnonzero(np.diff(np.concatenate(([False], turning, [False])).astype(int)))
    turns = [
        (int(first), int(after) - 1)
        for first, after in edges.reshape(-1, 2)
        if abs(course[after - 1] - course[first]) >= LEAST_TURN and abs(error[first]) >= LEAST_ANGLE
    ]
    return turns[-1] if turns else None


def _slopes(values: np.ndarray) -> np.ndarray:
    """Slope, per s, of the least-squares line through the window about each second."""
    half = WINDOW // 2
    away = np.arange(-half, half + 1)
    windows = np.lib.stride_tricks.sliding_window_view(np.pad(values, half, mode="edge"), WINDOW)
    return np.asarray(windows @ away / float(away @ away))
