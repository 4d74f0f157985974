"""Every gain from the linear model: linear-quadratic inner loops and the law of the route mode, by one recipe.

The weights say, in physical units, which deviation is as bad as which (Bryson's rule); they are the same for every
aircraft. The result is plain floats, so a worker process flies a design and never makes one.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any, NamedTuple

import numpy as np

from aircraft.state import STANDARD_GRAVITY
from autopilot.mode import RATE_MARGIN
from autopilot.modes.lateral_navigation import LateralNavigation

# Bryson weights: the deviation that is as bad as every other one in the list
AIRSPEED, ANGLE_OF_ATTACK, PITCH_RATE, PITCH, HEIGHT = 2.0, math.radians(8), math.radians(5), math.radians(5), 4.0
AIRSPEED_INTEGRAL, HEIGHT_INTEGRAL = 12.0, 30.0  # m, m s
THROTTLE = ELEVATOR = 0.25  # of full control
SIDESLIP, ROLL_RATE, YAW_RATE, BANK = math.radians(3), math.radians(12), math.radians(6), math.radians(4)
BANK_INTEGRAL = math.radians(12)  # rad s
AILERON, RUDDER = 0.47, 0.35  # of full control

REFERENCE_SHARE = (
    3.0  # of the bandwidth of the bank loop: natural frequency of the reference, which only rounds corners
)
COMMAND_RATE = math.radians(5.0)  # rad/s, at which the commanded bank runs up to its limit
BANK_OVERSHOOT = 0.1  # of the bank limit, over it at the end of that ramp; a slow loop needs a slower reference
SETTLED, STEP = 20.0, 0.05  # s, of the ramp that is looked at
SLOWEST_REFERENCE = 0.3  # of the bandwidth
LAW_SHARE = 1.0 / 6.0  # of the bandwidth of the bank loop: fastest natural frequency of the route law
BANK_SHARE = 0.85  # of the bank limit that an undisturbed intercept may use
LAW_DAMPING = 0.95
INTERCEPT = math.radians(30.0)

SCHEDULED = (
    *("angle_of_attack", "elevator", "throttle", "throttle_per_slope"),
    *("throttle_airspeed", "throttle_alpha", "throttle_pitch_rate", "throttle_pitch", "throttle_height"),
    *("throttle_airspeed_sum", "throttle_height_sum"),
    *("elevator_airspeed", "elevator_alpha", "elevator_pitch_rate", "elevator_pitch", "elevator_height"),
    *("elevator_airspeed_sum", "elevator_height_sum"),
    *("aileron_sideslip", "aileron_roll_rate", "aileron_yaw_rate", "aileron_bank", "aileron_bank_sum"),
    *("rudder_sideslip", "rudder_roll_rate", "rudder_yaw_rate", "rudder_bank", "rudder_bank_sum"),
    *("aileron_per_sideslip", "rudder_per_sideslip"),
)


class OperatingPoint(NamedTuple):
    """A trim and the linear model about it."""

    flaps: float  # rad
    gear: float
    airspeed: float  # m/s, true
    equivalent_airspeed: float  # m/s
    angle_of_attack: float  # rad
    elevator: float
    throttle: float
    longitudinal: tuple[Any, Any]  # A (5, 5), B (5, 2): airspeed, angle of attack, pitch rate, pitch, height
    lateral: tuple[Any, Any]  # A (4, 4), B (4, 2): sideslip, roll rate, yaw rate, bank


class Schedule(NamedTuple):
    """One flap setting: each of SCHEDULED is ``constant + slope / equivalent airspeed^2``, as lift coefficients."""

    flaps: float
    constant: tuple[float, ...]
    slope: tuple[float, ...]


class Designed(NamedTuple):
    """All that a flight needs of the design; plain numbers, so that it travels in a file."""

    schedules: tuple[Schedule, ...]  # by rising flaps
    bank_bandwidth: float  # rad/s, of the slowest operating point
    reference_frequency: float  # rad/s, of the critically damped bank reference
    bank_per_sideslip: float  # that keeps the track straight, in the landing configuration
    k1: float
    k2: float
    bank_limit: float
    cross_track_limit: float
    cross_track_rate_limit: float
    turning: float = 1.0  # share of g tan(bank) that turns the path: no loop takes the sideslip out of a steady turn

    @property
    def law(self) -> LateralNavigation:
        """The route law of the design."""
        return LateralNavigation(self.k1, self.k2, self.bank_limit, self.cross_track_limit, self.cross_track_rate_limit)

    def with_law(self, law: LateralNavigation) -> Designed:
        """The design with another route law."""
        names = ("k1", "k2", "bank_limit", "cross_track_limit", "cross_track_rate_limit")
        return self._replace(**{name: getattr(law, name) for name in names})

    def time_to_roll(self, speed: float, roll_rate_limit: float) -> float:
        """Time, s, by which a turn flown by the law lags behind the circle of its plan.

        Half the time to roll in, the lag of the bank reference at both ends, and the law's own way out of saturation:
        it ends a turn on the leg without overshoot when the full-bank circle passes the leg at bank_limit/(2 k1).
        """
        return (
            self.bank_limit / (2.0 * roll_rate_limit)
            + 4.0 / self.reference_frequency
            + self.bank_limit / (2.0 * self.k1 * speed)
        )

    def to_table(self) -> dict[str, Any]:
        """As lists and floats, for a file."""
        return self._asdict() | {
            "schedules": [{"flaps": f, "constant": list(c), "slope": list(s)} for f, c, s in self.schedules]
        }

    @classmethod
    def from_table(cls, table: dict[str, Any]) -> Designed:
        """Inverse of ``to_table``."""
        schedules = tuple(
            Schedule(float(s["flaps"]), tuple(map(float, s["constant"])), tuple(map(float, s["slope"])))
            for s in table["schedules"]
        )
        numbers = {name: float(table[name]) for name in cls._fields if name != "schedules"}
        return cls(schedules, **numbers)


def design(points: Sequence[OperatingPoint], speed: float, bank_limit: float) -> Designed:
    """Inner loops at every operating point and the route law for the fastest of them.

    Parameters
    ----------
    points : at least two speeds at each flap setting, of which the slowest and the fastest count
    speed : m/s, at which the route is intercepted
    bank_limit : rad
    """
    settings = sorted({point.flaps for point in points})
    schedules = []
    for flaps in settings:
        alike = sorted((point for point in points if point.flaps == flaps), key=lambda point: point.equivalent_airspeed)
        slow, fast = alike[0], alike[-1]
        if slow.equivalent_airspeed == fast.equivalent_airspeed:
            raise ValueError(f"the design needs two speeds with flaps at {math.degrees(flaps):.0f} deg, not one")
        x_slow, x_fast = slow.equivalent_airspeed**-2, fast.equivalent_airspeed**-2
        at_slow, at_fast = np.array(_scheduled(slow)), np.array(_scheduled(fast))
        slope = (at_slow - at_fast) / (x_slow - x_fast)
        schedules.append(Schedule(flaps, tuple(map(float, at_slow - slope * x_slow)), tuple(map(float, slope))))
    bandwidth = min(bank_bandwidth(point) for point in points)
    law = lateral_law(bandwidth, speed, bank_limit)
    return Designed(
        tuple(schedules),
        bandwidth,
        reference_frequency(points, bandwidth, bank_limit),
        steady_sideslip(min(points, key=lambda point: point.airspeed))[2],
        law.k1,
        law.k2,
        law.bank_limit,
        law.cross_track_limit,
        law.cross_track_rate_limit,
    )


def _scheduled(point: OperatingPoint) -> list[float]:
    longitudinal, lateral = longitudinal_gains(point), lateral_gains(point)
    per_slope = STANDARD_GRAVITY / float(point.longitudinal[1][0, 0])
    return [
        *(point.angle_of_attack, point.elevator, point.throttle, per_slope),
        *longitudinal.ravel().tolist(),
        *lateral.ravel().tolist(),
        *steady_sideslip(point)[:2],
    ]


def longitudinal_gains(point: OperatingPoint) -> Any:
    """u = -K e for [throttle, elevator] and the errors of the five states and the sums of airspeed and height error."""
    A, B = point.longitudinal
    A7, B7 = np.zeros((7, 7)), np.zeros((7, 2))
    A7[:5, :5], B7[:5] = A, B
    A7[5, 0] = A7[6, 4] = 1.0
    worst = np.array([AIRSPEED, ANGLE_OF_ATTACK, PITCH_RATE, PITCH, HEIGHT, AIRSPEED_INTEGRAL, HEIGHT_INTEGRAL])
    return _linear_quadratic(
        A7, B7, np.diag(worst**-2.0), np.diag(np.array([THROTTLE, ELEVATOR]) ** -2.0), "throttle and elevator"
    )


def lateral_gains(point: OperatingPoint) -> Any:
    """u = -K e for [aileron, rudder]: sideslip, roll rate, yaw rate beyond the turn's, bank error and its sum."""
    A, B = point.lateral
    turn = STANDARD_GRAVITY / point.airspeed
    T = np.eye(4)
    T[2, 3] = -turn  # yaw rate in excess of that of a coordinated turn at this bank
    A5, B5 = np.zeros((5, 5)), np.zeros((5, 2))
    A5[:4, :4], B5[:4] = T @ A @ np.linalg.inv(T), T @ B
    A5[4, 3] = 1.0
    worst = np.array([SIDESLIP, ROLL_RATE, YAW_RATE, BANK, BANK_INTEGRAL])
    return _linear_quadratic(
        A5, B5, np.diag(worst**-2.0), np.diag(np.array([AILERON, RUDDER]) ** -2.0), "aileron and rudder"
    )


