"""The law with all its limits, evaluated outside the filter on the filter's own estimate."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import Annotated, Any, Literal

from tracking.gaussian import Gaussian, Innovation, predict
from tracking.measurement import MeasurementModel
from tracking.reference_path import (
    SUB_STEP,
    Law,
    PathState,
    ReferencePath,
    ahead_in_sub_steps,
    begin_on_path,
    channels_on_path,
    check_tuning,
    corrected,
    estimate_on_path,
    path_of,
    steering,
    sub_steps,
    uniform,
)

DENSITIES = {"paper": 0.03, "jacobian": 0.3}  # m2/s3, by the covariance: the choices of docs/densities.md


@dataclass(frozen=True)
class SaturatedControl:
    """Kalman filter of the double integrator with ``U = law(estimate)`` as input [Vasylyev 2003, eqs. (4), (6), (9)].

    The control is held for ``sub_step``; one that is not below the scan period gives the zero-order hold over the whole
    scan, as published.

    On a line U is ``g bank`` across it. On a route the state has two axes, F, Q and the gain of (9) hold on both, and U
    is a vector: ``g tan(bank)`` at right angles to the estimated velocity through the air, whose motion over the ground
    the route tells, with the deviations from the leg that the estimate is on. So the control turns the velocity. An
    acceleration across the new leg alone would not: at a course error of 90 deg, where (6) is void, it stops the motion
    along the old leg instead of turning it. For small course errors both are (6). The autopilot holds a speed as well:
    where the route has a chart with speeds, the estimated one comes to it.

    ``covariance`` says what the control is to the filter. ``paper``: an input, which it truly is where the aircraft is
    flown on this very estimate; where the aircraft takes it from its own state, that is pessimistic inside the limits
    and exact in saturation. ``jacobian``: a function of the state, whose slope belongs into F where the aircraft flies
    on its own; that is sharper, leaves less room for a mismatched law, and is far too sure of itself where the aircraft
    is flown on this estimate.

    Erratum: (6) printed without a unit of u, used the bank in radians, because g times the bank is the acceleration.
    """

    law: Annotated[Law, "given"]
    route: Annotated[Any, "given"]  # a Line, or a route
    measurement: Annotated[MeasurementModel, "given"]
    acceleration_density: Annotated[float | None, "m2/s3"] = None  # that of DENSITIES
    sub_step: Annotated[float, "s"] = SUB_STEP
    covariance: Literal["paper", "jacobian"] = "paper"

    def __post_init__(self) -> None:
        if self.covariance not in DENSITIES:
            raise ValueError(f"covariance is 'paper' or 'jacobian', not '{self.covariance}'")
        check_tuning(self.density, self.sub_step)

    @property
    def density(self) -> float:
        """m2/s3, of the acceleration: the given one, or the best for the covariance."""
        return DENSITIES[self.covariance] if self.acceleration_density is None else self.acceleration_density

    def _driven(self, state: PathState, dt: float) -> PathState:
        mean, place = state.gaussian.mean, state.place
        count, step, rest = sub_steps(dt, self.sub_step)
        for _ in range(count):
            bank = self.law(self.path.deviation(place, mean))
            mean = self.path.steered(place, mean, bank, step)
            place = self.path.advance(place, mean, step)
        if rest:
            mean = uniform(self.path.axes, rest, 0.0)[0] @ mean
            place = self.path.advance(place, mean, rest)
        # uniform motion with isotropic noise looks the same from every leg: one covariance for all runs
        moved = predict(state.gaussian, *uniform(self.path.axes, dt, self.density))
        return PathState(moved._replace(mean=mean), place)

    path, channels = cached_property(path_of), cached_property(channels_on_path)
    begin, estimate = begin_on_path, estimate_on_path

    def step(self, state: PathState, dt: float, z: Any | None, R: Any | None) -> tuple[PathState, Innovation | None]:
        if dt > 0.0:
            slope = self.covariance == "jacobian"
            state = ahead_in_sub_steps(with_slope, self, state, dt, self.density) if slope else self._driven(state, dt)
        return corrected(self, state, z, R)


def with_slope(law: Law, path: ReferencePath, state: PathState, dt: float, Q: Any) -> Gaussian:
    """Estimate after one sub-step with the bank held; the bank is a function of the state, whose slope F carries."""
    mean, place = state.gaussian.mean, state.place
    moved, F = path.steered_with_slope(place, mean, steering(law, path, place, mean), dt)
    return predict(state.gaussian, F, Q)._replace(mean=moved)
