"""Lowest speed of level flight: by quasi-steady trims, and flown into the stall."""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import NamedTuple

import numpy as np

from aircraft.airframe import Airframe
from aircraft.errors import TrimError
from aircraft.linearise import LONGITUDINAL, linearise
from aircraft.trim import Trim, trim

HEIGHT = 100.0  # m: clear of the ground effect, density of sea level within 1 %
SINKING = 0.3  # m/s: from here on the flight is no longer level
CONTROL = 1.0 / 30.0  # s, of the controls


class MinimumSpeed(NamedTuple):
    """m/s, true, at 100 m above sea level in the standard atmosphere."""

    trimmed: float  # lowest speed at which a trim exists
    flown: float  # lowest speed met in level flight before the aircraft sinks
    angle_of_attack: float  # rad, of the body, at the flown minimum


def minimum_speed(
    load: Callable[[], Airframe], flaps: float, gear: float = 1.0, deceleration: float = 0.5, fast: float = 1.4
) -> MinimumSpeed:
    """Slow down in level flight at ``deceleration`` (m/s2) until the height cannot be held.

    Elevator and power follow the quasi-steady trims of the momentary speed; a linear-quadratic elevator feedback
    designed at the slowest trim keeps height and pitch. ``load`` gives a fresh aircraft each time it is called; the
    flight begins at ``fast`` times the lowest trimmed speed.
    """
    airframe = load()

    def at(speed: float) -> Trim:
        return trim(airframe, speed, 0.0, HEIGHT, flaps, gear, -deceleration)

    slowest = _slowest(at)
    trims = [at(speed) for speed in np.linspace(fast * slowest, slowest, 12)]
    speeds = [each.initial.airspeed for each in trims]
    wanted = np.array(
        [(each.initial.angle_of_attack, each.controls.elevator, each.controls.throttle) for each in trims]
    )
    gain = _height_feedback(airframe, trims[len(trims) // 2])

    flight = load()
    state = flight.begin(trims[0].at(0.0, 0.0, HEIGHT, 0.0))
    lowest, alpha = state.airspeed, state.angle_of_attack
    while state.velocity_up > -SINKING:
        speed = max(state.airspeed, speeds[-1])
        steady, elevator, throttle = (np.interp(-speed, -np.array(speeds), column) for column in wanted.T)
        error = np.array(
            [state.angle_of_attack - steady, state.pitch_rate, state.pitch - steady, state.height - HEIGHT]
        )
        controls = trims[0].controls._replace(
            elevator=float(np.clip(elevator - gain @ error, -1.0, 1.0)), throttle=float(throttle)
        )
        flight.step(controls, round(CONTROL * flight.rate))
        state = flight.read()
        if state.airspeed < lowest:
            lowest, alpha = state.airspeed, state.angle_of_attack
        if state.time > (speeds[0] / deceleration):
            raise TrimError("the aircraft did not slow down to its stall")
    return MinimumSpeed(slowest, lowest, alpha)


def _slowest(at: Callable[[float], Trim]) -> float:
    """Lowest speed with a trim, by bisection to 0.01 m/s."""
    high = 40.0
    while not _exists(at, high):
        high *= 1.3
        if high > 300.0:
            at(high)
    low = 0.0
    while high - low > 0.01:
        middle = 0.5 * (low + high)
        low, high = (low, middle) if middle > 0.0 and _exists(at, middle) else (middle, high)
    return high


def _exists(at: Callable[[float], Trim], speed: float) -> bool:
    try:
        at(speed)
    except TrimError:
        return False
    return True


def _height_feedback(airframe: Airframe, point: Trim) -> np.ndarray:
    """Elevator per angle of attack, pitch rate, pitch and height; 2 deg and 2 m cost as much as full elevator."""
    from scipy.linalg import solve_continuous_are

    states, inputs = LONGITUDINAL[1:], ("elevator",)
    matrix, column = linearise(airframe, point).part(states, inputs)
    weights = np.diag([0.0, 0.0, math.radians(2.0) ** -2, 2.0**-2])
    gain: np.ndarray = (column.T @ solve_continuous_are(matrix, column, weights, np.eye(1)))[0]
    return gain
