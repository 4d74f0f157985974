"""Kinds of route: each table has one, and each says where a flight begins."""

from __future__ import annotations

import math
from typing import get_args

from autopilot.approach import Approach
from autopilot.route import Leg, Route
from sim.flight.preparation import prepare
from sim.flight.routes.kind import RouteKind
from sim.flight.routes.kinds import KINDS, route_kind
from sim.flight.vehicles import Initial
from sim.scenario import model
from sim.scenario.reading import read

CONTRACT = [name for name in vars(RouteKind) if not name.startswith("_")]


def test_every_table_of_a_route_has_a_kind_with_the_whole_contract():
    assert set(KINDS) == set(get_args(model.Route))
    assert len(CONTRACT) == 8
    for kind in KINDS.values():
        assert not [name for name in CONTRACT if name not in vars(kind)]


def test_only_a_single_leg_is_approached_from_where_the_flight_starts():
    single = route_kind(read("vasylyev2003_jsbsim", {"start.cross_track_m": -1234.0}))
    assert single.offset(single.route(None)) == 1234.0
    assert not single.speeds
    pattern = prepare(read("an26_pattern", {"aircraft.model": "point_mass"}))
    assert route_kind(pattern.scenario).offset(pattern.route) == math.inf


def test_only_vectors_have_a_schedule_of_speeds_and_a_capture_without_an_offset():
    scenario = read("a320_vectored", {"start.cross_track_m": 500.0})
    kind, table = route_kind(scenario), scenario.route
    assert kind.speeds == ((math.inf, table.speed), *((one.distance, one.speed) for one in table.speeds))
    assert table.speeds
    assert kind.offset(Route((Leg((-30e3, 0.0), (0.0, 0.0), table.speed, table.height),))) == 0.0


def test_a_vectored_flight_begins_on_its_first_heading_unless_the_file_says_how_far_out():
    level = Initial(-9000.0, 0.0, 900.0, 0.0, 80.0)
    down = level._replace(height=400.0, gear=1.0)
    scenario = read("a320_vectored")
    begun = route_kind(scenario).begins(down, level)
    assert (begun.north, begun.east) != (level.north, level.east)
    assert begun.height == level.height
    assert begun.gear == 0.0
    stated = route_kind(read("a320_vectored", {"start.distance_m": 9000.0})).begins(down, level)
    assert stated == down._replace(course=begun.course, airspeed=begun.airspeed)


def test_legs_leave_the_deceleration_to_the_autopilot_and_a_pattern_sets_both():
    assert route_kind(read("vasylyev2003_jsbsim")).decelerations.deceleration == Approach.deceleration
    only_one = route_kind(read("an26_pattern", {"route.deceleration_mps2": 0.8})).decelerations
    assert only_one == (0.8, 0.8)
