"""Bank -> aileron and rudder, path -> elevator, speed -> throttle: Command -> Controls.

Linear-quadratic loops about a feed-forward that knows the trim. Two signals are made inertial so that gusts do not
shake the controls: the angle of attack fed back is pitch minus path angle, and the airspeed is the speed through the
slow part of the wind.
"""

from __future__ import annotations

from dataclasses import dataclass
from itertools import pairwise
from math import asin, atan2, cos, hypot, sin, sqrt, tan
from typing import NamedTuple

from aircraft.state import STANDARD_GRAVITY, AircraftState, Command, Controls
from autopilot.design import SCHEDULED, Designed
from autopilot.route import pack

GUST_TIME = 5.0  # s; slower changes of the wind count as airspeed
AIRSPEED_ERROR, HEIGHT_ERROR = 8.0, 20.0  # m/s, m: larger errors are not acted upon harder
LOWEST, HIGHEST = 0.7, 1.4  # load factors that the feed-forward believes
TRIMS = 3  # of SCHEDULED come first: angle of attack, elevator, throttle
STALE = (
    0.01  # relative change of equivalent airspeed squared, or rad of flaps, after which the gains are looked up again
)
LONGITUDINAL = SCHEDULED.index("aileron_sideslip") - TRIMS
MOTION = slice(AircraftState._fields.index("height"), AircraftState._fields.index("sideslip") + 1)


