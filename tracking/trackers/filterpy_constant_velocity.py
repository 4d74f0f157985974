"""The baseline that everybody knows: filterpy's constant-velocity Kalman filter, entering through the adapter."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Annotated, Any

from tracking.filterpy_adapter import constant_velocity
from tracking.gaussian import Gaussian, Innovation, predict, update
from tracking.measurement import MeasurementModel
from tracking.motion import CARTESIAN


@dataclass(frozen=True)
class FilterpyConstantVelocity:
    """Matrices by filterpy, designed anew for each period; arithmetic by this package."""

    measurement: Annotated[MeasurementModel, "given"]
    acceleration_density: Annotated[float, "m2/s3"] = 10.0  # docs/densities.md
    channels = CARTESIAN

    def __post_init__(self) -> None:
        if not self.acceleration_density >= 0.0:
            raise ValueError("acceleration_density must not be negative")

    def begin(self, prior: Gaussian) -> Gaussian:
        return prior

    def step(self, state: Gaussian, dt: float, z: Any | None, R: Any | None) -> tuple[Gaussian, Innovation | None]:
        if dt > 0.0:
            state = predict(state, *constant_velocity(dt, self.acceleration_density).transition(dt, state.mean))
        if z is None:
            return state, None
        return update(state, *self.measurement.linearise(z, R, state.mean))

    def estimate(self, state: Gaussian) -> Gaussian:
        return state
