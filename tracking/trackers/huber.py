"""Kalman filter with Huber's loss on the measurement: the robust baseline that rejects nothing."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Annotated, Any

import numpy as np

from tracking.gaussian import Gaussian, Innovation, lift, predict, update
from tracking.measurement import Linear, MeasurementModel
from tracking.motion import ConstantVelocity, Motion

STRAIGHT = ConstantVelocity()
CONVERGED = 1e-10  # relative change of a weight
ITERATIONS = 100


@dataclass(frozen=True)
class Huber:
    """Kalman filter whose update minimises ``(x - m)' P^-1 (x - m) + 2 sum rho(r_i / sigma_i)``, rho Huber's loss.

    Solved by iterated reweighting: a channel whose residual exceeds ``tuning`` of its standard deviations counts with
    the variance ``sigma^2 |r| / (tuning sigma)``, so that its pull no longer grows. Where channels are correlated,
    their correlation is kept. The covariance is that of the weighted measurement, which is too small while outliers
    are frequent.
    """

    measurement: Annotated[MeasurementModel, "given"]
    motion: Annotated[Motion, "given"] = STRAIGHT
    tuning: float = 1.345  # standard deviations; 95 % efficient on Gaussian noise

    def __post_init__(self) -> None:
        if not self.tuning > 0.0:
            raise ValueError("tuning must be positive")

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
        linear = self.measurement.linearise(z, R, state.mean)
        posterior, innovation = update(state, *linear)
        weight, R = np.ones(np.shape(linear.z)), lift(linear.R, 2, np.ndim(linear.z) - 1)
        for _ in range(ITERATIONS):
            better = self._weights(linear, posterior.mean)
            moving = np.any(np.abs(better - weight) > CONVERGED * weight, axis=0)  # each run ends by itself
            if not np.any(moving):
                break
            weight = np.where(moving, better, weight)
            spread = 1.0 / np.sqrt(weight)
            posterior, _ = update(state, linear.z, linear.H, R * spread[:, None] * spread)
        return posterior, innovation

    def estimate(self, state: Gaussian) -> Gaussian:
        return state

    def _weights(self, linear: Linear, mean: Any) -> Any:
        """Weights (m, *B) of the channels at an estimate; absent ones count 1, which says nothing."""
        batch = mean.ndim - 1
        residual = linear.z - np.einsum("ij...,j...->i...", lift(linear.H, 2, batch), mean)
        sigma = np.sqrt(np.einsum("ii...->i...", lift(linear.R, 2, batch)))
        size = np.abs(np.nan_to_num(residual, nan=0.0)) / sigma
        return self.tuning / np.maximum(size, self.tuning)
