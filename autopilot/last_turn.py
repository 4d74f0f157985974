"""The turn onto a leg, found in a record by the turn rate; and the bank that such a turn tells.

For the capture of a leg that is to be identified (`autopilot.identification`): at the record's own rate, to one side,
by 15 degrees or more, with its end. What is compared with flights of others (`sim.metrics.arrivals.last_turn`) is
found at one look a second, from 8 degrees on and by its angle to the final, as a surveillance sensor can see it.
"""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np

from aircraft.state import STANDARD_GRAVITY

TURNING = np.radians(0.3)  # rad/s; slower is no turn: at 75 m/s it takes 2.3 degrees of bank
LEAST_TURN = np.radians(15.0)  # rad, of course; less corrects, it does not turn onto a leg
LARGEST_TURN = np.radians(115.0)  # rad; more is no capture: far abeam a route law commands no such turn in one
PAUSE = 5.0  # s; a turn that goes on to the same side within them is one turn


class LastTurn(NamedTuple):
    """The last turn to one side by `LEAST_TURN` or more."""

    begin: float  # s, at which the turn rate first exceeds ``TURNING``
    end: float  # s, at which it last does
    angle: float  # rad, change of course, + right


def last_turn(time: Any, course: Any) -> LastTurn | None:
    """The last turn of a record; None where the course never changes by `LEAST_TURN` to one side.

    Parameters
    ----------
    time : (k,) s        course : (k,) rad over the ground, without steps at +-pi
    """
    rate = turn_rate(time, course)
    found: list[tuple[int, int]] = []
    for side in (1.0, -1.0):
        turning = np.flatnonzero(side * rate > TURNING)
        if not len(turning):
            continue
        apart = np.flatnonzero(np.diff(time[turning]) > PAUSE)
        begins, ends = turning[np.r_[0, apart + 1]], turning[np.r_[apart, len(turning) - 1]]
        turned = side * (course[ends] - course[begins])
        found += [(int(b), int(e)) for b, e, angle in zip(begins, ends, turned, strict=True) if angle >= LEAST_TURN]
    if not found:
        return None
    begin, end = max(found, key=lambda edges: edges[1])
    return LastTurn(float(time[begin]), float(time[end]), float(course[end] - course[begin]))


def turn_rate(time: Any, course: Any) -> Any:
    """rad/s, over the two neighbours of each instant; ``course`` (k, *B) at ``time`` (k,)."""
    return np.gradient(course, time, axis=0)


def bank_of_turn(ground_speed: Any, rate: Any) -> Any:
    """rad, of a level, coordinated turn of the path over the ground: tan(bank) = V rate / g."""
    return np.arctan(ground_speed * rate / STANDARD_GRAVITY)
