"""The papers' own kinematics behind the interface of the airframe: a point that banks, turns, climbs and changes speed.

It takes the commands of the autopilot directly. Floats or arrays of runs; its state is passed.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from typing import Annotated, Any, NamedTuple

import numpy as np

from aircraft.air import Air
from aircraft.state import MAIN_WHEEL, STANDARD_GRAVITY, AircraftState, Command

Real = Any


class PointMassState(NamedTuple):
    """One instant; rates are those at that instant under the command then in force."""

    time: Real  # s
    north: Real  # m from the threshold
    east: Real
    height: Real
    airspeed: Real  # m/s
    course: Real  # rad, of the path through the air
    flight_path_angle: Real  # rad, through the air
    bank: Real  # rad
    flaps: Real  # rad
    gear: Real
    acceleration: Real  # m/s2, along the path
    path_rate: Real  # rad/s, of the flight-path angle
    roll_rate: Real  # rad/s, of the bank
    wind: tuple[Real, Real, Real]  # m/s, (north, east, up)


@dataclass(frozen=True)
class PointMass:
    """Course rate a_n / V with a_n = g tan(bank), and lags and limits on what is commanded [Volovyk 2022, eq. (3)].

    Each channel follows its command with a first-order lag under a limit of its rate. A held height is approached
    through the vertical speed.
    """

    roll_lag: Annotated[float, "s"] = 0.8
    roll_rate_limit: Annotated[float, "rad/s"] = math.radians(10.0)
    path_lag: Annotated[float, "s"] = 0.8
    path_rate_limit: Annotated[float, "rad/s"] = math.radians(3.0)
    climb_limit: Annotated[float, "rad"] = math.radians(12.0)
    speed_lag: Annotated[float, "s"] = 2.0
    acceleration_limit: Annotated[float, "m/s2"] = 1.0
    height_lag: Annotated[float, "s"] = 5.0
    flap_rate: Annotated[float, "rad/s"] = math.radians(38.0 / 15.0)
    gear_rate: Annotated[float, "Hz"] = 0.1
    air: Annotated[Air, "given"] = field(
        default_factory=Air
    )  # of its equivalent airspeed; nothing else depends on the density

    def __post_init__(self) -> None:
        for name in ("roll_lag", "path_lag", "speed_lag", "height_lag"):
            if not getattr(self, name) > 0.0:
                raise ValueError(f"{name} must be positive")
        for name in ("roll_rate_limit", "path_rate_limit", "acceleration_limit", "flap_rate", "gear_rate"):
            if not getattr(self, name) > 0.0:
                raise ValueError(f"{name} must be positive")
        if not 0.0 < self.climb_limit < math.pi / 3.0:
            raise ValueError("climb_limit must lie between 0 and 60 deg")

    def begin(
        self,
        north: Real,
        east: Real,
        height: Real,
        heading: Real,
        airspeed: Real,
        flight_path_angle: Real = 0.0,
        flaps: Real = 0.0,
        gear: Real = 0.0,
        wind: tuple[Real, Real, Real] = (0.0, 0.0, 0.0),
    ) -> PointMassState:
        """Straight flight at constant speed; with arrays every field is broadcast to their common shape."""
        place, motion, rates = (0.0, north, east, height), (airspeed, heading, flight_path_angle, 0.0), (0.0, 0.0, 0.0)
        fields: tuple[Real, ...] = (*place, *motion, flaps, gear, *rates)
        if any(isinstance(field, np.ndarray) for field in fields):
            fields = tuple(np.array(field, dtype=float) for field in np.broadcast_arrays(*fields))
        else:
            fields = tuple(map(float, fields))
        return PointMassState._make((*fields, wind))

    def step(
        self, state: PointMassState, command: Command, dt: float, wind: tuple[Real, Real, Real] | None = None
    ) -> PointMassState:
        """State ``dt`` seconds later under a constant command.

        Lags are exact; course and position by the trapezoidal rule (1e-6 m per 30 Hz step). A new ``wind`` acts at once
        and adds to the path over the ground only.
        """
        batched = isinstance(state.bank, np.ndarray)
        pick = np if batched else math
        limit = _limit_array if batched else _limit
        bank, roll_rate = _lag(state.bank, command.bank, self.roll_lag, self.roll_rate_limit, dt, limit)
        airspeed, acceleration = _lag(
            state.airspeed, command.airspeed, self.speed_lag, self.acceleration_limit, dt, limit
        )
        wanted = self._path_angle(state, command, pick, limit)
        angle, path_rate = _lag(state.flight_path_angle, wanted, self.path_lag, self.path_rate_limit, dt, limit)
        turning = STANDARD_GRAVITY * pick.tan(state.bank) / state.airspeed
        turned = STANDARD_GRAVITY * pick.tan(bank) / airspeed
        course = state.course + 0.5 * dt * (turning + turned)
        north, east, up = _velocity(state.airspeed, state.course, state.flight_path_angle, state.wind, pick)
        wind = state.wind if wind is None else wind
        north_after, east_after, up_after = _velocity(airspeed, course, angle, wind, pick)
        flaps = state.flaps + limit(command.flaps - state.flaps, self.flap_rate * dt)
        gear = state.gear + limit(command.gear - state.gear, self.gear_rate * dt)
        return PointMassState(
            state.time + dt,
            state.north + 0.5 * dt * (north + north_after),
            state.east + 0.5 * dt * (east + east_after),
            state.height + 0.5 * dt * (up + up_after),
            airspeed,
            course,
            angle,
            bank,
            flaps,
            gear,
            acceleration,
            path_rate,
            roll_rate,
            wind,
        )

    def read(self, state: PointMassState) -> AircraftState:
        """As an airframe would give it; body axes are wind axes, so attitude is that of the path.

        The specific force is what this motion takes, exactly: a turn that is not quite coordinated, as g tan(bank) / V
        is while the path bends up or down, shows as a force to the right.
        """
        pick = np if isinstance(state.bank, np.ndarray) else math
        cos_path, sin_path = pick.cos(state.flight_path_angle), pick.sin(state.flight_path_angle)
        cos_bank, sin_bank = pick.cos(state.bank), pick.sin(state.bank)
        turning = STANDARD_GRAVITY * pick.tan(state.bank) / state.airspeed
        sideways = state.airspeed * cos_path * turning  # m/s2, horizontal, to the right of the path
        upwards = STANDARD_GRAVITY * cos_path + state.airspeed * state.path_rate  # normal to the path, in its plane
        north, east, up = _velocity(state.airspeed, state.course, state.flight_path_angle, state.wind, pick)
        nothing = 0.0 * state.bank
        on_ground = 1.0 * (state.height <= 0.0)
        return AircraftState(
            state.time,
            state.north,
            state.east,
            state.height,
            north,
            east,
            up,
            state.bank,
            state.flight_path_angle,
            state.course % (2.0 * math.pi),
            state.roll_rate - turning * sin_path,
            state.path_rate * cos_bank + turning * cos_path * sin_bank,
            turning * cos_path * cos_bank - state.path_rate * sin_bank,
            state.airspeed,
            state.airspeed * self.air.equivalent_share(state.height),
            nothing,
            nothing,
            state.acceleration + STANDARD_GRAVITY * sin_path,
            sideways * cos_bank - upwards * sin_bank,
            -upwards * cos_bank - sideways * sin_bank,
            nothing,
            nothing,
            nothing,
            nothing,
            state.flaps,
            state.gear,
            *(on_ground, MAIN_WHEEL * on_ground, MAIN_WHEEL * on_ground),
        )

    def _path_angle(self, state: PointMassState, command: Command, pick: Any, limit: Any) -> Real:
        """Flight-path angle through the air that follows the commanded one over the ground and holds the height."""
        north, east, _ = _velocity(state.airspeed, state.course, state.flight_path_angle, state.wind, pick)
        climb = pick.tan(command.flight_path_angle) * pick.sqrt(north * north + east * east)
        error = (command.height - state.height) / self.height_lag
        climb = climb + _where_held(error, pick) - state.wind[2]
        sine = limit(climb / state.airspeed, math.sin(self.climb_limit))
        return np.arcsin(sine) if pick is np else math.asin(sine)


def _velocity(airspeed: Real, course: Real, angle: Real, wind: tuple[Real, Real, Real], pick: Any) -> tuple[Real, ...]:
    """(north, east, up) over the ground."""
    level = airspeed * pick.cos(angle)
    return (
        level * pick.cos(course) + wind[0],
        level * pick.sin(course) + wind[1],
        airspeed * pick.sin(angle) + wind[2],
    )


def _lag(value: Real, wanted: Real, lag: float, rate_limit: float, dt: float, limit: Any) -> tuple[Real, Real]:
    """Value after ``dt``, and its rate then: exact for the lag, and for the limit as long as it lasts."""
    difference = wanted - value
    shift = limit(difference * (1.0 - math.exp(-dt / lag)), rate_limit * dt)
    return value + shift, limit((difference - shift) / lag, rate_limit)


def _limit(value: float, bound: float) -> float:
    return bound if value > bound else -bound if value < -bound else value


def _limit_array(value: Any, bound: Any) -> Any:
    return np.minimum(np.maximum(value, np.negative(bound)), bound)


def _where_held(error: Real, pick: Any) -> Real:
    """The height error, 0 where no height is held."""
    if pick is np:
        return np.where(np.isnan(error), 0.0, error)
    return 0.0 if error != error else error
