"""Who is flying, and by which law: interacting multiple models over control laws and free flight."""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cached_property
from typing import Annotated, Any, NamedTuple

import numpy as np

from tracking.gaussian import Gaussian, Innovation, Mixture, interact, lift, predict, update_mixture
from tracking.measurement import MeasurementModel
from tracking.reference_path import Law, Line, Placed, ReferencePath, check_tuning, reference_path, sub_steps, uniform
from tracking.trackers import law_ekf, route_control

LIMITS = {"cross_track_limit": "route law", "bearing_limit": "beacon law"}  # what sets a far intercept, by law
MANUAL = "manual"  # the intent of free flight


class Intent(NamedTuple):
    """Hypotheses and the place on the path that their common estimate has."""

    mixture: Mixture
    place: Any


class Bank(NamedTuple):
    """The told law with its limits over an axis of hypotheses, and another law in the last of them."""

    told: Law
    other: Law
    batch: int  # axes of runs behind that of the hypotheses

    @property
    def bank_limit(self) -> Any:
        """rad."""
        return self.told.bank_limit

    def __call__(self, deviation: Any) -> Any:
        """Bank, rad, of every hypothesis."""
        banks = self.told(deviation)
        banks[(..., slice(-1, None), *(slice(None),) * self.batch)] = self.other(deviation.of_last(self.batch))
        return banks


