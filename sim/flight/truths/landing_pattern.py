"""The landing pattern from the base leg to the touchdown, with its changes of speed and a random acceleration."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Annotated, Any, Literal

import numpy as np

from aircraft.point_mass import PointMass
from aircraft.state import AircraftState
from autopilot.landing import Landing
from autopilot.modes.lateral_navigation import LateralNavigation
from autopilot.route import Leg, PathDeviation, Route
from sim.flight.record import RECORD_STEP, Flight
from sim.flight.truths._closed_loop import Closed, Plan, choose, fly_closed, wandering_air

PHASES = ("base", "final_turn", "final", "glide", "ground")
BASE, FINAL_TURN, FINAL, GLIDE, GROUND = range(len(PHASES))
LANDED = 0.5  # m; lower is on the ground
SETTLED_TRACK = math.radians(5.0)  # of the course, within which the turn is over
SETTLED_CROSS_TRACK = 100.0  # m


@dataclass(frozen=True)
class LandingPattern:
    """Base leg, turn, final, deceleration at the glide path, touchdown [Volovyk 2022, experiment].

    Speeds, bank, glide path and scan period of the random acceleration are the paper's; the geometry of the base leg,
    the deceleration, the lags and the size of the acceleration are ours. Turn and glide path begin where the run's own
    position says so. Other entry directions turn by ``turn`` onto final. Final runs north to the aiming point.
    """

    side: Literal["left", "right"] = "left"
    turn: Annotated[float, "rad"] = 0.5 * math.pi  # onto final
    entry: Annotated[float, "m"] = 7000.0  # from where the flight begins to the extended centreline
    distance: Annotated[float, "m"] = 13800.0  # from there to the aiming point
    aiming_point: Annotated[float, "m"] = 300.0  # past the threshold
    height: Annotated[float, "m"] = 400.0
    glide_path: Annotated[float, "rad"] = math.radians(2.0 + 40.0 / 60.0)
    entry_speed: Annotated[float, "m/s"] = 72.0
    turn_speed: Annotated[float, "m/s"] = 69.0
    approach_speed: Annotated[float, "m/s"] = 58.0
    deceleration: Annotated[float, "m/s2"] = 0.5
    bank_limit: Annotated[float, "rad"] = math.radians(15.0)
    k1: Annotated[float, "rad/m"] = 0.00253
    k2: Annotated[float, "rad/(m/s)"] = 0.0289
    cross_track_limit: Annotated[float, "m"] = 412.0
    roll_lag: Annotated[float, "s"] = 1.5
    roll_rate_limit: Annotated[float, "rad/s"] = math.radians(5.0)
    acceleration_sigma: Annotated[float, "m/s2"] = 0.1  # per horizontal axis, of the air; 0 = none
    acceleration_period: Annotated[float, "s"] = 0.7  # over which it is constant

    def __post_init__(self) -> None:
        if self.side not in ("left", "right"):
            raise ValueError(f"the side of a pattern is 'left' or 'right', not '{self.side}'")
        if not 0.0 <= self.turn < math.pi:
            raise ValueError(
                f"the turn onto final must lie between 0 and 180 deg, not {math.degrees(self.turn):.0f} deg"
            )
        lengths = ("entry", "distance", "height", "glide_path")
        for name in (*lengths, "approach_speed", "deceleration", "acceleration_period"):
            if not getattr(self, name) > 0.0:
                raise ValueError(f"{name} of the landing pattern must be above 0")
        if not self.acceleration_sigma >= 0.0:
            raise ValueError("acceleration_sigma of the landing pattern must not be negative")

    @property
    def route(self) -> Route:
        """Entry leg and final."""
        sign = 1.0 if self.side == "right" else -1.0
        course = -sign * self.turn
        corner = (self.aiming_point - self.distance, 0.0)
        start = (corner[0] - self.entry * math.cos(course), corner[1] - self.entry * math.sin(course))
        return Route(
            (
                Leg(start, corner, self.entry_speed, self.height),
                Leg(corner, (self.aiming_point, 0.0), self.turn_speed, self.height),
            ),
            time_to_roll=self.roll_lag + 0.5 * self.bank_limit / self.roll_rate_limit,
        )

    def fly(
        self, generator: np.random.Generator | None = None, runs: int | None = None, *, step: float = RECORD_STEP
    ) -> Flight:
        """Phases base, final_turn, final, glide, ground.

        Parameters
        ----------
        generator : of the random acceleration; None = none
        runs : flown side by side, as a last axis of the record; None = one, without that axis
        """
        route = self.route
        route.check_turns(self.bank_limit)
        rate_limit = 1.1 * (self.k1 * self.cross_track_limit + self.bank_limit) / self.k2
        law = LateralNavigation(self.k1, self.k2, self.bank_limit, self.cross_track_limit, rate_limit)
        landing = Landing(approach_speed=self.approach_speed, glide_path=self.glide_path)
        bend = landing.bend(self.turn_speed)
        slope = math.tan(self.glide_path)
        glide_entry = self.height / slope + 0.5 * bend

        def plan(state: AircraftState, leg: Any, deviation: PathDeviation, phase: Any) -> Plan:
            to_go = deviation.distance_to_go
            settled = (abs(deviation.track_error) < SETTLED_TRACK) & (abs(deviation.cross_track) < SETTLED_CROSS_TRACK)
            reached = choose(leg == 1, choose(settled, FINAL, FINAL_TURN), BASE)
            reached = choose((leg == 1) & (to_go < glide_entry), GLIDE, reached)
            reached = choose((leg == 1) & (state.height < LANDED), GROUND, reached)
            phase = choose(reached > phase, reached, phase)
            into = glide_entry - to_go  # m since the path began to bend down
            bending = into < bend
            height = choose(bending, self.height - slope * into * into / (2.0 * bend), to_go * slope)
            angle = choose(bending, -slope * into / bend, -self.glide_path)  # of a path so flat that tan is the angle
            gliding = phase == GLIDE
            return Plan(
                choose(phase >= GLIDE, self.approach_speed, choose(leg == 1, self.turn_speed, self.entry_speed)),
                choose(gliding, height, choose(phase == GROUND, 0.0, self.height)),
                choose(gliding, angle, 0.0),
                phase,
                phase == GROUND,
            )

        mass = PointMass(
            roll_lag=self.roll_lag,
            roll_rate_limit=self.roll_rate_limit,
            speed_lag=1.0,
            acceleration_limit=self.deceleration,
            height_lag=3.0,
        )
        course, legs = route.legs[0].course, 0 if runs is None else np.zeros(runs, int)
        body = mass.begin(*route.legs[0].start, self.height, course, self.entry_speed)
        if runs is not None:
            north, east, height = (np.full(runs, value) for value in body[1:4])
            body = mass.begin(north, east, height, course, self.entry_speed)
        longest = 2.0 * (self.entry + self.distance) / self.approach_speed
        loop = Closed(mass, route, law, self.bank_limit, plan, PHASES, longest)
        shape = () if runs is None else (runs,)
        air = None
        if generator is not None:
            air = wandering_air(generator, self.acceleration_sigma, self.acceleration_period, step, longest, shape)
        return fly_closed(loop, body, legs, step, air, "touchdown of every run")
