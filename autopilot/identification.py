"""Which route law flew a capture: its gains, its limits and the lag of the bank, from the track over the ground alone.

The loop of law (4) is simulated over the whole capture, and its parameters are those whose cross-track and bank come
nearest to the record (output error). Nothing is assumed of the aircraft but how fast it rolls at most. What the law is
said to be is what flies the record best: a pilot who flies the same path has the same law.
"""

from __future__ import annotations

import math
from typing import Any, NamedTuple

import numpy as np

from aircraft.state import STANDARD_GRAVITY
from autopilot.capture import SAMPLE, Capture, Loop, Response, response
from autopilot.modes.lateral_navigation import LateralNavigation

ROLL_RATE_LIMIT = math.radians(5.0)  # rad/s, of autopilots as a rule; no record at 1 Hz tells it from the lag
CROSS_TRACK_SCALE = 6.5  # m, by which a residual counts: what law (4) leaves of captures by airliners, in the median
BANK_SCALE = math.radians(2.0)  # rad, likewise
EXPLAINED_CROSS_TRACK, EXPLAINED_BANK = 30.0, math.radians(3.0)  # RMS of residuals below which the law explains
AT_AN_END = 0.02  # of a gain, within which it is at the end of the range where none was found
SHORTEST = 30  # instants; fewer do not tell seven numbers
WORTH = 0.15  # of the squares, that a limit must take away to be one that was met; see _without
MOST_ALIKE = 0.95  # correlation of residuals from one instant to the next; beyond, nothing could be said of errors
STARTS = 3  # refined, of all that are tried
EVALUATIONS = 40  # of each at most
DIFFERENCE = 1e-5  # of a parameter, for derivatives
TOLERANCE = 1e-5  # of least squares, relative

FREQUENCIES = np.geomspace(0.045, 0.3, 7)  # rad/s, of the laws that are tried first
DAMPINGS = np.geomspace(0.45, 1.8, 5)
INTERCEPTS = (0.7, 1.0, 1.4, math.inf)  # of the cross-track limit at which the first course is held; inf = never met
LAGS = (0.5, 2.0, 5.0)  # s

NAMES = ("k1", "k2", "cross_track_limit", "bank_limit", "lag")
LEAST = np.array([math.radians(3e-3), math.radians(0.08), 20.0, math.radians(2.0), 0.05])  # of NAMES, SI
GREATEST = np.array([math.radians(1.0), math.radians(8.0), 2e4, math.radians(45.0), 15.0])
STEPS = np.array([2.0, 20.0, 0.05, 0.05])  # s, m, rad, rad: of the lag, and of cross-track, track error, bank at first
DUST = 1e-3  # squares for each instant, in units of the scales: 0.2 m or 0.06 deg, which no record resolves
NEVER = 1e9  # SI, of a limit that never acts
LIMITS = (2, 3)  # of NAMES


class Parameter(NamedTuple):
    """What a capture tells about one number of a law, SI."""

    value: float
    sigma: float  # standard error; NaN where the value is a bound
    met: bool = True  # False: a limit that never acted; it is no less than the value


class LawFit(NamedTuple):
    """The route law that comes nearest to a capture."""

    k1: Parameter  # rad/m
    k2: Parameter  # rad/(m/s)
    cross_track_limit: Parameter  # m
    bank_limit: Parameter  # rad
    lag: Parameter  # s, of the bank behind its command
    cross_track_rms: float  # m, of the residuals
    bank_rms: float  # rad
    capture: Capture  # the record
    flown: Response  # by the law that was found, arrays (k,)

    @property
    def explained(self) -> bool:
        """Whether the residuals are those of a law."""
        return not self.objections

    @property
    def objections(self) -> tuple[str, ...]:
        """Why the law does not explain the capture, in words; empty where it does."""
        found = []
        if self.cross_track_rms >= EXPLAINED_CROSS_TRACK:
            found.append(f"cross-track residuals of {self.cross_track_rms:.0f} m, {EXPLAINED_CROSS_TRACK:.0f} allowed")
        if self.bank_rms >= EXPLAINED_BANK:
            told, most = (math.degrees(value) for value in (self.bank_rms, EXPLAINED_BANK))
            found.append(f"bank residuals of {told:.1f} deg, {most:.0f} allowed")
        names = {"k1": self.k1, "k2": self.k2}
        for i, (name, one) in enumerate(names.items()):
            if not (1.0 + AT_AN_END) * LEAST[i] < one.value < (1.0 - AT_AN_END) * GREATEST[i]:
                found.append(f"{name} lies at an end of what is looked for")
        return tuple(found)

    @property
    def misfit(self) -> float:
        """The larger of both residuals over what is allowed of it."""
        return max(self.cross_track_rms / EXPLAINED_CROSS_TRACK, self.bank_rms / EXPLAINED_BANK)

    @property
    def frequency(self) -> float:
        """Natural frequency inside the limits, rad/s, the bank following at once."""
        return math.sqrt(STANDARD_GRAVITY * self.k1.value)

    @property
    def damping(self) -> float:
        """Damping ratio inside the limits."""
        return STANDARD_GRAVITY * self.k2.value / (2.0 * self.frequency)


