"""A vectored route laid out: the final as the one leg of the route, and the way on which the headings lead to it."""

from __future__ import annotations

import dataclasses
import math
from typing import Any

import numpy as np

from autopilot.approach import Approach
from autopilot.design import Designed
from autopilot.mode import DesignCase
from autopilot.route import Leg, Route
from autopilot.vectored import TRACKING_BANK, Vector, Vectored, heading_of, turn_time, way
from sim.scenario.arrivals.navigation import NavigationErrors
from sim.scenario.arrivals.vectored import VectoredTable
from sim.scenario.model import Scenario

BEYOND = 1000.0  # m of the final before anything that is flown


def final(scenario: Scenario, table: VectoredTable) -> Route:
    """The final approach, which is all of the route that a tracker may be told; it begins where anything is flown."""
    runway = scenario.runway
    along = way_of(scenario, table)[0]
    length = BEYOND + max(met(scenario, table), float(np.max(met(scenario, table) + along[-1] - along)))
    start, end = runway.to_local(runway.aiming_point - length, 0.0), runway.to_local(runway.aiming_point, 0.0)
    slowest = min(speed for _, speed, _ in table.levels)
    return Route((Leg(start, end, slowest, table.height),), scenario.wind.at(table.height))


def met(scenario: Scenario, table: VectoredTable) -> float:
    """Where the last heading is to meet the extended centreline, m before the aiming point."""
    if table.intercept_distance is not None:
        return table.intercept_distance
    return table.height / math.tan(scenario.runway.glide_path) + table.level


def vectors(scenario: Scenario, table: VectoredTable) -> tuple[Vector, ...]:
    """The headings that make good the courses of a table in the steady wind."""
    wind, pilot = _wind(scenario, table), scenario.autopilot
    found = [Vector(heading_of(course, table.speed, wind), time) for course, time in table.courses]
    if table.straight is not None and len(found) > 1:
        turn = math.remainder(found[-1].heading - found[-2].heading, math.tau)
        turned = turn_time(turn, table.speed, pilot.bank_limit, pilot.roll_rate_limit)
        found[-1] = found[-1]._replace(time=found[-1].time + turned)
    return tuple(found)


def way_of(scenario: Scenario, table: VectoredTable) -> Any:
    """(2, n) m along and to the right of the final course: the way of the vectors from where they begin."""
    pilot, wind = scenario.autopilot, _wind(scenario, table)
    return np.array(way(vectors(scenario, table), table.speed, pilot.bank_limit, pilot.roll_rate_limit, wind))


def planned(scenario: Scenario, table: VectoredTable) -> tuple[np.ndarray, np.ndarray]:
    """(n,) north and east of the planned way, m, up to where it meets the extended centreline."""
    along, across = way_of(scenario, table)
    past = scenario.runway.aiming_point - met(scenario, table) + along - along[-1]
    north, east = scenario.runway.to_local(past, across - across[-1])
    return np.asarray(north), np.asarray(east)


def planned_of(scenario: Scenario) -> tuple[np.ndarray, np.ndarray] | None:
    """`planned` of a scenario; None where nothing is vectored."""
    return planned(scenario, scenario.route) if isinstance(scenario.route, VectoredTable) else None


def in_words(scenario: Scenario, table: VectoredTable) -> list[tuple[str, ...]]:
    """(from s on, course deg, heading deg, angle to the final deg) of every vector."""
    rows: list[tuple[str, ...]] = []
    since = 0.0
    runway = scenario.runway.heading
    for (course, _), vector in zip(table.courses, vectors(scenario, table), strict=True):
        told = [math.degrees(runway + angle) % 360.0 for angle in (course, vector.heading)]
        rows.append((f"{since:.0f}", *(f"{angle:.1f}" for angle in told), f"{math.degrees(abs(course)):.1f}"))
        since += vector.time
    return rows


def begins(scenario: Scenario, table: VectoredTable) -> tuple[float, float, float]:
    """North and east, m, and course, rad, where the first heading is given."""
    north, east = planned(scenario, table)
    return float(north[0]), float(east[0]), scenario.runway.heading + table.courses[0][0]


def schedule(table: VectoredTable) -> tuple[tuple[float, float], ...]:
    """(m to go, m/s from there on) of the airspeeds before the glide path."""
    return ((math.inf, table.speed), *((one.distance, one.speed) for one in table.speeds))


def vectored(scenario: Scenario, table: VectoredTable, approach: Approach, after: Any, tracking: Any) -> Vectored:
    """The autopilot that holds the headings; ``after`` flies from where the law takes over, then ``tracking``."""
    return Vectored(approach, after, tracking, vectors(scenario, table), table.arm_late)


def tracking(scenario: Scenario, gains: Designed, approach: Approach) -> Approach:
    """The approach under the law that tracks the line once it is captured: of the same mode, as the aircraft's own
    design makes it, whatever law and lag the capture has."""
    limit = min(TRACKING_BANK, approach.law.bank_limit)
    speed = max(speed for _, speed, _ in scenario.route.levels)
    case = DesignCase(limit, gains.bank_bandwidth, speed, gains.k1, gains.k2, gains.cross_track_limit)
    return dataclasses.replace(approach, law=scenario.modes[scenario.mode].designed({}, case), bank_lag=0.0)


def localiser(scenario: Scenario) -> float:
    """Where its antenna stands, m behind the aiming point."""
    errors = scenario.navigation_errors or NavigationErrors()
    return errors.localiser_past - scenario.runway.aiming_point


def _wind(scenario: Scenario, table: VectoredTable) -> tuple[float, float]:
    """The way the air moves where the vectors are flown, m/s along and to the right of the final course."""
    along, across = scenario.runway.from_local(*scenario.wind.at(table.height))
    return float(along), float(across)
