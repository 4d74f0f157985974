"""The extended Kalman filter that knows the law: the slope of the limited law is part of its covariance."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import Annotated, Any

from tracking.gaussian import Gaussian, Innovation, predict
from tracking.measurement import MeasurementModel
from tracking.motion import GRAVITY, constant_velocity
from tracking.reference_path import (
    SUB_STEP,
    Law,
    PathState,
    ReferencePath,
    ahead_in_sub_steps,
    begin_on_path,
    channels_on_path,
    check_tuning,
    corrected,
    embed,
    estimate_on_path,
    folded,
    path_of,
    push,
    steering,
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
    sub_step: Annotated[float, "s"] = SUB_STEP

    def __post_init__(self) -> None:
        check_tuning(self.acceleration_density, self.sub_step)

    path, channels = cached_property(path_of), cached_property(channels_on_path)
    begin, estimate = begin_on_path, estimate_on_path

    def step(self, state: PathState, dt: float, z: Any | None, R: Any | None) -> tuple[PathState, Innovation | None]:
        if dt > 0.0:
            state = ahead_in_sub_steps(advance, self, state, dt)
        return corrected(self, state, z, R)


def advance(law: Law, path: ReferencePath, state: PathState, dt: float, Q: Any) -> Gaussian:
    """Estimate after one sub-step with the control held, and the covariance that belongs to it."""
    mean = state.gaussian.mean
    control = steering(law, path, state.place, mean)
    normal = path.normal(state.place)
    F = embed(normal, folded(control, dt), constant_velocity(dt, 0.0)[0])
    return predict(state.gaussian, F, Q)._replace(mean=push(normal, mean, GRAVITY * control.bank, dt))
