"""After the landing: nose lowered, brakes to a stop, the centreline held by rudder and nose wheel.

A wheel that does not slip rolls where it points, so on its main wheels the aircraft moves along its heading and turns by
the steering angle d over the wheelbase L: y' = V sin psi, psi' = V tan d / L. Along the path, without V, that is the same
at every speed, y'' = kappa, so the curvature kappa = -(2 psi + y / l) / l brings it back with both poles at -1 / l
whatever the speed. The length l grows with the speed, so that nothing is asked faster than rudder and tyres can follow.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Annotated, NamedTuple

from aircraft.state import STANDARD_GRAVITY, AircraftState, Controls, WheelControls
from autopilot.saturation import rate_limit, saturate

FULL_BRAKES = 0.8 * STANDARD_GRAVITY  # m/s2 that brakes take off at most, rubber on dry concrete [from memory]
LEAST_LENGTH = 3.0  # wheelbases, of the length l


class RolloutState(NamedTuple):
    """What the roll-out remembers from one step to the next."""

    braking_at: float  # s, when the brakes begin
    elevator: float
    speed: float  # m/s over the ground, one step before
    brakes: float  # 0..1


@dataclass(frozen=True)
class Rollout:
    """Steers and brakes an aircraft that has landed; ``begin`` and ``step`` pass the state.

    What differs between aircraft comes from their geometry (wheelbase, travel of the steering) and, for the rudder, from
    the design of the inner loops.
    """

    wheelbase: Annotated[float, "m"]  # 0 = no wheel is steered
    steering_limit: Annotated[float, "rad"]
    rudder_per_sideslip: float  # 1/rad, rudder that holds a sideslip
    rudder_per_yaw_rate: Annotated[float, "s"]  # rudder against a yaw rate, as the inner loops damp it
    deceleration: Annotated[float, "m/s2"] = 0.2 * STANDARD_GRAVITY  # a medium autobrake [from memory]
    brake_time: Annotated[float, "s"] = 1.0  # in which the brakes reach their deceleration
    nose_time: Annotated[float, "s"] = 3.0  # in which the elevator goes to neutral, before the brakes
    centring_time: Annotated[float, "s"] = 2.0  # the length l over the speed
    intercept: Annotated[float, "rad"] = math.radians(10.0)  # towards the centreline, at most
    lateral_acceleration: Annotated[float, "m/s2"] = 0.1 * STANDARD_GRAVITY
    level_bank: Annotated[float, "rad"] = math.radians(20.0)  # that asks for full aileron

    def begin(self, state: AircraftState) -> RolloutState:
        """From the landing on, with the controls where they are."""
        return RolloutState(state.time + self.nose_time, state.elevator, state.ground_speed, 0.0)

    def step(
        self, s: RolloutState, state: AircraftState, cross_track: float, heading_error: float, dt: float
    ) -> tuple[RolloutState, Controls, WheelControls]:
        """Controls for the next ``dt`` seconds; ``cross_track`` (m) and ``heading_error`` (rad) are + to the right."""
        elevator = rate_limit(s.elevator, 0.0, 1.0 / self.nose_time, dt)
        speed = math.hypot(state.velocity_north, state.velocity_east)
        brakes = s.brakes
        if state.time >= s.braking_at:
            lacking = self.deceleration - (s.speed - speed) / dt
            brakes = min(max(brakes + lacking / FULL_BRAKES * dt / self.brake_time, 0.0), 1.0)
        curvature = self.curvature(speed, cross_track, heading_error)
        steering = saturate(math.atan(self.wheelbase * curvature), self.steering_limit)
        rudder = self.rudder_per_sideslip * state.sideslip
        rudder -= self.rudder_per_yaw_rate * (state.yaw_rate - speed * curvature)
        controls = Controls(
            saturate(-state.bank / self.level_bank, 1.0), elevator, saturate(rudder, 1.0), 0.0, state.flaps, 1.0
        )
        wheels = WheelControls(brakes, steering / self.steering_limit if self.steering_limit else 0.0)
        return RolloutState(s.braking_at, elevator, speed, brakes), controls, wheels

    def curvature(self, speed: float, cross_track: float, heading_error: float) -> float:
        """Curvature, 1/m, + to the right, of the path back to the centreline."""
        length = max(speed * self.centring_time, LEAST_LENGTH * self.wheelbase, 1.0)
        towards = saturate(-0.5 * cross_track / length, self.intercept)
        return saturate(2.0 * (towards - heading_error) / length, self.lateral_acceleration / max(speed * speed, 1.0))