@dataclass(frozen=True)
class IntentImm:
    """The told law at several intercept limits, another law, and free flight with little and with much manoeuvre.

    Far from the path all that shows of a law is the course at which it intercepts, which the position limit sets (z_max
    of [Vasylyev 2003, eq. (4)], the bearing limit of eq. (5)). So the bank of laws varies that limit alone, and the
    model probabilities say which limit is flown, and whether any law is. On a line the laws move as in `law_ekf`, on a
    route as in `route_control` with the slope of the law, so an aircraft that is flown on the estimate itself is a case
    for `route_control` with the control as known, not for this tracker.

    The other law is one that the autopilot could be switched to: the beacon law where the told one is a route law. With
    it the tracker also says who is flying (`intents`): the told law, the other one, or the crew by hand.

    Model probabilities are in the order of `modes`. Modes are left at a rate of 1 / ``mean_stay`` for any other mode
    alike, whatever the time between steps.
    """

    law: Annotated[Any, "given"]
    route: Annotated[Any, "given"]  # a Line, or a route
    measurement: Annotated[MeasurementModel, "given"]
    other_law: Annotated[Law | None, "given"] = None  # that the autopilot has too; None = it has no other
    limit_factors: tuple[float, ...] = (0.4, 0.64, 1.0, 1.6, 2.4)
    mean_stay: Annotated[float, "s"] = 120.0
    law_density: Annotated[float, "m2/s3"] = 0.1
    straight_density: Annotated[float, "m2/s3"] = 0.05
    manoeuvre_density: Annotated[float, "m2/s3"] = 3.0
    sub_step: Annotated[float, "s"] = 0.5

    def __post_init__(self) -> None:
        if not self.limit_factors or not all(factor > 0.0 for factor in self.limit_factors):
            raise ValueError(f"limit_factors must be positive numbers, at least one, not {self.limit_factors}")
        if not any(hasattr(self.law, name) for name in LIMITS):
            raise ValueError(f"the law has no {' and no '.join(LIMITS)}, so there is no intercept to identify")
        if self.other_law is not None and self._other in ((), (LIMITS[self._limit],)):
            raise ValueError("the other law is a beacon law beside a route law, or a route law beside a beacon law")
        if not self.mean_stay > 0.0:
            raise ValueError(f"mean_stay must be positive, not {self.mean_stay} s")
        for density in (self.law_density, self.straight_density, self.manoeuvre_density):
            check_tuning(density, self.sub_step)

    @cached_property
    def _path(self) -> ReferencePath:
        return reference_path(self.route, self.law)

    @cached_property
    def _limit(self) -> str:
        return next(name for name in LIMITS if hasattr(self.law, name))

    @property
    def _other(self) -> tuple[str, ...]:
        """The intent of the other law, if there is one."""
        return (
            () if self.other_law is None else tuple(it for name, it in LIMITS.items() if hasattr(self.other_law, name))
        )

    @property
    def _laws(self) -> int:
        """How many hypotheses fly a law."""
        return len(self.limit_factors) + len(self._other)

    @property
    def channels(self) -> tuple[str, ...]:
        return self._path.channels

    @property
    def modes(self) -> tuple[str, ...]:
        """Names of the hypotheses: each law by the factor on its limit, the other law, then free flight."""
        return (*(f"law x {factor:g}" for factor in self.limit_factors), *self._other, "straight", "manoeuvre")

    @property
    def intents(self) -> tuple[str, ...]:
        """What each hypothesis says the aircraft follows: ``route law``, ``beacon law`` or ``manual``."""
        return (*(LIMITS[self._limit],) * len(self.limit_factors), *self._other, MANUAL, MANUAL)

    @property
    def limits(self) -> Any:
        """The position limit of each law of the bank, in the order of `modes`."""
        return getattr(self.law, self._limit) * np.array(self.limit_factors)

    def flown_limit(self, estimate: Mixture) -> Any:
        """The position limit that is flown (*B): geometric mean over the bank, given that a law is flown at all."""
        belief = estimate.weights[: len(self.limit_factors)]
        return np.exp(np.einsum("m...,m->...", belief, np.log(self.limits)) / belief.sum(axis=0))

    def bank(self, batch: int) -> Law:
        """The laws as one, their axis before ``batch`` axes of runs.

        The rate limit grows with the position limit: a law whose rate term cannot balance its position term orbits.
        """
        factors = lift(np.array((*self.limit_factors, *(1.0,) * (self._laws - len(self.limit_factors)))), 1, batch)
        limits = {self._limit: getattr(self.law, self._limit) * factors}
        if hasattr(self.law, "cross_track_rate_limit"):
            limits["cross_track_rate_limit"] = self.law.cross_track_rate_limit * np.maximum(factors, 1.0)
        laws: Law = replace(self.law, **limits)
        if self.other_law is None:
            return laws
        return Bank(laws, self.other_law, batch)

    def begin(self, prior: Gaussian) -> Intent:
        runs, count = prior.mean.shape[1:], len(self.modes)
        weights = np.full((count, *runs), 1.0 / count)
        mean = np.repeat(prior.mean[:, None], count, axis=1)
        cov = np.empty((len(mean), *mean.shape))
        cov[:] = lift(prior.cov, 2, len(runs))[:, :, None]
        return Intent(Mixture(weights, mean, cov), self._path.begin(prior.mean))

    def step(self, state: Intent, dt: float, z: Any | None, R: Any | None) -> tuple[Intent, Innovation | None]:
        if dt > 0.0:
            state = self._predict(state, dt)
        if z is None:
            return state, None
        predicted = np.einsum("m...,im...->i...", state.mixture.weights, state.mixture.mean)
        mixture, innovation = update_mixture(state.mixture, *self.measurement.linearise(z, R, predicted))
        return Intent(mixture, state.place), innovation

    def estimate(self, state: Intent) -> Mixture:
        return state.mixture

    def _predict(self, state: Intent, dt: float) -> Intent:
        weights, mean, cov = interact(state.mixture, self._switching(dt))
        laws = self._laws
        flown, place = self._fly(Mixture(weights[:laws], mean[:, :laws], cov[:, :, :laws]), state.place, dt)
        free = self._coast(Gaussian(mean[:, laws:], cov[:, :, laws:]), dt)
        means = np.concatenate([flown.mean, free.mean], axis=1)
        shape = np.broadcast_shapes(flown.cov.shape[3:], free.cov.shape[3:])
        covs = [np.broadcast_to(part.cov, (*part.cov.shape[:3], *shape)) for part in (flown, free)]
        return Intent(Mixture(weights, means, np.concatenate(covs, axis=2)), place)

    def switched(self, probabilities: Any, dt: Any) -> Any:
        """Model probabilities dt (s) later, before anything is measured: every mode is left at an even rate."""
        count = len(self.modes)
        stay = np.exp(-dt * count / ((count - 1) * self.mean_stay))
        return stay * probabilities + (1.0 - stay) / count

    def _switching(self, dt: float) -> Any:
        """Switching probabilities over dt, a semigroup."""
        return self.switched(np.eye(len(self.modes)), dt)

    def _fly(self, laws: Mixture, place: Any, dt: float) -> tuple[Gaussian, Any]:
        """Every law by itself, all from the place on the path that their common estimate has."""
        law = self.bank(laws.mean.ndim - 2)
        forward: Any = law_ekf.advance if isinstance(self._path, Line) else route_control.autonomous
        share = laws.weights / laws.weights.sum(axis=0)
        gaussian = Gaussian(laws.mean, laws.cov)
        count, step = sub_steps(dt, self.sub_step)
        Q = lift(uniform(self._path.axes, step, self.law_density)[1], 2, laws.cov.ndim - 2)
        for _ in range(count):
            gaussian = forward(law, self._path, Placed(gaussian, place), step, Q)
            place = self._path.advance(place, np.einsum("m...,im...->i...", share, gaussian.mean), step)
        return gaussian, place

    def _coast(self, gaussian: Gaussian, dt: float) -> Gaussian:
        """Free flight, straight and manoeuvring."""
        calm, F = uniform(self._path.axes, dt, self.straight_density)[::-1]
        wild = uniform(self._path.axes, dt, self.manoeuvre_density)[1]
        batch = gaussian.cov.ndim - 2
        return predict(gaussian, lift(F, 2, batch), lift(np.stack([calm, wild], axis=-1), 3, batch - 1))
