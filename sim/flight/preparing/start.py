"""Where and how a flight begins."""

from __future__ import annotations

import math

from autopilot.landing import Landing
from autopilot.route import Route
from sim.flight.routes.kind import RouteKind
from sim.flight.vehicles import Initial
from sim.scenario.tables import Start


def initial_of(start: Start, kind: RouteKind, route: Route, flaps: float, landing: Landing | None) -> Initial:
    """The begin of a flight with these flaps (rad) before the glide path; raises ``ValueError``."""
    number = kind.first_leg()
    if not 0 <= number < len(route.legs):
        raise ValueError(f"leg must lie within 0 and {len(route.legs) - 1}, not {number}")
    leg = route.legs[number]
    distance = leg.length if start.distance is None else start.distance
    along_north, along_east = leg.direction
    north = leg.end[0] - along_north * distance - along_east * start.cross_track
    east = leg.end[1] - along_east * distance + along_north * start.cross_track
    level = on_leg = Initial(north, east, leg.height, leg.course, leg.speed, flaps=flaps, leg=number)
    if landing is not None and number == len(route.legs) - 1:
        height, slope = landing.path(distance, leg.height, leg.speed)
        on_leg = level._replace(height=height)
        if slope < 0.0:
            on_leg = on_leg._replace(
                airspeed=landing.approach_speed, flight_path_angle=math.atan(slope), flaps=landing.flaps, gear=1.0
            )
    begun = kind.begins(on_leg, level)
    return begun._replace(
        height=begun.height if start.height is None else start.height,
        airspeed=begun.airspeed if start.speed is None else start.speed,
        course=begun.course if start.course is None else start.course,
    )
