"""Motion models: the transition F, the process noise Q and the known input of each.

The functions are the mathematics and take arrays where a parameter may differ between runs; the dataclasses bind
parameters and answer ``transition(dt, mean)``. The cartesian state is (north, north_rate, east, east_rate), so a
positive turn rate is a right turn.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import lru_cache
from typing import Annotated, Any, NamedTuple, Protocol

import numpy as np

from tracking.gaussian import lift

Array = Any

GRAVITY = 9.80665  # m/s2

CARTESIAN = ("north", "north_rate", "east", "east_rate")


class Transition(NamedTuple):
    """``x+ = F x + u + w``, w ~ N(0, Q)."""

    F: Array  # (n, n, *C)
    Q: Array  # (n, n, *C)
    u: Array | None = None  # (n, *B)


class Motion(Protocol):
    """How a state moves between measurements."""

    @property
    def channels(self) -> tuple[str, ...]:
        """Names of the state components."""
        ...

    @property
    def depends_on_state(self) -> bool:
        """Whether ``transition`` looks at the mean (False lets a filter keep the matrices of a period)."""
        ...

    def transition(self, dt: float, mean: Array) -> Transition:
        """Matrices over dt (s) from the estimate ``mean`` (n, *B)."""
        ...


def van_loan(A: Array, noise: Array, dt: float) -> tuple[Array, Array]:
    """Exact (F, Q) of ``x' = A x + w`` with white noise of density ``noise`` (n, n), by one matrix exponential.

    The exponential is taken over a part of dt on which A hardly acts and doubled up from there, because its block
    F^-1 Q would lose all digits where a mode has died out within dt.
    """

    from scipy.linalg import expm

    A, noise = np.asarray(A, dtype=float), np.asarray(noise, dtype=float)
    n = len(A)
    size = float(np.abs(A).sum(axis=1).max()) * dt
    doublings = max(0, math.ceil(math.log2(size))) if size > 1.0 else 0
    block = expm(np.block([[-A, noise], [np.zeros((n, n)), A.T]]) * (dt / 2**doublings))
    F = block[n:, n:].T
    Q = F @ block[:n, n:]
    for _ in range(doublings):
        F, Q = F @ F, F @ Q @ F.T + Q
    return F, 0.5 * (Q + Q.T)


def constant_velocity(dt: float, density: float) -> tuple[Array, Array]:
    """(F, Q) of position and rate driven by white acceleration of a density (m2/s3) [Volovyk 2022, eq. (4)].

    Erratum: [Volovyk 2022, eq. (7)] printed the density twice, used once, because Q of (4) already holds it.
    """
    F = np.array([[1.0, dt], [0.0, 1.0]])
    Q = density * np.array([[dt**3 / 3.0, dt**2 / 2.0], [dt**2 / 2.0, dt]])
    return F, Q


def planar_constant_velocity(dt: float, density_north: float, density_east: float) -> tuple[Array, Array]:
    """(F, Q) of the cartesian state in straight uniform motion [Volovyk 2022, eq. (4)]."""
    F, Q = np.zeros((4, 4)), np.zeros((4, 4))
    F[:2, :2], Q[:2, :2] = constant_velocity(dt, density_north)
    F[2:, 2:], Q[2:, 2:] = constant_velocity(dt, density_east)
    return F, Q


# Coefficients in powers of t^2 of (2t - sin 2t)/4t^3, (6t - 8 sin t + sin 2t)/4t^3, (2t + sin 2t - 4 sin t)/4t^3 and
# (t - sin t)/t^3, which cancel up to the fifth order. Nine terms reach rounding for |t| < 0.5.
_TERMS = range(1, 10)
_A = np.array([(-1) ** (k + 1) * 2.0 ** (2 * k - 1) / math.factorial(2 * k + 1) for k in _TERMS])
_B = np.array([(-1) ** k * (2.0 ** (2 * k - 1) - 2.0) / math.factorial(2 * k + 1) for k in _TERMS])
_E = np.array([(-1) ** k * (2.0 ** (2 * k - 1) - 1.0) / math.factorial(2 * k + 1) for k in _TERMS])
_M = np.array([(-1) ** (k + 1) / math.factorial(2 * k + 1) for k in _TERMS])
_polynomial = np.polynomial.polynomial.polyval


def turn_transition(dt: float, turn_rate: Array) -> Array:
    """F (4, 4, *B) of a level turn at a known rate (rad/s, + right), any B [Volovyk 2022, eq. (5)]."""
    t = np.asarray(turn_rate, dtype=float) * dt
    F = np.zeros((4, 4, *t.shape))
    F[0, 0] = F[2, 2] = 1.0
    F[1, 1] = F[3, 3] = np.cos(t)
    F[3, 1] = np.sin(t)
    F[1, 3] = -F[3, 1]
    F[0, 1] = F[2, 3] = dt * np.sinc(t / math.pi)  # sin t / t
    F[2, 1] = dt * 0.5 * t * np.sinc(t / (2.0 * math.pi)) ** 2  # (1 - cos t) / t
    F[0, 3] = -F[2, 1]
    return F


def coordinated_turn(dt: float, turn_rate: Array, density_north: float, density_east: float) -> tuple[Array, Array]:
    """(F, Q) (4, 4, *B) of a level turn at a known rate (rad/s, + right), any B [Volovyk 2022, eq. (5)].

    Exact for different densities on the two axes, and down to a turn rate of zero, where it is
    `planar_constant_velocity`.

    Erratum: printed a Q that is not symmetric for different densities (entry (1,4) carries the east one, (4,1) the
    north one, (1,3) and (2,4) are zero), used the integral of Phi G diag(X, Y) G' Phi', because a covariance is
    symmetric and the turn couples the axes.
    """
    F = turn_transition(dt, turn_rate)
    t = np.asarray(turn_rate, dtype=float) * dt
    noise = _even_turn_noise if density_north == density_east else _turn_noise
    return F, noise(
        dt, t, F[0, 1] / dt if dt > 0.0 else 1.0, F[2, 1] / dt if dt > 0.0 else t, density_north, density_east
    )


def _even_turn_noise(dt: float, t: Array, sinc: Array, rise: Array, density: float, _: float) -> Array:
    """Q of a turn with the same density on both axes: the printed form, which is right there."""
    small = np.abs(t) < 0.5
    safe = np.where(small, 1.0, t)
    m = np.where(small, _polynomial(t * t, _M), (safe - np.sin(safe)) / safe**3)
    Q = np.zeros((4, 4, *np.shape(t)))
    Q[0, 0] = Q[2, 2] = 2.0 * density * dt**3 * m
    Q[0, 1] = Q[1, 0] = Q[2, 3] = Q[3, 2] = 0.5 * density * dt**2 * (sinc * sinc + rise * rise)
    Q[0, 3] = Q[3, 0] = density * dt**2 * t * m
    Q[1, 2] = Q[2, 1] = -Q[0, 3]
    Q[1, 1] = Q[3, 3] = density * dt
    return Q


def _turn_noise(dt: float, t: Array, sinc: Array, rise: Array, X: float, Y: float) -> Array:
    """Q of a turn with a density X along the north axis and Y along the east axis."""
    s2, square = np.sin(2.0 * t), t * t
    small = np.abs(t) < 0.5
    safe = np.where(small, 1.0, t)
    cube = 4.0 * safe**3
    s = np.sin(t)
    half = np.sinc(t / (2.0 * math.pi))  # sin(t/2) / (t/2)
    a = np.where(small, _polynomial(square, _A), (2.0 * t - s2) / cube)
    b = np.where(small, _polynomial(square, _B), (6.0 * t - 8.0 * s + s2) / cube)
    e = np.where(small, _polynomial(square, _E), (2.0 * t + s2 - 4.0 * s) / cube)
    rates = 0.5 + 0.5 * np.sinc(2.0 * t / math.pi)  # (2t + sin 2t) / 4t
    q11, q33 = dt**3 * (X * a + Y * b), dt**3 * (X * b + Y * a)
    q12, q34 = 0.5 * dt**2 * (X * sinc**2 + Y * rise**2), 0.5 * dt**2 * (X * rise**2 + Y * sinc**2)
    q13 = dt**3 * (X - Y) * t * half**4 / 8.0
    q14, q23 = dt**2 * t * (X * a + Y * e), -(dt**2) * t * (X * e + Y * a)
    q22, q44 = dt * (X * rates + Y * square * a), dt * (X * square * a + Y * rates)
    q24 = 0.5 * dt * (X - Y) * t * sinc**2
    return np.array([[q11, q12, q13, q14], [q12, q22, q23, q24], [q13, q23, q33, q34], [q14, q24, q34, q44]])


def singer(dt: float, time_constant: float, variance: float) -> tuple[Array, Array]:
    """Exact (F, Q) of (position, rate, acceleration), acceleration first-order Markov [Volovyk 2018, eq. (3)].

    Erratum: printed one power of the time constant in entry (1,3), used two, because the entry is a time squared.
    """
    x = dt / time_constant
    decay = math.exp(-x)
    F = np.array(
        [
            [1.0, dt, time_constant**2 * (x + math.expm1(-x))],
            [0.0, 1.0, -time_constant * math.expm1(-x)],
            [0.0, 0.0, decay],
        ]
    )
    A = np.array([[0.0, 1.0, 0.0], [0.0, 0.0, 1.0], [0.0, 0.0, -1.0 / time_constant]])
    return F, van_loan(A, np.diag([0.0, 0.0, 2.0 * variance / time_constant]), dt)[1]


def singer_short(dt: float, time_constant: float, variance: float) -> tuple[Array, Array]:
    """(F, Q) with the leading term of `singer`'s Q in dt / time_constant [Volovyk 2018, eq. (3)].

    Erratum: printed the condition dt << 1 s, used dt << time constant, because the expansion is in their ratio: Q is
    2.6 % too large at a ratio of 0.025 and more than 60 % at 1.
    """
    powers = [[dt**5 / 20, dt**4 / 8, dt**3 / 6], [dt**4 / 8, dt**3 / 3, dt**2 / 2], [dt**3 / 6, dt**2 / 2, dt]]
    return singer(dt, time_constant, variance)[0], 2.0 * variance / time_constant * np.array(powers)


def closed_loop(dt: float, stiffness: float, damping: float, density: float = 0.0) -> tuple[Array, Array]:
    """(F, Q) of ``z'' = -stiffness z - damping z' + w``: a route held by linear feedback [Vasylyev 2003, eqs. (7)-(8)].

    With the gains of the law, stiffness = g k1 (1/s2) and damping = g k2 (1/s). Under-damped, critical and over-damped
    in one expression that is continuous between them.

    Erratum: printed omega = sqrt((g k2)^2/2 - g k1), used sqrt(g k1 - (g k2/2)^2), because the roots of
    p^2 + g k2 p + g k1 are -g k2/2 +- sqrt((g k2/2)^2 - g k1).
    """
    rate = 0.5 * damping
    square = (stiffness - rate**2) * dt**2  # (omega dt)^2, negative where over-damped
    if abs(square) < 1e-2:
        s = 1.0 - square / 6.0 * (1.0 - square / 20.0 * (1.0 - square / 42.0 * (1.0 - square / 72.0)))
        c = 1.0 - square / 2.0 * (1.0 - square / 12.0 * (1.0 - square / 30.0 * (1.0 - square / 56.0)))
        decay = math.exp(-rate * dt)
        s, c = decay * dt * s, decay * c
    elif square > 0.0:
        angle = math.sqrt(square)
        decay = math.exp(-rate * dt)
        s, c = decay * dt * math.sin(angle) / angle, decay * math.cos(angle)
    else:  # exponentials together: cosh alone overflows on a long look-ahead
        angle = math.sqrt(-square)
        slow, fast = math.exp(angle - rate * dt), math.exp(-angle - rate * dt)
        s, c = dt * (slow - fast) / (2.0 * angle), 0.5 * (slow + fast)
    F = np.array([[c + rate * s, s], [-stiffness * s, c - rate * s]])
    if density == 0.0:
        return F, np.zeros((2, 2))
    A = np.array([[0.0, 1.0], [-stiffness, -damping]])
    return F, van_loan(A, np.diag([0.0, density]), dt)[1]


def double_integrator(dt: float, density: float = 0.0) -> tuple[Array, Array, Array]:
    """(F, Q, B) of (position, rate) under a known constant acceleration [Vasylyev 2003, eq. (9)].

    B (2,) multiplies the acceleration (m/s2); for a bank angle it is gravity times the bank, eq. (6).
    """
    F, Q = constant_velocity(dt, density)
    return F, Q, np.array([0.5 * dt**2, dt])


def first_order(dt: float, time_constant: float, variance: float) -> tuple[Array, Array]:
    """Exact (F, Q), both (1, 1), of a first-order Markov process of a stationary variance."""
    return np.array([[math.exp(-dt / time_constant)]]), np.array([[-variance * math.expm1(-2.0 * dt / time_constant)]])


def turn_rate_of(bank: Array, speed: Array) -> Array:
    """Turn rate (rad/s) of a coordinated level turn, ``g tan(bank) / V``."""
    return GRAVITY * np.tan(bank) / speed


# sin(t)/t, (1 - cos t)/t^2, (sin(t)/t)'/t and ((1 - cos t)/t)' in powers of t^2, to rounding for |t| < 0.1
_SMALL_TURN = np.array(
    [
        [1.0, -1.0 / 6.0, 1.0 / 120.0, -1.0 / 5040.0, 1.0 / 362880.0],
        [1.0 / 2.0, -1.0 / 24.0, 1.0 / 720.0, -1.0 / 40320.0, 1.0 / 3628800.0],
        [-1.0 / 3.0, 1.0 / 30.0, -1.0 / 840.0, 1.0 / 45360.0, -1.0 / 3991680.0],
        [1.0 / 2.0, -1.0 / 8.0, 1.0 / 144.0, -1.0 / 5760.0, 1.0 / 403200.0],
    ]
)


def _turn_series(t: Array) -> Array:
    """(4, *B): the four functions of `_SMALL_TURN` at t, whatever its size."""
    square = t * t
    if np.max(square) < 0.01:  # the usual case: a sub-step of a turn; NaN of a lost run goes the other way
        coefficients = lift(_SMALL_TURN.T, 2, t.ndim)
        value = coefficients[4] * square
        for coefficient in coefficients[3:0:-1]:
            value += coefficient
            value *= square
        value += coefficients[0]
        return value
    small = np.abs(t) < 0.1
    near = _turn_series(np.where(small, t, 0.0))
    far = np.where(small, 1.0, t)
    s, rise = np.sin(far) / far, 2.0 * np.sin(0.5 * far) ** 2 / far
    return np.where(small, near, np.array([s, rise / far, (np.cos(far) - s) / far**2, s - rise / far]))


def course_kinematics(mean: Array, bank: Array, dt: float) -> tuple[Array, Array]:
    """State after dt at a constant bank, and its Jacobian (4, 4, *B), the bank taken as known.

    The velocity of the cartesian ``mean`` (4, *B) is turned by ``g tan(bank) / V``, V the estimate's own speed, whose
    effect on the turn rate is in the Jacobian.
    """
    north_rate, east_rate = mean[1], mean[3]
    square = np.maximum(north_rate * north_rate + east_rate * east_rate, 1.0)  # a target at rest has no course
    t = turn_rate_of(bank, np.sqrt(square)) * dt
    sine, rise, d_sine, d_rise = _turn_series(t)
    rise = t * rise
    along, across = dt * sine, dt * rise  # the way flown, as shares of the velocity and of the velocity turned right
    cosine, sine = 1.0 - t * rise, t * sine
    moved = np.empty((4, *t.shape))
    moved[0] = mean[0] + along * north_rate - across * east_rate
    moved[1] = cosine * north_rate - sine * east_rate
    moved[2] = mean[2] + across * north_rate + along * east_rate
    moved[3] = sine * north_rate + cosine * east_rate
    # d moved / d t: the end velocity is rotated on, the displacement grows by what is left of the turn;
    # d t / d velocity = -t velocity / V^2
    share = -t / square
    change = np.empty_like(moved)
    d_along, d_across = dt * t * d_sine, dt * d_rise
    change[0] = d_along * north_rate - d_across * east_rate
    change[1] = -moved[3]
    change[2] = d_across * north_rate + d_along * east_rate
    change[3] = moved[1]
    change *= share
    F = np.zeros((4, 4, *t.shape))
    F[0, 0] = F[2, 2] = 1.0
    F[:, 1] = change * north_rate
    F[:, 3] = change * east_rate
    F[0, 1] += along
    F[1, 1] += cosine
    F[2, 1] += across
    F[3, 1] += sine
    F[0, 3] -= across
    F[1, 3] -= sine
    F[2, 3] += along
    F[3, 3] += cosine
    return moved, F


@dataclass(frozen=True)
class ConstantVelocity:
    """Straight uniform motion of the cartesian state [Volovyk 2022, eq. (4)]."""

    acceleration_density: Annotated[float, "m2/s3"] = 0.3
    channels = CARTESIAN
    depends_on_state = False

    def __post_init__(self) -> None:
        _require(np.all(np.asarray(self.acceleration_density) >= 0.0), "acceleration_density must not be negative")

    def transition(self, dt: float, mean: Array) -> Transition:
        F, Q, _ = _fixed(planar_constant_velocity, dt, 1.0, 1.0)
        return Transition(F, np.multiply.outer(Q, self.acceleration_density))


@dataclass(frozen=True)
class CoordinatedTurn:
    """Level turn of the cartesian state at a fixed rate, + right [Volovyk 2022, eq. (5)]."""

    turn_rate: Annotated[float, "rad/s"]
    acceleration_density: Annotated[float, "m2/s3"] = 0.3
    channels = CARTESIAN
    depends_on_state = False

    def __post_init__(self) -> None:
        _require(math.isfinite(self.turn_rate), "turn_rate must be finite")
        _require(self.acceleration_density >= 0.0, "acceleration_density must not be negative")

    def transition(self, dt: float, mean: Array) -> Transition:
        density = self.acceleration_density
        return _fixed(coordinated_turn, dt, self.turn_rate, density, density)


@dataclass(frozen=True)
class ScheduledTurn:
    """Level turn at the rate that a bank gives at the estimated speed, ``g tan(bank) / V``; + bank is right."""

    bank: Annotated[float, "rad"]
    acceleration_density: Annotated[float, "m2/s3"] = 0.05
    slowest: Annotated[float, "m/s"] = 30.0  # a worse speed estimate schedules no faster turn than this
    channels = CARTESIAN
    depends_on_state = True

    def __post_init__(self) -> None:
        _require(abs(self.bank) < 0.5 * math.pi, "bank must lie between -90 and 90 deg")
        _require(np.all(np.asarray(self.acceleration_density) >= 0.0), "acceleration_density must not be negative")
        _require(self.slowest > 0.0, "slowest must be positive")

    def transition(self, dt: float, mean: Array) -> Transition:
        speed = np.maximum(np.hypot(mean[1], mean[3]), self.slowest)
        F, Q = coordinated_turn(dt, turn_rate_of(self.bank, speed), 1.0, 1.0)
        return Transition(F, Q * self.acceleration_density)


@dataclass(frozen=True)
class AlongTrackAcceleration:
    """Straight motion with a known acceleration along the estimated track, negative when slowing down."""

    acceleration: Annotated[float, "m/s2"] = -0.5
    acceleration_density: Annotated[float, "m2/s3"] = 0.05
    channels = CARTESIAN
    depends_on_state = True

    def __post_init__(self) -> None:
        _require(math.isfinite(self.acceleration), "acceleration must be finite")
        _require(np.all(np.asarray(self.acceleration_density) >= 0.0), "acceleration_density must not be negative")

    def transition(self, dt: float, mean: Array) -> Transition:
        F, Q, _ = _fixed(planar_constant_velocity, dt, 1.0, 1.0)
        _, _, B = double_integrator(dt)
        along = self.acceleration / np.maximum(np.hypot(mean[1], mean[3]), 1.0)  # no direction below 1 m/s
        north, east = along * mean[1], along * mean[3]
        Q = np.multiply.outer(Q, self.acceleration_density)
        return Transition(F, Q, np.stack([B[0] * north, B[1] * north, B[0] * east, B[1] * east]))


@lru_cache(maxsize=256)
def _fixed(function: Any, dt: float, *parameters: float) -> Transition:
    """Matrices of a state-independent model, computed once per period and shared read-only."""
    F, Q = function(dt, *parameters)
    F.flags.writeable = Q.flags.writeable = False
    return Transition(F, Q)


def _require(condition: Any, sentence: str) -> None:
    if not condition:
        raise ValueError(sentence)
