"""The law flown along a route with real course kinematics: north, east and velocity, turned by the commanded bank."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import Annotated, Any, Literal

import numpy as np

from tracking.gaussian import Gaussian, Innovation, lift, predict
from tracking.measurement import MeasurementModel
from tracking.motion import CARTESIAN, GRAVITY, course_kinematics
from tracking.reference_path import (
    SUB_STEP,
    Law,
    Legs,
    PathState,
    ahead_in_sub_steps,
    begin_on_path,
    check_tuning,
    corrected,
    estimate_on_path,
    steering,
)


@dataclass(frozen=True)
class RouteControl:
    """``course' = g tan(bank) / V`` with ``bank = law(deviation of the estimate from its own leg)``.

    The velocity turns in the air, whose motion over the ground the route tells: V is the airspeed. This goes beyond
    [Vasylyev 2003, eqs. (4), (6)], which belong to one line and are void at a course error of 90 deg.

    ``covariance`` says what the bank is to the filter. ``known_control``: an input, which it truly is where the
    aircraft is flown on this very estimate; F holds the kinematics of the turn and no law. ``jacobian``: a function of
    the state, which it truly is where the aircraft flies on its own; F holds the slope of the law as well. The second
    is sharper, but diverges where the first belongs; the first is only pessimistic where the second belongs.
    """

    law: Annotated[Law, "given"]
    route: Annotated[Any, "given"]
    measurement: Annotated[MeasurementModel, "given"]
    covariance: Literal["known_control", "jacobian"] = "known_control"
    acceleration_density: Annotated[float, "m2/s3"] = 0.1
    sub_step: Annotated[float, "s"] = SUB_STEP

    channels = CARTESIAN

    def __post_init__(self) -> None:
        if self.covariance not in ("known_control", "jacobian"):
            raise ValueError(f"covariance is 'known_control' or 'jacobian', not '{self.covariance}'")
        check_tuning(self.acceleration_density, self.sub_step)

    begin, estimate = begin_on_path, estimate_on_path

    @cached_property
    def path(self) -> Legs:
        return Legs(self.route, float(np.max(self.law.bank_limit)))

    def step(self, state: PathState, dt: float, z: Any | None, R: Any | None) -> tuple[PathState, Innovation | None]:
        if dt > 0.0:
            forward = known_control if self.covariance == "known_control" else autonomous
            state = ahead_in_sub_steps(forward, self, state, dt)
        return corrected(self, state, z, R)


def turned(path: Legs, mean: Any, bank: Any, dt: float) -> tuple[Any, Any]:
    """State after dt at a constant bank, and its Jacobian; it is the velocity through the air that turns."""
    north, east = path.wind
    if not (north or east):
        return course_kinematics(mean, bank, dt)
    moved, F = course_kinematics(mean - _drift(north, east, 0.0, mean), bank, dt)
    return moved + _drift(north, east, dt, mean), F


def known_control(law: Law, path: Legs, state: PathState, dt: float, Q: Any) -> Gaussian:
    """Estimate after one sub-step; the bank is an input of the covariance."""
    bank = law(path.deviation(state.place, state.gaussian.mean))
    mean, F = turned(path, state.gaussian.mean, bank, dt)
    return predict(state.gaussian, F, Q)._replace(mean=mean)


def autonomous(law: Law, path: Legs, state: PathState, dt: float, Q: Any) -> Gaussian:
    """Estimate after one sub-step; the bank is a function of the state that F carries.

    The slope is the one across the leg: along it only the beacon law changes, by the ratio of cross-track to distance
    less.
    """
    control = steering(law, path, state.place, state.gaussian.mean)
    mean, F = turned(path, state.gaussian.mean, control.bank, dt)
    normal = lift(path.normal(state.place), 1, mean.ndim - 1)
    gradient = np.empty(np.broadcast_shapes(mean.shape, (4, *control.per_cross_track.shape)))  # d bank / d state
    gradient[0::2] = normal * control.per_cross_track
    gradient[1::2] = normal * control.per_cross_track_rate
    # the bank acts at right angles to the air velocity: d acceleration / d bank = g / cos^2(bank)
    north_rate, east_rate = mean[1] - path.wind[0], mean[3] - path.wind[1]
    speed = np.maximum(np.hypot(north_rate, east_rate), 1.0)
    push = GRAVITY / np.cos(control.bank) ** 2 / speed
    effect = dt * np.stack([-east_rate * push, north_rate * push])[:, None] * gradient  # on the velocity
    F[1::2] += effect
    effect *= 0.5 * dt  # on the position
    F[0::2] += effect
    return predict(state.gaussian, F, Q)._replace(mean=mean)


def _drift(north: float, east: float, dt: float, mean: Any) -> Any:
    """What the air adds to the state over dt."""
    return lift(np.array([dt * north, north, dt * east, east]), 1, mean.ndim - 1)
