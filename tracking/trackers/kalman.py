"""Kalman filter of any linear motion: the single-model reference of every comparison."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Annotated, Any

from tracking.gaussian import Gaussian, Innovation, predict, update
from tracking.measurement import MeasurementModel
from tracking.motion import ConstantVelocity, Motion

STRAIGHT = ConstantVelocity()


@dataclass(frozen=True)
class Kalman:
    """Predict with one motion model, update with one measurement model [Volovyk 2022, eqs. (15)-(18)].

    Erratum: (15) printed without the estimate's hats and (17) with the covariance of k-1 given k, used the prediction
    of k given k-1, because the gain weighs the prediction against the measurement.
    """

    measurement: Annotated[MeasurementModel, "given"]
    motion: Annotated[Motion, "given"] = STRAIGHT

    @property
    def channels(self) -> tuple[str, ...]:
        return self.motion.channels

    def begin(self, prior: Gaussian) -> Gaussian:
        return prior

    def step(self, state: Gaussian, dt: float, z: Any | None, R: Any | None) -> tuple[Gaussian, Innovation | None]:
        if dt > 0.0:
            state = predict(state, *self.motion.transition(dt, state.mean))
        if z is None:
            return state, None
        return update(state, *self.measurement.linearise(z, R, state.mean))

    def estimate(self, state: Gaussian) -> Gaussian:
        return state
