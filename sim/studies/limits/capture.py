"""Capture of a line from the side under the route law: when its limits act, and what its two filters make of that.

All of it is arithmetic on the law, without noise and without an aircraft, for any number of cases side by side.

The aircraft banks at once and keeps its speed V: its course chi turns at g tan(bank) / V, the cross-track rate is
V sin(chi). For small angles that is z'' = g bank [Vasylyev 2003, eq. (6)].

A filter's RMSE over the scans is that of its bias, which is its error on the noise-free capture, and of its spread
about that, which the plots' noise and the prior make of it. Linear feedback knows no limits: its bias is what they do
to the capture, its spread that of a linear filter. Saturated control is taken to have no bias, since its motion and its
law are those of the aircraft; its spread is carried on by the slope of the law along the capture, which is none in what
a limit cuts off, and corrected with gains that know no law. Spreads so large that the law's slope changes within them,
and what makes an aircraft slower than its command, are left out.
"""

from __future__ import annotations

import math
from typing import Any, NamedTuple

import numpy as np

from autopilot.modes.lateral_navigation import LateralNavigation
from autopilot.route import PathDeviation
from tracking.motion import GRAVITY, closed_loop, constant_velocity

Array = Any
STEP = 0.2  # s, at most: the loops of captures have time constants of 10 s and more


class Filters(NamedTuple):
    """What both filters of a capture are given."""

    period: float  # s, of the scans
    sigma: float  # m, of a plot across the line
    prior: tuple[float, float]  # m, m/s: standard deviations at the first scan
    linear_density: float  # m2/s3, of the acceleration that linear feedback expects
    saturated_density: float  # m2/s3, that of saturated control


class Capture(NamedTuple):
    """What limits do to a capture, one value for each case."""

    at_limits: Array  # s, during which any limit acts
    ratio: Array | None  # RMSE of linear feedback over that of saturated control, of the cross-track; None = no filters


def contact(law: LateralNavigation, offset: Array, seconds: float) -> Array:
    """How far the capture that knows no limits would go, over the limit it comes first to; above 1 a limit acts.

    It is z'' = -g k1 z - g k2 z' from an offset (m) at rest: the greatest of cross-track, rate and bank command, each
    over its own limit.
    """
    F, _ = closed_loop(STEP, GRAVITY * law.k1, GRAVITY * law.k2)
    z = np.array([1.0, 0.0])
    fastest = 0.0
    for _ in range(math.ceil(seconds / STEP)):
        z = F @ z
        fastest = max(fastest, abs(float(z[1])))
    rest = np.abs(offset)
    # the command is z'' / g, which is greatest at the start
    return np.maximum.reduce(
        np.broadcast_arrays(
            rest / law.cross_track_limit,
            fastest * rest / law.cross_track_rate_limit,
            law.k1 * rest / law.bank_limit,
        )
    )


def capture(law: LateralNavigation, offset: Array, speed: float, seconds: float, filters: Filters | None) -> Capture:
    """Fly the capture with its limits and run both filters along it.

    Parameters
    ----------
    law : its limits may be arrays of the shape of ``offset``, its gains are numbers
    offset : (...) m, from the line at the start, on a parallel course
    speed : m/s, over the ground
    seconds : of the flight
    """
    z: Array = np.array(offset, float)
    course: Array = np.zeros_like(z)
    period = seconds if filters is None else filters.period
    parts = math.ceil(period / STEP - 1e-9)
    step, scans = period / parts, math.floor(seconds / period + 1e-9)
    at_limits = np.zeros_like(z)
    linear, saturated = _Linear.begin(law, filters), _Saturated.begin(filters)
    for scan in range(scans):
        slope = _identity(z.shape)
        for _ in range(parts):
            middle = 0.5 * step
            turn = _turn_rate(law, z, course, speed)
            halfway = z + middle * speed * np.sin(course), course + middle * turn
            acts, per_cross_track, per_rate = _slope(law, *halfway, speed)
            at_limits = at_limits + step * acts
            slope = _advanced(slope, per_cross_track, per_rate, step)
            z = z + step * speed * np.sin(halfway[1])
            course = course + step * _turn_rate(law, *halfway, speed)
        if filters is not None:
            now = np.stack([z, speed * np.sin(course)])
            linear = linear.after(now, filters, first=scan == 0)
            saturated = saturated.after(slope, filters, first=scan == 0)
    if filters is None or not scans:
        return Capture(at_limits, None)
    return Capture(at_limits, np.sqrt(linear.squares / saturated.squares))


def _turn_rate(law: LateralNavigation, z: Array, course: Array, speed: float) -> Array:
    deviation = PathDeviation(z, speed * np.sin(course), np.inf, 0.0, 0.0, 0.0)
    return GRAVITY * np.tan(law(deviation)) / speed


