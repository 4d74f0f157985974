"""The idealised landing profile of the papers on the microwave landing system: a motion in the vertical plane."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Annotated, Any

import numpy as np

from autopilot.route import Leg, Route
from sim.flight.record import RECORD_STEP, Flight
from sim.flight.truths._motion import prescribed_flight, state_of_motion

Motion = tuple[Any, Any, Any, Any, Any, Any]  # along and up: place, rate, acceleration, each (k,) or one for all


@dataclass(frozen=True)
class MlsProfile:
    """Level deceleration, glide towards the elevation beacon at constant elevation, flare [Volovyk 2018, fig. 1].

    Distances are from the elevation beacon, which is at the origin; the flight goes north. Speeds fall uniformly
    on each leg, along the path. The corner at the glide path is sharp, as in the paper. The flare is a parabola that
    touches the ground without sink: the paper guides it by other means and gives no shape.
    """

    level_distance: Annotated[float, "m"] = 15000.0  # where the level leg begins
    glide_distance: Annotated[float, "m"] = 5000.0  # where the glide path begins
    decision_distance: Annotated[float, "m"] = 750.0  # where the flare begins
    level_height: Annotated[float, "m"] = 200.0
    decision_height: Annotated[float, "m"] = 30.0
    start_speed: Annotated[float, "m/s"] = 150.0
    glide_speed: Annotated[float, "m/s"] = 100.0
    decision_speed: Annotated[float, "m/s"] = 80.0

    def __post_init__(self) -> None:
        if not self.level_distance > self.glide_distance > self.decision_distance > 0.0:
            raise ValueError("level leg, glide path and flare must begin one behind the other, before the beacon")
        if not self.level_height > self.decision_height > 0.0:
            raise ValueError("the decision height must lie between the ground and the level leg")
        if not self.start_speed > self.glide_speed > self.decision_speed > 0.0:
            raise ValueError("the speed must fall from leg to leg")

    def fly(self, *, step: float = RECORD_STEP) -> Flight:
        """Phases level, glide, flare; ends at the touchdown."""
        descent = self.level_height - self.decision_height
        run = self.glide_distance - self.decision_distance
        slope = descent / run
        level_length, glide_length = self.level_distance - self.glide_distance, math.hypot(run, descent)
        braking = (self.start_speed**2 - self.glide_speed**2) / (2.0 * level_length)
        gliding = (self.glide_speed**2 - self.decision_speed**2) / (2.0 * glide_length)
        level_time = (self.start_speed - self.glide_speed) / braking
        glide_time = (self.glide_speed - self.decision_speed) / gliding
        flare_length = 2.0 * self.decision_height / slope  # a parabola loses its height at half the slope
        across = self.decision_speed / math.hypot(1.0, slope)  # horizontal speed in the flare, constant
        flare_time = flare_length / across
        time = step * np.arange(math.floor((level_time + glide_time + flare_time) / step + 1e-9) + 1)
        phase = np.searchsorted([level_time, level_time + glide_time], time, side="right")

        flown, speed = _decelerated(time, self.start_speed, braking)
        level: Motion = (flown - self.level_distance, speed, -braking, 0.0 * time + self.level_height, 0.0 * time, 0.0)
        flown, speed = _decelerated(time - level_time, self.glide_speed, gliding)
        forward, down = run / glide_length, -descent / glide_length
        glide: Motion = (
            forward * flown - self.glide_distance, forward * speed, -forward * gliding,
            self.level_height + down * flown, down * speed, -down * gliding,
        )  # fmt: skip
        since = time - level_time - glide_time
        bend = slope * across / flare_time  # m/s2, upwards
        flare: Motion = (
            across * since - self.decision_distance, 0.0 * time + across, 0.0,
            self.decision_height - slope * across * since + 0.5 * bend * since**2, -slope * across + bend * since, bend,
        )  # fmt: skip
        north, north_rate, north_acceleration, height, climb, climb_rate = (
            np.choose(phase, choices) for choices in zip(level, glide, flare, strict=True)
        )
        zero = np.zeros_like(time)
        state = state_of_motion(
            time,
            (north, zero, np.maximum(height, 0.0)),
            (north_rate, zero, climb),
            (north_acceleration, zero, climb_rate),
        )
        route = Route((Leg((-self.level_distance, 0.0), (flare_length, 0.0), self.start_speed, self.level_height),))
        return prescribed_flight(
            state, route, 0, phase, ("level", "glide", "flare"), "touchdown of the prescribed path"
        )


def _decelerated(time: Any, speed: float, deceleration: float) -> tuple[Any, Any]:
    """Distance flown and speed left."""
    return speed * time - 0.5 * deceleration * time**2, speed - deceleration * time
