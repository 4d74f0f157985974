"""The law that comes nearest to a capture: many tried at once, the best few refined by least squares."""

from __future__ import annotations

import math
from typing import Any, NamedTuple

import numpy as np

from aircraft.state import STANDARD_GRAVITY
from autopilot.capture import Capture, Loop, response
from autopilot.modes.lateral_navigation import LateralNavigation

CROSS_TRACK_SCALE = 6.5  # m, by which a residual counts: what law (4) leaves of captures by airliners, in the median
BANK_SCALE = math.radians(2.0)  # rad, likewise

NAMES = ("k1", "k2", "cross_track_limit", "bank_limit", "lag")
LEAST = np.array([math.radians(3e-3), math.radians(0.08), 20.0, math.radians(2.0), 0.05])  # of NAMES, SI
GREATEST = np.array([math.radians(1.0), math.radians(8.0), 2e4, math.radians(45.0), 15.0])
LIMITS = (2, 3)  # of NAMES
LATE, LINE, PARAMETERS = 8, 9, 10  # places of the time at which the law takes over and of the line, and count
STEPS = np.array([2.0, 20.0, 0.05, 0.05, 2.0, 20.0])  # SI, of all behind the logarithms
LINE_SIGMA = 40.0  # m, by which the line that is held may lie beside the leg: .1 deg of course at 12 nautical miles
FARTHEST, LATEST = 10.0, 20.0  # steps from the record at the first instant; of taking over
NEVER = 1e9  # SI, of a limit that never acts

FREQUENCIES = np.geomspace(0.045, 0.3, 7)  # rad/s, of the laws that are tried first
DAMPINGS = np.geomspace(0.45, 1.8, 5)
LAGS = (0.5, 2.0, 5.0)  # s
# cross-track limit over that at which the first course is held (inf = never met), s at which the law takes over
INTERCEPTS = (
    *((share, -1.0) for share in (0.7, 1.0, 1.4, math.inf)),
    *((share, since) for share in (0.3, 0.5, 0.8, math.inf) for since in (5.1, 8.1, 11.1)),
)
FIRST_ROUNDS, ROUNDS = 10, 40  # of least squares: of all starts, and at most of the best `KEPT` with the same limits
KEPT = 2
DIFFERENCE = 1e-5  # of a parameter, for derivatives
TOLERANCE = 1e-5  # of the squares, relative: less is no progress
DAMPED, LEAST_DAMPED, MOST_DAMPED = 1e-2, 1e-7, 1e7  # of the diagonal (Levenberg and Marquardt)
# share of its squares by which a fit without it is worse, from which on something is believed: either limit, and taking
# over late. Of 60 captures by known laws, a limit that never acted took away 13 % at most, one that did 75 % in the
# median; for a law that took over late and one that did not it is 32 % and 34 %
WORTH = np.array([0.15, 0.15, 0.4])
DUST = 1e-3  # squares for each instant, in units of the scales: 0.2 m or 0.06 deg, which no record resolves


