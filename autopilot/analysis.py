"""What the route law does before anything flies: poles, margins, limit cycles, predictions, the phase portrait.

For design, tests and reports; python-control is imported when a margin is asked for, because it takes seconds.
"""

from __future__ import annotations

import math
from typing import Any, NamedTuple

import numpy as np
from scipy.linalg import expm
from scipy.optimize import brentq

from aircraft.state import STANDARD_GRAVITY
from autopilot.design import OperatingPoint, bank_loop
from autopilot.modes.lateral_navigation import LateralNavigation
from autopilot.route import PathDeviation
from autopilot.saturation import rate_limit

PREDICTION_STEP = 0.02  # s
LOOP_DELAY = 0.1  # s: half of it actuators of 20 rad/s, which the linear model has not, half sample and hold at 30 Hz


class Prediction(NamedTuple):
    """A predicted capture of one leg."""

    time: Any  # (k,) s
    cross_track: Any  # (k,) m
    cross_track_rate: Any  # (k,) m/s
    bank: Any  # (k,) rad


def closed_loop(law: LateralNavigation) -> Any:
    """F of the law inside its limits on the double integrator [Vasylyev 2003, eq. (7)].

    Erratum: printed with the control added as an input, used without it, because the feedback is already folded into F
    and would count twice.
    """
    return np.array([[0.0, 1.0], [-STANDARD_GRAVITY * law.k1, -STANDARD_GRAVITY * law.k2]])


def poles(law: LateralNavigation) -> tuple[complex, complex]:
    """Poles of the law inside its limits [Vasylyev 2003, eq. (7)]."""
    one, other = np.linalg.eigvals(closed_loop(law)).astype(complex)
    return complex(one), complex(other)


def frequency_and_damping(law: LateralNavigation) -> tuple[float, float]:
    """Natural frequency (rad/s) and damping ratio inside the limits."""
    frequency = math.sqrt(STANDARD_GRAVITY * law.k1)
    return frequency, STANDARD_GRAVITY * law.k2 / (2.0 * frequency)


def outer_loop(law: LateralNavigation, point: OperatingPoint, reference_frequency: float) -> Any:
    """The route loop opened at the bank command, as a python-control state-space model."""
    import control

    w = reference_frequency
    reference = control.ss([[0.0, 1.0], [-w * w, -2.0 * w]], [[0.0], [w * w]], np.eye(2), 0.0)
    A, B, C = bank_loop(point)
    bank = control.ss(A, B, C.reshape(1, -1), 0.0)
    lateral = control.ss([[0.0, 1.0], [0.0, 0.0]], [[0.0], [STANDARD_GRAVITY]], [[law.k1, law.k2]], 0.0)
    delay = control.tf2ss(*control.pade(LOOP_DELAY, 3))
    return lateral * delay * bank * reference


class Margins(NamedTuple):
    """Stability margins of the route loop."""

    gain: float  # factor
    phase: float  # rad
    phase_crossover: float  # rad/s, where the gain margin is
    gain_crossover: float  # rad/s, where the phase margin is


def margins(law: LateralNavigation, point: OperatingPoint, reference_frequency: float) -> Margins:
    """Gain and phase margin of the route loop inside the limits of the law."""
    loop = outer_loop(law, point, reference_frequency)
    frequency = np.geomspace(1e-3, 1e2, 4000)
    response = loop(1j * frequency)

    def crossing(values: Any, of: Any) -> float:
        at = int(np.nonzero((values[:-1] > 0.0) & (values[1:] <= 0.0))[0][0])
        return float(brentq(lambda w: float(of(complex(loop(1j * w)))), frequency[at], frequency[at + 1]))

    # the loop comes from -180 deg (a double integrator), leads, and falls through -180 deg again
    turned = crossing(np.where(response.real < 0.0, -response.imag, 1.0), lambda value: -value.imag)
    level = crossing(np.abs(response) - 1.0, lambda value: abs(value) - 1.0)
    phase = math.pi + math.remainder(np.angle(complex(loop(1j * level))), math.tau)
    return Margins(1.0 / abs(complex(loop(1j * turned))), math.remainder(phase, math.tau), turned, level)


def saturation_describing_function(amplitude: float, limit: float) -> float:
    """Gain of a saturation for a sine: 2/pi (asin r + r sqrt(1 - r^2)), r = limit/amplitude, 1 below the limit."""
    if amplitude <= limit:
        return 1.0
    r = limit / amplitude
    return 2.0 / math.pi * (math.asin(r) + r * math.sqrt(1.0 - r * r))


class LimitCycle(NamedTuple):
    """A periodic motion that the bank limit sustains."""

    period: float  # s
    bank: float  # rad, amplitude of the flown bank
    cross_track: float  # m, amplitude


