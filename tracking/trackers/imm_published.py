"""The interacting multiple models exactly as published: two left turns and straight flight."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import Annotated, Any

from tracking.gaussian import Gaussian, Innovation, Mixture
from tracking.measurement import MeasurementModel
from tracking.motion import CARTESIAN
from tracking.packed import Packed
from tracking.trackers.imm import InteractingMultipleModel, published_set


@dataclass(frozen=True)
class PublishedModels:
    """IMM with the published set, which knows no slowing down and no right turn [Volovyk 2022, section 4]."""

    measurement: Annotated[MeasurementModel, "given"]
    acceleration_density: Annotated[float, "m2/s3"] = 0.01
    slow_turn_rate: Annotated[float, "rad/s"] = -0.001
    fast_turn_rate: Annotated[float, "rad/s"] = -0.045
    channels = CARTESIAN

    def __post_init__(self) -> None:
        _ = self._filter  # a bad parameter is told when it is given

    @cached_property
    def _filter(self) -> InteractingMultipleModel:
        models = published_set(self.acceleration_density, self.slow_turn_rate, self.fast_turn_rate)
        return InteractingMultipleModel(self.measurement, models)

    @property
    def modes(self) -> tuple[str, ...]:
        """Names of the models."""
        return self._filter.modes

    def begin(self, prior: Gaussian) -> Packed:
        return self._filter.begin(prior)

    def step(self, state: Packed, dt: float, z: Any | None, R: Any | None) -> tuple[Packed, Innovation | None]:
        return self._filter.step(state, dt, z, R)

    def estimate(self, state: Packed) -> Mixture:
        return self._filter.estimate(state)