def identify_law(capture: Capture, roll_rate_limit: float = ROLL_RATE_LIMIT) -> LawFit:
    """Law (4), its limits and the lag of the bank, fitted to one capture [Vasylyev 2003, eq. (4)].

    Many laws are tried at once, the best few are refined by least squares over cross-track and bank together with the
    place, the course and the bank at the first instant. Raises ``ValueError`` for a capture that is too short.
    """
    if len(capture.time) < SHORTEST:
        raise ValueError(f"a capture needs {SHORTEST * SAMPLE:.0f} s of record, not {len(capture.time) * SAMPLE:.0f} s")
    problem = _Problem(capture, roll_rate_limit)
    found = min((problem.refined(start) for start in problem.starts()), key=lambda one: one.cost)
    for limit in LIMITS:
        without = problem.refined(_never(found.x, limit))
        if without.cost < (1.0 + WORTH) * found.cost + DUST * len(capture.time):
            found = without
    return _fit(problem, found.x)


class _Found(NamedTuple):
    """Parameters of least squares."""

    x: Any  # (8,)
    cost: float


class _Problem(NamedTuple):
    """Least squares over one capture.

    Parameters are the logarithms of k1, k2 and both limits, then the lag and what corrects cross-track, track error and
    bank of the first instant, in `STEPS`; a limit that is `NEVER` met is none.
    """

    capture: Capture
    roll_rate_limit: float

    def loops(self, x: Any) -> Loop:
        """Of parameters (8, *B)."""
        k1, k2, cross_track_limit, bank_limit = np.exp(x[:4])
        law = LateralNavigation(k1, k2, bank_limit, cross_track_limit, np.inf)
        begin = self.capture.cross_track[0], self.capture.track_error[0], self.capture.bank[0]
        first = (value + step * moved for value, step, moved in zip(begin, STEPS[1:], x[5:], strict=True))
        return Loop(law, STEPS[0] * x[4], self.roll_rate_limit, *first)

    def errors(self, x: Any) -> Any:
        """(2 k, *B) residuals in units of their scales, cross-track first."""
        flown = response(self.loops(x), self.capture)
        over = (slice(None), *(None,) * (np.ndim(x) - 1))
        offset = (flown.cross_track - self.capture.cross_track[over]) / CROSS_TRACK_SCALE
        return np.concatenate((offset, (flown.bank - self.capture.bank[over]) / BANK_SCALE))

    def jacobian(self, x: Any, free: Any) -> Any:
        """(2 k, free), by differences of one simulation of all."""
        moved = np.repeat(x[:, None], len(free) + 1, axis=1)
        moved[free, 1 + np.arange(len(free))] += DIFFERENCE
        errors = self.errors(moved)
        return (errors[:, 1:] - errors[:, :1]) / DIFFERENCE

    def refined(self, start: Any) -> _Found:
        """The least squares near a start, with the limits that it has."""
        from scipy.optimize import least_squares

        free = _free(start)
        low = np.r_[np.log(LEAST[:4]), LEAST[4] / STEPS[0], *(-10.0,) * 3]
        high = np.r_[np.log(GREATEST[:4]), GREATEST[4] / STEPS[0], *(10.0,) * 3]
        high[2] = max(math.log(1.02 * np.abs(self.capture.cross_track).max()), low[2] + 0.1)  # beyond it is never met
        low, high = low[free], high[free]

        def whole(some: Any) -> Any:
            x = start.copy()
            x[free] = some
            return x

        found = least_squares(
            lambda some: self.errors(whole(some)),
            np.clip(start[free], low + 1e-6, high - 1e-6),
            lambda some: self.jacobian(whole(some), free),
            (low, high),
            max_nfev=EVALUATIONS,
            xtol=TOLERANCE,
            ftol=TOLERANCE,
        )
        return _Found(whole(found.x), float(found.cost))

    def starts(self) -> list[Any]:
        """The best of many laws for the first course, each with another of `INTERCEPTS`."""
        capture = self.capture
        rate = abs(float(np.median((capture.ground_speed * np.sin(capture.track_error))[:8])))
        limits = 0.95 * float(np.abs(capture.bank).max()), NEVER
        axes = np.meshgrid(FREQUENCIES, DAMPINGS, limits, LAGS, INTERCEPTS, indexing="ij")
        frequency, damping, limit, lag, share = (axis.reshape(-1, len(INTERCEPTS)) for axis in axes)
        k1, k2 = frequency**2 / STANDARD_GRAVITY, 2.0 * damping * frequency / STANDARD_GRAVITY
        reach = np.where(np.isinf(share), NEVER, np.maximum(share * k2 * rate / k1, LEAST[2]))
        zero = np.zeros_like(k1)
        tried = np.stack((*np.log([k1, k2, reach, limit]), lag / STEPS[0], zero, zero, zero))
        rough = self._replace(capture=capture._replace(smoother=None))  # it costs more than the rest, for many laws
        cost = np.square(rough.errors(tried)).sum(axis=0)
        best = np.argmin(cost, axis=0)
        order = np.argsort(cost.min(axis=0), kind="stable")[:STARTS]
        return [tried[:, best[i], i] for i in order]


