"""Kalman filter of the elevation channel of a microwave landing system, and its four realisations.

In the order of Volovyk, Havrilov, Mozgovoj 2018: the kinematics of the angle, the Kalman filter as a tracker, its four
realisations as plain functions, and the number of runs that a Monte-Carlo check needs.

The gain of a Kalman filter does not look at the data, so a filter with a stored gain schedule (realisation 4) is the
full filter (realisation 1) to the last bit, under any mismatch of model and truth. What it cannot do is take a noise
variance that is told on line, or know of a missed measurement; and a *constant* gain loses the transient.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from functools import lru_cache
from typing import Annotated, Any, NamedTuple

import numpy as np

from tracking.gaussian import LOG_TWO_PI, Gaussian, Innovation, lift, predict, update
from tracking.measurement import wrap
from tracking.motion import singer

Array = Any

PERIOD = 0.0247  # s, of a landing system's angle data (40.5 Hz)


class AngleMotion(NamedTuple):
    """An angle with its rate (rad/s) and acceleration (rad/s2)."""

    angle: Array
    rate: Array
    acceleration: Array


def elevation_of(
    distance: Array,
    height: Array,
    distance_rate: Array = 0.0,
    height_rate: Array = 0.0,
    distance_acceleration: Array = 0.0,
    height_acceleration: Array = 0.0,
) -> AngleMotion:
    """Elevation of an aircraft seen from the beacon, and its two derivatives [Volovyk 2018, eq. (1)].

    Distance is horizontal and shrinks inbound (negative rate); an aircraft that slows down inbound has a positive
    distance acceleration. All in metres and seconds.

    Erratum: printed H''D - HD'' - 2 (H'D - HD') (HH' + DD') over (D2 + H2)^2, used (H''D - HD'') (D2 + H2) in the first
    term, because otherwise the terms do not have one dimension and the accelerations vanish.
    Erratum: [Kychak 2011, eq. (2)] printed H'D' - HD' and a last factor H'D' over H2 + D2^2, used H'D - HD', HH' + DD'
    and (H2 + D2)^2, because that is the derivative of the rate; as printed it is nine orders too small.
    """
    square = distance**2 + height**2
    moment = height_rate * distance - height * distance_rate
    turning = height_acceleration * distance - height * distance_acceleration
    receding = height * height_rate + distance * distance_rate
    return AngleMotion(
        np.arctan2(height, distance), moment / square, (turning * square - 2.0 * moment * receding) / square**2
    )


def manoeuvre_variance(largest: float, share_largest: float, share_none: float) -> float:
    """Variance (m2/s4) of a manoeuvre acceleration that is none, +-largest, or uniform between [Volovyk 2018, eq. (3)].

    With probabilities ``share_none``, ``share_largest`` for either sign, and the rest uniform.
    """
    if not 0.0 <= share_none + 2.0 * share_largest <= 1.0:
        raise ValueError("share_none + 2 share_largest must lie between 0 and 1")
    return largest**2 * (1.0 + 4.0 * share_largest - share_none) / 3.0


@dataclass(frozen=True)
class Elevation:
    """Kalman filter of the elevation seen from a landing beacon, order 1, 2 or 3 [Volovyk 2018, eqs. (5), (7)-(10)].

    Order 1 holds the angle, order 2 also its rate, order 3 also its acceleration, a first-order Markov process of the
    print's Singer model (3). The disturbance of orders 1 and 2 is a random increment every ``period``; over another
    interval as many increments act as fit in it, so that a look-ahead is the recursion itself.

    Erratum: (5) printed B = [0, 1]' with Q = 1e-4 (deg/s)^2 beside a disturbance called an acceleration, used as
    printed by default (a jump of the rate by ``rate_increment``); ``held`` is the other reading B = [T^2/2, T]', the
    same increment gathered by an acceleration over the period. Read as 0.01 deg/s2 it is rate_increment = 0.01 T.

    Parameters
    ----------
    measured : names of the rows of z; the one that ends with ".elevation" is used.
    angle_increment, rate_increment, acceleration_density : process noise of orders 1, 2, 3. The density is that of the
        acceleration at low frequency, 2 variance correlation_time. Orders 1 and 3 have no printed value; theirs are
        tuned on the paper's level leg.
    gain : an arbitrary constant gain in (1, 1/s, 1/s2) instead of the optimal one; the covariance is then the Joseph
        form (19), the only one that holds for it.
    """

    measured: Annotated[tuple[str, ...], "given"]
    order: int = 2
    period: Annotated[float, "s"] = PERIOD
    angle_increment: Annotated[float, "rad"] = math.radians(math.sqrt(1e-5))
    rate_increment: Annotated[float, "rad/s"] = math.radians(0.01)
    held: bool = False
    acceleration_density: Annotated[float, "rad2/s3"] = 2.0 * 80.0 * math.radians(0.001) ** 2
    correlation_time: Annotated[float, "s"] = 80.0
    gain: tuple[float, ...] | None = None

    def __post_init__(self) -> None:
        if self.order not in (1, 2, 3):
            raise ValueError("order must be 1, 2 or 3")
        for name in ("period", "correlation_time"):
            if not getattr(self, name) > 0.0:
                raise ValueError(f"{name} must be above 0")
        for name in ("angle_increment", "rate_increment", "acceleration_density"):
            if not getattr(self, name) >= 0.0:
                raise ValueError(f"{name} must not be negative")
        if self.gain is not None and len(self.gain) != self.order:
            raise ValueError(f"gain needs {self.order} numbers, one for each state")
        row_of("elevation", self.measured)

    @property
    def channels(self) -> tuple[str, ...]:
        name = self.measured[row_of("elevation", self.measured)]
        return (name, f"{name}_rate", f"{name}_acceleration")[: self.order]

    @property
    def H(self) -> Array:
        """(1, order): the angle itself is measured."""
        return np.eye(1, self.order)

    def begin(self, prior: Gaussian) -> Gaussian:
        if len(prior.mean) != self.order:
            raise ValueError(f"the prior must have the {self.order} states {', '.join(self.channels)}")
        return prior

    def step(self, state: Gaussian, dt: float, z: Any | None, R: Any | None) -> tuple[Gaussian, Innovation | None]:
        state = predict(state, *self.transition(dt))
        if z is None:
            return state, None
        angle, R = pick(z, R, row_of("elevation", self.measured), state.mean)
        if self.gain is None:
            return update(state, angle, self.H, R)
        return _update_with_gain(state, angle, self.H, R, np.array(self.gain)[:, None])

    def estimate(self, state: Gaussian) -> Gaussian:
        return state

    def transition(self, dt: float) -> tuple[Array, Array]:
        """(F, Q) over dt: A and B Q B' of (5), repeated as often as dt needs."""
        if self.order == 3:
            variance = 0.5 * self.acceleration_density / self.correlation_time
            return _shared(singer, dt, self.correlation_time, variance)
        increment = self.angle_increment if self.order == 1 else self.rate_increment
        return _shared(increments, self.order, dt, self.period, increment, self.held)


