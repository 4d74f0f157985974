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
from autopilot.capture import SAMPLE, Capture, Response, response
from autopilot.law_search import BANK_SCALE, CROSS_TRACK_SCALE, LATE, LINE, PARAMETERS, STEPS, Search, free

ROLL_RATE_LIMIT = math.radians(5.0)  # rad/s, of autopilots as a rule; no record at 1 Hz tells it from the lag
EXPLAINED_CROSS_TRACK, EXPLAINED_BANK = 30.0, math.radians(3.0)  # RMS of residuals below which the law explains
LONGEST_APPROACH = 60.0  # s, k2 / k1, with which a law without limits nears its leg; slower, a capture does not show it
SHORTEST = 30  # instants; fewer do not tell nine numbers
UNSEEN = 8.0  # s, or the lag if that is longer, for which a limit may act without being seen (of 75 bounds, 1 is wrong)
MOST_ALIKE = 0.95  # correlation of residuals from one instant to the next; beyond, nothing could be said of errors


class Parameter(NamedTuple):
    """What a capture tells about one number of a law, SI."""

    value: float
    sigma: float  # standard error; NaN where the value is a bound
    met: bool = True  # False: a limit that was not seen to act; it is no less than the value, or hardly


class LawFit(NamedTuple):
    """The route law that comes nearest to a capture."""

    k1: Parameter  # rad/m
    k2: Parameter  # rad/(m/s)
    cross_track_limit: Parameter  # m
    bank_limit: Parameter  # rad
    lag: Parameter  # s, of the bank behind its command
    line: Parameter  # m, cross-track of the line that was held, beside the leg
    engaged: float | None  # s, time at which the law took over from a held course; None = it flew all of the capture
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
        approach = self.k2.value / self.k1.value
        if approach > LONGEST_APPROACH:
            found.append(f"a course is steered, not the line: it would be approached with {approach:.0f} s")
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

    Many laws are tried at once, the best are refined by least squares over cross-track and bank together with place,
    course and bank of the first instant. A law that took over within the capture, and each limit, must pay for itself:
    a far intercept on its own course looks the same as a heading that was held. The line that is held may lie beside
    the leg, as a beam beside a published course: else k1 and the cross-track limit would answer for it.

    Raises ``ValueError`` for a capture that is too short.
    """
    if len(capture.time) < SHORTEST:
        raise ValueError(f"a capture needs {SHORTEST * SAMPLE:.0f} s of record, not {len(capture.time) * SAMPLE:.0f} s")
    search = Search(capture, roll_rate_limit)
    return _fit(search, search.best())


def _fit(search: Search, x: Any) -> LawFit:
    """What the best parameters say."""
    capture, known = search.capture, free(x)
    flown = response(search.loop(x), capture)
    values = np.r_[np.exp(x[:4]), STEPS[0] * x[4]]
    sigmas = np.full(PARAMETERS, math.nan)
    errors, slopes = search.slopes(x[:, None])
    sigmas[known] = np.sqrt(np.diag(_covariance(errors[:, 0], slopes[:, known, 0])))
    sigmas *= np.r_[values[:4], STEPS]
    since = float(STEPS[LATE - 4] * x[LATE])
    by_law = capture.time - capture.time[0] >= since
    unseen = int(max(UNSEEN, values[4]) / SAMPLE)
    reached = {2: _held(capture.cross_track[by_law], unseen), 3: _held(flown.wanted[by_law], unseen)}
    k1, k2, cross_track_limit, bank_limit, lag = (
        Parameter(float(values[i]), float(sigmas[i])) if known[i] else Parameter(reached[i], math.nan, False)
        for i in range(5)
    )
    offset, bank = (math.sqrt(float(np.mean(np.square(one)))) for one in np.split(errors[:-1, 0], 2))
    offset, bank = CROSS_TRACK_SCALE * offset, BANK_SCALE * bank
    engaged = float(capture.time[0]) + since if since >= 0.0 else None
    line = Parameter(float(STEPS[LINE - 4] * x[LINE]), float(sigmas[LINE]))
    return LawFit(k1, k2, cross_track_limit, bank_limit, lag, line, engaged, offset, bank, capture, flown)


def _held(values: Any, instants: int) -> float:
    """The largest size that is reached or passed at so many instants and one more."""
    return float(np.sort(np.abs(values))[::-1][min(instants, len(values) - 1)])


def _covariance(errors: Any, jacobian: Any) -> Any:
    """Of the parameters, from the Jacobian (2 k + 1, p), where errors (2 k + 1,) near in time are alike.

    What a smoother, a gust or a law that is not quite this one leaves in cross-track and bank is no white noise. With
    the correlation a from one instant to the next, each channel has as many independent errors as k (1 - a) / (1 + a)
    instants; the estimate of a is too small by (1 + 4 a) / k, and that is put back (Kendall).
    """
    count = len(errors) // 2
    freedom = count - 0.5 * jacobian.shape[1]
    inverse = np.linalg.pinv(jacobian.T @ jacobian, rcond=1e-12, hermitian=True)
    middle = 0.0
    for channel in (slice(count), slice(count, 2 * count)):
        left, slopes = errors[channel], jacobian[channel]
        squares = max(float(left @ left), 1e-300)
        alike = float(left[1:] @ left[:-1]) / squares
        alike = min(max(alike + (1.0 + 4.0 * alike) / count, 0.0), MOST_ALIKE)
        middle = middle + slopes.T @ slopes * (squares / freedom * (1.0 + alike) / (1.0 - alike))
    return inverse @ middle @ inverse
