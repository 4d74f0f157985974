"""The baseline that everybody knows: filterpy's constant-velocity Kalman filter, entering through the adapter."""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache
from typing import Annotated, Any

from tracking.gaussian import Gaussian, Innovation, predict, update
from tracking.measurement import MeasurementModel
from tracking.motion import CARTESIAN, Transition
from tracking.trackers.kalman import Kalman


@dataclass(frozen=True)
class FilterpyConstantVelocity:
    """Matrices by filterpy, designed anew for each period; arithmetic by this package."""

    measurement: Annotated[MeasurementModel, "given"]
    acceleration_density: Annotated[float, "m2/s3"] = 0.3
    channels = CARTESIAN

    def __post_init__(self) -> None:
        if not self.acceleration_density >= 0.0:
            raise ValueError("acceleration_density must not be negative")

    def begin(self, prior: Gaussian) -> Gaussian:
        return prior

    def step(self, state: Gaussian, dt: float, z: Any | None, R: Any | None) -> tuple[Gaussian, Innovation | None]:
        if dt > 0.0:
            state = predict(state, *designed(dt, self.acceleration_density))
        if z is None:
            return state, None
        return update(state, *self.measurement.linearise(z, R, state.mean))

    def estimate(self, state: Gaussian) -> Gaussian:
        return state


@lru_cache(maxsize=256)
def designed(dt: float, acceleration_density: float) -> Transition:
    """F and Q of filterpy's own design for one period."""
    import numpy as np
    from filterpy.common import Q_continuous_white_noise  # type: ignore[import-untyped]
    from filterpy.kalman import KalmanFilter  # type: ignore[import-untyped]

    from tracking.filterpy_adapter import from_filterpy

    filter_ = KalmanFilter(dim_x=4, dim_z=2)
    filter_.F = np.kron(np.eye(2), [[1.0, dt], [0.0, 1.0]])
    filter_.Q = Q_continuous_white_noise(dim=2, dt=dt, spectral_density=acceleration_density, block_size=2)
    filter_.H = np.array([[1.0, 0.0, 0.0, 0.0], [0.0, 0.0, 1.0, 0.0]])
    tracker = from_filterpy(filter_)
    assert isinstance(tracker, Kalman)
    return tracker.motion.transition(dt, None)
