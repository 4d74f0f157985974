"""A flight that was flown elsewhere, prepared for those who watch it."""

from __future__ import annotations

import dataclasses
import functools

from aircraft.data import AircraftData
from aircraft.point_mass import PointMass
from autopilot.approach import Approach
from autopilot.landing import REFERENCE_MARGIN, Landing
from autopilot.modes.lateral_navigation import LateralNavigation
from sim.flight.gains import Gains
from sim.flight.outcomes import Limits
from sim.flight.preparing.law import design_case, law_of
from sim.flight.preparing.prepared import Prepared
from sim.flight.recording.flight import REMARK
from sim.flight.recording.flights import recording
from sim.flight.recording.unknown import FINAL_TAKEN, unknown_flight
from sim.flight.routes.kinds import route_kind
from sim.flight.vehicles import Initial, PointMassVehicle, designed_point_mass
from sim.scenario.messages import at
from sim.scenario.model import Scenario
from sim.scenario.recording.table import RecordTable


def recorded(scenario: Scenario, record: RecordTable) -> Prepared:
    """A recorded flight, with the route and the law that trackers are told. They fly nothing here: the point mass lends
    its bank loop to laws that are designed."""
    place, told = functools.partial(at, scenario.name), scenario.autopilot
    with place("[route]"):
        route = route_kind(scenario).route(None)
        speed = max(leg.speed for leg in route.legs)
        gains = designed_point_mass(speed, told.bank_limit, told.roll_rate_limit)
        route = dataclasses.replace(route, time_to_roll=gains.time_to_roll(speed, told.roll_rate_limit))
    with place("[autopilot.law]"):
        law = law_of(scenario, design_case(scenario, gains, route))
        known = LateralNavigation.of(law)
        gains = gains if known is None else gains.with_law(known)
    with place("[route]"):
        glide = Landing(speed, speed / REFERENCE_MARGIN, glide_path=scenario.runway.glide_path)
        landing = None if scenario.has_route else glide
        autopilot = Approach(route, law, landing, roll_rate_limit=told.roll_rate_limit, allow_orbit=True)
        first = route.legs[0]
    with place("[record]"):
        if record.known:
            flight = recording(record, scenario.runway, scenario.air, route)
        else:
            flight = unknown_flight(route, scenario.sensors)
    remarks = tuple(event.detail for event in flight.events if event.name == REMARK)
    if not record.known and not scenario.has_route:
        remarks += (f"no [route] is told: {FINAL_TAKEN}, at most {first.height:.0f} m high",)
    return Prepared(
        scenario,
        autopilot,
        PointMassVehicle(PointMass(air=scenario.air)),
        Initial(*first.start, first.height, first.course, first.speed),
        Limits(scenario.until, scenario.runway),
        Gains(gains, None),
        gains,
        AircraftData("point mass").rate,
        remarks,
        recording=flight,
    )
