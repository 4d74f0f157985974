"""Flaps and landing of an approach, and what is said of an aircraft that is flown beyond its limits."""

from __future__ import annotations

import math

from aircraft.data import AircraftData
from aircraft.properties import FOOT
from autopilot.approach import Approach
from autopilot.design import Designed
from autopilot.landing import REFERENCE_MARGIN, Landing
from autopilot.stabilised_gate import StabilisedGate
from sim.flight.airspeeds import MANOEUVRE_MARGIN, least_approach_speed, level_speeds, remarks
from sim.flight.preparing.aircraft import airframe_of
from sim.flight.routes.kinds import route_kind
from sim.scenario.model import Scenario

SINK_MARGIN = 1.2  # of the gate over the sink of a fast approach, which is briefed for more than 1000 ft/min [FSF ALAR]


def configured(scenario: Scenario, aircraft: AircraftData) -> tuple[float, Landing | None]:
    """Flaps before the glide path, and the landing where the route ends in one; margins are in equivalent airspeed."""
    mass = scenario.aircraft.mass or aircraft.reference_mass
    settings = sorted(aircraft.flap_settings, key=lambda setting: setting.flaps)
    table, air = scenario.route, scenario.air
    slowest = min(equivalent for _, _, equivalent in level_speeds(scenario))
    enough = [s.flaps for s in settings if MANOEUVRE_MARGIN * aircraft.stall_speed(s.flaps, mass) <= slowest]
    flaps = enough[0] if enough else settings[-1].flaps if settings else 0.0
    speed = table.approach_speed
    if speed is None:
        return flaps, None
    full = settings[-1].flaps if settings else 0.0
    stall = speed / REFERENCE_MARGIN  # true, over the runway
    if settings:
        reference = least_approach_speed(aircraft, full, mass)
        speed = max(speed, reference / air.equivalent_share(table.levels[-1][2]))  # it is least where final begins
        stall = aircraft.stall_speed(full, mass) / air.equivalent_share(0.0)
    glide_path = scenario.runway.glide_path
    return flaps, Landing(
        approach_speed=speed,
        stall_speed=stall,
        flaps=full,
        glide_path=glide_path,
        localiser=route_kind(scenario).localiser,
        wheel_height=aircraft.height_of_wheels,
        lowest_pitch=aircraft.lowest_touchdown_pitch,
        highest_pitch=aircraft.highest_touchdown_pitch,
        highest_bank=aircraft.highest_touchdown_bank,
        gate=StabilisedGate(
            scenario.autopilot.gate_height,
            sink=max(StabilisedGate.sink, SINK_MARGIN * speed * math.tan(glide_path)),
        ),
    )


def beyond_limits(scenario: Scenario, autopilot: Approach, aircraft: AircraftData, gains: Designed) -> tuple[str, ...]:
    """What is beyond the limits of the aircraft or of the model, and what was changed: flown all the same."""
    north, east = scenario.wind.steady
    along, across = scenario.runway.from_local(north, east)
    told, landing = [], autopilot.landing
    if scenario.aircraft.repairs and scenario.aircraft.model != "point_mass":
        told += [f"the model is repaired: {text}" for text in airframe_of(scenario).load().repairs]
    if landing is not None and landing.gate.sink > StabilisedGate.sink:
        sink, usual, allowed = (
            60.0 * speed / FOOT
            for speed in (landing.approach_speed * landing.slope, StabilisedGate.sink, landing.gate.sink)
        )
        told.append(
            f"a glide path of {math.degrees(landing.glide_path):.2f} deg at {landing.approach_speed:.1f} m/s sinks at "
            f"{sink:.0f} ft/min: its gate lets {allowed:.0f} ft/min pass, not the usual {usual:.0f}"
        )
    if scenario.wind.events and scenario.aircraft.model == "point_mass":
        told.append("the point mass keeps its airspeed in wind events: they only carry it along")
    if along > aircraft.tailwind_limit:
        told.append(
            f"tailwind {along:.1f} m/s is above the limit of {aircraft.tailwind_limit:.1f} m/s ({aircraft.title})"
        )
    if abs(across) > aircraft.crosswind_limit:
        limit = aircraft.crosswind_limit
        told.append(f"crosswind {abs(across):.1f} m/s is above the limit of {limit:.1f} m/s ({aircraft.title})")
    return (*told, *remarks(scenario, autopilot, aircraft, gains))
