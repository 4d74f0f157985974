"""What flies: JSBSim with inner loops, or the papers' point mass; both take the autopilot's commands."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, NamedTuple, Protocol

from aircraft import model_files
from aircraft.actuators import actuator_bandwidth
from aircraft.air import Air
from aircraft.airframe import Airframe, Wind, load
from aircraft.errors import TrimError
from aircraft.linearise import linearise
from aircraft.point_mass import PointMass, PointMassState
from aircraft.runway import Runway
from aircraft.state import STANDARD_GRAVITY, AircraftState, Command, Controls, WheelControls
from aircraft.trim import trim
from autopilot.design import SCHEDULED, Designed, OperatingPoint, design, lateral_law
from autopilot.inner_loops import InnerLoops, LoopState
from autopilot.rollout import Rollout
from autopilot.route_loop import RouteLoop, lag_loop, route_loop, turning
from autopilot.swing_margin import steadied

LONGITUDINAL = ("airspeed", "angle_of_attack", "pitch_rate", "pitch", "height")
LIMITS = ("bank_limit", "cross_track_limit", "cross_track_rate_limit")
LOST = (0.0, 0.25, 0.5, 0.75)  # of the range of speeds of a configuration, where its upper end has no trim
LATERAL = ("sideslip", "roll_rate", "yaw_rate", "bank")


class Initial(NamedTuple):
    """Where a flight begins: steady on a course, in the wind that blows there."""

    north: float  # m from the threshold
    east: float
    height: float  # m
    course: float  # rad, over the ground
    airspeed: float  # m/s
    flight_path_angle: float = 0.0  # rad, through the air
    flaps: float = 0.0  # rad
    gear: float = 0.0
    leg: int = 0  # of the route


class AirframeChoice(NamedTuple):
    """What an airframe is built from: the aircraft model, its loading and the runway."""

    model: str | Path = "an26"
    mass: float | None = None  # kg; None = as the model says
    centre_of_gravity_mac: float | None = None  # share of the mean aerodynamic chord; None = as the model says
    factors: Mapping[str, float] | None = None  # of groups of coefficients, by the names that the aircraft declares
    runway: Runway | None = None
    air: Air | None = None  # None = the standard atmosphere
    rate: float | None = None  # Hz, of the equations of motion; None = as its data say
    repaired: bool = False  # what waits for another simulator is mended

    def load(self) -> Airframe:
        """A fresh aircraft; raises ``ModelError`` for anything that cannot be loaded."""
        return load(*self)

    def actuators(self) -> tuple[float, float]:
        """Bandwidths of aileron and rudder, rad/s; infinite where the model has no lag."""
        model = model_files.read(self.model)
        return actuator_bandwidth(model, "aileron"), actuator_bandwidth(model, "rudder")


class Vehicle(Protocol):
    """Anything that flies a command. A state is passed to the next step; one of JSBSim may be used only once."""

    def begin(self, initial: Initial, wind: Wind) -> Any:
        """State at the start."""
        ...

    def step(self, state: Any, command: Command, dt: float) -> Any:
        """State ``dt`` seconds later."""
        ...

    def read(self, state: Any) -> AircraftState:
        """What sensors and autopilot see."""
        ...

    def rollout(self, state: Any) -> Rollout | None:
        """What brings it to a stop after a landing; None = it has no wheels to roll on."""
        ...

    def roll(self, state: Any, controls: Controls, wheels: WheelControls, dt: float) -> Any:
        """State ``dt`` seconds later on the wheels; only where there is a ``rollout``."""
        ...


class JsbsimBody:
    """A flight in progress: the airframe, its loops and what was last read."""

    __slots__ = ("airframe", "inner_loops", "loops", "state", "wind")

    def __init__(
        self, airframe: Airframe, inner_loops: InnerLoops, loops: LoopState, state: AircraftState, wind: Wind | None
    ) -> None:
        self.airframe = airframe
        self.inner_loops = inner_loops
        self.loops = loops
        self.state = state
        self.wind = wind


@dataclass(frozen=True)
class JsbsimVehicle:
    """A JSBSim aircraft that flies commands through the inner loops of a design."""

    designed: Designed
    airframe: AirframeChoice

    def begin(self, initial: Initial, wind: Wind | None) -> JsbsimBody:
        """Load the aircraft afresh and trim it on its course."""
        airframe = self.airframe.load()
        steady = trim(
            airframe,
            initial.airspeed,
            initial.flight_path_angle,
            initial.height,
            initial.flaps,
            initial.gear,
        )
        moving, heading = _into_the_wind(initial, wind)
        state = airframe.begin(steady.at(initial.north, initial.east, initial.height, heading), moving)
        inner_loops = InnerLoops(self.designed)
        return JsbsimBody(airframe, inner_loops, inner_loops.begin(state), state, wind)

    def step(self, state: JsbsimBody, command: Command, dt: float) -> JsbsimBody:
        """Fly ``dt`` seconds, a multiple of the step of the equations of motion."""
        airframe = state.airframe
        state.loops, controls = state.inner_loops.step(state.loops, command, state.state, dt)
        airframe.step(controls, round(dt * airframe.rate), state.wind)
        state.state = airframe.read()
        return state

    def read(self, state: JsbsimBody) -> AircraftState:
        """What was read at the end of the last step."""
        return state.state

    def rollout(self, state: JsbsimBody) -> Rollout:
        """Steering by the geometry of the wheels, rudder by the inner loops at the airspeed now."""
        data, flown = state.airframe.data, state.state
        lateral = state.inner_loops.lookup(flown.equivalent_airspeed**-2.0, flown.flaps).lateral
        gains = dict(zip(SCHEDULED[-len(lateral) :], lateral, strict=True))
        return Rollout(
            data.wheelbase,
            data.wheel_track,
            data.steering_limit,
            gains["rudder_per_sideslip"],
            gains["rudder_yaw_rate"],
        )

    def roll(self, state: JsbsimBody, controls: Controls, wheels: WheelControls, dt: float) -> JsbsimBody:
        """Fly ``dt`` seconds with these controls, without the inner loops."""
        airframe = state.airframe
        airframe.set_wheels(wheels)
        airframe.step(controls, round(dt * airframe.rate), state.wind)
        state.state = airframe.read()
        return state


def _into_the_wind(initial: Initial, wind: Wind | None) -> tuple[tuple[float, float, float], float]:
    """Wind at the start, m/s (north, east, up), and the heading, rad, that keeps the course in it."""
    if wind is None:
        return (0.0, 0.0, 0.0), initial.course
    moving = wind.velocity(0.0, (initial.north, initial.east, initial.height), initial.airspeed)
    across = moving[1] * math.cos(initial.course) - moving[0] * math.sin(initial.course)
    return moving, initial.course - math.asin(max(-1.0, min(across / initial.airspeed, 1.0)))


class Configuration(NamedTuple):
    """A flap setting and the speeds between which it is flown."""

    flaps: float  # rad
    gear: float
    slowest: float  # m/s
    fastest: float
    path: float = 0.0  # rad, + up: where it is flown if it has no level flight


def designed(
    choice: AirframeChoice,
    configurations: Sequence[Configuration],
    *,
    speed: float,
    bank_limit: float,
    roll_rate_limit: float,
    height: float = 300.0,
) -> Designed:
    """Trim and linearise an aircraft at the speeds of its configurations and design its loops and its route law.

    ``speed`` (m/s) is flown on intercepts, ``bank_limit`` (rad) and ``roll_rate_limit`` (rad/s) limit the bank command,
    ``height`` (m) is where it is trimmed.
    """
    airframe = choice.load()
    points = []
    for configuration in configurations:
        points.append(_level_or_not(airframe, configuration, (configuration.slowest,), height))
        points.append(_level_or_not(airframe, configuration, _fast(configuration), height))
    gains, surfaces = design(points, speed, bank_limit), choice.actuators()
    loops = [route_loop(point, gains, surfaces, airframe.rate) for point in points]
    turns = loops[:2]  # they are flown in the first configuration
    gains = gains._replace(turning=sum(map(turning, turns)) / len(turns))
    gains = gains.with_law(lateral_law(gains.bank_bandwidth, speed, bank_limit, gains.turning))
    return steadied(gains, loops, speed, roll_rate_limit)


def leg_loop(
    choice: AirframeChoice, gains: Designed, airspeed: float, height: float, flaps: float, gear: float
) -> RouteLoop:
    """The loop that a design closes around an aircraft on a leg at an airspeed (m/s), height (m) and flaps (rad)."""
    airframe = choice.load()
    point = operating_point(airframe, airspeed, height, flaps, gear)
    return route_loop(point, gains, choice.actuators(), airframe.rate)


def operating_point(
    airframe: Airframe, airspeed: float, height: float, flaps: float, gear: float, path: float = 0.0
) -> OperatingPoint:
    """The linear model of an aircraft at an airspeed (m/s), height (m), flaps and flight-path angle (rad).

    The power lever is that of level flight: what the slope gives is added, be it beyond the stop.
    """
    steady = trim(airframe, airspeed, path, height, flaps, gear)
    linear = linearise(airframe, steady)
    per_slope = STANDARD_GRAVITY / float(linear.B[0, 0]) if path else 0.0  # of the power lever, per rad
    return OperatingPoint(
        flaps,
        gear,
        airspeed,
        airspeed * airframe.air.equivalent_share(height),
        steady.initial.angle_of_attack,
        steady.controls.elevator,
        steady.controls.throttle - per_slope * path,
        linear.part(LONGITUDINAL, ("throttle", "elevator")),
        linear.part(LATERAL, ("aileron", "rudder")),
    )


def _fast(configuration: Configuration) -> tuple[float, ...]:
    """The fastest speed of a configuration, and slower ones where that has no trim.

    An aircraft that enters the glide path fast slows down there: with flaps and gear out it may have no steady level
    flight at that speed.
    """
    width = configuration.fastest - configuration.slowest
    return tuple(configuration.fastest - lost * width for lost in LOST)


def _level_or_not(
    airframe: Airframe, configuration: Configuration, speeds: tuple[float, ...], height: float
) -> OperatingPoint:
    """The operating point at the first of the speeds that has level flight, else at the first that has it on the path.

    Flaps and gear that thin air has not the power for in level flight are flown on the glide path only.
    """
    _, gear, _, _, path = configuration
    for slope in dict.fromkeys((0.0, path)):
        for airspeed in speeds:
            try:
                return operating_point(airframe, airspeed, height, configuration.flaps, gear, slope)
            except TrimError as error:
                reason = error
    raise reason


@dataclass(frozen=True)
class PointMassVehicle:
    """The papers' point mass, which takes commands without inner loops."""

    body: PointMass = field(default_factory=PointMass)

    def begin(self, initial: Initial, wind: Wind | None) -> tuple[PointMassState, Wind | None]:
        """On its course in the wind that blows at the start."""
        moving, heading = _into_the_wind(initial, wind)
        state = self.body.begin(
            initial.north,
            initial.east,
            initial.height,
            heading,
            initial.airspeed,
            initial.flight_path_angle,
            initial.flaps,
            initial.gear,
            moving,
        )
        return state, wind

    def step(
        self, state: tuple[PointMassState, Wind | None], command: Command, dt: float
    ) -> tuple[PointMassState, Wind | None]:
        """Fly ``dt`` seconds in the wind that blew at the start."""
        body, wind = state
        moving = None if wind is None else wind.velocity(body.time, (body.north, body.east, body.height), body.airspeed)
        return self.body.step(body, command, dt, moving), wind

    def read(self, state: tuple[PointMassState, Wind | None]) -> AircraftState:
        """What sensors and autopilot see."""
        return self.body.read(state[0])

    def rollout(self, state: tuple[PointMassState, Wind | None]) -> None:
        """A point has no wheels."""


def designed_point_mass(
    speed: float, bank_limit: float, roll_rate_limit: float, body: PointMass | None = None
) -> Designed:
    """The route law for the point mass, whose bank follows with one lag; it has no loops to design.

    ``speed`` (m/s) is that of intercepts, ``bank_limit`` (rad) and ``roll_rate_limit`` (rad/s) limit the bank command.
    """
    lag = (body or PointMass()).roll_lag
    law = lateral_law(1.0 / lag, speed, bank_limit)
    gains = Designed(
        schedules=(),
        bank_bandwidth=1.0 / lag,
        reference_frequency=1.0 / lag,
        bank_per_sideslip=0.0,
        **{name: getattr(law, name) for name in ("k1", "k2", *LIMITS)},
    )
    return steadied(gains, [lag_loop(lag, speed)], speed, roll_rate_limit)
