"""What the route law does before anything flies: poles, predictions, the phase portrait."""

from __future__ import annotations

import math
from typing import Any, NamedTuple

import numpy as np

from aircraft.state import STANDARD_GRAVITY
from autopilot.modes.lateral_navigation import LateralNavigation
from autopilot.route import PathDeviation
from autopilot.saturation import rate_limit

PREDICTION_STEP = 0.02  # s


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


def predict_linear(law: LateralNavigation, cross_track: float, cross_track_rate: float, time: Any) -> Prediction:
    """The law without limits on the double integrator, exactly [Vasylyev 2003, eq. (7)]."""

    from scipy.linalg import expm

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
