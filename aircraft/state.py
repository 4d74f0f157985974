"""What passes between airframe, autopilot and sensors: SI, radians, floats or arrays of any common shape."""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np

STANDARD_GRAVITY = 9.80665  # m/s2, the g of the papers and of load factors

Real = Any  # float in the loop, array over a record


class AircraftState(NamedTuple):
    """One instant of motion, or a whole record when every field is an array of the same shape.

    Fields are what an airframe measures independently; what follows from them (air-path angles, wind-axis load
    factors) are properties, so that a flight loop never pays for what only a sensor or a report asks for.

    Position is from the runway threshold, velocity over the ground; see ``aircraft.__doc__`` for frames and signs.
    """

    time: Real  # s
    north: Real  # m
    east: Real  # m
    height: Real  # m above the threshold
    velocity_north: Real  # m/s over the ground
    velocity_east: Real  # m/s
    velocity_up: Real  # m/s
    bank: Real  # rad, + right
    pitch: Real  # rad, + up
    heading: Real  # rad, clockwise from north
    roll_rate: Real  # rad/s, body axes
    pitch_rate: Real  # rad/s
    yaw_rate: Real  # rad/s
    airspeed: Real  # m/s, true
    angle_of_attack: Real  # rad
    sideslip: Real  # rad, + wind from the right
    specific_force_forward: Real  # m/s2, body axes, everything but gravity
    specific_force_right: Real  # m/s2
    specific_force_down: Real  # m/s2
    aileron: Real  # -1..1, + rolls right
    elevator: Real  # -1..1, + pitches up
    rudder: Real  # -1..1, + yaws right
    throttle: Real  # 0..1, power lever
    flaps: Real  # rad
    gear: Real  # 0 up, 1 down
    main_wheels: Real  # share of the main gear units on the ground, 0..1

    @property
    def course(self) -> Real:
        """Ground track angle, rad clockwise from north, -pi..pi."""
        return np.arctan2(self.velocity_east, self.velocity_north)

    @property
    def ground_speed(self) -> Real:
        """Horizontal speed over the ground, m/s."""
        return np.hypot(self.velocity_north, self.velocity_east)


class Command(NamedTuple):
    """What the autopilot asks of the inner loops."""

    bank: Real  # rad, + right
    flight_path_angle: Real  # rad over the ground, + up; the feed-forward when a height is held
    height: Real  # m above the threshold, NaN = not held
    airspeed: Real  # m/s, true
    flaps: Real  # rad
    gear: Real  # 0 up, 1 down
    sideslip: Real = 0.0  # rad, 0 = coordinated; the de-crab holds the drift angle


class Controls(NamedTuple):
    """What the inner loops set; -1..1 with the signs of ``AircraftState``, throttle 0..1."""

    aileron: Real
    elevator: Real
    rudder: Real
    throttle: Real
    flaps: Real  # rad
    gear: Real  # 0 up, 1 down