def _linear_quadratic(A: Any, B: Any, Q: Any, R: Any, controls: str) -> Any:
    from scipy.linalg import solve_continuous_are

    try:
        K = np.linalg.solve(R, B.T @ solve_continuous_are(A, B, Q, R))
        if max(np.linalg.eigvals(A - B @ K).real) < 0.0:  # rounding decides whether scipy sees that nothing steers
            return K
    except np.linalg.LinAlgError:
        pass
    raise ValueError(f"no gains can be designed: {controls} do not steer this aircraft")


def steady_sideslip(point: OperatingPoint) -> tuple[float, float, float]:
    """Aileron, rudder and bank per sideslip on a straight track."""
    A, B = point.lateral
    aileron, rudder, bank = np.linalg.solve(np.column_stack([B[:3], A[:3, 3]]), -A[:3, 0])
    return float(aileron), float(rudder), float(bank)


def bank_loop(point: OperatingPoint) -> tuple[Any, Any, Any]:
    """(A, B, C) from the bank reference and its rate to the bank, closed by the lateral gains."""
    A, B = point.lateral
    K = lateral_gains(point)
    turn = STANDARD_GRAVITY / point.airspeed
    onto = np.zeros((5, 5))  # errors from states, the reference apart
    onto[:4, :4] = np.eye(4)
    onto[2, 3], onto[4, 4] = -turn, 1.0
    A5, B5 = np.zeros((5, 5)), np.zeros((5, 2))
    A5[:4, :4], B5[:4] = A, B
    A5[4, 3] = 1.0
    reference = np.column_stack([B5 @ K[:, 3] - np.eye(5)[4], B5 @ K[:, 1]])
    return A5 - B5 @ K @ onto, reference, np.array([0.0, 0.0, 0.0, 1.0, 0.0])


