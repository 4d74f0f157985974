"""The law with all its limits, evaluated outside the filter on the filter's own estimate."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import Annotated, Any

from tracking.gaussian import Gaussian, Innovation, predict, update
from tracking.measurement import MeasurementModel
from tracking.motion import GRAVITY
from tracking.reference_path import (
    Law,
    PathState,
    ReferencePath,
    check_tuning,
    push,
    reference_path,
    sub_steps,
    uniform,
)


@dataclass(frozen=True)
class SaturatedControl:
    """Kalman filter of the double integrator with ``U = law(estimate)`` as input [Vasylyev 2003, eqs. (4), (6), (9)].

    The control is held for ``sub_step``; one that is not below the scan period gives the zero-order hold over the whole
    scan, as published. On a route every leg is a line of its own, chosen by the estimate.

    The covariance treats the control as known, though the aircraft takes it from its own state: inside the limits it is
    pessimistic, in saturation exact.

    Erratum: (6) printed without a unit of u, used the bank in radians, because g times the bank is the acceleration.
    """

    law: Annotated[Law, "given"]
    route: Annotated[Any, "given"]  # a Line, or a route
    measurement: Annotated[MeasurementModel, "given"]
    acceleration_density: Annotated[float, "m2/s3"] = 0.1
    sub_step: Annotated[float, "s"] = 0.5

    def __post_init__(self) -> None:
        check_tuning(self.acceleration_density, self.sub_step)

    @cached_property
    def _path(self) -> ReferencePath:
        return reference_path(self.route, self.law)

    @property
    def channels(self) -> tuple[str, ...]:
        return self._path.channels

    def begin(self, prior: Gaussian) -> PathState:
        return PathState(prior, self._path.begin(prior.mean))

    def step(self, state: PathState, dt: float, z: Any | None, R: Any | None) -> tuple[PathState, Innovation | None]:
        if dt > 0.0:
            state = self._predict(state, dt)
        if z is None:
            return state, None
        gaussian, innovation = update(state.gaussian, *self.measurement.linearise(z, R, state.gaussian.mean))
        return PathState(gaussian, state.place), innovation

    def estimate(self, state: PathState) -> Gaussian:
        return state.gaussian

    def _predict(self, state: PathState, dt: float) -> PathState:
        mean, place = state.gaussian.mean, state.place
        count, step = sub_steps(dt, self.sub_step)
        for _ in range(count):
            acceleration = GRAVITY * self.law(self._path.deviation(place, mean))
            mean = push(self._path.normal(place), mean, acceleration, step)
            place = self._path.advance(place, mean, step)
        # uniform motion with isotropic noise looks the same from every leg: one covariance for all runs
        moved = predict(state.gaussian, *uniform(self._path.axes, dt, self.acceleration_density))
        return PathState(moved._replace(mean=mean), place)
