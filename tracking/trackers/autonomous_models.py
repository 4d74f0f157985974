"""Autonomous multiple models, the first generation: filters side by side that never learn from each other."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import Annotated, Any

import numpy as np

from tracking.gaussian import Gaussian, Innovation, Mixture, predict, update_mixture
from tracking.measurement import MeasurementModel
from tracking.packed import unpack
from tracking.trackers.imm import InteractingMultipleModel, ModelSet, published_set, transitions


@dataclass(frozen=True)
class AutonomousModels:
    """One filter for each model, weighted by Bayes' rule over the whole record [Volovyk 2022, introduction].

    The models are taken for constant in time: their filters are never mixed, only their estimates are. With
    ``least_weight = 0`` this is exact for an aircraft that never changes its motion, and blind to one that does, since
    a model that was wrong for long enough has no weight left. The usual remedy is a floor: no weight is lower than
    ``least_weight`` after a measurement, and the others make room in proportion to what they have above it. See Li and
    Jilkov, "Survey of maneuvering target tracking, part V", 2005.

    The file parameters are those of the published set, as in `imm_published`, with the density and the floor where a
    search ended on landing patterns under the radar of Volovyk 2022; another set is given as `model_set`, whose
    switching is not used.
    """

    measurement: Annotated[MeasurementModel, "given"]
    model_set: Annotated[ModelSet | None, "given"] = None
    acceleration_density: Annotated[float, "m2/s3"] = 3.0
    slow_turn_rate: Annotated[float, "rad/s"] = -0.001
    fast_turn_rate: Annotated[float, "rad/s"] = -0.045
    least_weight: float = 0.01

    def __post_init__(self) -> None:
        if not 0.0 <= self.least_weight * len(self._set.models) < 1.0:
            raise ValueError(f"least_weight must not be negative and be below 1/{len(self._set.models)}")

    @cached_property
    def _set(self) -> ModelSet:
        if self.model_set is not None:
            return self.model_set
        return published_set(self.acceleration_density, self.slow_turn_rate, self.fast_turn_rate)

    @cached_property
    def _interacting(self) -> InteractingMultipleModel:
        return InteractingMultipleModel(self.measurement, self._set)

    @property
    def channels(self) -> tuple[str, ...]:
        return self._interacting.channels

    @property
    def modes(self) -> tuple[str, ...]:
        """Names of the models."""
        return self._interacting.modes

    def begin(self, prior: Gaussian) -> Mixture:
        return unpack(self._interacting.begin(prior))

    def step(self, state: Mixture, dt: float, z: Any | None, R: Any | None) -> tuple[Mixture, Innovation | None]:
        if dt > 0.0:
            moved = predict(Gaussian(state.mean, state.cov), *transitions(self._set.models, dt, state.mean))
            state = Mixture(state.weights, moved.mean, moved.cov)
        if z is None:
            return state, None
        predicted = np.einsum("m...,im...->i...", state.weights, state.mean)
        state, innovation = update_mixture(state, *self.measurement.linearise(z, R, predicted))
        measured = np.isfinite(innovation.white).any(axis=0)
        return state._replace(weights=np.where(measured, self._floored(state.weights), state.weights)), innovation

    def estimate(self, state: Mixture) -> Mixture:
        return state

    def _floored(self, weights: Any) -> Any:
        """Weights (M, *B) of at least ``least_weight``, what others have above it scaled down alike."""
        low = weights < self.least_weight
        above = np.where(low, 0.0, weights - self.least_weight)
        room = 1.0 - self.least_weight * len(weights)
        return np.where(low.any(axis=0), self.least_weight + room * above / above.sum(axis=0), weights)