class Lookup(NamedTuple):
    """The schedule at one equivalent airspeed and flap angle."""

    inverse_square: float  # s2/m2, of the equivalent airspeed
    flaps: float  # rad
    trim: tuple[float, ...]  # constant and slope of angle of attack, elevator, throttle
    longitudinal: tuple[float, ...]  # the throttle and elevator gains of SCHEDULED
    lateral: tuple[float, ...]  # its aileron and rudder gains


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
        over_ground = hypot(state.velocity_north, state.velocity_east)
        slope = atan2(state.velocity_up, over_ground)
        level = state.airspeed * cos(asin(state.velocity_up / state.airspeed))
        s = LoopState(
            *(state.bank, 0.0, 0.0, 0.0, 0.0, 0.0),
            state.velocity_north - level * cos(state.heading + state.sideslip),
            state.velocity_east - level * sin(state.heading + state.sideslip),
            state.airspeed,
            slope,
            self.lookup(state.equivalent_airspeed**-2.0, state.flaps),
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
        """The schedule at 1/equivalent airspeed^2 (s2/m2) and flaps (rad)."""
        schedules = self.designed.schedules
        low, high, share = schedules[0], schedules[0], 0.0
        for below, above in pairwise(schedules):
            if flaps > below.flaps:
                low, high = below, above
                share = min((flaps - below.flaps) / (above.flaps - below.flaps), 1.0)
        constant = [a + share * (b - a) for a, b in zip(low.constant, high.constant, strict=True)]
        slope = [a + share * (b - a) for a, b in zip(low.slope, high.slope, strict=True)]
        trim = (constant[0], slope[0], constant[1], slope[1], constant[2], slope[2])
        gains = tuple(c + s * inverse_square for c, s in zip(constant[TRIMS:], slope[TRIMS:], strict=True))
        return Lookup(inverse_square, flaps, trim, gains[:LONGITUDINAL], gains[LONGITUDINAL:])

    def step(self, s: LoopState, command: Command, state: AircraftState, dt: float) -> tuple[LoopState, Controls]:
        """Controls for the next ``dt`` seconds."""
        (
            reference,
            reference_rate,
            throttle_sum,
            elevator_sum,
            aileron_sum,
            rudder_sum,
            wind_north,
            wind_east,
            before,
            old,
            lookup,
        ) = s
        wanted_bank, slope, wanted_height, wanted_airspeed, wanted_flaps, gear, wanted_sideslip = command
        (
            height,
            velocity_north,
            velocity_east,
            climb,
            bank,
            pitch,
            heading,
            roll_rate,
            pitch_rate,
            yaw_rate,
            measured,
            equivalent,
            _,
            sideslip,
        ) = state[MOTION]
        wanted = wanted_airspeed * equivalent / measured  # equivalent: wing and controls feel the dynamic pressure
        inverse_square, flaps = 1.0 / (wanted * wanted), state.flaps
        known, known_flaps, trim, longitudinal, lateral = lookup
        if abs(inverse_square - known) > STALE * known or abs(flaps - known_flaps) > STALE:
            lookup = self.lookup(inverse_square, flaps)
            _, _, trim, longitudinal, lateral = lookup
        # first letter the control, then what it answers to; a last s for the sum
        alpha_0, alpha_1, elevator_0, elevator_1, throttle_0, throttle_1 = trim
        throttle_per_slope, tv, ta, tq, tp, th, tvs, ths, ev, ea, eq, ep, eh, evs, ehs = longitudinal
        ab, ap, ar, ak, aks, rb, rp, rr, rk, rks, aileron_per_sideslip, rudder_per_sideslip = lateral

        cos_bank, sin_bank = cos(bank), sin(bank)
        over_ground = sqrt(velocity_north * velocity_north + velocity_east * velocity_east)
        level = measured - 0.5 * climb * climb / measured
        share = dt / GUST_TIME
        wind_north += (velocity_north - level * cos(heading + sideslip) - wind_north) * share
        wind_east += (velocity_east - level * sin(heading + sideslip) - wind_east) * share
        air_north, air_east = velocity_north - wind_north, velocity_east - wind_east
        airspeed = sqrt(air_north * air_north + air_east * air_east + climb * climb)

        frequency = self.designed.reference_frequency
        reference_rate += frequency * (frequency * (wanted_bank - reference) - 2.0 * reference_rate) * dt
        reference += reference_rate * dt

        # path: what the trim needs at the wanted load factor, and the errors from it
        turning_up = (slope - old) / dt
        load_factor = 1.0 / cos(reference) + over_ground * turning_up / STANDARD_GRAVITY
        load_factor = LOWEST if load_factor < LOWEST else HIGHEST if load_factor > HIGHEST else load_factor
        inverse_square *= load_factor
        alpha = alpha_0 + alpha_1 * inverse_square
        path = over_ground * tan(slope) / airspeed  # rad, through the air
        turn = STANDARD_GRAVITY / airspeed * sin_bank
        v = airspeed - wanted_airspeed
        v = -AIRSPEED_ERROR if v < -AIRSPEED_ERROR else AIRSPEED_ERROR if v > AIRSPEED_ERROR else v
        h = height - wanted_height
        h = -HEIGHT_ERROR if h < -HEIGHT_ERROR else HEIGHT_ERROR if h > HEIGHT_ERROR else h
        a = (pitch - climb / airspeed) / cos_bank - alpha
        q = pitch_rate - turning_up - turn * sin_bank / cos_bank
        p = pitch - path - alpha * cos_bank
        power = path + (wanted_airspeed - before) / dt / STANDARD_GRAVITY
        throttle = throttle_0 + throttle_1 * inverse_square + throttle_per_slope * power + throttle_sum
        throttle -= tv * v + ta * a + tq * q + tp * p + th * h
        elevator = elevator_0 + elevator_1 * inverse_square + elevator_sum
        elevator -= ev * v + ea * a + eq * q + ep * p + eh * h

        b = sideslip - wanted_sideslip
        k = bank - reference
        p = roll_rate - reference_rate
        r = yaw_rate - turn
        aileron = aileron_per_sideslip * wanted_sideslip + aileron_sum - (ab * b + ap * p + ar * r + ak * k)
        rudder = rudder_per_sideslip * wanted_sideslip + rudder_sum - (rb * b + rp * p + rr * r + rk * k)

        # a sum waits while its control is at a stop and the error would drive it further
        change = (tvs * v + ths * h) * dt
        if 0.0 <= throttle <= 1.0:
            throttle_sum -= change
        else:
            stop = 1.0 if throttle > 1.0 else 0.0
            throttle_sum -= change if (change > 0.0) is (throttle > stop) else 0.0
            throttle = stop
        change = (evs * v + ehs * h) * dt
        if -1.0 <= elevator <= 1.0:
            elevator_sum -= change
        else:
            stop = 1.0 if elevator > 1.0 else -1.0
            elevator_sum -= change if (change > 0.0) is (elevator > stop) else 0.0
            elevator = stop
        change = aks * k * dt
        if -1.0 <= aileron <= 1.0:
            aileron_sum -= change
        else:
            stop = 1.0 if aileron > 1.0 else -1.0
            aileron_sum -= change if (change > 0.0) is (aileron > stop) else 0.0
            aileron = stop
        change = rks * k * dt
        if -1.0 <= rudder <= 1.0:
            rudder_sum -= change
        else:
            stop = 1.0 if rudder > 1.0 else -1.0
            rudder_sum -= change if (change > 0.0) is (rudder > stop) else 0.0
            rudder = stop
        return (
            pack(
                LoopState,
                (
                    reference,
                    reference_rate,
                    throttle_sum,
                    elevator_sum,
                    aileron_sum,
                    rudder_sum,
                    wind_north,
                    wind_east,
                    wanted_airspeed,
                    slope,
                    lookup,
                ),
            ),
            pack(Controls, (aileron, elevator, rudder, throttle, wanted_flaps, gear)),
        )