def _slope(law: LateralNavigation, z: Array, course: Array, speed: float) -> tuple[Array, Array, Array]:
    """Whether any limit acts, and how the acceleration across the line changes with cross-track and its rate."""
    rate = speed * np.sin(course)
    inside, slow = np.abs(z) < law.cross_track_limit, np.abs(rate) < law.cross_track_rate_limit
    asked = law.k1 * np.clip(z, -law.cross_track_limit, law.cross_track_limit)
    asked = asked + law.k2 * np.clip(rate, -law.cross_track_rate_limit, law.cross_track_rate_limit)
    free = np.abs(asked) < law.bank_limit
    return ~(inside & slow & free), -GRAVITY * law.k1 * (inside & free), -GRAVITY * law.k2 * (slow & free)


def _identity(shape: tuple[int, ...]) -> Array:
    return np.broadcast_to(np.eye(2).reshape(2, 2, *(1,) * len(shape)), (2, 2, *shape)).copy()


def _advanced(slope: Array, per_cross_track: Array, per_rate: Array, step: float) -> Array:
    """The slope of a state on the one at the scan before, (2, 2, ...), one step on, the control held."""
    z, rate = slope
    push = per_cross_track * z + per_rate * rate
    return np.stack([z + step * rate + 0.5 * step**2 * push, rate + step * push])


class _Linear(NamedTuple):
    """Linear feedback along a capture: its mean (2, ...), the covariance of its error (2, 2), its squares so far."""

    F: Array
    Q: Array
    claimed: Array
    spread: Array
    mean: Array
    squares: Array

    @classmethod
    def begin(cls, law: LateralNavigation, filters: Filters | None) -> _Linear:
        density = 0.0 if filters is None else filters.linear_density
        period = STEP if filters is None else filters.period
        F, Q = closed_loop(period, GRAVITY * law.k1, GRAVITY * law.k2, density)
        start = np.zeros((2, 2)) if filters is None else np.diag(np.square(filters.prior))
        return cls(F, Q, start, start, None, 0.0)

    def after(self, now: Array, filters: Filters, first: bool) -> _Linear:
        """One scan on; at the first one the filter begins, on the truth."""
        ahead = now if first else np.einsum("ij,j...->i...", self.F, self.mean)
        claimed = self.claimed if first else self.F @ self.claimed @ self.F.T + self.Q
        spread = self.spread if first else self.F @ self.spread @ self.F.T
        gain, left, claimed = _corrected(claimed, filters.sigma)
        mean = ahead + np.multiply.outer(gain, now[0] - ahead[0])
        spread = left @ spread @ left.T + filters.sigma**2 * np.outer(gain, gain)
        error = (mean[0] - now[0]) ** 2 + spread[0, 0]
        return self._replace(claimed=claimed, spread=spread, mean=mean, squares=self.squares + error)


class _Saturated(NamedTuple):
    """Saturated control along a capture: the covariance of its error, (2, 2, ...), and its squares so far."""

    F: Array
    Q: Array
    claimed: Array
    spread: Array
    squares: Array

    @classmethod
    def begin(cls, filters: Filters | None) -> _Saturated:
        density = 0.0 if filters is None else filters.saturated_density
        F, Q = constant_velocity(STEP if filters is None else filters.period, density)
        start = np.zeros((2, 2)) if filters is None else np.diag(np.square(filters.prior))
        return cls(F, Q, start, start, 0.0)

    def after(self, slope: Array, filters: Filters, first: bool) -> _Saturated:
        """One scan on, over which the truth's slope was ``slope`` (2, 2, ...)."""
        claimed = self.claimed if first else self.F @ self.claimed @ self.F.T + self.Q
        gain, left, claimed = _corrected(claimed, filters.sigma)
        moved = _identity(slope.shape[2:]) if first else slope
        whole = np.einsum("ij,jk...->ik...", left, moved)
        before = self.spread if self.spread.ndim > 2 else self.spread.reshape(2, 2, *(1,) * (slope.ndim - 2))
        spread = np.einsum("ij...,jk...,lk...->il...", whole, before, whole)
        noise = filters.sigma**2 * np.outer(gain, gain)
        spread = spread + noise.reshape(2, 2, *(1,) * (slope.ndim - 2))
        return self._replace(claimed=claimed, spread=spread, squares=self.squares + spread[0, 0])


def _corrected(claimed: Array, sigma: float) -> tuple[Array, Array, Array]:
    """Gain (2,), what it leaves of an error (2, 2), and the covariance that the filter claims afterwards."""
    gain = claimed[:, 0] / (claimed[0, 0] + sigma**2)
    left = np.eye(2) - np.outer(gain, (1.0, 0.0))
    return gain, left, left @ claimed
