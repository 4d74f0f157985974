"""The alpha-beta tracker: all that a kind of tracker needs to say.

As ``alpha_beta.py`` in ``tracking/trackers``, or as ``--plugin alpha_beta.py``, a scenario may say

    [trackers.simple]
    kind = "alpha_beta"
    alpha = 0.4
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Annotated, Any

import numpy as np

from tracking.gaussian import Gaussian, Innovation, lift, predict, update
from tracking.measurement import MeasurementModel
from tracking.motion import ConstantVelocity


@dataclass(frozen=True)
class AlphaBeta:
    """Straight flight, corrected by fixed shares of each residual: alpha of it in position, beta / period in rate."""

    measurement: Annotated[MeasurementModel, "given"]  # how plots become z = H x + v: filled by the simulation
    alpha: float = 0.4
    beta: float = 0.1
    period: Annotated[float, "s"] = 1.0  # of the radar
    acceleration_density: Annotated[float, "m2/s3"] = 0.3
    channels = ("north", "north_rate", "east", "east_rate")

    def __post_init__(self) -> None:
        if not (0.0 < self.alpha <= 1.0 and self.beta >= 0.0 and self.period > 0.0):
            raise ValueError("alpha must lie above 0 and not above 1, beta not be negative, period be above 0")

    def begin(self, prior: Gaussian) -> Gaussian:
        return prior

    def step(self, state: Gaussian, dt: float, z: Any | None, R: Any | None) -> tuple[Gaussian, Innovation | None]:
        state = predict(state, *ConstantVelocity(self.acceleration_density).transition(dt, None))
        if z is None:
            return state, None
        linear = self.measurement.linearise(z, R, state.mean)
        _, innovation = update(state, *linear)  # for the statistics alone
        present = np.isfinite(linear.z)  # (rows, runs)
        H, P, R = (lift(matrix, 2, present.ndim - 1) for matrix in (linear.H, state.cov, linear.R))
        gain = np.kron(np.eye(2), [[self.alpha, 0.0], [self.beta / self.period, 0.0]])
        K = np.where(present, np.einsum("ij,kj...->ik...", gain, H), 0.0)
        residual = np.where(present, linear.z - np.einsum("ij...,j...->i...", H, state.mean), 0.0)
        mean = state.mean + np.einsum("ij...,j...->i...", K, residual)
        kept = lift(np.eye(4), 2, present.ndim - 1) - np.einsum("ij...,jk...->ik...", K, H)
        noise = np.einsum("ij...,jk...,lk...->il...", K, np.where(present & present[:, None], R, 0.0), K)
        return Gaussian(mean, np.einsum("ij...,jk...,lk...->il...", kept, P, kept) + noise), innovation

    def estimate(self, state: Gaussian) -> Gaussian:
        return state


SHORTFINAL = {"trackers": {"alpha_beta": AlphaBeta}}  # what this file brings, where it stays outside
