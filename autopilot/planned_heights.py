"""The heights along a route as the approach will order them: level, changed at its turns, down the glide path."""

from __future__ import annotations

from collections.abc import Iterator
from typing import NamedTuple

from autopilot.approach import Approach
from autopilot.landing import Landing

STEP = 50.0  # m between points while the height changes: less than a second at most speeds
BEND_POINTS = 8  # on the parabola onto the glide path


class PlannedHeight(NamedTuple):
    """A point of the plan; between two points the height is linear."""

    along: float  # m along the legs, from the start of the first to the end of the last
    height: float  # m above the threshold
    on_glide_path: bool = False  # tied to the ground by the landing aid; before, only to the moment of a turn


def planned_heights(
    approach: Approach, leg: int = 0, distance: float | None = None, height: float | None = None
) -> tuple[PlannedHeight, ...]:
    """Heights along the whole route of an aircraft that begins on a leg, a distance (m) before its end, at a height.

    Without these it begins at the start of the leg, at the leg's height. A new level is ordered where the turn to its
    leg is due and flown by the rule of the approach; the legs' airspeeds are taken as flown and the steady wind of the
    route as blowing. A fly-by turn takes less time than the way by the corner: on that way the height changes as it
    does along the arc.
    """
    route = approach.route
    legs = route.legs
    along = sum(before.length for before in legs[:leg])
    if distance is not None:
        along += legs[leg].length - distance
    level = legs[leg].height
    height, climb_rate = level if height is None else height, 0.0
    points = [PlannedHeight(along, height)]
    for end, level, airspeed, over_ground in _stretches(approach, leg):
        while along < end:
            if height == level and climb_rate == 0.0:
                along = end
            else:
                step = min(STEP, end - along)
                height, climb_rate = approach.towards(
                    level, height, climb_rate, airspeed * approach.level_change_angle, step / over_ground
                )
                along += step
            points.append(PlannedHeight(along, height))
    return tuple(points) if approach.landing is None else _with_glide_path(approach, approach.landing, points)


def _stretches(approach: Approach, first: int) -> Iterator[tuple[float, float, float, float]]:
    """(end m along the legs, level m, airspeed m/s, speed m/s along the legs) of straight parts and turns in order."""
    route, bank = approach.route, approach.law.bank_limit
    end = sum(before.length for before in route.legs[:first])
    for number, leg in list(enumerate(route.legs))[first:]:
        end += leg.length
        over_ground = route.ground_speed(number, leg.speed)
        if number + 1 == len(route.legs):
            yield end, leg.height, leg.speed, over_ground
            return
        following = route.legs[number + 1]
        turn = route.turn(number, following.speed, bank)
        yield end - turn.entry, leg.height, leg.speed, over_ground
        way, time = turn.entry + turn.exit, turn.duration + route.time_to_roll
        if turn.duration > 0.0 and way > 0.0:  # on a straight line the next leg's level is ordered at its beginning
            yield end + turn.exit, following.height, following.speed, way / time


def _with_glide_path(approach: Approach, landing: Landing, points: list[PlannedHeight]) -> tuple[PlannedHeight, ...]:
    """The plan with the path down to the end of the last leg in place of what would be level there."""
    route = approach.route
    end, last = sum(leg.length for leg in route.legs), route.legs[-1]
    bend = landing.bend(route.ground_speed(len(route.legs) - 1, last.speed))
    entry = last.height / landing.slope + 0.5 * bend
    down = [entry - bend * k / BEND_POINTS for k in range(BEND_POINTS + 1)]
    before = [point for point in points if point.along < end - entry]
    path = [PlannedHeight(end - to_go, landing.path(to_go, last.height, bend)[0], True) for to_go in (*down, 0.0)]
    return (*before, *path)