@lru_cache(maxsize=256)
def _shared(function: Callable[..., tuple[Array, Array]], *arguments: float) -> tuple[Array, Array]:
    """(F, Q) of an interval, computed once and read-only."""
    F, Q = function(*arguments)
    F.flags.writeable = Q.flags.writeable = False
    return F, Q


def increments(order: int, dt: float, period: float, increment: float, held: bool = False) -> tuple[Array, Array]:
    """(F, Q) of an angle (order 1) or an angle and its rate (order 2) that jump every period [Volovyk 2018, eq. (5)].

    ``increment`` is the standard deviation of one jump of the last state; with ``held`` the jump of the rate is
    gathered evenly over the period, so that the angle takes part of it. An interval that holds no whole number of
    periods has its increments scaled, which keeps the variance gained per second.
    """
    steps = max(1, round(dt / period))
    short = dt / steps
    variance = increment**2 * short / period
    if order == 1:
        return np.eye(1), np.array([[steps * variance]])
    lead = 0.5 * short if held else 0.0
    once, twice = steps * (steps - 1) / 2.0, (steps - 1) * steps * (2 * steps - 1) / 6.0
    cross = short * once + steps * lead
    square = short**2 * twice + 2.0 * lead * short * once + steps * lead**2
    return np.array([[1.0, dt], [0.0, 1.0]]), variance * np.array([[square, cross], [cross, steps]])


