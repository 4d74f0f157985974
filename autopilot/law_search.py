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
LATE, PARAMETERS = 8, 9  # place of the time at which the law takes over, and count
STEPS = np.array([2.0, 20.0, 0.05, 0.05, 2.0])  # SI, of all behind the logarithms
FARTHEST, LATEST = 10.0, 20.0  # steps from the record at the first instant; of taking over
NEVER = 1e9  # SI, of a limit that never acts

FREQUENCIES = np.geomspace(0.045, 0.3, 7)  # rad/s, of the laws that are tried first
DAMPINGS = np.geomspace(0.45, 1.8, 5)
LAGS = (0.5, 2.0, 5.0)  # s
# cross-track limit over that at which the first course is held (inf = never met), s at which the law takes over
INTERCEPTS = ((0.7, -1.0), (1.0, -1.0), (1.4, -1.0), (math.inf, -1.0), (0.4, 9.0), (math.inf, 6.0), (math.inf, 10.0))
STARTS = 2  # refined, of laws that fly all of the capture and of those that take over in it
EVALUATIONS = 40  # of each at most
DIFFERENCE = 1e-5  # of a parameter, for derivatives
TOLERANCE = 1e-5  # of least squares, relative


class Found(NamedTuple):
    """The least squares near a start."""

    x: Any  # (PARAMETERS,)
    cost: float


class Search(NamedTuple):
    """Least squares over one capture.

    Parameters are the logarithms of k1, k2 and both limits; then, in `STEPS`, the lag, what corrects cross-track, track
    error and bank of the first instant, and when the law takes over. A limit that is `NEVER` met is none, and a law
    that takes over before the first instant flies all of it.
    """

    capture: Capture
    roll_rate_limit: float

    def loop(self, x: Any) -> Loop:
        """Of parameters (PARAMETERS, *B)."""
        k1, k2, cross_track_limit, bank_limit = np.exp(x[:4])
        law = LateralNavigation(k1, k2, bank_limit, cross_track_limit, np.inf)
        lag, offset, track, bank, engaged = (step * value for step, value in zip(STEPS, x[4:], strict=True))
        first = self.capture
        begin = first.cross_track[0] + offset, first.track_error[0] + track, first.bank[0] + bank
        return Loop(law, lag, self.roll_rate_limit, begin[0], begin[1], begin[2], engaged)

    def errors(self, x: Any) -> Any:
        """(2 k, *B) residuals in units of their scales, cross-track first."""
        flown = response(self.loop(x), self.capture)
        over = (slice(None), *(None,) * (np.ndim(x) - 1))
        offset = (flown.cross_track - self.capture.cross_track[over]) / CROSS_TRACK_SCALE
        return np.concatenate((offset, (flown.bank - self.capture.bank[over]) / BANK_SCALE))

    def slopes(self, x: Any, free: Any) -> tuple[Any, Any]:
        """(2 k,) residuals and their derivatives (2 k, free) by differences, of one simulation of all."""
        moved = np.repeat(x[:, None], len(free) + 1, axis=1)
        moved[free, 1 + np.arange(len(free))] += DIFFERENCE
        errors = self.errors(moved)
        return errors[:, 0], (errors[:, 1:] - errors[:, :1]) / DIFFERENCE

    def free(self, x: Any) -> Any:
        """Numbers of the parameters that are looked for: no limit that is never met, no time of a law always on."""
        fixed = {i for i in LIMITS if x[i] > math.log(NEVER) - 1e-6} | ({LATE} if x[LATE] < 0.0 else set())
        return np.array([i for i in range(PARAMETERS) if i not in fixed])

    def refined(self, start: Any) -> Found:
        """The least squares near a start, with the limits that it has."""
        from scipy.optimize import least_squares

        free = self.free(start)
        low = np.r_[np.log(LEAST[:4]), LEAST[4] / STEPS[0], *(-FARTHEST,) * 3, 0.0]
        high = np.r_[np.log(GREATEST[:4]), GREATEST[4] / STEPS[0], *(FARTHEST,) * 3, LATEST]
        high[2] = max(math.log(1.02 * np.abs(self.capture.cross_track).max()), low[2] + 0.1)  # beyond it is never met
        low, high = low[free], high[free]
        known: dict[bytes, tuple[Any, Any]] = {}

        def whole(some: Any) -> Any:
            x = start.copy()
            x[free] = some
            return x

        def both(some: Any) -> tuple[Any, Any]:
            key = some.tobytes()
            if key not in known:  # derivatives cost nothing beside the simulation, and are asked for next
                known.clear()
                known[key] = self.slopes(whole(some), free)
            return known[key]

        found = least_squares(
            lambda some: both(some)[0],
            np.clip(start[free], low + 1e-6, high - 1e-6),
            lambda some: both(some)[1],
            (low, high),
            max_nfev=EVALUATIONS,
            xtol=TOLERANCE,
            ftol=TOLERANCE,
        )
        return Found(whole(found.x), float(found.cost))

    def starts(self) -> tuple[list[Any], list[Any]]:
        """The best of many laws for the first course: some that fly all of the capture, some that take over in it."""
        capture = self.capture
        rate = abs(float(np.median((capture.ground_speed * np.sin(capture.track_error))[:8])))
        limits = 0.95 * float(np.abs(capture.bank).max()), NEVER
        axes = np.meshgrid(FREQUENCIES, DAMPINGS, limits, LAGS, np.arange(len(INTERCEPTS)), indexing="ij")
        frequency, damping, limit, lag, _ = (axis.reshape(-1, len(INTERCEPTS)) for axis in axes)
        k1, k2 = frequency**2 / STANDARD_GRAVITY, 2.0 * damping * frequency / STANDARD_GRAVITY
        share, engaged = np.array(INTERCEPTS).T[:, None] * np.ones_like(k1)
        reach = np.where(np.isinf(share), NEVER, np.maximum(share * k2 * rate / k1, LEAST[2]))
        zero = np.zeros_like(k1)
        tried = np.stack((*np.log([k1, k2, reach, limit]), lag / STEPS[0], zero, zero, zero, engaged / STEPS[-1]))
        rough = self._replace(capture=capture._replace(smoother=None))  # it costs more than the rest, for many laws
        cost = np.square(rough.errors(tried)).sum(axis=0)
        best, order = np.argmin(cost, axis=0), np.argsort(cost.min(axis=0), kind="stable")
        late = tried[LATE, 0, order] >= 0.0
        whole, taking_over = (order[which][:STARTS] for which in (~late, late))
        return [tried[:, best[i], i] for i in whole], [tried[:, best[i], i] for i in taking_over]


def never(x: Any, limit: int) -> Any:
    """The same parameters without a limit."""
    without = x.copy()
    without[limit] = math.log(NEVER)
    return without