def _free(x: Any) -> Any:
    """Numbers of the parameters that are looked for: all but limits that are never met."""
    return np.array([i for i in range(8) if i not in LIMITS or x[i] < math.log(NEVER) - 1e-6])


def _never(x: Any, limit: int) -> Any:
    """The same without a limit."""
    without = x.copy()
    without[limit] = math.log(NEVER)
    return without


def _fit(problem: _Problem, x: Any) -> LawFit:
    """What the best parameters say."""
    capture, free = problem.capture, _free(x)
    flown = response(problem.loops(x), capture)
    values = np.r_[np.exp(x[:4]), STEPS[0] * x[4]]
    sigmas = np.full(8, math.nan)
    sigmas[free] = np.sqrt(np.diag(_covariance(problem.errors(x), problem.jacobian(x, free))))
    sigmas[:5] *= np.r_[values[:4], STEPS[0]]
    reached = {2: float(np.abs(capture.cross_track).max()), 3: float(np.abs(flown.wanted).max())}
    k1, k2, cross_track_limit, bank_limit, lag = (
        Parameter(float(values[i]), float(sigmas[i])) if i in free else Parameter(reached[i], math.nan, False)
        for i in range(5)
    )
    errors = flown.cross_track - capture.cross_track, flown.bank - capture.bank
    offset, bank = (math.sqrt(float(np.mean(np.square(one)))) for one in errors)
    return LawFit(k1, k2, cross_track_limit, bank_limit, lag, offset, bank, capture, flown)


def _covariance(errors: Any, jacobian: Any) -> Any:
    """Of the parameters, from the Jacobian (2 k, p), where errors (2 k,) near in time are alike.

    What a smoother, a gust or a law that is not quite this one leaves in cross-track and bank is no white noise. With
    the correlation a from one instant to the next, each channel has as many independent errors as k (1 - a) / (1 + a)
    instants; the estimate of a is too small by (1 + 4 a) / k, and that is put back (Kendall).
    """
    count = len(errors) // 2
    freedom = count - 0.5 * jacobian.shape[1]
    inverse = np.linalg.pinv(jacobian.T @ jacobian, rcond=1e-12, hermitian=True)
    middle = 0.0
    for channel in (slice(count), slice(count, None)):
        left, slopes = errors[channel], jacobian[channel]
        squares = max(float(left @ left), 1e-300)
        alike = float(left[1:] @ left[:-1]) / squares
        alike = min(max(alike + (1.0 + 4.0 * alike) / count, 0.0), MOST_ALIKE)
        middle = middle + slopes.T @ slopes * (squares / freedom * (1.0 + alike) / (1.0 - alike))
    return inverse @ middle @ inverse
