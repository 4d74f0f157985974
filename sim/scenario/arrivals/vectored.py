"""The route of an approach that is vectored: headings from outside, and the final on which the law takes over."""

from __future__ import annotations

import itertools
import math
from dataclasses import dataclass
from typing import Annotated, ClassVar, Literal

from aircraft.ranges import Range, check_ranges, within
from sim.scenario.tables import AIRSPEED, DECELERATION, FARTHEST, HEIGHT, LENGTH

LONGEST_VECTOR = 900.0  # s
HELD = Range(above=0.0, most=LONGEST_VECTOR)
DISTANCE = Range(least=0.0, most=FARTHEST)
MOST = 20  # vectors, and speeds of a schedule


@dataclass(frozen=True)
class VectorTable:
    """A heading that is held before the last one; with no time it is left out."""

    # of its course to that of the final, + towards the line: 90 is a base leg
    angle: Annotated[float, "rad", within(math.pi)]
    for_: Annotated[float, "s", Range(least=0.0, most=LONGEST_VECTOR)]  # until the next heading is given

    def __post_init__(self) -> None:
        check_ranges(self)


@dataclass(frozen=True)
class SpeedTable:
    """An airspeed of the schedule, from a distance to the aiming point on."""

    distance: Annotated[float, "m", DISTANCE]
    speed: Annotated[float, "m/s", "indicated", AIRSPEED]  # true airspeed

    def __post_init__(self) -> None:
        check_ranges(self)


@dataclass(frozen=True)
class VectoredTable:
    """Vectors onto a final approach: the aircraft holds headings that it is given until the law takes over.

    The last heading meets the extended centreline at ``intercept_distance`` before the aiming point; absent, that is
    ``level`` before the point at which the glide path comes down to ``height``. Angles are those of courses over the
    ground in the steady wind; what is held is the heading.
    """

    side: Literal["left", "right"] = "left"  # of the final course from which it comes; it turns that way, as a pattern
    height: Annotated[float, "m", HEIGHT] = 900.0
    # below 0 it comes from the other side
    intercept_angle: Annotated[float, "rad", Range(above=-math.pi, below=math.pi)] = math.radians(35.0)
    intercept_distance: Annotated[float | None, "m", LENGTH] = None
    level: Annotated[float, "m", DISTANCE] = 8000.0
    last_vector: Annotated[float, "s", HELD] = 60.0  # from the last heading given to the extended centreline
    straight: Annotated[float | None, "s", HELD] = None  # instead of it: from the end of the turn to that heading
    arm_late: Annotated[float, "s", Range(least=0.0, most=120.0)] = 0.0  # after the law would have turned in
    speed: Annotated[float, "m/s", "indicated", AIRSPEED] = 72.0  # this and the next are true airspeeds
    approach_speed: Annotated[float, "m/s", "indicated", AIRSPEED] = 58.0
    deceleration: Annotated[float, "m/s2", DECELERATION] = 0.5
    glide_deceleration: Annotated[float | None, "m/s2", DECELERATION] = None  # on the glide path; absent = the same
    vectors: tuple[VectorTable, ...] = ()  # before the last one
    speeds: tuple[SpeedTable, ...] = ()  # schedule, by falling distance

    final: ClassVar[int | None] = 0  # the leg that ends on the runway

    def __post_init__(self) -> None:
        check_ranges(self)
        if self.intercept_angle == 0.0:
            raise ValueError("intercept_angle must not be 0: it says from which side the line is met, and how steeply")
        for several in ("vectors", "speeds"):
            if len(getattr(self, several)) > MOST:
                raise ValueError(f"{several}: {len(getattr(self, several))} are more than the {MOST} of one approach")
        if any(a.distance <= b.distance for a, b in itertools.pairwise(self.speeds)):
            raise ValueError("speeds: the distances of the schedule must fall")
        schedule = [self.speed, *(one.speed for one in self.speeds)]
        if any(a < b for a, b in itertools.pairwise(schedule)):
            told = ", ".join(f"{speed:.4g}" for speed in schedule)
            raise ValueError(f"speeds must not rise towards the runway, but speed and its schedule are {told} m/s true")

    @property
    def levels(self) -> tuple[tuple[str, float, float], ...]:
        """(where, true airspeed m/s, height m) of everything flown before the glide path."""
        scheduled = ((f"{one.distance / 1e3:.1f} km out", one.speed, self.height) for one in self.speeds)
        return (("the vectors", self.speed, self.height), *scheduled)

    @property
    def sign(self) -> float:
        """+1 where it comes from the left of the final course, with courses that lead to the right of it."""
        return math.copysign(1.0, self.intercept_angle) * (1.0 if self.side == "left" else -1.0)

    @property
    def courses(self) -> tuple[tuple[float, float], ...]:
        """(rad less the final course, + to the right; s) of every vector that is flown, the last one last.

        The turn to the last one is not counted where ``straight`` sets its time.
        """
        earlier = tuple((self.sign * one.angle, one.for_) for one in self.vectors if one.for_ > 0.0)
        last = self.last_vector if self.straight is None else self.straight
        return (*earlier, (self.sign * abs(self.intercept_angle), last))