class Search(NamedTuple):
    """Least squares over one capture.

    Parameters are the logarithms of k1, k2 and both limits; then, in `STEPS`, the lag, what corrects cross-track, track
    error and bank of the first instant, when the law takes over, and the cross-track of the line that it holds. A limit
    that is `NEVER` met is none, and a law that takes over before the first instant flies all of it.
    """

    capture: Capture
    roll_rate_limit: float

    def loop(self, x: Any) -> Loop:
        """Of parameters (PARAMETERS, *B)."""
        k1, k2, cross_track_limit, bank_limit = np.exp(x[:4])
        law = LateralNavigation(k1, k2, bank_limit, cross_track_limit, np.inf)
        lag, offset, track, bank, engaged, line = (step * value for step, value in zip(STEPS, x[4:], strict=True))
        first = self.capture
        begin = first.cross_track[0] + offset, first.track_error[0] + track, first.bank[0] + bank
        return Loop(law, lag, self.roll_rate_limit, begin[0], begin[1], begin[2], line, engaged)

    def errors(self, x: Any) -> Any:
        """(2 k + 1, *B) residuals in units of their scales: cross-track, bank, and how far the line is from the leg."""
        flown = response(self.loop(x), self.capture)
        over = (slice(None), *(None,) * (np.ndim(x) - 1))
        offset = (flown.cross_track - self.capture.cross_track[over]) / CROSS_TRACK_SCALE
        bank = (flown.bank - self.capture.bank[over]) / BANK_SCALE
        return np.concatenate((offset, bank, STEPS[LINE - 4] / LINE_SIGMA * x[LINE:]))

    def slopes(self, x: Any) -> tuple[Any, Any]:
        """Of parameters (PARAMETERS, N): residuals (2 k + 1, N) and their derivatives (2 k + 1, PARAMETERS, N).

        By differences, of one simulation of all. What is not looked for has none.
        """
        moved = x[:, None] + DIFFERENCE * np.concatenate((np.zeros((PARAMETERS, 1)), np.eye(PARAMETERS)), 1)[..., None]
        errors = self.errors(np.where(free(x)[:, None], moved, x[:, None]))
        return errors[:, 0], (errors[:, 1:] - errors[:, :1]) / DIFFERENCE

    def best(self) -> Any:
        """(PARAMETERS,) the law to be believed: of all starts, the best by its squares and `WORTH`."""
        x, squares = self.refined(self.starts(), FIRST_ROUNDS)
        kinds = free(x)[[*LIMITS, LATE]].T @ (1, 2, 4)
        order = np.argsort(squares, kind="stable")
        kept = np.concatenate([order[kinds[order] == kind][:KEPT] for kind in np.unique(kinds)])
        x, squares = self.refined(x[:, kept], ROUNDS)
        score = np.log(squares + DUST * len(self.capture.time)) + np.log1p(WORTH) @ free(x)[[*LIMITS, LATE]]
        return x[:, int(np.argmin(score))]

    def refined(self, x: Any, rounds: int) -> tuple[Any, Any]:
        """Least squares from starts (PARAMETERS, N), all at once: parameters and their squares (N,).

        Steps of Levenberg and Marquardt within bounds: a parameter that a step would push through its bound stays
        there.
        """
        low, high = self._bounds()
        x = np.where(free(x), np.clip(x, low[:, None], high[:, None]), x)
        errors, slopes = self.slopes(x)
        squares = np.square(errors).sum(axis=0)
        damped, done = np.full(len(squares), DAMPED), np.zeros(len(squares), bool)
        for _ in range(rounds):
            gradient = np.einsum("kpn,kn->np", slopes, errors)
            still = ((low >= x.T) & (gradient > 0.0)) | ((high <= x.T) & (gradient < 0.0)) | (gradient == 0.0)
            normal = np.einsum("kpn,kqn->npq", slopes, slopes) * ~still[:, :, None] * ~still[:, None, :]
            diagonal = np.einsum("npp->np", normal)
            diagonal += damped[:, None] * diagonal + np.where(still, 1.0, 1e-12)
            step = np.linalg.solve(normal, -np.where(still, 0.0, gradient)[..., None])[..., 0].T
            trial = np.where(free(x), np.clip(x + step, low[:, None], high[:, None]), x)
            trial_errors, trial_slopes = self.slopes(trial)
            trial_squares = np.square(trial_errors).sum(axis=0)
            better = trial_squares < squares
            done |= (better & (squares - trial_squares < TOLERANCE * squares)) | (damped >= MOST_DAMPED)
            x, errors, slopes = (
                np.where(better, new, old) for new, old in ((trial, x), (trial_errors, errors), (trial_slopes, slopes))
            )
            squares = np.where(better, trial_squares, squares)
            damped = np.clip(np.where(better, 0.2, 5.0) * damped, LEAST_DAMPED, MOST_DAMPED)
            if done.all():
                break
        return x, squares

    def _bounds(self) -> tuple[Any, Any]:
        low = np.r_[np.log(LEAST[:4]), LEAST[4] / STEPS[0], *(-FARTHEST,) * 3, 0.0, -FARTHEST]
        high = np.r_[np.log(GREATEST[:4]), GREATEST[4] / STEPS[0], *(FARTHEST,) * 3, LATEST, FARTHEST]
        high[2] = max(math.log(1.02 * np.abs(self.capture.cross_track).max()), low[2] + 0.1)  # beyond it is never met
        return low, high

    def starts(self) -> Any:
        """(PARAMETERS, N) for each of `INTERCEPTS` and `LAGS`, with a bank limit and without, the best of many laws."""
        capture = self.capture
        rate = abs(float(np.median((capture.ground_speed * np.sin(capture.track_error))[:8])))
        limits = np.array((0.95 * float(np.abs(capture.bank).max()), NEVER))
        kinds = np.arange(len(INTERCEPTS))
        axes = np.meshgrid(FREQUENCIES, DAMPINGS, LAGS, kinds, limits, indexing="ij")
        some = len(FREQUENCIES) * len(DAMPINGS)
        frequency, damping, lag, kind, limit = (axis.reshape(some, -1) for axis in axes)
        share, since = np.moveaxis(np.array(INTERCEPTS)[kind.astype(int)], -1, 0)
        k1, k2 = frequency**2 / STANDARD_GRAVITY, 2.0 * damping * frequency / STANDARD_GRAVITY
        reach = np.where(np.isinf(share), NEVER, np.maximum(share * k2 * rate / k1, LEAST[2]))
        zero = np.zeros_like(k1)
        tried = np.stack(
            (*np.log([k1, k2, reach, limit]), lag / STEPS[0], zero, zero, zero, since / STEPS[LATE - 4], zero)
        )
        rough = self._replace(capture=capture._replace(smoother=None))  # it costs more than the rest, for many laws
        chosen = np.argmin(np.square(rough.errors(tried)).sum(axis=0), axis=0)
        return tried[:, chosen, np.arange(tried.shape[-1])]


def free(x: Any) -> Any:
    """(PARAMETERS, *B) what is looked for: no limit that is never met, no time of a law that is always on."""
    looked = np.ones(np.shape(x), bool)
    looked[list(LIMITS)] = x[list(LIMITS)] < math.log(NEVER) - 1e-6
    looked[LATE] = x[LATE] >= 0.0
    return looked
