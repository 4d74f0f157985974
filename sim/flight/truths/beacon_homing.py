"""Homing on a radio beacon under the radio-beacon law, also in wind."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Annotated, Any

import numpy as np

from aircraft.point_mass import PointMass
from aircraft.state import AircraftState
from autopilot.modes.radio_beacon import RadioBeacon
from autopilot.route import Leg, PathDeviation, Route
from sim.flight.record import RECORD_STEP, Flight
from sim.flight.truths._closed_loop import Closed, Plan, fly_closed, wandering_air

NOMINAL = RadioBeacon(6.0, 1.2, math.radians(20.0), math.radians(5.0))


@dataclass(frozen=True)
class BeaconHoming:
    """Towards a beacon from an angle off the prescribed direction [Vasylyev 2003, eq. (5)].

    The prescribed course is north; the beacon is at the origin. The law's gains and limits are not in the paper:
    the nominal ones are ours. In a crosswind the heading form of the law flies the homing curve.
    """

    law: Annotated[Any, "given"] = NOMINAL
    distance: Annotated[float, "m"] = 40000.0  # from the beacon at the start
    bearing: Annotated[Any, "rad"] = 0.1974  # off the direction, + right, 11.3 deg; an array is an ensemble
    speed: Annotated[float, "m/s"] = 100.0  # airspeed
    height: Annotated[float, "m"] = 600.0
    nearest: Annotated[float, "m"] = 2000.0  # to go where the flight ends
    wind: Annotated[tuple[float, float], "m/s"] = (0.0, 0.0)  # (north, east), the way the air moves
    acceleration_density: Annotated[float, "m2/s3"] = 0.1  # of the random acceleration, per horizontal axis
    roll_lag: Annotated[float, "s"] = 1.5
    roll_rate_limit: Annotated[float, "rad/s"] = math.radians(5.0)

    def __post_init__(self) -> None:
        if not self.distance > self.nearest > 0.0:
            raise ValueError("the homing must begin farther from the beacon than it ends")
        if not self.acceleration_density >= 0.0:
            raise ValueError("acceleration_density of a homing must not be negative")
        if not self.speed > math.hypot(*self.wind):
            raise ValueError("the speed of a homing must exceed the wind")
        if not np.all(np.abs(self.bearing) < 0.5 * math.pi):
            raise ValueError("the homing must begin within 90 deg of the prescribed direction")

    def fly(
        self, generator: np.random.Generator | None = None, runs: int | None = None, *, step: float = RECORD_STEP
    ) -> Flight:
        """One phase, homing; until every run is at ``nearest``. The aircraft starts on the prescribed course.

        Parameters
        ----------
        generator : of the random acceleration; None = none
        runs : flown side by side, as a last axis of the record; None = as many as the start has, one without that axis
        """
        route = Route((Leg((-self.distance, 0.0), (0.0, 0.0), self.speed, self.height),), self.wind)

        def plan(state: AircraftState, leg: Any, deviation: PathDeviation, phase: Any) -> Plan:
            return Plan(self.speed, self.height, 0.0, phase, deviation.distance_to_go < self.nearest)

        mass = PointMass(roll_lag=self.roll_lag, roll_rate_limit=self.roll_rate_limit)
        east = np.tan(np.asarray(self.bearing, float)) * self.distance
        east = np.broadcast_to(east, east.shape if runs is None else (runs,))
        heading = -math.asin(self.wind[1] / self.speed)  # crabbed, so that the track is the prescribed course
        body = mass.begin(
            -self.distance, east if east.ndim else float(east), self.height, heading, self.speed, wind=(*self.wind, 0.0)
        )
        slowest = self.speed - math.hypot(*self.wind)
        longest, air = 3.0 * self.distance / slowest, None
        if generator is not None:
            sigma = math.sqrt(self.acceleration_density / step)  # white, as far as a step can tell
            air = wandering_air(generator, sigma, step, step, longest, east.shape, self.wind)
        loop = Closed(mass, route, self.law, 0.0, plan, ("homing",), longest)
        return fly_closed(loop, body, 0, step, air, "arrived at the beacon")
