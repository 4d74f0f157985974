"""Who is flying, and by which law: interacting multiple models over control laws and free flight."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from functools import cached_property, lru_cache
from typing import Annotated, Any, NamedTuple

import numpy as np
from scipy.linalg import expm

from tracking.gaussian import Gaussian, Innovation, Mixture, interact, lift, predict, update_mixture
from tracking.measurement import MeasurementModel
from tracking.motion import constant_velocity
from tracking.reference_path import (
    SLOWEST,
    SUB_STEP,
    Law,
    Line,
    PathState,
    ReferencePath,
    check_tuning,
    embed,
    reference_path,
    sub_steps,
    uniform,
)
from tracking.trackers import saturated_control
from tracking.trackers.imm import ModelSet, improved_set, transitions

MANUAL = "manual"  # the intent of free flight
MANOEUVRE_STAY = 30.0  # s, of a turn or a change of speed under vectors: a turn onto final lasts 29 s in the median
LARGEST_INTERCEPT = math.radians(120.0)  # an aircraft that flies away from the end of its leg has no law armed


class Intent(NamedTuple):
    """Hypotheses and the place on the path that their common estimate has."""

    mixture: Mixture
    place: Any


class Bank(NamedTuple):
    """The assumed law with its limits over an axis of hypotheses; behind them it is armed, then come other laws."""

    assumed: Law
    armed: bool  # whether it is
    others: tuple[Law, ...]
    batch: int  # axes of runs behind that of the hypotheses

    @property
    def bank_limit(self) -> Any:
        """rad."""
        return self.assumed.bank_limit

    def __call__(self, deviation: Any) -> Any:
        """Bank, rad, of every hypothesis."""
        banks = self.assumed(deviation)
        first = banks.shape[-1 - self.batch] - len(self.others)
        if self.armed:
            which, own = self._one(first - 1, deviation)
            error = own.track_error
            engages = (banks[which] * error < 0.0) & (np.abs(error) < LARGEST_INTERCEPT)
            banks[which] = np.where(engages, banks[which], 0.0)
        for number, law in enumerate(self.others, first):
            which, own = self._one(number, deviation)
            banks[which] = law(own)
        return banks

    def _one(self, number: int, deviation: Any) -> tuple[Any, Any]:
        """Where the banks of one hypothesis are, and its deviation."""
        one = slice(number, number + 1)
        return (..., one, *(slice(None),) * self.batch), deviation.of_hypotheses(one, self.batch)


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

    ``vectored``: the aircraft is flown to the path by headings and speeds that a controller gives, as airliners are.
    Free flight is then that of the improved set of `imm`: straight, slowing down, a turn to either side at the bank
    limit. One more hypothesis has the law armed: the heading is held until the law, without its limits on the intercept,
    turns the aircraft towards the course of the leg; then it flies that. And the law steers across its path alone: along
    it the speed changes by orders that no law gives, with the density of a manoeuvre.

    Model probabilities are in the order of `modes`. Modes are left at a rate of 1 / ``mean_stay`` for any other mode
    alike, whatever the time between steps; manoeuvres under vectors, which last for less, at 1 / `MANOEUVRE_STAY`.
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
        for density in (self.law_density, self.straight_density, self.manoeuvre_density):
            check_tuning(density, self.sub_step)

    @cached_property
    def _path(self) -> ReferencePath:
        return reference_path(self.route, self.law)

    @property
    def _intents(self) -> tuple[str, ...]:
        """Of the assumed law and of the alternatives."""
        return (self.law.intent, *(law.intent for law in self.alternative_laws))

    @property
    def _laws(self) -> int:
        """How many hypotheses fly a law."""
        return len(self.limit_factors) + self.vectored + len(self.alternative_laws)

    @cached_property
    def _vectors(self) -> ModelSet:
        """Free flight under vectors."""
        bank = float(np.max(self.law.bank_limit))
        return improved_set(self.straight_density, self.manoeuvre_density, bank=bank)

    @property
    def _free(self) -> tuple[str, ...]:
        """Names of the hypotheses of free flight."""
        return self._vectors.names if self.vectored else ("straight", "manoeuvre")

    @property
    def channels(self) -> tuple[str, ...]:
        return self._path.channels

    @property
    def modes(self) -> tuple[str, ...]:
        """Names of the hypotheses: the law by the factors on its limit, armed, the alternatives, then free flight."""
        laws = (f"law x {factor:g}" for factor in self.limit_factors)
        return (*laws, *("armed",) * self.vectored, *self._intents[1:], *self._free)

    @property
    def intents(self) -> tuple[str, ...]:
        """What each hypothesis says the aircraft follows: the intent of a law, or ``manual``, as while one is armed."""
        assumed = (self._intents[0],) * len(self.limit_factors)
        return (*assumed, *(MANUAL,) * self.vectored, *self._intents[1:], *(MANUAL,) * len(self._free))

    @property
    def limits(self) -> Any:
        """The position limit of each law of the bank, in the order of `modes`."""
        return getattr(self.law, self.law.intercept[0]) * np.array(self.limit_factors)

    def flown_limit(self, estimate: Mixture) -> Any:
        """The position limit that is flown (*B): geometric mean over the bank, given that a law is flown at all."""
        belief = estimate.weights[: len(self.limit_factors)]
        return np.exp(np.einsum("m...,m->...", belief, np.log(self.limits)) / belief.sum(axis=0))

    def bank(self, batch: int) -> Law:
        """The laws as one, their axis before ``batch`` axes of runs.

        What has to grow with the position limit grows: a law whose rate term cannot balance its position term orbits.
        """
        others = len(self.alternative_laws)
        factors = lift(np.array((*self.limit_factors, *(math.inf,) * self.vectored, *(1.0,) * others)), 1, batch)
        limit, *growing = self.law.intercept
        limits = {limit: getattr(self.law, limit) * factors}
        limits |= {name: getattr(self.law, name) * np.maximum(factors, 1.0) for name in growing}
        laws: Law = replace(self.law, **limits)
        return Bank(laws, self.vectored, self.alternative_laws, batch) if self.vectored or others else laws

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
        """Model probabilities (k, M, *B) dt (s), a number or (k, 1, 1), later, before anything is measured."""
        if np.ndim(dt) == 0:
            return np.einsum("km...,mj->kj...", probabilities, self._switching(float(dt)))
        after = np.empty_like(probabilities)
        for step in np.unique(dt):
            rows = np.ravel(dt) == step
            after[rows] = self.switched(probabilities[rows], step)
        return after

    def _switching(self, dt: float) -> Any:
        """Switching probabilities over dt, a semigroup; rows are "from"."""
        return _exponential(self._rates, dt)

    @cached_property
    def _rates(self) -> tuple[tuple[float, ...], ...]:
        """Rates (M, M), 1/s, of the switching, rows "from": a mode is left for any other alike.

        But no law is left for being armed: an autopilot that has captured its path does not wait for it again.
        """
        count, bank = len(self.modes), len(self.limit_factors)
        leave = np.full(count, 1.0 / self.mean_stay)
        into = 1.0 - np.eye(count)
        if self.vectored:
            leave[1 - len(self._free) :] = 1.0 / MANOEUVRE_STAY
            into[: self._laws, bank] = 0.0
        rates = leave[:, None] * into / into.sum(axis=1, keepdims=True)
        return tuple(map(tuple, rates - np.diag(rates.sum(axis=1))))

    def _fly(self, laws: Mixture, place: Any, dt: float) -> tuple[Gaussian, Any]:
        """Every law by itself, all from the place on the path that their common estimate has."""
        law = self.bank(laws.mean.ndim - 2)
        share = laws.weights / laws.weights.sum(axis=0)
        gaussian = Gaussian(laws.mean, laws.cov)
        count, step, rest = sub_steps(dt, self.sub_step)
        Q = lift(uniform(self._path.axes, step, self.law_density)[1], 2, laws.cov.ndim - 2)
        if self.vectored:
            Q = self._unsteady(laws.mean, step)
        for _ in range(count):
            gaussian = saturated_control.with_slope(law, self._path, PathState(gaussian, place), step, Q)
            place = self._path.advance(place, np.einsum("m...,im...->i...", share, gaussian.mean), step)
        if rest:
            F, Q = uniform(self._path.axes, rest, self.law_density)
            gaussian = predict(gaussian, lift(F, 2, laws.cov.ndim - 2), lift(Q, 2, laws.cov.ndim - 2))
            place = self._path.advance(place, np.einsum("m...,im...->i...", share, gaussian.mean), rest)
        return gaussian, place

    def _unsteady(self, mean: Any, dt: float) -> Any:
        """Q (4, 4, *B) of a law over dt where nobody holds the speed: more of it along the velocity than across."""
        velocity = mean[1::2]
        course = velocity / np.maximum(np.hypot(*velocity), SLOWEST)
        along, across = (constant_velocity(dt, density)[1] for density in (self.manoeuvre_density, self.law_density))
        return embed(course, along, across)

    def _coast(self, gaussian: Gaussian, dt: float) -> Gaussian:
        """Every hypothesis of free flight by itself."""
        if self.vectored:
            return predict(gaussian, *transitions(self._vectors.models, dt, gaussian.mean))
        calm, F = uniform(self._path.axes, dt, self.straight_density)[::-1]
        wild = uniform(self._path.axes, dt, self.manoeuvre_density)[1]
        batch = gaussian.cov.ndim - 2
        return predict(gaussian, lift(F, 2, batch), lift(np.stack([calm, wild], axis=-1), 3, batch - 1))


@lru_cache(maxsize=256)
def _exponential(rates: tuple[tuple[float, ...], ...], dt: float) -> Any:
    """Probabilities (M, M) of the transitions over dt (s) of a chain with these rates (1/s)."""
    return expm(np.array(rates) * dt)
