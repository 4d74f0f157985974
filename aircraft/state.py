"""What passes between airframe, autopilot and sensors: SI, radians, floats or arrays of any common shape."""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np

STANDARD_GRAVITY = 9.80665  # m/s2, the g of the papers and of load factors

Real = Any  # float in the loop, array over a record

# parts of an aircraft that may touch the ground; several at once are the sum of theirs
MAIN_WHEEL, NOSE_WHEEL, TAIL_WHEEL, TAIL, WING_TIP, FUSELAGE = (1 << number for number in range(6))
PARTS = {
    MAIN_WHEEL: "main wheel",
    NOSE_WHEEL: "nose wheel",
    TAIL_WHEEL: "tail wheel",
    TAIL: "tail",
    WING_TIP: "wing tip",
    FUSELAGE: "fuselage",
}


def parts(touching: float) -> str:
    """The parts of a sum of ``PARTS`` in words: "main wheel and nose wheel"."""
    return " and ".join(word for part, word in PARTS.items() if int(touching) & part)


def main_wheel_first(first_contact: float) -> bool:
    """Whether an aircraft touched down as it should: a main wheel first, or all three points of a tail-dragger."""
    return int(first_contact) in (MAIN_WHEEL, MAIN_WHEEL + TAIL_WHEEL)


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
    equivalent_airspeed: Real  # m/s, of the same dynamic pressure in the standard air of sea level, as indicated
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
    first_contact: Real  # sum of ``PARTS`` that touched the ground first, within one step of the motion; 0 = none
    touched: Real  # sum of ``PARTS`` that have touched it so far

    @property
    def course(self) -> Real:
        """Ground track angle, rad clockwise from north, -pi..pi."""
        return np.arctan2(self.velocity_east, self.velocity_north)

    @property
    def ground_speed(self) -> Real:
        """Horizontal speed over the ground, m/s."""
        return np.hypot(self.velocity_north, self.velocity_east)

    @property
    def air_velocity(self) -> tuple[Real, Real, Real]:
        """(north, east, up) through the air, m/s."""
        forward, _, _ = self.wind_axes
        return self.airspeed * forward[0], self.airspeed * forward[1], -self.airspeed * forward[2]

    @property
    def flight_path_angle(self) -> Real:
        """Of the path through the air, rad, + up."""
        return -np.arcsin(self.wind_axes[0][2])

    @property
    def air_course(self) -> Real:
        """Of the path through the air, rad clockwise from north, -pi..pi."""
        north, east, _ = self.wind_axes[0]
        return np.arctan2(east, north)

    @property
    def aerodynamic_bank(self) -> Real:
        """Bank about the velocity through the air, rad, + right."""
        _, right, down = self.wind_axes
        return np.arctan2(right[2], down[2])

    @property
    def load_factor(self) -> tuple[Real, Real, Real]:
        """(forward, right, up) in wind axes: specific force over standard gravity; (0, 0, 1) in steady level flight."""
        cos_alpha, sin_alpha = np.cos(self.angle_of_attack), np.sin(self.angle_of_attack)
        cos_beta, sin_beta = np.cos(self.sideslip), np.sin(self.sideslip)
        x, y, z = self.specific_force_forward, self.specific_force_right, self.specific_force_down
        along = x * cos_alpha + z * sin_alpha
        return (
            (along * cos_beta + y * sin_beta) / STANDARD_GRAVITY,
            (y * cos_beta - along * sin_beta) / STANDARD_GRAVITY,
            (x * sin_alpha - z * cos_alpha) / STANDARD_GRAVITY,
        )

    @property
    def acceleration(self) -> tuple[Real, Real, Real]:
        """(north, east, up) m/s2 from load factors and air-path angles: gravity acts on the vertical only.

        The horizontal part is eq. (1)'s bracket taken apart into its two components [Glistin, eq. (1)].
        """
        forward, right, down = self.wind_axes
        along, side, up = self.load_factor
        north, east, sinking = (along * forward[i] + side * right[i] - up * down[i] for i in range(3))
        return STANDARD_GRAVITY * north, STANDARD_GRAVITY * east, -STANDARD_GRAVITY * (sinking + 1.0)

    @property
    def wind_axes(self) -> tuple[tuple[Real, Real, Real], tuple[Real, Real, Real], tuple[Real, Real, Real]]:
        """Unit vectors forward, right, down of the wind axes, each as (north, east, down)."""
        cos_alpha, sin_alpha = np.cos(self.angle_of_attack), np.sin(self.angle_of_attack)
        cos_beta, sin_beta = np.cos(self.sideslip), np.sin(self.sideslip)
        return (
            self._to_earth(cos_alpha * cos_beta, sin_beta, sin_alpha * cos_beta),
            self._to_earth(-cos_alpha * sin_beta, cos_beta, -sin_alpha * sin_beta),
            self._to_earth(-sin_alpha, 0.0, cos_alpha),
        )

    def _to_earth(self, x: Real, y: Real, z: Real) -> tuple[Real, Real, Real]:
        """Body-axis vector (forward, right, down) as (north, east, down)."""
        cos_bank, sin_bank = np.cos(self.bank), np.sin(self.bank)
        cos_pitch, sin_pitch = np.cos(self.pitch), np.sin(self.pitch)
        cos_heading, sin_heading = np.cos(self.heading), np.sin(self.heading)
        along = cos_pitch * x + sin_pitch * (sin_bank * y + cos_bank * z)
        across = cos_bank * y - sin_bank * z
        return (
            cos_heading * along - sin_heading * across,
            sin_heading * along + cos_heading * across,
            -sin_pitch * x + cos_pitch * (sin_bank * y + cos_bank * z),
        )


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


class WheelControls(NamedTuple):
    """What is set on the ground besides."""

    left_brake: Real  # 0..1
    right_brake: Real
    steering: Real  # -1..1 of the travel of the steered wheels, + to the right
