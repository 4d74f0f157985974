"""Kalman filter of any linear motion: the single-model reference of every comparison."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property
from typing import Annotated, Any, Protocol

from tracking.gaussian import Gaussian, Innovation, predict, update
from tracking.measurement import Linear, MeasurementModel
from tracking.motion import ConstantVelocity, Motion


class OneMotion(Protocol):
    """A filter with one motion model."""

    @property
    def motion(self) -> Motion | None:
        """The given one."""
        ...

    @property
    def acceleration_density(self) -> float:
        """Where none is given, m2/s3."""
        ...


def motion_of(tracker: OneMotion) -> Motion:
    """The given motion, or straight flight with white acceleration of the given density."""
    return ConstantVelocity(tracker.acceleration_density) if tracker.motion is None else tracker.motion


@dataclass(frozen=True)
class Kalman:
    """Predict with one motion model, update with one measurement model [Volovyk 2022, eqs. (15)-(18)].

    The motion is straight with white acceleration of ``acceleration_density``, unless another one is given.

    Erratum: (15) printed without the estimate's hats and (17) with the covariance of k-1 given k, used the prediction
    of k given k-1, because the gain weighs the prediction against the measurement.
    """

    measurement: Annotated[MeasurementModel, "given"]
    motion: Annotated[Motion | None, "given"] = None
    acceleration_density: Annotated[float, "m2/s3"] = 10.0  # docs/densities.md

    def __post_init__(self) -> None:
        _ = self._motion  # a bad parameter is told when it is given

    _motion = cached_property(motion_of)

    @property
    def channels(self) -> tuple[str, ...]:
        return self._motion.channels

    def begin(self, prior: Gaussian) -> Gaussian:
        return prior

    def step(self, state: Gaussian, dt: float, z: Any | None, R: Any | None) -> tuple[Gaussian, Innovation | None]:
        return filtered(self._motion, self.measurement, _conditioned, state, dt, z, R)

    def estimate(self, state: Gaussian) -> Gaussian:
        return state


def filtered(
    motion: Motion,
    measurement: MeasurementModel,
    condition: Callable[[Gaussian, Linear], tuple[Gaussian, Innovation]],
    state: Gaussian,
    dt: float,
    z: Any | None,
    R: Any | None,
) -> tuple[Gaussian, Innovation | None]:
    """One step of every filter with one motion model; ``condition`` is what it does with a measurement."""
    if dt > 0.0:
        state = predict(state, *motion.transition(dt, state.mean))
    if z is None:
        return state, None
    return condition(state, measurement.linearise(z, R, state.mean))


def _conditioned(state: Gaussian, linear: Linear) -> tuple[Gaussian, Innovation]:
    return update(state, *linear)
