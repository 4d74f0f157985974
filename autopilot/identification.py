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
SHORTEST = 30  # instants; fewer do not tell seven numbers
MET = 2.0  # s, for which a limit must have acted to be one that was met
CORRELATED = 8.0  # s, over which residuals may be alike; see _covariance
STARTS = 3  # refined, of all that are tried
EVALUATIONS = 40  # of each at most
DIFFERENCE = 1e-5  # of a logarithm, for derivatives

FREQUENCIES = np.geomspace(0.045, 0.3, 7)  # rad/s, of the laws that are tried first
DAMPINGS = np.geomspace(0.45, 1.8, 5)
INTERCEPTS = (0.7, 1.0, 1.4, math.inf)  # of the cross-track limit at which the first course is held; inf = never met
LAGS = (0.5, 2.0, 5.0)  # s

NAMES = ("k1", "k2", "cross_track_limit", "bank_limit", "lag")
LEAST = np.array([math.radians(3e-3), math.radians(0.08), 20.0, math.radians(2.0), 0.05])  # of NAMES, SI
GREATEST = np.array([math.radians(1.0), math.radians(8.0), 2e4, math.radians(45.0), 15.0])
FREE_START = np.array([20.0, 0.05])  # m, rad: steps of the cross-track and the track error of the first instant


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
        return tuple(found)

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
    place and the course at the first instant. Raises ``ValueError`` for a capture that is too short.
    """
    from scipy.optimize import least_squares

    if len(capture.time) < SHORTEST:
        raise ValueError(f"a capture needs {SHORTEST * SAMPLE:.0f} s of record, not {len(capture.time) * SAMPLE:.0f} s")
    low = np.r_[np.log(LEAST), -np.full(2, 10.0)]
    high = np.r_[np.log(GREATEST), np.full(2, 10.0)]
    reach = float(np.abs(capture.cross_track).max())
    high[2] = max(math.log(1.02 * reach), low[2] + 0.1)  # a limit beyond is never met
    problem = _Problem(capture, roll_rate_limit)
    best = None
    for start in problem.starts():
        inside = np.clip(start, low + 1e-6, high - 1e-6)
        found = least_squares(
            problem.residuals, inside, problem.jacobian, (low, high), x_scale=1.0, max_nfev=EVALUATIONS, xtol=1e-6
        )
        if best is None or found.cost < best.cost:
            best = found
    return _fit(problem, best.x, reach)


class _Problem(NamedTuple):
    """Least squares over one capture: parameters are the logarithms of NAMES and the two of the first instant."""

    capture: Capture
    roll_rate_limit: float

    def loops(self, x: Any) -> Loop:
        """Of parameters (7, *B)."""
        k1, k2, cross_track_limit, bank_limit, lag = np.exp(x[:5])
        law = LateralNavigation(k1, k2, bank_limit, cross_track_limit, np.inf)
        offset = self.capture.cross_track[0] + FREE_START[0] * x[5]
        return Loop(law, lag, self.roll_rate_limit, offset, self.capture.track_error[0] + FREE_START[1] * x[6])

    def errors(self, x: Any) -> Any:
        """(2 k, *B) residuals in units of their scales, cross-track first."""
        flown = response(self.loops(x), self.capture)
        over = (slice(None), *(None,) * (np.ndim(x) - 1))
        offset = (flown.cross_track - self.capture.cross_track[over]) / CROSS_TRACK_SCALE
        return np.concatenate((offset, (flown.bank - self.capture.bank[over]) / BANK_SCALE))

    def residuals(self, x: Any) -> Any:
        """(2 k,)."""
        return self.errors(x)

    def jacobian(self, x: Any) -> Any:
        """(2 k, 7), by differences of one simulation of all."""
        moved = np.repeat(x[:, None], len(x) + 1, axis=1)
        moved[:, 1:] += DIFFERENCE * np.eye(len(x))
        errors = self.errors(moved)
        return (errors[:, 1:] - errors[:, :1]) / DIFFERENCE

    def starts(self) -> list[Any]:
        """The best of many laws for the first course, each with another of `INTERCEPTS`."""
        capture = self.capture
        k1 = FREQUENCIES**2 / STANDARD_GRAVITY
        rate = abs(float(np.median((capture.ground_speed * np.sin(capture.track_error))[:8])))
        most = float(np.abs(capture.bank).max())
        tried = []
        for share in INTERCEPTS:
            grid = np.meshgrid(FREQUENCIES, DAMPINGS, (0.95 * most, GREATEST[3]), LAGS, indexing="ij")
            frequency, damping, limit, lag = (axis.ravel() for axis in grid)
            k1, k2 = frequency**2 / STANDARD_GRAVITY, 2.0 * damping * frequency / STANDARD_GRAVITY
            reach = np.full_like(k1, GREATEST[2]) if share == math.inf else np.maximum(share * k2 * rate / k1, LEAST[2])
            start = np.zeros((2, len(k1)))
            tried.append(np.concatenate((np.log([k1, k2, reach, limit, lag]), start)))
        laws = np.concatenate(tried, axis=1)
        cost = np.square(self.errors(laws)).sum(axis=0).reshape(len(INTERCEPTS), -1)
        cost = np.where(np.isfinite(cost), cost, np.inf)
        order = np.argsort(cost.min(axis=1), kind="stable")[:STARTS]
        return [tried[i][:, int(np.argmin(cost[i]))] for i in order]


def _fit(problem: _Problem, x: Any, reach: float) -> LawFit:
    """What the best parameters say."""
    capture = problem.capture
    flown = response(problem.loops(x), capture)
    values = np.exp(x[:5])
    met = np.ones(7, bool)
    met[2] = np.count_nonzero(np.abs(flown.cross_track) > values[2]) * SAMPLE >= MET
    met[3] = np.count_nonzero(np.abs(flown.wanted) > values[3]) * SAMPLE >= MET
    sigmas = np.full(7, math.nan)
    sigmas[met] = np.sqrt(np.diag(_covariance(problem.errors(x), problem.jacobian(x)[:, met])))
    sigmas[:5] *= values  # of a number from that of its logarithm
    bounds = {2: reach, 3: float(np.abs(flown.wanted).max())}
    parameters = [
        Parameter(float(values[i]), float(sigmas[i])) if met[i] else Parameter(bounds[i], math.nan, False)
        for i in range(5)
    ]
    errors = flown.cross_track - capture.cross_track, flown.bank - capture.bank
    offset, bank = (math.sqrt(float(np.mean(np.square(one)))) for one in errors)
    return LawFit(*parameters, offset, bank, capture, flown)


def _covariance(errors: Any, jacobian: Any) -> Any:
    """Of the parameters, from the Jacobian (2 k, p), where errors (2 k,) near in time are alike.

    The score of each instant is summed over neighbours with falling weights up to `CORRELATED` (Newey and West): what a
    smoother or a gust leaves in the residuals is no independent noise, which would make the errors too small.
    """
    count = len(errors) // 2
    scores = (errors[:, None] * jacobian).reshape(2, count, -1).sum(axis=0)
    lags = int(CORRELATED / SAMPLE)
    middle = scores.T @ scores
    for lag in range(1, min(lags, count - 1) + 1):
        both = scores[lag:].T @ scores[:-lag]
        middle += (1.0 - lag / (lags + 1.0)) * (both + both.T)
    inverse = np.linalg.pinv(jacobian.T @ jacobian, rcond=1e-12, hermitian=True)
    return inverse @ middle @ inverse * (count / max(count - jacobian.shape[1], 1))
