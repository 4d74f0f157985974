"""A capture of a leg as it was recorded, and as a route law would have flown it."""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np

from aircraft.state import STANDARD_GRAVITY
from autopilot.last_turn import bank_of_turn, turn_rate
from autopilot.modes.lateral_navigation import LateralNavigation
from autopilot.saturation import rate_limit

SAMPLE = 1.0  # s, between the instants of a capture
STEPS = 4  # of the simulation within one


class Capture(NamedTuple):
    """One capture at k instants, `SAMPLE` apart; cross-track and angles + right of the leg."""

    time: Any  # (k,) s
    cross_track: Any  # (k,) m
    track_error: Any  # (k,) rad, course over the ground minus that of the leg
    ground_speed: Any  # (k,) m/s
    bank: Any  # (k,) rad, of the turn
    smoother: Any = None  # (2 k, 2 k) of along and cross-track, by which the record was smoothed; None = it was not


class Loop(NamedTuple):
    """What closes the loop: the law, the bank that follows its command, and where the capture begins; arrays (*B,)."""

    law: LateralNavigation
    lag: Any  # s, of the bank behind its command
    roll_rate_limit: Any  # rad/s
    cross_track: Any  # m, at the first instant
    track_error: Any  # rad
    bank: Any  # rad
    line: Any = 0.0  # m, cross-track of the line that the law holds
    engaged: Any = -np.inf  # s after the first instant, at which the law takes over from a course that is held


class Response(NamedTuple):
    """A capture as a loop flies it, (k, *B)."""

    cross_track: Any  # m
    bank: Any  # rad, of the turn
    wanted: Any  # rad, what the law commands before its bank limit, 0 before it has taken over


class _Point(NamedTuple):
    """What the route law looks at of a deviation."""

    cross_track: Any
    cross_track_rate: Any


def response(loop: Loop, capture: Capture) -> Response:
    """How many loops at once would fly a capture, from its first instant on at the ground speed that was recorded.

    z' = V sin(track error), the track turns with g tan(bank) / V, and the bank follows the command with one lag and no
    faster than the roll-rate limit. The command is wings level until the law takes over. Each step takes the command at
    its middle and is exact in the lag. The bank is read from the turn of the track as it is in a record; the path is
    smoothed as the record was.
    """
    dt = SAMPLE / STEPS
    law, speeds = loop.law, _at_the_middles(capture.ground_speed)
    share = -np.expm1(-dt / loop.lag)  # of the way to the command, in one step
    unlimited = LateralNavigation(law.k1, law.k2, np.inf, law.cross_track_limit, np.inf)
    shape = np.broadcast_shapes(*map(np.shape, (law.k1, loop.lag, loop.cross_track)))
    cross_track = np.broadcast_to(np.asarray(loop.cross_track - loop.line, float), shape)
    track = np.broadcast_to(np.asarray(loop.track_error, float), shape)
    bank = np.broadcast_to(np.asarray(loop.bank, float), shape)
    count = len(capture.time)
    along, latest = np.zeros(shape), np.max(loop.engaged)
    places, tracks, commands = np.empty((2, count, *shape)), np.empty((count, *shape)), np.empty((count, *shape))
    for k in range(count):
        places[0, k], places[1, k], tracks[k] = along, cross_track, track
        commands[k] = (k * SAMPLE >= loop.engaged) * unlimited(
            _Point(cross_track, capture.ground_speed[k] * np.sin(track))
        )
        if k + 1 == count:
            break
        for step, speed in enumerate(speeds[k]):
            turn = 0.5 * dt * STANDARD_GRAVITY / speed * np.tan(bank)  # by the middle of the step
            rate = speed * np.sin(track)
            wanted = law(_Point(cross_track + 0.5 * dt * rate, speed * np.sin(track + turn)))
            before, bank = bank, rate_limit(bank, bank + share * (wanted - bank), loop.roll_rate_limit, dt)
            if k * SAMPLE <= latest:
                held = rate_limit(before, (1.0 - share) * before, loop.roll_rate_limit, dt)
                by_law = np.clip(((k + (step + 1) / STEPS) * SAMPLE - loop.engaged) / dt, 0.0, 1.0)  # of the step
                bank = held + by_law * (bank - held)
            turn = dt * STANDARD_GRAVITY / speed * np.tan(0.5 * (before + bank))
            along = along + dt * speed * np.cos(track + 0.5 * turn)
            cross_track = cross_track + dt * speed * np.sin(track + 0.5 * turn)
            track = track + turn
    speed = np.reshape(capture.ground_speed, (count, *(1,) * len(shape)))
    places[1] += loop.line
    if capture.smoother is not None:
        places = _smoothed(places, capture.smoother)
        tracks = np.arctan2(*_smoothed(speed * np.array((np.cos(tracks), np.sin(tracks))), capture.smoother)[::-1])
    return Response(places[1], bank_of_turn(speed, turn_rate(capture.time, tracks)), commands)


def smoother_of(track_error: Any, along: float, across: float, density: float) -> Any:
    """(2 k, 2 k) what a smoother with white jerk makes of places that are measured once in a `SAMPLE`.

    The smoothed path has the least sum of squared residuals over their variance and of squared jerk over its density,
    which is what the recursion of Rauch, Tung and Striebel finds. It is linear in the places, so the path of a law can
    be smoothed as the record was; what it does to a quick roll is then no lag of the aircraft.

    Parameters
    ----------
    track_error : (k,) rad, along which places are less accurate
    along, across : m, standard deviations of a place        density : m2/s5, of the jerk on each axis
    """
    count = len(track_error)
    jerk = np.diff(np.eye(count), 3, axis=0) / SAMPLE**3
    stiff = SAMPLE / density * jerk.T @ jerk
    c, s = np.cos(track_error)[:, None], np.sin(track_error)[:, None]
    own, mixed, other = (along * c) ** 2 + (across * s) ** 2, (along**2 - across**2) * c * s, (along * s) ** 2
    blocks = [[own * stiff, mixed * stiff], [mixed * stiff, (other + (across * c) ** 2) * stiff]]
    return np.linalg.inv(np.eye(2 * count) + np.block(blocks))


def _smoothed(pair: Any, smoother: Any) -> Any:
    """Along and across, (2, k, *B), behind a smoother."""
    return np.tensordot(smoother, pair.reshape(len(smoother), *pair.shape[2:]), 1).reshape(pair.shape)


def _at_the_middles(speed: Any) -> Any:
    """(k - 1, STEPS) ground speeds at the middles of the steps."""
    weights = (np.arange(STEPS) + 0.5) / STEPS
    return speed[:-1, None] * (1.0 - weights) + speed[1:, None] * weights


def capture_of(time: Any, cross_track: Any, track_error: Any, ground_speed: Any, begin: float, end: float) -> Capture:
    """The capture between two times of a record, which may have any rate.

    Parameters
    ----------
    time : (k,) s                                    cross_track : (k,) m
    track_error : (k,) rad, without steps            ground_speed : (k,) m/s
    """
    times = np.arange(max(begin, time[0]), min(end, time[-1]) + 1e-9, SAMPLE)
    offset, track, speed = (np.interp(times, time, values) for values in (cross_track, track_error, ground_speed))
    return Capture(times, offset, track, speed, bank_of_turn(speed, turn_rate(times, track)))
