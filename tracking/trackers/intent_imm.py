"""Who is flying, and by which law: interacting multiple models over control laws and free flight."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from functools import cached_property, lru_cache
from typing import Annotated, Any, NamedTuple

import numpy as np
from scipy.linalg import expm

from tracking.gaussian import Gaussian, Innovation, Mixture, interact, lift, predict, update_mixture
from tracking.law_bank import LawBank
from tracking.measurement import MeasurementModel
from tracking.reference_path import (
    SLOWEST,
    SUB_STEP,
    Law,
    Line,
    PathState,
    ReferencePath,
    check_tuning,
    reference_path,
    sub_steps,
    uniform,
)
from tracking.track import ARMED, MANUAL
from tracking.trackers import saturated_control
from tracking.trackers.imm import ModelSet, improved_set, transitions
from tracking.vectored_switching import Rates, VectoredSwitching, law_is_met, unlimited, vectored_switching

DENSITIES = ("law_density", "straight_density", "manoeuvre_density")
DECELERATION = 0.5  # m/s2, of an aircraft that slows down, as of the improved set: a knot in a second


class Intent(NamedTuple):
    """Hypotheses and the place on the path that their common estimate has."""

    mixture: Mixture
    place: Any


@dataclass(frozen=True)
class IntentImm:
    """The assumed law at several intercept limits, other laws, and free flight with little and with much manoeuvre.

    Far from the path all that shows of a law is the course at which it intercepts, which the position limit sets (z_max
    of [Vasylyev 2003, eq. (4)], the bearing limit of eq. (5)). So the bank of laws varies that limit alone, and the
    model probabilities say which limit is flown, and whether any law is. The laws move as in `saturated_control` with
    the slope of the law in the covariance, so an aircraft that is flown on the estimate itself is a case for
    `saturated_control` with the control as known, not for this tracker.

    The alternative laws are those that the autopilot could be switched to: the beacon law where the assumed one is a
    route law. With them the tracker also says who is flying (`intents`): the assumed law, another one, or the crew by
    hand.

    Of a law this tracker needs two facts more than others do: ``intent``, what it is called, and ``intercept``, the
    names of its fields that set the course of a far intercept: the limit itself, then what has to grow with it.

    ``vectored``: the aircraft is led to its path by headings and speeds that a controller gives, as airliners are. Free
    flight is then that of the improved set of `imm`: straight, slowing down, a turn to either side at the bank limit.
    No chart tells the speed, so that every limit of the law is flown both at an even speed and slowing down. And two
    hypotheses, likewise, have the law armed: the heading is held until a softer law, with no limit on the intercept,
    turns the aircraft towards the course of the leg (`LawBank`).

    Model probabilities are in the order of `modes`. Modes are left at a rate of 1 / ``mean_stay`` for any other mode
    alike, whatever the time between steps. Under vectors a law is taken up where it is met, and rarely left there:
    `vectored_switching`.
    """

    law: Annotated[Any, "given"]
    route: Annotated[Any, "given"]  # a Line, or a route
    measurement: Annotated[MeasurementModel, "given"]
    alternative_laws: Annotated[tuple[Any, ...], "given"] = ()  # that the autopilot has too
    limit_factors: tuple[float, ...] = (0.4, 0.64, 1.0, 1.6, 2.4)
    mean_stay: Annotated[float, "s"] = 120.0
    law_density: Annotated[float, "m2/s3"] = 0.3  # docs/densities.md
    straight_density: Annotated[float, "m2/s3"] = 0.05
    manoeuvre_density: Annotated[float, "m2/s3"] = 3.0
    sub_step: Annotated[float, "s"] = SUB_STEP
    vectored: bool = False

    def __post_init__(self) -> None:
        if self.vectored and isinstance(self.route, Line):
            raise ValueError("vectored needs a route of legs: across one line there are no headings")
        if not self.limit_factors or not all(factor > 0.0 for factor in self.limit_factors):
            raise ValueError(f"limit_factors must be positive numbers, at least one, not {self.limit_factors}")
        if not self.law.intercept:
            raise ValueError(f"the {self.law.intent} names no limit in its 'intercept', so there is none to identify")
        if len(set(self._intents)) < len(self._intents):
            raise ValueError(f"every law needs an intent of its own, not {', '.join(self._intents)}")
        if not self.mean_stay > 0.0:
            raise ValueError(f"mean_stay must be positive, not {self.mean_stay} s")
        for name in DENSITIES:
            check_tuning(getattr(self, name), self.sub_step)

    @property
    def per_run(self) -> dict[str, str]:
        """Its densities; those of the improved set, which flies under vectors, are of one value."""
        return {} if self.vectored else {name: name for name in DENSITIES}

    @cached_property
    def _path(self) -> ReferencePath:
        return reference_path(replace(self.route, chart=None) if self.vectored else self.route, self.law)

    @property
    def _intents(self) -> tuple[str, ...]:
        """Of the assumed law and of the alternatives."""
        return (self.law.intent, *(law.intent for law in self.alternative_laws))

    @property
    def _laws(self) -> int:
        """How many hypotheses fly a law."""
        return len(self._factors) + len(self.alternative_laws)

    @property
    def _factors(self) -> tuple[float, ...]:
        """On the position limit, of each hypothesis of the assumed law."""
        return (*self.limit_factors * 2, math.inf, math.inf) if self.vectored else self.limit_factors

    @cached_property
    def _vectors(self) -> ModelSet:
        """Free flight under vectors."""
        bank = float(np.max(self.law.bank_limit))
        return improved_set(self.straight_density, self.manoeuvre_density, -DECELERATION, bank)

    @property
    def _free(self) -> tuple[str, ...]:
        """Names of the hypotheses of free flight."""
        return self._vectors.names if self.vectored else ("straight", "manoeuvre")

    @property
    def channels(self) -> tuple[str, ...]:
        return self._path.channels

    @property
    def modes(self) -> tuple[str, ...]:
        """Names of the hypotheses: the law by the factors on its limit, the alternatives, then free flight."""
        laws = tuple(f"law x {factor:g}" for factor in self.limit_factors)
        assumed = [f"{law}{how}" for one in (laws, ("law armed",)) for how in ("", ", slowing") for law in one]
        return (*(assumed if self.vectored else laws), *self._intents[1:], *self._free)

    @property
    def intents(self) -> tuple[str, ...]:
        """What each hypothesis says the aircraft follows: the intent of a law, ``armed`` or ``manual``."""
        assumed = tuple(ARMED if math.isinf(factor) else self._intents[0] for factor in self._factors)
        return (*assumed, *self._intents[1:], *(MANUAL,) * len(self._free))

    @property
    def limits(self) -> Any:
        """The position limits of the law, in the order of ``limit_factors``."""
        return getattr(self.law, self.law.intercept[0]) * np.array(self.limit_factors)

    def flown_limit(self, estimate: Mixture) -> Any:
        """The position limit that is flown (*B): geometric mean over the bank, given that a law is flown at all."""
        count = len(self.limit_factors)
        belief = estimate.weights[:count]
        if self.vectored:
            belief = belief + estimate.weights[count : 2 * count]
        return np.exp(np.einsum("m...,m->...", belief, np.log(self.limits)) / belief.sum(axis=0))

    def bank(self, batch: int) -> Law:
        """The laws as one, their axis before ``batch`` axes of runs.

        What has to grow with the position limit grows: a law whose rate term cannot balance its position term orbits.
        """
        others = len(self.alternative_laws)
        factors = lift(np.array((*self._factors, *(1.0,) * others)), 1, batch)
        limit, *growing = self.law.intercept
        limits = {limit: getattr(self.law, limit) * factors}
        limits |= {name: getattr(self.law, name) * np.maximum(factors, 1.0) for name in growing}
        laws: Law = replace(self.law, **limits)
        armed = (self._unlimited,) * 2 if self.vectored else ()
        return LawBank(laws, armed, self.alternative_laws, batch) if armed or others else laws

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
        weights, mean, cov = interact(state.mixture, self._switching(state, dt))
        laws = self._laws
        flown, place = self._fly(Mixture(weights[:laws], mean[:, :laws], cov[:, :, :laws]), state.place, dt)
        free = self._coast(Gaussian(mean[:, laws:], cov[:, :, laws:]), dt)
        means = np.concatenate([flown.mean, free.mean], axis=1)
        shape = np.broadcast_shapes(flown.cov.shape[3:], free.cov.shape[3:])
        covs = [np.broadcast_to(part.cov, (*part.cov.shape[:3], *shape)) for part in (flown, free)]
        return Intent(Mixture(weights, means, np.concatenate(covs, axis=2)), place)

    def _switching(self, state: Intent, dt: float) -> Any:
        """Switching probabilities (M, M) over dt, a semigroup; under vectors (M, M, *B), each run by where it is."""
        if not self.vectored:
            return _exponential(self._rates, dt)
        mean = np.einsum("m...,im...->i...", state.mixture.weights, state.mixture.mean)
        met = self._is_met(state.place, mean)
        return np.where(met, *(lift(_exponential(rates, dt), 2, met.ndim) for rates in self._vectored_rates))

    def switched(self, probabilities: Any, dt: Any, mean: Any) -> Any:
        """Model probabilities (k, M, *B) dt (s), a number or (k, 1, 1), later, before anything is measured.

        ``mean`` (k, n, *B) is the estimate that goes with them.
        """
        if np.ndim(dt) == 0:
            return self._switched(probabilities, float(dt), mean)
        after = np.empty_like(probabilities)
        for step in np.unique(dt):
            rows = np.ravel(dt) == step
            after[rows] = self._switched(probabilities[rows], float(step), mean[rows])
        return after

    def _switched(self, probabilities: Any, dt: float, mean: Any) -> Any:
        def later(rates: Rates) -> Any:
            return np.einsum("km...,mj->kj...", probabilities, _exponential(rates, dt))

        if not self.vectored:
            return later(self._rates)
        mean = np.moveaxis(mean, 1, 0)
        met = self._is_met(self._path.begin(mean), mean)
        return np.where(met[:, None], *map(later, self._vectored_rates))

    def _is_met(self, place: Any, mean: Any) -> Any:
        """(*B) bool: whether the mean (n, *B) is where the assumed law is met."""
        return law_is_met(self._unlimited, self._path, place, mean)

    @cached_property
    def _unlimited(self) -> Law:
        return unlimited(self.law)

    @cached_property
    def _rates(self) -> Rates:
        """Rates (M, M), 1/s, of the switching; rows are "from"."""
        rates = 1.0 / self.mean_stay * (1.0 - np.eye(len(self.modes))) / (len(self.modes) - 1.0)
        return tuple(map(tuple, rates - np.diag(rates.sum(axis=1))))

    @cached_property
    def _vectored_rates(self) -> VectoredSwitching:
        return vectored_switching(len(self.limit_factors), len(self.alternative_laws), self._vectors, self.mean_stay)

    def _fly(self, laws: Mixture, place: Any, dt: float) -> tuple[Gaussian, Any]:
        """Every law by itself, all from the place on the path that their common estimate has."""
        law = self.bank(laws.mean.ndim - 2)
        share = laws.weights / laws.weights.sum(axis=0)
        gaussian = Gaussian(laws.mean, laws.cov)
        count, step, rest = sub_steps(dt, self.sub_step)
        Q = lift(uniform(self._path.axes, step, self.law_density)[1], 2, laws.cov.ndim - 2)
        for _ in range(count):
            gaussian = saturated_control.with_slope(law, self._path, PathState(gaussian, place), step, Q)
            if self.vectored:
                self._slow_down(gaussian.mean, step)
            place = self._path.advance(place, np.einsum("m...,im...->i...", share, gaussian.mean), step)
        if rest:
            F, Q = uniform(self._path.axes, rest, self.law_density)
            gaussian = predict(gaussian, lift(F, 2, laws.cov.ndim - 2), lift(Q, 2, laws.cov.ndim - 2))
            place = self._path.advance(place, np.einsum("m...,im...->i...", share, gaussian.mean), rest)
        return gaussian, place

    def _slow_down(self, mean: Any, dt: float) -> None:
        """Take from the means (4, M, *B) of the slowing laws, in place, what dt of it takes from their speed."""
        count = len(self.limit_factors)
        for which in (slice(count, 2 * count), slice(2 * count + 1, 2 * count + 2)):
            slowing = mean[:, which]
            velocity = slowing[1::2]
            lost = np.minimum(DECELERATION * dt / np.maximum(np.hypot(*velocity), SLOWEST), 1.0) * velocity
            slowing[1::2] -= lost
            slowing[0::2] -= 0.5 * dt * lost

    def _coast(self, gaussian: Gaussian, dt: float) -> Gaussian:
        """Every hypothesis of free flight by itself."""
        if self.vectored:
            return predict(gaussian, *transitions(self._vectors.models, dt, gaussian.mean))
        batch = gaussian.cov.ndim - 2
        F = uniform(self._path.axes, dt, 0.0)[0]
        each = [
            lift(uniform(self._path.axes, dt, density)[1], 2, batch - 1)
            for density in (self.straight_density, self.manoeuvre_density)
        ]
        return predict(gaussian, lift(F, 2, batch), np.stack(np.broadcast_arrays(*each), axis=2))


@lru_cache(maxsize=256)
def _exponential(rates: Rates, dt: float) -> Any:
    """Probabilities (M, M) of the transitions over dt (s) of a chain with these rates (1/s)."""
    return expm(np.array(rates) * dt)
