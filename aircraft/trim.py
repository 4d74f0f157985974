"""Trim: the steady state of an aircraft at a speed and flight-path angle, by Newton's method on the airframe itself."""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import NamedTuple

import numpy as np

from aircraft.air import STANDARD_DENSITY
from aircraft.airframe import Airframe, InitialCondition
from aircraft.errors import TrimError
from aircraft.state import Controls

TOLERANCE = 1e-8  # m/s2 and rad/s2; Newton converges quadratically, so this is one iteration beyond 1e-4
ACCEPTED = 1e-6  # m/s2 and rad/s2; the thrust of a propeller comes to rest only to about 1e-8 of itself
ITERATIONS = 40
STALE = 10  # iterations without halving the residual: there is no such state
STALE_NEAR = 4  # from a neighbouring trim
FALLING = 0.3  # of the residual from one iteration to the next, from a neighbouring trim: its Jacobian still serves
DIFFERENCE = 1e-4  # of the central differences: rad and share of control
LARGEST_STEP = np.array([math.radians(3.0), 0.2, 0.2, math.radians(5.0), 0.2, 0.2])
TOO_WEAK = "it needs more than full power"
SHORTFALLS = 8  # iterations of the search for the power that lacks
STALLED = 0.25  # rad of body incidence; no aeroplane of ours carries its weight beyond


class Trim(NamedTuple):
    """A steady state through the air; wind does not change it."""

    initial: InitialCondition
    flight_path_angle: float  # rad, through the air
    residual: float  # largest of the six accelerations left over, m/s2 or rad/s2

    @property
    def controls(self) -> Controls:
        """Controls that hold it."""
        return self.initial.controls

    def at(self, north: float, east: float, height: float, heading: float) -> InitialCondition:
        """The same steady state at another place and heading."""
        return self.initial._replace(north=north, east=east, height=height, heading=heading)


def trim(
    airframe: Airframe,
    airspeed: float,
    flight_path_angle: float = 0.0,
    height: float = 500.0,
    flaps: float = 0.0,
    gear: float = 0.0,
    acceleration: float = 0.0,
    near: Trim | None = None,
) -> Trim:
    """Straight flight at zero sideslip: angle of attack, throttle and five more such that nothing accelerates.

    Parameters
    ----------
    airframe : one that has not flown; it is left in the trimmed state.
    airspeed : m/s, true.
    flight_path_angle : rad, through the air, + up.
    acceleration : m/s2 along the path; not zero for a quasi-steady deceleration.
    near : a trim to start from, which saves iterations.

    Raises ``TrimError`` when there is no such state.
    """
    if not airspeed > 0.0 or not math.isfinite(airspeed):
        raise TrimError(f"airspeed must be positive, not {airspeed} m/s")
    if not 0.0 <= flaps <= airframe.full_flaps + 1e-9:
        raise TrimError(
            f"flaps must lie between 0 and {math.degrees(airframe.full_flaps):.0f} deg, "
            f"not {math.degrees(flaps):.0f} deg"
        )

    def condition(unknowns: np.ndarray) -> InitialCondition:
        alpha, throttle, elevator, bank, aileron, rudder = map(float, unknowns)
        controls = Controls(aileron, elevator, rudder, throttle, flaps, gear)
        pitch = _pitch(alpha, bank, flight_path_angle)
        return InitialCondition(0.0, 0.0, height, 0.0, pitch, bank, airspeed, alpha, 0.0, controls)

    def residual(unknowns: np.ndarray, acceleration: float = acceleration) -> np.ndarray:
        state = airframe.begin(condition(unknowns))
        along, side, down, roll, pitch, yaw = airframe.accelerations()
        alpha = state.angle_of_attack
        along -= acceleration * math.cos(alpha)
        down -= acceleration * math.sin(alpha)
        return np.array([along, side, down, roll, pitch, yaw])

    unknowns = np.array([math.radians(4.0), 0.4, 0.0, 0.0, 0.0, 0.0] if near is None else _unknowns(near.initial))
    patience = STALE if near is None else STALE_NEAR
    best, before, stale, jacobian = math.inf, math.inf, 0, None
    for _ in range(ITERATIONS):
        error = residual(unknowns)
        size = float(np.abs(error).max())
        best, stale = (size, 0) if size < 0.5 * best else (best, stale + 1)
        if size < TOLERANCE or stale == patience or (stale > 0 and size < ACCEPTED):
            break
        if jacobian is None or near is None or size > FALLING * before:
            steps = DIFFERENCE * np.eye(6)
            jacobian = np.column_stack(
                [(residual(unknowns + step) - residual(unknowns - step)) / (2.0 * DIFFERENCE) for step in steps]
            )
        before = size
        correction = np.linalg.lstsq(jacobian, error, rcond=1e-10)[0]
        unknowns = unknowns - correction / max(1.0, float(np.abs(correction / LARGEST_STEP).max()))
        unknowns = np.clip(unknowns, [-0.3, 0.0, -1.0, -0.5, -1.0, -1.0], [0.6, 1.0, 1.0, 0.5, 1.0, 1.0])
    remaining = float(np.abs(residual(unknowns)).max())
    if not remaining < ACCEPTED:
        told = _failure(airframe.data.title, airspeed, flight_path_angle, unknowns, remaining)
        if told.endswith(TOO_WEAK) and near is None:
            told += _lacking(airframe, residual, unknowns, acceleration, airspeed, height, flaps)
        raise TrimError(told)
    return Trim(condition(unknowns), flight_path_angle, remaining)


