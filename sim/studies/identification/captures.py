"""The verb ``identify``: the capture of a leg found in a flight, and the route law that flew it."""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from autopilot.capture import Capture, capture_of, smoother_of
from autopilot.identification import LawFit, identify_law
from autopilot.last_turn import LARGEST_TURN, LEAST_TURN, last_turn
from sim.errors import ScenarioError
from sim.flight.record import Flight

BEFORE, AFTER = 12.0, 40.0  # s of a capture before and after its turn
LEAST_BEFORE, LEAST_AFTER = 4.0, 15.0  # s of them that a record must have
LONGEST_GAP = 5.0  # s, over which a record is read as a straight line
SMOOTHED = (21.0, 2.8, 0.3)  # m, m, m2/s5: of the smoother of recorded flights, along and across, and its jerk
ONTO = math.radians(30.0)  # of track error, within which a turn onto a leg ends


def identify(flight: Flight, leg: int | None = None) -> LawFit:
    """The route law, its limits and the lag of the bank that fit the capture of a leg best.

    Only place and velocity over the ground are looked at, and which leg was active, so a recorded flight tells as much
    as one flown here.

    Parameters
    ----------
    leg : number of the leg, from 0; None is the last one

    Raises ``ScenarioError``, in a sentence, where the flight has no such leg or does not turn onto it.
    """
    legs = len(flight.route.legs)
    number = legs - 1 if leg is None else leg
    if not 0 <= number < legs:
        raise ScenarioError(f"identify: leg: there are legs 0 to {legs - 1}, not {number}")
    capture = _capture(flight, number)
    if flight.utc is not None:
        capture = capture._replace(smoother=smoother_of(capture.track_error, *SMOOTHED))
    return identify_law(capture)


def _capture(flight: Flight, number: int) -> Capture:
    """The last turn onto a leg with what lies around it."""
    s = flight.state
    deviation: Any = flight.route.deviation(
        np.full(len(flight.time), number), (s.north, s.east), (s.velocity_north, s.velocity_east)
    )
    whole = np.isfinite(deviation.cross_track) & np.isfinite(deviation.track_error)
    known = np.flatnonzero(whole & (deviation.distance_to_go > 0.0) & (flight.leg <= number))
    if len(known) < 2:
        raise ScenarioError(f"identify: the record has no place before the end of leg {number}")
    time, course = flight.time[known], np.unwrap(deviation.track_error[known])
    turn = last_turn(time, course)
    least, most = (math.degrees(angle) for angle in (LEAST_TURN, LARGEST_TURN))
    if turn is None:
        raise ScenarioError(f"identify: no turn of {least:.0f} deg or more leads onto leg {number}")
    if abs(turn.angle) > LARGEST_TURN:
        told = f"{abs(math.degrees(turn.angle)):.0f} deg, at most {most:.0f} are one capture"
        raise ScenarioError(f"identify: the last turn onto leg {number} is one of {told}")
    left = math.remainder(float(np.interp(turn.end, time, course)), math.tau)
    if abs(left) > ONTO:
        raise ScenarioError(f"identify: the last turn ends {abs(math.degrees(left)):.0f} deg off leg {number}")
    if turn.begin - time[0] < LEAST_BEFORE or time[-1] - turn.end < LEAST_AFTER:
        told = f"{turn.begin - time[0]:.0f} s before the turn and {time[-1] - turn.end:.0f} s after it"
        raise ScenarioError(f"identify: of {told} there must be {LEAST_BEFORE:.0f} s and {LEAST_AFTER:.0f} s")
    begin, end = turn.begin - BEFORE, turn.end + AFTER
    inside = time[(time >= begin) & (time <= end)]
    if np.diff(inside).max() > LONGEST_GAP:
        raise ScenarioError(f"identify: the record has a gap of {np.diff(inside).max():.0f} s in the capture")
    speed = np.hypot(s.velocity_north, s.velocity_east)[known]
    turns = float(np.interp(turn.end, time, course)) - left  # whole ones, taken off
    return capture_of(time, deviation.cross_track[known], course - turns, speed, begin, end)
