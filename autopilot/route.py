"""Legs, routes and the deviations from them; (north, east) in metres from the runway threshold."""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from typing import Any, NamedTuple, overload

import numpy as np

from aircraft.state import STANDARD_GRAVITY

Real = Any

pack = tuple.__new__  # a named tuple in a third of the time, for what is built at every step of a flight
STRAIGHT = 1e-6  # sine of a turn below which two legs are one line
CONTIGUOUS = 1.0  # m, how far apart the end of a leg and the start of the next may lie


class PathDeviation(NamedTuple):
    """Where a point is relative to one leg; floats or arrays, + right of the course."""

    cross_track: Real  # m
    cross_track_rate: Real  # m/s
    distance_to_go: Real  # m along the leg to its end
    bearing_error: Real  # rad, bearing to the leg's end minus course: negative when right of the leg
    track_error: Real  # rad, ground track minus course
    heading_error: Real  # rad, heading minus course; equals track_error where no heading is known


class ArrayDeviation:
    """`PathDeviation` of many points; the angles are worked out when they are asked for, which few laws do."""

    __slots__ = ("_along_rate", "_off_course", "cross_track", "cross_track_rate", "distance_to_go")

    def __init__(self, cross_track: Any, cross_track_rate: Any, to_go: Any, along_rate: Any, off_course: Any) -> None:
        self.cross_track = cross_track
        self.cross_track_rate = cross_track_rate
        self.distance_to_go = to_go
        self._along_rate = along_rate
        self._off_course = off_course

    @property
    def bearing_error(self) -> Any:
        """rad, as in `PathDeviation`."""
        return np.arctan2(-self.cross_track, self.distance_to_go)

    @property
    def track_error(self) -> Any:
        """rad."""
        return np.arctan2(self.cross_track_rate, self._along_rate)

    @property
    def heading_error(self) -> Any:
        """rad; the track error where no heading is known."""
        if self._off_course is None:
            return self.track_error
        return np.mod(self._off_course + np.pi, 2 * np.pi) - np.pi

    def softened(self, share: float) -> ArrayDeviation:
        """What makes of a law one that is ``share`` as quick and damped alike: its gains by share^2 and by share."""
        place, rate = share**2 * self.cross_track, share * self.cross_track_rate
        return ArrayDeviation(place, rate, self.distance_to_go, self._along_rate, None)

    def of_hypotheses(self, which: slice, batch: int) -> ArrayDeviation:
        """That of some hypotheses, of an axis before ``batch`` axes of runs; its angles are worked out alone."""
        among = (..., which, *(slice(None),) * batch)
        off_course = None if self._off_course is None else self._off_course[among]
        return ArrayDeviation(
            self.cross_track[among],
            self.cross_track_rate[among],
            self.distance_to_go[among],
            self._along_rate[among],
            off_course,
        )


class Turn(NamedTuple):
    """The turn from one leg to the next at constant airspeed and bank."""

    entry: float  # m before the corner at which the bank is commanded
    exit: float  # m behind the corner at which the turn ends on the new leg
    duration: float  # s


@dataclass(frozen=True)
class Leg:
    """A straight leg between two points, flown at a speed and a height."""

    start: tuple[float, float]  # m, (north, east)
    end: tuple[float, float]
    speed: float  # m/s, airspeed
    height: float  # m above the threshold

    def __post_init__(self) -> None:
        numbers = (*self.start, *self.end, self.speed, self.height)
        if not all(math.isfinite(number) for number in numbers):
            raise ValueError(f"a leg needs finite points, speed and height, not {numbers}")
        if self.length <= 0.0:
            raise ValueError(f"a leg needs two different points, not {self.start} twice")
        if self.speed <= 0.0:
            raise ValueError(f"the speed of a leg must be positive, not {self.speed} m/s")

    @property
    def direction(self) -> tuple[float, float]:
        """Unit vector (north, east) of the course."""
        return (self.end[0] - self.start[0]) / self.length, (self.end[1] - self.start[1]) / self.length

    @property
    def course(self) -> float:
        """rad, clockwise from north."""
        return math.atan2(self.end[1] - self.start[1], self.end[0] - self.start[0])

    @property
    def length(self) -> float:
        """m."""
        return math.hypot(self.end[0] - self.start[0], self.end[1] - self.start[1])


