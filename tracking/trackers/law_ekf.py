"""The extended Kalman filter that knows the law: the slope of the limited law is part of its covariance."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import Annotated, Any

from tracking.gaussian import Gaussian, Innovation, predict, update
from tracking.measurement import MeasurementModel
from tracking.motion import GRAVITY, constant_velocity
from tracking.reference_path import (
    Law,
    PathState,
    ReferencePath,
    check_tuning,
    embed,
    folded,
    push,
    reference_path,
    steering,
    sub_steps,
    uniform,
)


@dataclass(frozen=True)
class LawEkf:
    """Mean as in `saturated_control`, covariance through ``F + g B dlaw/dx`` in the same sub-steps.

    Inside the limits it is the closed loop of `linear_feedback`, in saturation the open one of `saturated_control`.
    It is right only while the aircraft is flown on its own state: where it is flown on this estimate, the error obeys
    the open loop and the covariance is far too small.
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
            count, step = sub_steps(dt, self.sub_step)
            _, Q = uniform(self._path.axes, step, self.acceleration_density)
            for _ in range(count):
                gaussian = advance(self.law, self._path, state, step, Q)
                state = PathState(gaussian, self._path.advance(state.place, gaussian.mean, step))
        if z is None:
            return state, None
        gaussian, innovation = update(state.gaussian, *self.measurement.linearise(z, R, state.gaussian.mean))
        return PathState(gaussian, state.place), innovation

    def estimate(self, state: PathState) -> Gaussian:
        return state.gaussian


def advance(law: Law, path: ReferencePath, state: PathState, dt: float, Q: Any) -> Gaussian:
    """Estimate after one sub-step with the control held, and the covariance that belongs to it."""
    mean = state.gaussian.mean
    control = steering(law, path, state.place, mean)
    normal = path.normal(state.place)
    F = embed(normal, folded(control, dt), constant_velocity(dt, 0.0)[0])
    return predict(state.gaussian, F, Q)._replace(mean=push(normal, mean, GRAVITY * control.bank, dt))