def row_of(quantity: str, measured: tuple[str, ...]) -> int:
    """Row of z that holds a quantity, the last part of a channel's name.

    Raises ``ValueError`` unless there is exactly one.
    """
    rows = [row for row, name in enumerate(measured) if name.rsplit(".", 1)[-1] == quantity]
    if len(rows) != 1:
        raise ValueError(f"needs one sensor that measures '{quantity}', among {', '.join(measured) or 'nothing'}")
    return rows[0]


def pick(z: Array, R: Array, row: int, mean: Array) -> tuple[Array, Array]:
    """One angle of z (1, *B), on the turn nearest to its prediction ``mean[0]``, and its variance (1, 1, *C)."""
    return mean[:1] + wrap(z[row : row + 1] - mean[:1]), R[row : row + 1, row : row + 1]


def _update_with_gain(gaussian: Gaussian, z: Array, H: Array, R: Array, K: Array) -> tuple[Gaussian, Innovation]:
    """Condition on one scalar z (1, *B) with the gain K (n, 1), whatever it is."""
    residual = z - np.einsum("ij...,j...->i...", lift(H, 2, z.ndim - 1), gaussian.mean)
    present = np.isfinite(residual[0])
    batch = max(residual.ndim - 1, gaussian.cov.ndim - 2) if not present.all() else max(gaussian.cov.ndim, R.ndim) - 2
    P, H, R, K = (lift(matrix, 2, batch) for matrix in (gaussian.cov, H, R, K))
    if not present.all():
        K = np.where(present, K, 0.0)
    S = _times(_times(H, P), H.swapaxes(0, 1)) + R
    white = residual / np.sqrt(S[0])
    log_likelihood = np.where(present, -0.5 * (white[0] ** 2 + np.log(S[0, 0]) + LOG_TWO_PI), 0.0)
    known = np.where(present, residual, 0.0)
    mean = gaussian.mean + np.einsum("ij...,j...->i...", lift(K, 2, known.ndim - 1), known)
    innovation = Innovation(white, np.where(present, white[0] ** 2, 0.0), log_likelihood)
    return Gaussian(mean, joseph(P, K, H, R)), innovation


# The four realisations. Matrices have trailing batch axes like everywhere; every product goes through `_times`, so
# that numbers that count their operations can stand in for floats (tracking/operations.py).


class Model(NamedTuple):
    """A, B Q B', C and R of (5): what a realisation keeps besides its state."""

    A: Array  # (n, n)
    Q: Array  # (n, n), the stored constant B Q B'
    C: Array  # (m, n)
    R: Array  # (m, m)


def _times(A: Array, B: Array) -> Array:
    """Matrix product over the first two axes, batch axes behind."""
    batch = max(A.ndim, B.ndim) - 2
    A, B = (M.reshape(*M.shape[:2], *(1,) * (batch + 2 - M.ndim), *M.shape[2:]) for M in (A, B))
    return (A[:, :, None] * B[None]).sum(axis=1)


def _inverse(S: Array) -> Array:
    """Inverse over the first two axes, batch axes behind."""
    return np.moveaxis(np.linalg.inv(np.moveaxis(S, (0, 1), (-2, -1))), (-2, -1), (0, 1))


def _predicted(x: Array, P: Array, model: Model) -> tuple[Array, Array]:
    """Extrapolated state (n, *B) and covariance [Volovyk 2018, eqs. (11), (13)]."""
    half = _times(model.A, P)
    return _column(model.A, x), _times(half, model.A.swapaxes(0, 1)) + model.Q


def _column(A: Array, x: Array) -> Array:
    return _times(A, x[:, None])[:, 0]


def _identity_minus(product: Array) -> Array:
    n = len(product)
    return np.eye(n).reshape(n, n, *(1,) * (product.ndim - 2)) - product


def full(
    x: Array, P: Array, z: Array, model: Model, inverse: Callable[[Array], Array] = _inverse
) -> tuple[Array, Array, Array]:
    """Realisation 1, the complete filter: state, covariance, gain [Volovyk 2018, eqs. (11)-(15)]."""
    x, P = _predicted(x, P, model)
    PC = _times(P, model.C.swapaxes(0, 1))
    K = _times(PC, inverse(_times(model.C, PC) + model.R))
    x = x + _column(K, z - _column(model.C, x))
    return x, _times(_identity_minus(_times(K, model.C)), P), K