def bank_bandwidth(point: OperatingPoint) -> float:
    """Frequency, rad/s, at which the bank follows its reference with -3 dB, without help from the reference's rate."""
    A, B, C = bank_loop(point)
    B = B[:, 0]
    frequency = np.geomspace(0.05, 50.0, 2000)
    shifted = 1j * frequency[:, None, None] * np.eye(5) - A
    response = np.abs(np.linalg.solve(shifted, B[:, None])[..., 0] @ C)
    below = np.nonzero(response < math.sqrt(0.5))[0]
    if not len(below):
        raise ValueError("the bank loop has no bandwidth: the model has no usable ailerons")
    return float(frequency[below[0]])


def reference_frequency(points: Sequence[OperatingPoint], bandwidth: float, bank_limit: float) -> float:
    """Natural frequency, rad/s, of the bank reference: as high as the bank's overshoot over its limit allows."""
    highest = REFERENCE_SHARE * bandwidth

    def overshoots(frequency: float) -> bool:
        return any(bank_overshoot(point, frequency, bank_limit) > BANK_OVERSHOOT * bank_limit for point in points)

    if not overshoots(highest):
        return highest
    low, high = SLOWEST_REFERENCE * bandwidth, highest
    while high > 1.02 * low:
        middle = math.sqrt(low * high)
        low, high = (low, middle) if overshoots(middle) else (middle, high)
    return low