@dataclass(frozen=True)
class Route:
    """Legs in the order in which they are flown, and the wind for which the turns are planned."""

    legs: tuple[Leg, ...]
    wind: tuple[float, float] = (0.0, 0.0)  # m/s, the way the air moves, (north, east)
    time_to_roll: float = 2.8  # s, by which the turn lags behind its plan; see Designed.time_to_roll
    turning: float = 1.0  # share of g tan(bank) that turns the path; see Designed.turning
    chart: tuple[tuple[int, float, float], ...] | None = None  # see charted_speed; None = it shows no speeds
    _lines: tuple[tuple[float, ...], ...] = field(init=False, repr=False, compare=False)  # end, direction, course
    _table: Any = field(init=False, repr=False, compare=False)  # the same (5, legs)
    _speeds: Any = field(init=False, repr=False, compare=False)  # (legs,)
    _near: dict[tuple[float, float], Any] = field(init=False, repr=False, compare=False)  # see _near_turns

    def __post_init__(self) -> None:
        if not self.legs:
            raise ValueError("a route needs at least one leg")
        for number, (leg, following) in enumerate(zip(self.legs, self.legs[1:], strict=False)):
            if math.dist(leg.end, following.start) > CONTIGUOUS:
                raise ValueError(f"leg {number + 1} of the route must start where leg {number} ends")
        slowest = min(leg.speed for leg in self.legs)
        if math.hypot(*self.wind) >= slowest:
            raise ValueError(
                f"the wind of {math.hypot(*self.wind):.1f} m/s is not less than {slowest:.1f} m/s, the slowest leg"
            )
        object.__setattr__(self, "_lines", tuple((*leg.end, *leg.direction, leg.course) for leg in self.legs))
        object.__setattr__(self, "_table", np.array(self._lines).T)
        object.__setattr__(self, "_speeds", np.array([leg.speed for leg in self.legs]))
        object.__setattr__(self, "_near", {})

    @overload
    def deviation(self, leg: int, position: Any, velocity: Any, heading: Any = None) -> PathDeviation: ...

    @overload
    def deviation(self, leg: Any, position: Any, velocity: Any, heading: Any = None) -> ArrayDeviation: ...

    def deviation(self, leg: Any, position: Any, velocity: Any, heading: Any = None) -> PathDeviation | ArrayDeviation:
        """Deviation from ``leg`` (an int, or an int array with one leg per run).

        ``position`` and ``velocity`` start with their north and east components, floats or arrays of shape (*B).
        """
        north, east, velocity_north, velocity_east = position[0], position[1], velocity[0], velocity[1]
        if isinstance(leg, int) and isinstance(north, float):
            return self.deviation_at(leg, north, east, velocity_north, velocity_east, heading)
        return self._deviations(leg, north, east, velocity_north, velocity_east, heading)

    def deviation_at(
        self, leg: int, north: float, east: float, velocity_north: float, velocity_east: float, heading: float | None
    ) -> PathDeviation:
        """Deviation of one point, as the autopilot asks for it at every step."""
        end_north, end_east, along_north, along_east, course = self._lines[leg]
        north -= end_north
        east -= end_east
        cross_track = east * along_north - north * along_east
        distance_to_go = -north * along_north - east * along_east
        cross_track_rate = velocity_east * along_north - velocity_north * along_east
        track_error = math.atan2(cross_track_rate, velocity_north * along_north + velocity_east * along_east)
        bearing_error = math.atan2(-cross_track, distance_to_go)
        heading_error = track_error if heading is None else math.remainder(heading - course, math.tau)
        return pack(
            PathDeviation,
            (cross_track, cross_track_rate, distance_to_go, bearing_error, track_error, heading_error),
        )

    def _deviations(
        self, leg: Any, north: Any, east: Any, rate_north: Any, rate_east: Any, heading: Any
    ) -> ArrayDeviation:
        """The same for arrays."""
        end_north, end_east, along_north, along_east, course = self._table[:, leg]
        north = north - end_north
        east = east - end_east
        return ArrayDeviation(
            east * along_north - north * along_east,
            rate_east * along_north - rate_north * along_east,
            -north * along_north - east * along_east,
            rate_north * along_north + rate_east * along_east,
            None if heading is None else heading - course,
        )

    def turn(self, leg: int, airspeed: Any, bank_limit: Any) -> Turn:
        """Where the turn from ``leg`` to the next begins and ends.

        At constant airspeed V and bank the turn is a circle of radius V^2/(g tan bank) in the air mass, and the air
        mass drifts: the entry is the point from which the drifted arc ends on the new leg. In calm air it is
        ``time_to_roll V + R tan(turn/2)`` before the corner. Floats or arrays.
        """
        _, _, north_1, east_1, _ = self._lines[leg]
        _, _, north_2, east_2, _ = self._lines[leg + 1]
        wind_north, wind_east = self.wind
        sine = north_1 * east_2 - east_1 * north_2  # of the turn, + right
        if abs(sine) < STRAIGHT and north_1 * north_2 + east_1 * east_2 > 0.0:
            return Turn(0.0 * airspeed, 0.0 * airspeed, 0.0 * airspeed)
        side = 1.0 if sine > 0.0 else -1.0
        drift_1 = (wind_east * north_1 - wind_north * east_1) / airspeed  # sines of the drift angles, + right
        drift_2 = (wind_east * north_2 - wind_north * east_2) / airspeed
        nose_1, nose_2 = (1.0 - drift_1 * drift_1) ** 0.5, (1.0 - drift_2 * drift_2) ** 0.5
        # unit vectors of the air velocity that keeps each course: along the leg nose, across it -drift
        heading_north_1, heading_east_1 = north_1 * nose_1 + east_1 * drift_1, east_1 * nose_1 - north_1 * drift_1
        heading_north_2, heading_east_2 = north_2 * nose_2 + east_2 * drift_2, east_2 * nose_2 - north_2 * drift_2
        cross = heading_north_1 * heading_east_2 - heading_east_1 * heading_north_2
        dot = heading_north_1 * heading_north_2 + heading_east_1 * heading_east_2
        acceleration = self.turning * STANDARD_GRAVITY * _tan(bank_limit)
        duration = _arctan2(side * cross, dot) % math.tau * airspeed / acceleration
        radius = side * airspeed * airspeed / acceleration
        # the arc, from the difference of the two right-hand normals, plus the way of the air
        arc_north = radius * (heading_east_2 - heading_east_1) + wind_north * duration
        arc_east = radius * (heading_north_1 - heading_north_2) + wind_east * duration
        straight = (arc_north * east_2 - arc_east * north_2) / sine  # m before the corner where the arc must begin
        past = arc_north * north_2 + arc_east * east_2 - straight * (north_1 * north_2 + east_1 * east_2)
        return Turn(straight + self.time_to_roll * self.ground_speed(leg, airspeed), past, duration)

    def charted_speed(self, leg: Any, distance_to_go: Any) -> Any:
        """Airspeed, m/s, that the chart shows so far (m) before the end of each run's leg (an int array).

        That of the leg, or another one from a point of it on: ``chart`` has the leg, the point as m to go, and the m/s.
        """
        speed = self._speeds[leg]
        for number, begins, shown in self.chart or ():
            speed = np.where((leg == number) & (distance_to_go <= begins), shown, speed)
        return speed

    def ground_speed(self, leg: int, airspeed: Any) -> Any:
        """Speed over the ground along a leg that is held against the wind, m/s."""
        _, _, north, east, _ = self._lines[leg]
        across = self.wind[1] * north - self.wind[0] * east
        return (airspeed * airspeed - across * across) ** 0.5 + self.wind[0] * north + self.wind[1] * east

    def sequence(self, leg: Any, position: Any, velocity: Any, bank_limit: Any) -> Any:
        """The leg to fly next: ``leg``, or ``leg + 1`` once its turn is due."""
        north, east, velocity_north, velocity_east = position[0], position[1], velocity[0], velocity[1]
        if isinstance(leg, int) and isinstance(north, float):
            if leg + 1 >= len(self.legs):
                return leg
            end_north, end_east, along_north, along_east, _ = self._lines[leg]
            to_go = (end_north - north) * along_north + (end_east - east) * along_east
            airspeed = math.hypot(velocity_north - self.wind[0], velocity_east - self.wind[1])
            return leg + 1 if to_go < self.turn(leg, max(airspeed, self._least_airspeed), bank_limit).entry else leg
        end_north, end_east, along_north, along_east, _ = self._table[:, leg]
        to_go = (end_north - north) * along_north + (end_east - east) * along_east
        airspeed = np.hypot(np.subtract(velocity_north, self.wind[0]), np.subtract(velocity_east, self.wind[1]))
        fastest = float(np.fmax.reduce(airspeed, axis=None, initial=self._least_airspeed))  # lost runs are NaN
        near = (
            to_go < self._near_turns(10.0 * math.ceil(fastest / 10.0) if fastest < 1e3 else math.inf, bank_limit)[leg]
        )
        if not near.any():
            return leg
        airspeed = np.maximum(airspeed, self._least_airspeed)
        leg = following = np.broadcast_to(leg, near.shape)
        for number in np.unique(leg[near]).tolist():
            due = near & (leg == number) & (to_go < self.turn(number, airspeed, bank_limit).entry)
            following = np.where(due, number + 1, following)
        return following

    def _near_turns(self, airspeed: float, bank_limit: float) -> Any:
        """(legs,) distances to go, m, beyond which nobody slower than ``airspeed`` can be due for the next turn.

        An entry grows with the speed; it is doubled for what the wind may do to it.
        """
        known = self._near.get((airspeed, bank_limit))
        if known is None:
            turns = range(len(self.legs) - 1)
            entries = [
                2.0 * self.turn(number, airspeed, bank_limit).entry if airspeed < math.inf else math.inf
                for number in turns
            ]
            known = self._near.setdefault((airspeed, bank_limit), np.array([*entries, -math.inf]))
        return known

    @property
    def _least_airspeed(self) -> float:
        """Below it no heading holds the courses in the wind: a noisy estimate must not ask for that."""
        return 1.2 * math.hypot(*self.wind) + 1.0

    def check_turns(self, bank_limit: float) -> None:
        """Raise ``ValueError`` naming the legs when a leg is too short for the turns at its ends."""
        exit_before = 0.0
        for number, leg in enumerate(self.legs):
            entry = 0.0
            if number + 1 < len(self.legs):
                following = self.legs[number + 1]
                if (
                    math.hypot(leg.direction[0] + following.direction[0], leg.direction[1] + following.direction[1])
                    < 1e-3
                ):
                    raise ValueError(f"leg {number + 1} turns straight back along leg {number}")
                turn = self.turn(number, max(leg.speed, following.speed), bank_limit)
                entry = turn.entry
            if entry + exit_before > leg.length:
                neighbours = f"leg {number}" if number == 0 else f"leg {number} (after leg {number - 1})"
                raise ValueError(
                    f"{neighbours} is {leg.length:.0f} m long, but at {math.degrees(bank_limit):.0f} deg of bank "
                    f"its turns need {entry + exit_before:.0f} m"
                )
            exit_before = turn.exit if number + 1 < len(self.legs) else 0.0


