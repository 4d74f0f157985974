"""Capture of a straight leg from the side, under the route law."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Annotated, Any, Literal

import numpy as np

from aircraft.point_mass import PointMass
from aircraft.state import STANDARD_GRAVITY, AircraftState, Command
from autopilot.modes.lateral_navigation import LateralNavigation
from autopilot.route import Leg, PathDeviation, Route
from sim.flight.record import RECORD_STEP, Flight
from sim.flight.truths._closed_loop import Closed, Plan, fly_closed, wandering_air
from sim.flight.truths._motion import recorded, state_of_motion

NOMINAL = LateralNavigation(math.radians(0.02), math.radians(0.5), math.radians(20.0), 1250.0, 60.0)

LONGEST_STEP = 0.1  # s; of the integration: the loop's time constant is 17 s


@dataclass(frozen=True)
class RouteCapture:
    """From beside a line onto it under a law [Vasylyev 2003, fig. 3].

    ``double_integrator`` is the paper's motion ``z'' = g bank`` (6), flown without lag; ``course`` turns the course at
    g tan(bank) / V and rolls with a lag. The law's gains and limits are not in the paper: the nominal ones are ours, of
    the size of real autopilots. The line runs north through the origin. The law is any function of the deviation; with
    ``offset`` the aircraft follows a parallel line, and so never converges to the one that trackers assume.
    """

    motion: Literal["double_integrator", "course"] = "course"
    law: Annotated[Any, "given"] = NOMINAL
    cross_track: Annotated[Any, "m"] = 5000.0  # at the start, + right; an array is an ensemble
    cross_track_rate: Annotated[Any, "m/s"] = 0.0
    offset: Annotated[float, "m"] = 0.0  # of the line that is really flown, + right
    speed: Annotated[float, "m/s"] = 100.0
    height: Annotated[float, "m"] = 600.0
    duration: Annotated[float, "s"] = 300.0
    acceleration_density: Annotated[float, "m2/s3"] = 0.1  # of the random acceleration
    roll_lag: Annotated[float, "s"] = 1.5  # of the course motion
    roll_rate_limit: Annotated[float, "rad/s"] = math.radians(5.0)

    def __post_init__(self) -> None:
        if self.motion not in ("double_integrator", "course"):
            raise ValueError(f"the motion of a route capture is 'double_integrator' or 'course', not '{self.motion}'")
        for name in ("speed", "height", "duration"):
            if not getattr(self, name) > 0.0:
                raise ValueError(f"{name} of a route capture must be above 0")
        if not self.acceleration_density >= 0.0:
            raise ValueError("acceleration_density of a route capture must not be negative")
        if not np.all(np.abs(self.cross_track_rate) < self.speed):
            raise ValueError("the cross-track rate of a route capture must be below its speed")

    def fly(
        self, generator: np.random.Generator | None = None, runs: int | None = None, *, step: float = RECORD_STEP
    ) -> Flight:
        """One phase, capture; as long as ``duration``.

        Parameters
        ----------
        generator : of the random acceleration, across the line or, in the course motion, on both axes; None = none
        runs : flown side by side, as a last axis of the record; None = as many as the start has, one without that axis
        """
        start, rate = np.broadcast_arrays(np.asarray(self.cross_track, float), np.asarray(self.cross_track_rate, float))
        if runs is not None:
            start, rate = np.broadcast_to(start, (runs,)), np.broadcast_to(rate, (runs,))
        route = Route((Leg((0.0, 0.0), (2.0 * self.speed * self.duration, 0.0), self.speed, self.height),))
        if self.motion == "double_integrator":
            return self._integrated(route, start, rate, generator, step)
        rows = math.floor(self.duration / step + 1e-9)

        def plan(state: AircraftState, leg: Any, deviation: PathDeviation, phase: Any) -> Plan:
            return Plan(self.speed, self.height, 0.0, phase, state.time > (rows - 0.5) * step)

        mass = PointMass(roll_lag=self.roll_lag, roll_rate_limit=self.roll_rate_limit)
        beside, sideways = (start, rate) if start.ndim else (float(start), float(rate))
        body = mass.begin(0.0, beside, self.height, np.arcsin(sideways / self.speed), self.speed)
        air = None
        if generator is not None:
            sigma = math.sqrt(self.acceleration_density / step)  # white, as far as a step can tell
            air = wandering_air(generator, sigma, step, step, self.duration + step, start.shape)
        loop = Closed(mass, route, self._bank, 0.0, plan, ("capture",), self.duration + step)
        return fly_closed(loop, body, 0, step, air, "flown for the time asked")

    def _bank(self, deviation: PathDeviation) -> Any:
        """What the law commands on the line that is flown."""
        if self.offset:
            deviation = deviation._replace(cross_track=deviation.cross_track - self.offset)
        return self.law(deviation)

    def _integrated(
        self, route: Route, z: Any, rate: Any, generator: np.random.Generator | None, step: float
    ) -> Flight:
        """The double integrator under the law of its own state, by Runge and Kutta."""
        rows, parts = math.floor(self.duration / step + 1e-9) + 1, math.ceil(step / LONGEST_STEP - 1e-9)
        dt = step / parts
        sigma = math.sqrt(self.acceleration_density / dt)
        record = np.zeros((4, rows, *z.shape))
        push: Any = np.zeros(z.shape)

        def force(z: Any, rate: Any) -> Any:
            return STANDARD_GRAVITY * self._bank(PathDeviation(z, rate, np.inf, 0.0, 0.0, 0.0)) + push

        for row in range(rows):
            record[:, row] = z, rate, self._bank(PathDeviation(z, rate, np.inf, 0.0, 0.0, 0.0)), push
            for _ in range(parts):
                if generator is not None:
                    push = sigma * generator.standard_normal(z.shape)
                z, rate = _runge_kutta(force, z, rate, dt)
        time = step * np.arange(rows)
        z, rate, bank, push = record
        along = np.broadcast_to(self.speed * np.reshape(time, (-1, *(1,) * (z.ndim - 1))), z.shape)
        felt = STANDARD_GRAVITY * bank + push
        state = state_of_motion(time, (along, z, self.height), (self.speed, rate, 0.0), (0.0, felt, 0.0), bank)
        level = np.broadcast_to(0.0, z.shape)
        command = Command(bank, level, state.height, level + self.speed, level, level, level)
        return recorded(state, command, route, 0, 0, ("capture",), "flown for the time asked")


def _runge_kutta(force: Any, z: Any, rate: Any, dt: float) -> tuple[Any, Any]:
    """One step of ``z'' = force(z, z')``."""
    v1, a1 = rate, force(z, rate)
    v2 = rate + 0.5 * dt * a1
    a2 = force(z + 0.5 * dt * v1, v2)
    v3 = rate + 0.5 * dt * a2
    a3 = force(z + 0.5 * dt * v2, v3)
    v4 = rate + dt * a3
    a4 = force(z + dt * v3, v4)
    return z + dt * (v1 + 2 * v2 + 2 * v3 + v4) / 6, rate + dt * (a1 + 2 * a2 + 2 * a3 + a4) / 6
