"""After the landing: nose lowered, brakes to a stop, the centreline held by nose wheel, rudder and brakes.

With the track chi off the runway's direction the aircraft leaves the centreline by y' = V sin chi, and it turns by the
curvature kappa of its path, chi' = V kappa. Per metre of path that is the same at every speed, y'' = kappa, so the
curvature kappa = -(2 chi + y / l) / l brings it back with both poles at -1 / l.

A tyre gives a side force of its load times the slip angle times a coefficient c. So the track follows the heading with
the lag V / (c g), and the yaw rate follows the steered wheel with the lag k^2 V / (c g a b): a and b are the distances
of the steered and the main wheels from the centre of gravity, k is the radius of gyration. Feedback of the error e of
the yaw rate to the steering angle, d = L r / V + w k^2 L / (c g a b) e, gives the yaw rate r the bandwidth w at any
speed. For chi the law takes the heading less the slip angle that lasts: the heading leads the track by its lag, and
what a side wind needs stays out of it. With n = V / l and T = V / (c g) the loop is then T s^3 + (1 + 2 n T) s^2 +
2 n s + n^2, stable for every n, and damped by .7 for n T = 1 / 2; a fourth of w leaves the yaw rate in time. Hence
l = 2 V (2 / w + V / (c g)). Rudder and brakes turn the aircraft too, the brakes by what the one side takes off more
than the other: some models steer no wheel, and at high speed a nose wheel carries little.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from typing import Annotated, NamedTuple

from aircraft.state import STANDARD_GRAVITY, AircraftState, Controls, WheelControls
from autopilot.saturation import rate_limit, saturate

FULL_BRAKES = 0.8 * STANDARD_GRAVITY  # m/s2 that brakes take off at most, rubber on dry concrete [from memory]
CORNERING = 7.7  # 1/rad, c: the slope of JSBSim's tyre at no slip, 0.06 * 2.8 * 0.8 per deg
GYRATION = 0.65  # k over the wheelbase, of the An-26
NOSE_LOAD = 0.09  # b over the wheelbase: the share of the weight on the steered wheel, 8 to 15 % of most aircraft
LEAST_LENGTH = 3.0  # wheelbases, of the length l
SLOW = 1.0  # m/s; the steering angle is not reckoned with less


class RolloutState(NamedTuple):
    """What the roll-out remembers from one step to the next."""

    braking_at: float  # s, when the brakes begin
    elevator: float
    speed: float  # m/s over the ground, one step before
    brakes: float  # 0..1
    yaw_rate_sum: float  # rad/s, asked for beyond what the curvature needs
    slip: float  # rad, heading less track, what lasts of it


@dataclass(frozen=True)
class Rollout:
    """Steers and brakes an aircraft that has landed; ``begin`` and ``step`` pass the state.

    What differs between aircraft comes from their geometry (wheelbase, track, travel of the steering) and, for the
    rudder, from the design of the inner loops.
    """

    wheelbase: Annotated[float, "m"]  # from the main wheels forward to the steered one; 0 = none is steered
    wheel_track: Annotated[float, "m"]
    steering_limit: Annotated[float, "rad"]  # negative where the wheel turns against its command
    rudder_per_sideslip: float  # 1/rad, rudder that holds a sideslip
    rudder_per_yaw_rate: Annotated[float, "s"]  # rudder against a yaw rate, as the inner loops damp it
    deceleration: Annotated[float, "m/s2"] = 0.2 * STANDARD_GRAVITY  # a medium autobrake [from memory]
    brake_time: Annotated[float, "s"] = 1.0  # in which the brakes reach their deceleration
    nose_time: Annotated[float, "s"] = 3.0  # in which the elevator goes to neutral, before the brakes
    yaw_bandwidth: Annotated[float, "rad/s"] = 2.0
    yaw_time: Annotated[float, "s"] = 2.0  # in which a lasting error of the yaw rate is taken out
    slip_time: Annotated[float, "s"] = 4.0  # after which a slip angle counts as lasting
    intercept: Annotated[float, "rad"] = math.radians(10.0)  # towards the centreline, at most
    lateral_acceleration: Annotated[float, "m/s2"] = 0.1 * STANDARD_GRAVITY
    level_bank: Annotated[float, "rad"] = math.radians(20.0)  # that asks for full aileron
    _steering: float = field(init=False, repr=False, compare=False)  # s/m, angle over the wheelbase, for a yaw rate
    _turning: float = field(init=False, repr=False, compare=False)  # s, brakes of one side more, of the other less

    def __post_init__(self) -> None:
        bandwidth, gyration = self.yaw_bandwidth, GYRATION * self.wheelbase
        lag = GYRATION**2 / (CORNERING * STANDARD_GRAVITY * NOSE_LOAD * (1.0 - NOSE_LOAD))
        object.__setattr__(self, "_steering", bandwidth * lag)
        # the yaw acceleration of the bandwidth, from a force with half the wheel track as its arm
        turning = 2.0 * bandwidth * gyration**2 / (self.wheel_track * FULL_BRAKES) if self.wheel_track else 0.0
        object.__setattr__(self, "_turning", turning)

    def begin(self, state: AircraftState) -> RolloutState:
        """From the landing on, with the controls where they are."""
        return RolloutState(state.time + self.nose_time, state.elevator, state.ground_speed, 0.0, 0.0, 0.0)

    def step(
        self,
        s: RolloutState,
        state: AircraftState,
        cross_track: float,
        track_error: float,
        heading_error: float,
        dt: float,
    ) -> tuple[RolloutState, Controls, WheelControls]:
        """Controls for the next ``dt`` seconds.

        ``cross_track`` (m) from the centreline, ``track_error`` and ``heading_error`` (rad) from its direction are + to
        the right.
        """
        elevator = rate_limit(s.elevator, 0.0, 1.0 / self.nose_time, dt)
        speed = math.hypot(state.velocity_north, state.velocity_east)
        brakes = s.brakes
        if state.time >= s.braking_at:
            lacking = self.deceleration - (s.speed - speed) / dt
            brakes = min(max(brakes + lacking / FULL_BRAKES * dt / self.brake_time, 0.0), 1.0)
        slip = s.slip + (heading_error - track_error - s.slip) * dt / self.slip_time
        wanted = speed * self.curvature(speed, cross_track, heading_error - slip)  # rad/s
        error = wanted - state.yaw_rate
        beyond = s.yaw_rate_sum
        steering = self.wheelbase * ((wanted + beyond) / max(speed, SLOW) + self._steering * error)
        rudder = self.rudder_per_sideslip * state.sideslip + self.rudder_per_yaw_rate * (error + beyond)
        turning = self._turning * (error + beyond) if state.time >= s.braking_at else 0.0
        limit = abs(self.steering_limit)
        if abs(steering) < limit or abs(rudder) < 1.0 or error * beyond < 0.0:  # else all of it is at its stop
            beyond += error * dt / self.yaw_time
        steering = saturate(steering, limit)
        controls = Controls(
            saturate(-state.bank / self.level_bank, 1.0), elevator, saturate(rudder, 1.0), 0.0, state.flaps, 1.0
        )
        wheels = WheelControls(
            min(max(brakes - turning, 0.0), 1.0),
            min(max(brakes + turning, 0.0), 1.0),
            steering / self.steering_limit if self.steering_limit else 0.0,
        )
        return RolloutState(s.braking_at, elevator, speed, brakes, beyond, slip), controls, wheels

    def curvature(self, speed: float, cross_track: float, track_error: float) -> float:
        """Curvature, 1/m, + to the right, of the path back to the centreline."""
        lags = 2.0 / self.yaw_bandwidth + speed / (CORNERING * STANDARD_GRAVITY)
        length = max(2.0 * speed * lags, LEAST_LENGTH * abs(self.wheelbase), 1.0)
        towards = saturate(-0.5 * cross_track / length, self.intercept)
        sharpest = self.lateral_acceleration / max(speed * speed, 1.0)
        return float(saturate(2.0 * (towards - track_error) / length, sharpest))
