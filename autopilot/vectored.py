"""An approach that is vectored: headings given from outside are held until the law takes over, often late.

Until then the bank follows the heading error; speed and height are those of the approach. The law is armed on the last
heading and captures when it would itself turn towards the final course. Nothing plans this turn: where it begins is the
law's own affair, and the wind's. Once the capture is complete, a law that tracks the line follows it.
"""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Annotated, Any, NamedTuple

from aircraft.state import STANDARD_GRAVITY, AircraftState, Command
from autopilot.approach import CAPTURE, TURNING, VECTORS, Approach, ApproachState, established
from autopilot.departure import Departing
from autopilot.route import PathDeviation, Route
from autopilot.saturation import saturate

ON_HEADING = math.radians(5.0)  # from a heading, within which it is held
HEADING_TIME = 8.0  # s, in which a heading error fades: slow beside the bank loop, quick beside a vector
PLAN_STEP = 0.5  # s
CAPTURE_TIME = 25.0  # s, of a capture at least, before the line is tracked [L-1011 flight guidance, ATA 22-30] ...
CAPTURE_BANK = math.radians(5.0)  # ... and the bank command below which it is complete
TRACKING_BANK = math.radians(10.0)  # largest bank command of the law that tracks the line, of the same autopilot


class Vector(NamedTuple):
    """One heading and how long it is held."""

    heading: float  # rad less the final course, + to the right
    time: float  # s; of the last one, from its beginning until the extended centreline is met


@dataclass(frozen=True)
class HeldHeading:
    """The bank that turns onto a heading and holds it: the error fades within a time, at a speed through the air."""

    heading: Annotated[float, "rad"]  # less the course of the leg, + to the right
    speed: Annotated[float, "m/s"]
    bank_limit: Annotated[float, "rad"]

    def __call__(self, deviation: PathDeviation) -> float:
        """Bank command, rad: the turn rate g/V bank that takes the error out in ``HEADING_TIME``."""
        error = math.remainder(self.heading - deviation.heading_error, math.tau)
        return float(saturate(self.speed / (STANDARD_GRAVITY * HEADING_TIME) * error, self.bank_limit))

    def check_convergence(self, ground_speed: float, offset: float = math.inf, turns: bool = False) -> None:
        """Nothing: a heading leads nowhere."""


class VectoredState(NamedTuple):
    """What the autopilot remembers; the first four are those that every autopilot shows."""

    phase: int
    leg: int
    finished: str
    flown: ApproachState
    began: float  # s, when the first heading was given
    captured: float  # s, when the law would first have turned in; infinite until then
    tracking: bool  # the capture is complete


@dataclass(frozen=True)
class Vectored:
    """Headings held one after another, and the approach from where its law takes over.

    ``after`` is what flies then: the approach, or one that is left again. ``late`` (s) is how long after the law's own
    criterion it is engaged. Autopilots capture a localiser by one law and track it by another, stiffer one, with less
    bank: ``tracking`` flies once the law has been engaged for `CAPTURE_TIME`, the aircraft is on the line and the bank
    command is below `CAPTURE_BANK`.
    """

    approach: Approach
    after: Approach | Departing
    tracking: Approach | Departing
    vectors: tuple[Vector, ...]
    late: float = 0.0
    held: tuple[tuple[float, Approach], ...] = dataclasses.field(init=False, repr=False, compare=False)

    def __post_init__(self) -> None:
        """Until the law takes over nothing descends or ends, and the schedule of speeds counts on the last heading.

        The lag of the bank is one of the capture: headings are held, and the line is tracked, without it.
        """
        speed, limit = self.approach.route.legs[-1].speed, self.approach.law.bank_limit
        since, held = 0.0, []
        for number, vector in enumerate(self.vectors):
            flown = self.approach if number + 1 == len(self.vectors) else self._unscheduled
            law = HeldHeading(vector.heading, speed, limit)
            held.append((since, dataclasses.replace(flown, law=law, landing=None, bank_lag=0.0)))
            since += vector.time
        object.__setattr__(self, "held", tuple(held))

    @property
    def _unscheduled(self) -> Approach:
        """At its first speed: far from the final, the distance along it is not the way to go."""
        return dataclasses.replace(self.approach, speeds=self.approach.speeds[:1])

    @property
    def route(self) -> Route:
        """The final approach."""
        return self.approach.route

    def begin(self, state: AircraftState, leg: int = 0) -> VectoredState:
        """On the first heading."""
        return VectoredState(VECTORS, leg, "", self.approach.begin(state, leg), state.time, math.inf, False)

    def step(self, s: VectoredState, state: AircraftState, dt: float) -> tuple[VectoredState, Command]:
        """Command for the next ``dt`` seconds, of the heading or of the law."""
        captured = s.captured
        if (
            math.isinf(captured)
            and state.time - s.began >= self.held[-1][0]
            and self._captures(self.approach.deviation(s.leg, state))
        ):
            captured = state.time
        engaged = state.time - captured - self.late  # s, below 0 until then
        tracking = s.tracking or (
            engaged >= CAPTURE_TIME
            and abs(s.flown.bank) < CAPTURE_BANK
            and established(self.approach.deviation(s.leg, state))
        )
        flown = self.tracking if tracking else self.after
        if engaged < 0.0:
            flown = next(one for since, one in reversed(self.held) if state.time - s.began >= since)
        inner, command = flown.step(s.flown, state, dt)
        phase = inner.phase
        if engaged < 0.0:
            return VectoredState(VECTORS, inner.leg, "", inner._replace(finished=""), s.began, captured, False), command
        return VectoredState(
            CAPTURE if phase in TURNING else phase, inner.leg, inner.finished, inner, s.began, captured, tracking
        ), command

    def _captures(self, deviation: PathDeviation) -> bool:
        """Whether the law turns in, on a line that it sees."""
        landing = self.approach.landing
        sees = landing is None or landing.sees_line(deviation.cross_track, deviation.distance_to_go)
        return sees and captures(self.approach.law, deviation, self.vectors[-1].heading)


