"""The law with all its limits, evaluated outside the filter on the filter's own estimate."""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import cached_property
from typing import Annotated, Any, ClassVar, Literal, NamedTuple

import numpy as np

from tracking.gaussian import Gaussian, Innovation, predict
from tracking.measurement import MeasurementModel
from tracking.reference_path import (
    SUB_STEP,
    Law,
    PathState,
    ReferencePath,
    ahead_in_sub_steps,
    begin_on_path,
    channels_on_path,
    check_tuning,
    coasted,
    corrected,
    path_of,
    steering,
    sub_steps,
    uniform,
)
from tracking.tree import choose

DENSITIES = {"paper": 0.03, "jacobian": 0.3}  # m2/s3, by the covariance: the choices of docs/densities.md
FREE_DENSITY = 10.0  # m2/s3, of the straight flight that a law is set against: the choice for `kalman`
ENGAGED = 30.0  # times likelier than what is believed a rival has to make the looks before it is believed itself


class Awaited(NamedTuple):
    """The estimate under the law and the one in free flight; what is not believed is the rival of what is."""

    law: PathState
    free: PathState
    evidence: Any  # (*B) logarithm of the likelihood ratio for the rival since it started, never below zero
    engaged: Any  # (*B) bool: whether the law is believed


@dataclass(frozen=True)
class SaturatedControl:
    """Kalman filter of the double integrator with ``U = law(estimate)`` as input [Vasylyev 2003, eqs. (4), (6), (9)].

    The control is held for ``sub_step``; one that is not below the scan period gives the zero-order hold over the whole
    scan, as published.

    On a line U is ``g bank`` across it. On a route the state has two axes, F, Q and the gain of (9) hold on both, and U
    is a vector: ``g tan(bank)`` at right angles to the estimated velocity through the air, whose motion over the ground
    the route tells, with the deviations from the leg that the estimate is on. So the control turns the velocity. An
    acceleration across the new leg alone would not: at a course error of 90 deg, where (6) is void, it stops the motion
    along the old leg instead of turning it. For small course errors both are (6). The autopilot holds a speed as well:
    where the route has a chart with speeds, the estimated one comes to it.

    ``covariance`` says what the control is to the filter. ``paper``: an input, which it truly is where the aircraft is
    flown on this very estimate; where the aircraft takes it from its own state, that is pessimistic inside the limits
    and exact in saturation. ``jacobian``: a function of the state, whose slope belongs into F where the aircraft flies
    on its own; that is sharper, leaves less room for a mismatched law, and is far too sure of itself where the aircraft
    is flown on this estimate.

    ``begins`` says when the law acts. ``at once``: from the first look on. ``engaged``: the law is waited for, as an
    aircraft needs that is led to its path by headings. Straight flight with `FREE_DENSITY` is believed first, and the
    law is its rival, which starts from the estimate of free flight anew as long as no look speaks for it. Once the
    looks since then are `ENGAGED` times likelier by the law, the law is believed, and free flight becomes its rival: an
    aircraft that leaves the law is followed by the same rule, Page's test to either side.

    Erratum: (6) printed without a unit of u, used the bank in radians, because g times the bank is the acceleration.
    """

    law: Annotated[Law, "given"]
    route: Annotated[Any, "given"]  # a Line, or a route
    measurement: Annotated[MeasurementModel, "given"]
    acceleration_density: Annotated[float | None, "m2/s3"] = None  # that of DENSITIES
    sub_step: Annotated[float, "s"] = SUB_STEP
    covariance: Literal["paper", "jacobian"] = "paper"
    begins: Literal["at once", "engaged"] = "at once"
    per_run: ClassVar[dict[str, str]] = {"acceleration_density": "density"}

    def __post_init__(self) -> None:
        if self.covariance not in DENSITIES:
            raise ValueError(f"covariance is 'paper' or 'jacobian', not '{self.covariance}'")
        if self.begins not in ("at once", "engaged"):
            raise ValueError(f"begins is 'at once' or 'engaged', not '{self.begins}'")
        check_tuning(self.density, self.sub_step)

    @property
    def density(self) -> float:
        """m2/s3, of the acceleration: the given one, or the best for the covariance."""
        return DENSITIES[self.covariance] if self.acceleration_density is None else self.acceleration_density

    def _driven(self, state: PathState, dt: float) -> PathState:
        mean, place = state.gaussian.mean, state.place
        count, step, rest = sub_steps(dt, self.sub_step)
        for _ in range(count):
            bank = self.law(self.path.deviation(place, mean))
            mean = self.path.steered(place, mean, bank, step)
            place = self.path.advance(place, mean, step)
        if rest:
            mean = uniform(self.path.axes, rest, 0.0)[0] @ mean
            place = self.path.advance(place, mean, rest)
        # uniform motion with isotropic noise looks the same from every leg: one covariance for all runs
        moved = predict(state.gaussian, *uniform(self.path.axes, dt, self.density))
        return PathState(moved._replace(mean=mean), place)

    path, channels = cached_property(path_of), cached_property(channels_on_path)

    def begin(self, prior: Gaussian) -> PathState | Awaited:
        state = begin_on_path(self, prior)
        if self.begins == "at once":
            return state
        runs = prior.mean.shape[1:]
        return Awaited(state, state, np.zeros(runs), np.zeros(runs, dtype=bool))

    def estimate(self, state: PathState | Awaited) -> Gaussian:
        if isinstance(state, PathState):
            return state.gaussian
        believed: Gaussian = choose(state.engaged, state.law.gaussian, state.free.gaussian)
        return believed

    def step(self, state: Any, dt: float, z: Any | None, R: Any | None) -> tuple[Any, Innovation | None]:
        if isinstance(state, PathState):
            return corrected(self, self._moved(state, dt) if dt > 0.0 else state, z, R)
        if dt > 0.0:
            free = coasted(self.path, state.free, dt, FREE_DENSITY)
            state = state._replace(law=self._moved(state.law, dt), free=free)
        return (state, None) if z is None else self._weighed(state, z, R)

    def _moved(self, state: PathState, dt: float) -> PathState:
        slope = self.covariance == "jacobian"
        return ahead_in_sub_steps(with_slope, self, state, dt, self.density) if slope else self._driven(state, dt)

    def _weighed(self, state: Awaited, z: Any, R: Any) -> tuple[Awaited, Innovation | None]:
        """Both estimates updated, and which of them is believed from now on."""
        (law, by_law), (free, by_free) = (corrected(self, one, z, R) for one in (state.law, state.free))
        if by_law is None or by_free is None:
            return state, None
        innovation: Innovation = choose(state.engaged, by_law, by_free)
        change = by_law.log_likelihood - by_free.log_likelihood
        evidence = np.maximum(state.evidence + np.where(state.engaged, -change, change), 0.0)
        changes = evidence > math.log(ENGAGED)
        engaged, evidence = state.engaged ^ changes, np.where(changes, 0.0, evidence)
        anew = evidence == 0.0  # the rival starts from what is believed
        law, free = choose(anew & ~engaged, free, law), choose(anew & engaged, law, free)
        return Awaited(law, free, evidence, engaged), innovation


def with_slope(law: Law, path: ReferencePath, state: PathState, dt: float, Q: Any) -> Gaussian:
    """Estimate after one sub-step with the bank held; the bank is a function of the state, whose slope F carries."""
    mean, place = state.gaussian.mean, state.place
    moved, F = path.steered_with_slope(place, mean, steering(law, path, place, mean), dt)
    return predict(state.gaussian, F, Q)._replace(mean=moved)
