"""Kalman filter with Huber's loss on the measurement: the robust baseline that rejects nothing."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import Annotated, Any

import numpy as np

from tracking.gaussian import Gaussian, Innovation, lift, update
from tracking.measurement import Linear, MeasurementModel
from tracking.motion import Motion
from tracking.trackers.kalman import filtered, motion_of

TURNS = 20  # of the search for the far channels; two or three are usual


@dataclass(frozen=True)
class Huber:
    """Kalman filter whose update minimises ``(x - m)' P^-1 (x - m) + 2 sum rho(r_i / sigma_i)``, rho Huber's loss.

    A channel whose residual exceeds ``tuning`` of its standard deviations pulls with the constant force
    ``tuning / sigma``, which displaces the prediction, and says nothing more: which channels are far is found by
    Newton's method on the piecewise quadratic loss. The covariance is the inverse of its curvature, to which far
    channels add nothing. Where channels are correlated, sigma is that of each and the near ones keep their correlation.
    The motion is that of `tracking.trackers.kalman`.
    """

    measurement: Annotated[MeasurementModel, "given"]
    motion: Annotated[Motion | None, "given"] = None
    tuning: float = 1.345  # standard deviations; 95 % efficient on Gaussian noise
    acceleration_density: Annotated[float, "m2/s3"] = 10.0  # docs/densities.md

    def __post_init__(self) -> None:
        _ = self._motion  # a bad parameter is told when it is given
        if not self.tuning > 0.0:
            raise ValueError("tuning must be positive")

    _motion = cached_property(motion_of)

    @property
    def channels(self) -> tuple[str, ...]:
        return self._motion.channels

    def begin(self, prior: Gaussian) -> Gaussian:
        return prior

    def step(self, state: Gaussian, dt: float, z: Any | None, R: Any | None) -> tuple[Gaussian, Innovation | None]:
        return filtered(self._motion, self.measurement, self._robust, state, dt, z, R)

    def estimate(self, state: Gaussian) -> Gaussian:
        return state

    def _robust(self, state: Gaussian, linear: Linear) -> tuple[Gaussian, Innovation]:
        posterior, innovation = update(state, *linear)
        batch = posterior.mean.ndim - 1
        H, P = lift(linear.H, 2, batch), lift(state.cov, 2, batch)
        sigma = np.sqrt(np.einsum("ii...->i...", lift(linear.R, 2, batch)))
        far = np.zeros(np.shape(linear.z))  # the side on which a channel is far, or 0
        for _ in range(TURNS):
            residual = (linear.z - np.einsum("ij...,j...->i...", H, posterior.mean)) / sigma
            now = np.where(np.abs(residual) > self.tuning, np.sign(residual), 0.0)  # absent ones are near
            if np.array_equal(now, far):
                break
            far = now
            force = np.where(far, far * self.tuning / sigma, 0.0)  # what is absent has no sigma, and no force
            pull = np.einsum("ij...,kj...,k...->i...", P, H, force)
            posterior, _ = update(Gaussian(state.mean + pull, P), np.where(far, np.nan, linear.z), H, linear.R)
        return posterior, innovation