def arbitrary_gain(x: Array, P: Array, z: Array, K: Array, model: Model) -> tuple[Array, Array]:
    """Realisation 2, any gain: state and the covariance that it really has [Volovyk 2018, eqs. (16)-(19)]."""
    x, P = _predicted(x, P, model)
    x = x + _column(K, z - _column(model.C, x))
    return x, joseph(P, K, model.C, model.R)


def joseph(P: Array, K: Array, C: Array, R: Array) -> Array:
    """Covariance after an update with any gain K (n, m) [Volovyk 2018, eq. (19)]."""
    G = _identity_minus(_times(K, C))
    return _times(_times(G, P), G.swapaxes(0, 1)) + _times(_times(K, R), K.swapaxes(0, 1))


def information(
    x: Array, P: Array, z: Array, model: Model, inverse: Callable[[Array], Array] = _inverse
) -> tuple[Array, Array]:
    """Realisation 3, the information form: state and covariance [Volovyk 2018, eqs. (20)-(23)].

    Erratum: (23) printed P(k+1/k+1) and indices k+1 on its right, used P(k/k) and A(k+1, k), because it is the
    extrapolation (13).
    Erratum: printed three inversions of n x n matrices, used two and one of m x m, because R is m x m.
    """
    x, P = _predicted(x, P, model)
    weighted = _times(model.C.swapaxes(0, 1), inverse(model.R))
    P = inverse(inverse(P) + _times(weighted, model.C))
    return x + _column(_times(P, weighted), z - _column(model.C, x)), P


def stored_gain(x: Array, z: Array, K: Array, A: Array, C: Array) -> Array:
    """Realisation 4, a gain from memory and no covariance: state [Volovyk 2018, variant 4].

    With the schedule of `gain_schedule` it is realisation 1 to the last bit, for any data. The print's loss of
    accuracy needs a constant gain, or a variance or a missed measurement that only realisation 1 is told.
    """
    x = _column(A, x)
    return x + _column(K, z - _column(C, x))


def gain_schedule(P: Array, model: Model, steps: int) -> tuple[Array, Array]:
    """Gains (steps, n, m) and covariances (steps, n, n), known before the data [Volovyk 2018, eqs. (8)-(10)]."""
    gains, covariances = [], []
    nothing = np.zeros(len(model.A))
    for _ in range(steps):
        _, P, K = full(nothing, P, np.zeros(len(model.C)), model)
        gains.append(K)
        covariances.append(P)
    return np.array(gains), np.array(covariances)


def short_form(P: Array, K: Array, C: Array, R: Array) -> Array:
    """Covariance (I - K C) P after an update with the optimal gain, and with no other [Volovyk 2018, eq. (15)].

    Raises ``ValueError`` for any other gain: the result would be wrong by factors, and not even symmetric.
    """
    PC = _times(P, C.swapaxes(0, 1))
    optimal = _times(PC, _inverse(_times(C, PC) + R))
    if not np.allclose(K, optimal, rtol=1e-9, atol=0.0):
        raise ValueError("the short form (I - K C) P holds only for the optimal gain; use the Joseph form")
    return _times(_identity_minus(_times(K, C)), P)


def interval_half_width(confidence: float, runs: int) -> float:
    """Relative half-width q of the interval s (1 +- q) of a standard deviation [Volovyk 2018, confidence interval].

    s is the sample's, over ``runs`` errors about their mean; q covers the true value with the given confidence.
    """
    from scipy.optimize import brentq
    from scipy.stats import chi2

    free = runs - 1

    def shortfall(q: float) -> float:
        high = 1.0 if q >= 1.0 else chi2.cdf(free / (1.0 - q) ** 2, free)
        return float(high - chi2.cdf(free / (1.0 + q) ** 2, free) - confidence)

    return float(brentq(shortfall, 1e-9, 50.0, xtol=1e-12))


def band_coverage(half_width: float, runs: int) -> float:
    """Probability that a sample's standard deviation lies within ``sigma (1 +- half_width)`` of the true sigma.

    This is the band of [Volovyk 2018, fig. 4], drawn about the theory; `interval_half_width` is the interval about
    the sample. Both are about the standard deviation: about the variance the same band covers 0.68, not 0.95.
    """
    from scipy.stats import chi2

    free = runs - 1
    low, high = free * (1.0 - half_width) ** 2, free * (1.0 + half_width) ** 2
    return float(chi2.cdf(high, free) - chi2.cdf(low, free))