def _unknowns(initial: InitialCondition) -> list[float]:
    controls = initial.controls
    return [
        *(initial.angle_of_attack, controls.throttle, controls.elevator),
        *(initial.bank, controls.aileron, controls.rudder),
    ]


def _pitch(alpha: float, bank: float, flight_path_angle: float) -> float:
    """Pitch at zero sideslip for a wanted flight-path angle [Stevens and Lewis, eq. (3.4-2)]."""
    a, b, sine = math.cos(alpha), math.cos(bank) * math.sin(alpha), math.sin(flight_path_angle)
    return math.atan2(a * b + sine * math.sqrt(a * a - sine * sine + b * b), a * a - sine * sine)


def _failure(title: str, airspeed: float, flight_path_angle: float, unknowns: np.ndarray, remaining: float) -> str:
    where = f"{title} cannot be trimmed at {airspeed:.1f} m/s and {math.degrees(flight_path_angle):+.2f} deg"
    alpha, throttle, elevator, _, aileron, rudder = unknowns
    if alpha > STALLED:
        return f"{where}: it is too slow, the wing stalls before it carries the weight"
    if throttle > 0.999:
        return f"{where}: {TOO_WEAK}"
    if throttle < 0.001:
        return f"{where}: it needs less than idle power"
    for name, value in (("elevator", elevator), ("aileron", aileron), ("rudder", rudder)):
        if abs(value) > 0.999:
            return f"{where}: the {name} is at its stop"
    return f"{where}: {remaining:.2g} m/s2 remain, whatever the controls"


def _lacking(
    airframe: Airframe,
    residual: Callable[[np.ndarray, float], np.ndarray],
    unknowns: np.ndarray,
    acceleration: float,
    airspeed: float,
    height: float,
    flaps: float,
) -> str:
    """What lacks at full power: the same Newton iteration with the acceleration along the path for the power lever."""
    full, unknowns = unknowns[1], np.array([*unknowns[:1], acceleration, *unknowns[2:]])

    def error_of(x: np.ndarray) -> np.ndarray:
        return residual(np.array([x[0], full, *x[2:]]), float(x[1]))

    for _ in range(SHORTFALLS):
        error = error_of(unknowns)
        jacobian = np.column_stack(
            [
                (error_of(unknowns + step) - error_of(unknowns - step)) / (2.0 * DIFFERENCE)
                for step in DIFFERENCE * np.eye(6)
            ]
        )
        unknowns = unknowns - np.linalg.lstsq(jacobian, error, rcond=1e-10)[0]
    if not float(np.abs(error_of(unknowns)).max()) < ACCEPTED:
        return ""
    force = airframe.mass * (acceleration - float(unknowns[1]))
    share = float(airframe.air.density(height)) / STANDARD_DENSITY
    lacks = f"{force * airspeed / 1e3:.0f} kW lack, {force / 1e3:.2f} kN of thrust"
    return f": {lacks}, with flaps at {math.degrees(flaps):.0f} deg in air of {share:.2f} of the density of sea level"
