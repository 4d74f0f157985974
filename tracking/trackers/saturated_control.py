"""The law with all its limits, evaluated outside the filter on the filter's own estimate."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import Annotated, Any

from tracking.gaussian import Innovation, predict
from tracking.measurement import MeasurementModel
from tracking.motion import GRAVITY
from tracking.reference_path import (
    SUB_STEP,
    Law,
    PathState,
    begin_on_path,
    channels_on_path,
    check_tuning,
    corrected,
    estimate_on_path,
    path_of,
    push,
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
    sub_step: Annotated[float, "s"] = SUB_STEP

    def __post_init__(self) -> None:
        check_tuning(self.acceleration_density, self.sub_step)

    def _driven(self, state: PathState, dt: float) -> PathState:
        mean, place = state.gaussian.mean, state.place
        count, step = sub_steps(dt, self.sub_step)
        for _ in range(count):
            acceleration = GRAVITY * self.law(self.path.deviation(place, mean))
            mean = push(self.path.normal(place), mean, acceleration, step)
            place = self.path.advance(place, mean, step)
        # uniform motion with isotropic noise looks the same from every leg: one covariance for all runs
        moved = predict(state.gaussian, *uniform(self.path.axes, dt, self.acceleration_density))
        return PathState(moved._replace(mean=mean), place)

    path, channels = cached_property(path_of), cached_property(channels_on_path)
    begin, estimate = begin_on_path, estimate_on_path

    def step(self, state: PathState, dt: float, z: Any | None, R: Any | None) -> tuple[PathState, Innovation | None]:
        if dt > 0.0:
            state = self._driven(state, dt)
        return corrected(self, state, z, R)