def bank_overshoot(point: OperatingPoint, frequency: float, bank_limit: float) -> float:
    """How far, rad, the bank goes over its limit when the command runs up to it at ``COMMAND_RATE``.

    ``frequency`` (rad/s) is that of the critically damped reference between the command and the closed bank loop.
    """

    from scipy.linalg import expm

    A, B, C = bank_loop(point)
    A9 = np.zeros((9, 9))  # the loop, the reference and its rate, the command and its rate
    A9[:5, :5], A9[:5, 5:7] = A, B
    A9[5, 6] = A9[7, 8] = 1.0
    A9[6, 5:8] = -frequency * frequency, -2.0 * frequency, frequency * frequency
    onward = expm(A9 * STEP)
    ramp = round(bank_limit / COMMAND_RATE / STEP)
    x, peak = np.zeros(9), 0.0
    x[8] = bank_limit / (ramp * STEP)
    for step in range(round(SETTLED / STEP)):
        if step == ramp:
            x[8] = 0.0
        x = onward @ x
        peak = max(peak, float(C @ x[:5]))
    return peak - bank_limit


def intercept_peak(damping: float) -> float:
    """Largest |z''| / (wn |z'|) of the linear law that takes over on the intercept line.

    There z'' is the impulse response: zero at first, with the slope wn^2 z'. Its peak is
    exp(-damping acos(damping) / sqrt(1 - damping^2)).
    """
    if damping >= 1.0:
        raise ValueError(f"the damping of the route law must be below 1, not {damping}")
    return math.exp(-damping * math.acos(damping) / math.sqrt(1.0 - damping * damping))


def lateral_law(bank_bandwidth: float, speed: float, bank_limit: float, turning: float = 1.0) -> LateralNavigation:
    """Gains and limits of the route law [Vasylyev 2003, eq. (4)] from what the bank loop and the bank limit allow.

    The natural frequency is the lower of a share of the bank bandwidth, so that the lag of the bank does not matter,
    and of that at which the capture from a 30 degree intercept asks for a share of the bank limit. ``turning`` is the
    share of g tan(bank) that turns the path.
    """
    closing = speed * math.sin(INTERCEPT)
    turn = pull(turning) * math.tan(bank_limit)
    authority = BANK_SHARE * turn / (intercept_peak(LAW_DAMPING) * closing)
    return law_of_frequency(min(LAW_SHARE * bank_bandwidth, authority), speed, bank_limit, turning)


def pull(turning: float) -> float:
    """What a law counts on of gravity, m/s2.

    A loss of less than what `BANK_SHARE` leaves of the bank limit is left to that; beyond it, the capture would meet
    the limit and overshoot.
    """
    return STANDARD_GRAVITY * (turning if turning < BANK_SHARE else 1.0)


def law_of_frequency(frequency: float, speed: float, bank_limit: float, turning: float = 1.0) -> LateralNavigation:
    """The route law of a natural frequency (rad/s), with intercepts at 30 degrees of the speed (m/s)."""
    k1 = frequency**2 / pull(turning)
    k2 = 2.0 * LAW_DAMPING * frequency / pull(turning)
    cross_track_limit = k2 / k1 * (speed * math.sin(INTERCEPT))
    return LateralNavigation(
        k1, k2, bank_limit, cross_track_limit, RATE_MARGIN * (k1 * cross_track_limit + bank_limit) / k2
    )
