"""Kalman filter with an innovation gate: the common baseline against outliers."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import Annotated, Any

import numpy as np

from tracking.gaussian import Gaussian, Innovation, update
from tracking.intervals import chi_square
from tracking.measurement import Linear, MeasurementModel
from tracking.motion import Motion
from tracking.trackers.kalman import filtered, motion_of


@dataclass(frozen=True)
class Gated:
    """Kalman filter that ignores a measurement whose NIS is too large for its number of channels.

    A tracker that has lost its target stays lost: it then rejects the truth as well, and says so by its NIS.
    The motion is that of `tracking.trackers.kalman`.
    """

    measurement: Annotated[MeasurementModel, "given"]
    motion: Annotated[Motion | None, "given"] = None
    gate_probability: float = 0.9973  # of passing when the model is right: three standard deviations of one channel
    acceleration_density: Annotated[float, "m2/s3"] = 30.0  # docs/densities.md

    def __post_init__(self) -> None:
        _ = self._motion  # a bad parameter is told when it is given
        if not 0.0 < self.gate_probability < 1.0:
            raise ValueError("gate_probability must lie between 0 and 1")

    @cached_property
    def _limits(self) -> Any:
        """Largest NIS by the number of channels present."""
        rows = self.measurement.rows
        return np.array([0.0, *(chi_square(self.gate_probability, degrees) for degrees in range(1, rows + 1))])

    _motion = cached_property(motion_of)

    @property
    def channels(self) -> tuple[str, ...]:
        return self._motion.channels

    def begin(self, prior: Gaussian) -> Gaussian:
        return prior

    def step(self, state: Gaussian, dt: float, z: Any | None, R: Any | None) -> tuple[Gaussian, Innovation | None]:
        return filtered(self._motion, self.measurement, self._gate, state, dt, z, R)

    def estimate(self, state: Gaussian) -> Gaussian:
        return state

    def _gate(self, state: Gaussian, linear: Linear) -> tuple[Gaussian, Innovation]:
        posterior, innovation = update(state, *linear)
        accepted = innovation.nis <= self._limits[np.isfinite(innovation.white).sum(axis=0)]
        if np.all(accepted):
            return posterior, innovation
        return Gaussian(*(np.where(accepted, *pair) for pair in zip(posterior, state, strict=True))), innovation