def _tan(angle: Any) -> Any:
    return math.tan(angle) if isinstance(angle, float) else np.tan(angle)


def _arctan2(y: Any, x: Any) -> Any:
    return math.atan2(y, x) if isinstance(y, float) else np.arctan2(y, x)


def pattern_route(
    side: str,
    height: float,
    downwind_abeam: float,
    base_distance: float,
    downwind_speed: float,
    turn_speed: float,
    aiming_point: float,
    runway_heading: float,
    wind: tuple[float, float] = (0.0, 0.0),
    time_to_roll: float = 2.8,
) -> Route:
    """The landing pattern: downwind, base and final, which ends at the aiming point [Volovyk 2022, fig. 1].

    Parameters
    ----------
    side : "left" or "right", the direction of its turns
    height : m, of the pattern
    downwind_abeam : m, from the runway to the downwind leg
    base_distance : m, from the base leg to the aiming point
    downwind_speed : m/s, on downwind and base        turn_speed : m/s, on the turn to final and up to the glide path
    aiming_point : m past the threshold               runway_heading : rad
    """
    if side not in ("left", "right"):
        raise ValueError(f"the side of a pattern is 'left' or 'right', not '{side}'")
    if downwind_abeam <= 0.0 or base_distance <= 0.0:
        raise ValueError("downwind and base leg of a pattern must lie at positive distances from the runway")
    if height <= 0.0:
        raise ValueError(f"the height of a pattern must be positive, not {height} m")
    along = math.cos(runway_heading), math.sin(runway_heading)
    lateral = downwind_abeam if side == "right" else -downwind_abeam

    def point(past_threshold: float, right: float) -> tuple[float, float]:
        return past_threshold * along[0] - right * along[1], past_threshold * along[1] + right * along[0]

    abeam = point(aiming_point, lateral)
    base_corner = point(aiming_point - base_distance, lateral)
    final_corner = point(aiming_point - base_distance, 0.0)
    return Route(
        (
            Leg(abeam, base_corner, downwind_speed, height),
            Leg(base_corner, final_corner, downwind_speed, height),
            Leg(final_corner, point(aiming_point, 0.0), turn_speed, height),
        ),
        wind,
        time_to_roll,
    )
