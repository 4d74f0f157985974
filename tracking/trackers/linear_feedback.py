"""The law without its limits, folded into the dynamics of the filter."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import Annotated, Any, ClassVar

import numpy as np

from tracking.gaussian import Gaussian, Innovation, predict
from tracking.measurement import MeasurementModel
from tracking.motion import GRAVITY, closed_loop
from tracking.reference_path import (
    SUB_STEP,
    Law,
    Legs,
    PathState,
    begin_on_path,
    channels_on_path,
    check_tuning,
    closed,
    coasted,
    corrected,
    embed,
    estimate_on_path,
    path_of,
    steering,
    sub_steps,
    uniform,
)


@dataclass(frozen=True)
class LinearFeedback:
    """Kalman filter of ``X' = (F + B C) X`` with ``U = C X`` folded into F [Vasylyev 2003, eqs. (2), (3), (7), (8)].

    C is the slope of the law on the path itself, so the same filter serves both laws: k1 and k2 of the route mode, and
    k3 / distance, k4 / ground speed of the radio-beacon mode, whose stiffness grows on the way.

    On a route every leg is a line of its own, chosen by the estimate; there the feedback is folded in once per
    ``sub_step``, because the stiffness may differ from run to run. It is told of the route what
    `tracking.trackers.saturated_control` is: where the circles of the turns begin, the wind, and the speeds of a chart,
    to which the speed along the leg comes; the limits of the law are all that it leaves out.

    Erratum: (7) printed ``+ [0; g] u`` beside the folded feedback, used none, because it would apply the gains twice.
    """

    law: Annotated[Law, "given"]
    route: Annotated[Any, "given"]  # a Line, or a route
    measurement: Annotated[MeasurementModel, "given"]
    acceleration_density: Annotated[float, "m2/s3"] = 1000.0  # docs/densities.md
    sub_step: Annotated[float, "s"] = SUB_STEP
    per_run: ClassVar[dict[str, str]] = {"acceleration_density": "acceleration_density"}

    def __post_init__(self) -> None:
        check_tuning(self.acceleration_density, self.sub_step)

    def _on_line(self, state: PathState, dt: float) -> PathState:
        """By (8), with the gains of the middle of the step: one covariance for all runs."""
        on_line = np.zeros(2)
        middle = self.path.advance(state.place, on_line, 0.5 * dt)
        control = steering(self.law, self.path, middle, on_line)
        stiffness, damping = -GRAVITY * float(control.per_cross_track), -GRAVITY * float(control.per_cross_track_rate)
        F, Q = closed_loop(dt, stiffness, damping, 1.0)
        Q = np.multiply.outer(Q, self.acceleration_density)
        return PathState(predict(state.gaussian, F, Q), self.path.advance(state.place, on_line, dt))

    def _on_legs(self, path: Legs, state: PathState, dt: float) -> PathState:
        count, step, rest = sub_steps(dt, self.sub_step)
        F, Q = uniform(path.axes, step, self.acceleration_density)
        for _ in range(count):
            (mean, cov), place = state
            normal = path.normal(place)
            deviation = path.deviation(place, mean)
            off_leg = np.empty_like(mean)
            off_leg[0::2], off_leg[1::2] = normal * deviation.cross_track, normal * deviation.cross_track_rate
            on_leg = mean - off_leg
            control = steering(self.law, path, place, on_leg)
            transition, noise = closed(control, step, Q[:2, :2])
            faster, kept = path.along_at_charted_speed(place, on_leg, step)
            on_leg[1::2] += faster
            moved = predict(
                Gaussian(off_leg, cov),
                embed(normal, transition, F[:2, :2] * (1.0, kept)),
                embed(normal, noise, Q[:2, :2]),
                F @ on_leg,
            )
            state = PathState(moved, path.advance(place, moved.mean, step))
        return coasted(path, state, rest, self.acceleration_density)

    path, channels = cached_property(path_of), cached_property(channels_on_path)
    begin, estimate = begin_on_path, estimate_on_path

    def step(self, state: PathState, dt: float, z: Any | None, R: Any | None) -> tuple[PathState, Innovation | None]:
        if dt > 0.0:
            state = self._on_legs(self.path, state, dt) if isinstance(self.path, Legs) else self._on_line(state, dt)
        return corrected(self, state, z, R)
