"""Bank -> aileron and rudder, path -> elevator, speed -> throttle: Command -> Controls.

Linear-quadratic loops about a feed-forward that knows the trim. Two signals are made inertial so that gusts do not
shake the controls: the angle of attack fed back is pitch minus path angle, and the airspeed is the speed through the
slow part of the wind.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from itertools import pairwise
from typing import NamedTuple

from aircraft.state import STANDARD_GRAVITY, AircraftState, Command, Controls
from autopilot.design import Designed

GUST_TIME = 5.0  # s; slower changes of the wind count as airspeed
AIRSPEED_ERROR, HEIGHT_ERROR = 8.0, 20.0  # m/s, m: larger errors are not acted upon harder
LOAD_FACTORS = 0.7, 1.4  # that the feed-forward believes
STALE = 0.01  # relative change of airspeed squared, or rad of flaps, after which the gains are looked up again


class Lookup(NamedTuple):
    """The schedule at one airspeed and flap angle."""

    inverse_square: float  # s2/m2, of the airspeed
    flaps: float  # rad
    trim: tuple[float, ...]  # constant and slope of angle of attack, elevator, throttle
    gains: tuple[float, ...]  # the rest of SCHEDULED


class LoopState(NamedTuple):
    """What the loops remember from one step to the next."""

    bank: float  # rad, reference
    bank_rate: float  # rad/s
    throttle_sum: float
    elevator_sum: float
    aileron_sum: float
    rudder_sum: float
    wind_north: float  # m/s, slow part of the velocity over the ground minus that through the air
    wind_east: float
    airspeed: float  # m/s, command of the step before
    slope: float  # rad, path angle commanded in the step before
    lookup: Lookup


@dataclass(frozen=True)
class InnerLoops:
    """Holds bank, path and airspeed with the gains of a design."""

    designed: Designed

    def begin(self, state: AircraftState) -> LoopState:
        """In a steady state, whose controls are kept."""
        over_ground = math.hypot(state.velocity_north, state.velocity_east)
        slope = math.atan2(state.velocity_up, over_ground)
        s = LoopState(
            *(state.bank, 0.0, 0.0, 0.0, 0.0, 0.0),
            *_wind(state),
            state.airspeed,
            slope,
            self.lookup(state.airspeed**-2.0, state.flaps),
        )
        hold = Command(state.bank, slope, state.height, state.airspeed, state.flaps, state.gear, state.sideslip)
        _, controls = self.step(s, hold, state, 1e-9)
        return s._replace(
            throttle_sum=state.throttle - controls.throttle,
            elevator_sum=state.elevator - controls.elevator,
            aileron_sum=state.aileron - controls.aileron,
            rudder_sum=state.rudder - controls.rudder,
        )

    def lookup(self, inverse_square: float, flaps: float) -> Lookup:
        """The schedule at 1/airspeed^2 (s2/m2) and flaps (rad)."""
        schedules = self.designed.schedules
        low, high, share = schedules[0], schedules[0], 0.0
        for below, above in pairwise(schedules):
            if flaps > below.flaps:
                low, high = below, above
                share = min((flaps - below.flaps) / (above.flaps - below.flaps), 1.0)
        constant = [a + share * (b - a) for a, b in zip(low.constant, high.constant, strict=True)]
        slope = [a + share * (b - a) for a, b in zip(low.slope, high.slope, strict=True)]
        trim = (constant[0], slope[0], constant[1], slope[1], constant[2], slope[2])
        gains = tuple(c + s * inverse_square for c, s in zip(constant[3:], slope[3:], strict=True))
        return Lookup(inverse_square, flaps, trim, gains)

    def step(self, s: LoopState, command: Command, state: AircraftState, dt: float) -> tuple[LoopState, Controls]:
        """Controls for the next ``dt`` seconds."""
        (reference, reference_rate, throttle_sum, elevator_sum, aileron_sum, rudder_sum, *slow) = s
        wind_north, wind_east, before, old, lookup = slow
        wanted_bank, slope, wanted_height, wanted_airspeed, wanted_flaps, gear, wanted_sideslip = command
        inverse_square = 1.0 / (wanted_airspeed * wanted_airspeed)
        known, known_flaps, trim, gains = lookup
        flaps = state.flaps
        if abs(inverse_square - known) > STALE * known or abs(flaps - known_flaps) > STALE:
            lookup = self.lookup(inverse_square, flaps)
            known, known_flaps, trim, gains = lookup
        # first letter the control, then what it answers to; a last s for the sum
        (throttle_per_slope, tv, ta, tq, tp, th, tvs, ths, ev, ea, eq, ep, eh, evs, ehs, *lateral) = gains
        (ab, ap, ar, ak, aks, rb, rp, rr, rk, rks, aileron_per_sideslip, rudder_per_sideslip) = lateral

        bank, pitch = state.bank, state.pitch
        cos_bank, sin_bank = math.cos(bank), math.sin(bank)
        velocity_north, velocity_east, climb = state.velocity_north, state.velocity_east, state.velocity_up
        over_ground = math.sqrt(velocity_north * velocity_north + velocity_east * velocity_east)
        share = dt / GUST_TIME
        blowing_north, blowing_east = _wind(state)
        wind_north += (blowing_north - wind_north) * share
        wind_east += (blowing_east - wind_east) * share
        air_north, air_east = velocity_north - wind_north, velocity_east - wind_east
        airspeed = math.sqrt(air_north * air_north + air_east * air_east + climb * climb)

        frequency = self.designed.reference_frequency
        reference_rate += frequency * (frequency * (wanted_bank - reference) - 2.0 * reference_rate) * dt
        reference += reference_rate * dt

        # path: what the trim needs at the wanted load factor, and the errors from it
        turning_up = (slope - old) / dt
        load_factor = 1.0 / math.cos(reference) + over_ground * turning_up / STANDARD_GRAVITY
        load_factor = max(LOAD_FACTORS[0], min(load_factor, LOAD_FACTORS[1]))
        inverse_square *= load_factor
        angle_of_attack = trim[0] + trim[1] * inverse_square
        path = over_ground * math.tan(slope) / airspeed  # rad, through the air
        flown = climb / airspeed
        airspeed_error = max(-AIRSPEED_ERROR, min(airspeed - wanted_airspeed, AIRSPEED_ERROR))
        height_error = max(-HEIGHT_ERROR, min(state.height - wanted_height, HEIGHT_ERROR))
        alpha_error = (pitch - flown) / cos_bank - angle_of_attack
        pitch_error = pitch - path - angle_of_attack * cos_bank
        turn = STANDARD_GRAVITY / airspeed * sin_bank
        rate_error = state.pitch_rate - turning_up - turn * sin_bank / cos_bank
        acceleration = (wanted_airspeed - before) / dt
        throttle = (
            trim[4]
            + trim[5] * inverse_square
            + throttle_per_slope * (path + acceleration / STANDARD_GRAVITY)
            + throttle_sum
            - (tv * airspeed_error + ta * alpha_error + tq * rate_error + tp * pitch_error + th * height_error)
        )
        elevator = (
            trim[2]
            + trim[3] * inverse_square
            + elevator_sum
            - (ev * airspeed_error + ea * alpha_error + eq * rate_error + ep * pitch_error + eh * height_error)
        )
        throttle_change = -(tvs * airspeed_error + ths * height_error) * dt
        elevator_change = -(evs * airspeed_error + ehs * height_error) * dt

        # bank
        sideslip_error = state.sideslip - wanted_sideslip
        roll_error = state.roll_rate - reference_rate
        yaw_error = state.yaw_rate - turn
        bank_error = bank - reference
        aileron = (
            aileron_per_sideslip * wanted_sideslip
            + aileron_sum
            - (ab * sideslip_error + ap * roll_error + ar * yaw_error + ak * bank_error)
        )
        rudder = (
            rudder_per_sideslip * wanted_sideslip
            + rudder_sum
            - (rb * sideslip_error + rp * roll_error + rr * yaw_error + rk * bank_error)
        )
        aileron_change, rudder_change = -aks * bank_error * dt, -rks * bank_error * dt

        # a sum waits while its control is at a stop and the error would drive it further
        if 0.0 < throttle < 1.0 or (throttle <= 0.0) == (throttle_change > 0.0):
            throttle_sum += throttle_change
        if -1.0 < elevator < 1.0 or (elevator <= -1.0) == (elevator_change > 0.0):
            elevator_sum += elevator_change
        if -1.0 < aileron < 1.0 or (aileron <= -1.0) == (aileron_change > 0.0):
            aileron_sum += aileron_change
        if -1.0 < rudder < 1.0 or (rudder <= -1.0) == (rudder_change > 0.0):
            rudder_sum += rudder_change
        return (
            LoopState(
                *(reference, reference_rate, throttle_sum, elevator_sum, aileron_sum, rudder_sum),
                *(wind_north, wind_east, wanted_airspeed, slope, lookup),
            ),
            Controls(
                -1.0 if aileron < -1.0 else 1.0 if aileron > 1.0 else aileron,
                -1.0 if elevator < -1.0 else 1.0 if elevator > 1.0 else elevator,
                -1.0 if rudder < -1.0 else 1.0 if rudder > 1.0 else rudder,
                0.0 if throttle < 0.0 else 1.0 if throttle > 1.0 else throttle,
                wanted_flaps,
                gear,
            ),
        )


def _wind(state: AircraftState) -> tuple[float, float]:
    """Velocity over the ground minus velocity through the air, m/s (north, east)."""
    air_course = state.heading + state.sideslip
    level = state.airspeed - 0.5 * state.velocity_up * state.velocity_up / state.airspeed
    return state.velocity_north - level * math.cos(air_course), state.velocity_east - level * math.sin(air_course)
