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
from sim.flight import RECORD_STEP, Flight
from sim.truths._closed_loop import Closed, Plan, fly_closed

NOMINAL = RadioBeacon(6.0, 1.2, math.radians(20.0), math.radians(5.0))


@dataclass(frozen=True)
class BeaconHoming:
    """Towards a beacon from an angle off the prescribed direction [Vasylyev 2003, eq. (5)].

    The prescribed course is north; the beacon stands at the origin. The law's gains and limits are not in the paper:
    the nominal ones are ours. In a crosswind the heading form of the law flies the homing curve.
    """

    law: Annotated[Any, "given"] = NOMINAL
    distance: Annotated[float, "m"] = 40000.0  # from the beacon at the start
    bearing: Annotated[Any, "rad"] = 0.1974  # off the direction, + right, 11.3 deg; an array is an ensemble
    speed: Annotated[float, "m/s"] = 100.0  # airspeed
    height: Annotated[float, "m"] = 600.0
    nearest: Annotated[float, "m"] = 2000.0  # to go where the flight ends
    wind: Annotated[tuple[float, float], "m/s"] = (0.0, 0.0)  # (north, east), the way the air moves
    roll_lag: Annotated[float, "s"] = 1.5
    roll_rate_limit: Annotated[float, "rad/s"] = math.radians(5.0)

    def __post_init__(self) -> None:
        if not self.distance > self.nearest > 0.0:
            raise ValueError("the homing must begin farther from the beacon than it ends")
        if not self.speed > math.hypot(*self.wind):
            raise ValueError("the speed of a homing must exceed the wind")
        if not np.all(np.abs(self.bearing) < 0.5 * math.pi):
            raise ValueError("the homing must begin within 90 deg of the prescribed direction")

    def fly(self, step: float = RECORD_STEP) -> Flight:
        """One phase, homing; until every run is at ``nearest``. The aircraft starts on the prescribed course."""
        route = Route((Leg((-self.distance, 0.0), (0.0, 0.0), self.speed, self.height),), self.wind)

        def plan(state: AircraftState, leg: Any, deviation: PathDeviation, phase: Any) -> Plan:
            return Plan(self.speed, self.height, 0.0, phase, deviation.distance_to_go < self.nearest)

        mass = PointMass(roll_lag=self.roll_lag, roll_rate_limit=self.roll_rate_limit)
        east = np.tan(self.bearing) * self.distance
        heading = -math.asin(self.wind[1] / self.speed)  # crabbed, so that the track is the prescribed course
        body = mass.begin(-self.distance, east, self.height, heading, self.speed, wind=(*self.wind, 0.0))
        slowest = self.speed - math.hypot(*self.wind)
        loop = Closed(mass, route, self.law, self.law.bank_limit, plan, ("homing",), 3.0 * self.distance / slowest)
        return fly_closed(loop, body, 0, step, reason="arrived at the beacon")