def limit_cycle(law: LateralNavigation, point: OperatingPoint, reference_frequency: float) -> LimitCycle | None:
    """The limit cycle that the describing function of the bank limit predicts; None where there is none.

    Saturation only lowers the gain, so a cycle needs a loop that is unstable without it (gain margin below one).
    """
    loop = outer_loop(law, point, reference_frequency)
    gain, _, frequency, _ = margins(law, point, reference_frequency)
    if not gain < 1.0:
        return None
    limit = float(law.bank_limit)
    command = brentq(lambda a: saturation_describing_function(a, limit) - gain, limit, 1e3 * limit)
    behind = saturation_describing_function(command, limit) * command  # bank command behind the limit
    response = abs(complex(loop(1j * frequency)))
    law_gain = abs(complex(law.k1, law.k2 * frequency))
    cross_track = behind * response / law_gain
    return LimitCycle(2.0 * math.pi / frequency, cross_track * frequency**2 / STANDARD_GRAVITY, cross_track)


def predict_linear(law: LateralNavigation, cross_track: float, cross_track_rate: float, time: Any) -> Prediction:
    """The law without limits on the double integrator, exactly [Vasylyev 2003, eq. (7)]."""
    F = closed_loop(law)
    states = np.array([expm(F * t) @ [cross_track, cross_track_rate] for t in np.asarray(time)])
    return Prediction(time, states[:, 0], states[:, 1], -(states @ [law.k1, law.k2]))


def predict_limited(law: LateralNavigation, cross_track: float, cross_track_rate: float, time: Any) -> Prediction:
    """The law with its limits on the double integrator [Vasylyev 2003, eq. (6)]."""
    return _predict(law, cross_track, cross_track_rate, time, None)


class BankReference(NamedTuple):
    """How the bank follows its command, and the speed at which the bank turns the path."""

    speed: float  # m/s
    roll_rate_limit: float  # rad/s, of the command
    frequency: float  # rad/s, of the critically damped reference


def predict_kinematic(
    law: LateralNavigation, cross_track: float, cross_track_rate: float, time: Any, bank: BankReference
) -> Prediction:
    """The law with its limits, the rate-limited bank reference and z'' = g tan(bank) cos(course error)."""
    return _predict(law, cross_track, cross_track_rate, time, bank)


def _predict(
    law: LateralNavigation, cross_track: float, cross_track_rate: float, time: Any, reference: BankReference | None
) -> Prediction:
    """Semi-implicit Euler steps, interpolated at ``time``."""
    dt = PREDICTION_STEP
    z, rate, command, bank, bank_rate = float(cross_track), float(cross_track_rate), 0.0, 0.0, 0.0
    steps = math.ceil(float(np.max(time)) / dt) + 1
    rows = np.empty((steps, 3))
    for step in range(steps):
        wanted = law(PathDeviation(z, rate, math.inf, 0.0, 0.0, 0.0))
        if reference is None:
            bank, acceleration = wanted, STANDARD_GRAVITY * wanted
        else:
            command = rate_limit(command, wanted, reference.roll_rate_limit, dt)
            w = reference.frequency
            bank_rate += w * (w * (command - bank) - 2.0 * bank_rate) * dt
            bank += bank_rate * dt
            sine = max(-1.0, min(rate / reference.speed, 1.0))
            acceleration = STANDARD_GRAVITY * math.tan(bank) * math.sqrt(1.0 - sine * sine)
        rows[step] = z, rate, bank
        rate += acceleration * dt
        z += rate * dt
    at = dt * np.arange(steps)
    return Prediction(time, *(np.interp(time, at, column) for column in rows.T))


class PhasePortrait(NamedTuple):
    """Geometry of the law in the plane of cross-track deviation (m) and its rate (m/s)."""

    cross_track_limit: float
    cross_track_rate_limit: float
    intercept_speed: float  # far captures settle on -/+ this rate
    zero_bank: Any  # (2, k) where the law commands no bank: the switching curve
    right_limit: Any  # (2, k) boundary beyond which the bank stays at its right limit
    left_limit: Any  # (2, k) at its left limit


def phase_portrait(law: LateralNavigation, cross_track: Any) -> PhasePortrait:
    """Curves of the portrait over the given cross-track deviations (k,); NaN where a curve leaves the rate limit."""
    z = np.asarray(cross_track, float)
    held = np.clip(z, -law.cross_track_limit, law.cross_track_limit)

    def curve(bank: float) -> Any:
        rate = (-bank - law.k1 * held) / law.k2
        return np.stack([z, np.where(np.abs(rate) <= law.cross_track_rate_limit, rate, np.nan)])

    return PhasePortrait(
        float(law.cross_track_limit),
        float(law.cross_track_rate_limit),
        float(law.intercept_speed),
        curve(0.0),
        curve(float(law.bank_limit)),
        curve(-float(law.bank_limit)),
    )