def captures(law: Any, deviation: PathDeviation, heading: float) -> bool:
    """Whether a law that is armed on a heading (rad less the course) turns in: its bank leads towards the course.

    Law (4) turns in where k1 c1{z} + k2 c2{z'} has changed its sign: on a heading that is shallower than its own
    intercept when the line is k2/k1 seconds away, on a steeper one at once, to fly its own. As long as the aircraft
    still turns to the heading, the law waits until its cross-track limit is reached: only there does it see the line.
    """
    side = math.copysign(1.0, heading)
    if not (side * deviation.cross_track_rate > 0.0 and side * law(deviation) < 0.0):
        return False
    if abs(math.remainder(heading - deviation.heading_error, math.tau)) < ON_HEADING:
        return True
    limit = next((one.limit for one in law.limits() if one.of == "cross_track"), math.inf)
    return bool(abs(deviation.cross_track) < limit)


def way(
    vectors: Sequence[Vector], airspeed: float, bank_limit: float, roll_rate_limit: float, wind: tuple[float, float]
) -> tuple[list[float], list[float]]:
    """The way over the ground, m along and to the right of the final course, while the vectors are flown.

    It begins at (0, 0) on the first heading; each other one is turned to as `HeldHeading` does, at one airspeed (m/s),
    with a bank that is there after half the time that it takes to roll to its limit.
    ``wind`` is the way the air moves, m/s along and to the right.
    """
    heading, along, across = vectors[0].heading, [0.0], [0.0]
    most = STANDARD_GRAVITY * math.tan(bank_limit) / airspeed
    rolled = bank_limit / (2.0 * roll_rate_limit)
    for vector in vectors:
        steps = math.ceil(vector.time / PLAN_STEP)
        dt = vector.time / steps
        for step in range(steps):
            error = math.remainder(vector.heading - heading, math.tau)
            if step * dt >= rolled:
                heading += saturate(error / HEADING_TIME, most) * dt
            along.append(along[-1] + (airspeed * math.cos(heading) + wind[0]) * dt)
            across.append(across[-1] + (airspeed * math.sin(heading) + wind[1]) * dt)
    return along, across


def turn_time(angle: float, airspeed: float, bank_limit: float, roll_rate_limit: float) -> float:
    """Time, s, in which `HeldHeading` turns by an angle (rad) but for `ON_HEADING`, as `way` flies it: at the bank
    limit, until the error is one that fades."""
    most = STANDARD_GRAVITY * math.tan(bank_limit) / airspeed
    fading, left = most * HEADING_TIME, abs(angle)
    if left <= ON_HEADING:
        return 0.0
    fade = HEADING_TIME * math.log(max(min(left, fading) / ON_HEADING, 1.0))
    return bank_limit / (2.0 * roll_rate_limit) + max(left - max(fading, ON_HEADING), 0.0) / most + fade


def heading_of(course: float, airspeed: float, wind: tuple[float, float]) -> float:
    """Heading, rad, that keeps a course (rad) in a wind (m/s along and to the right of the axis of both angles)."""
    across = wind[1] * math.cos(course) - wind[0] * math.sin(course)
    return course - math.asin(max(-1.0, min(across / airspeed, 1.0)))
