"""A flight that is flown here, prepared: everything that can be refused is refused here, before the first step."""

from __future__ import annotations

import dataclasses
import functools
import math

from autopilot.approach import Approach
from autopilot.modes.lateral_navigation import LateralNavigation
from autopilot.swing_margin import shallower
from sim.flight import swings
from sim.flight.airspeeds import extremes, landing_stall_speed
from sim.flight.outcomes import Limits
from sim.flight.preparing.aircraft import data_of, loop_on, vehicle_of
from sim.flight.preparing.configuration import beyond_limits, configured
from sim.flight.preparing.law import design_case, law_of
from sim.flight.preparing.loops import gains_of
from sim.flight.preparing.prepared import Prepared
from sim.flight.preparing.start import initial_of
from sim.flight.routes.kinds import route_kind
from sim.flight.weather import air
from sim.scenario.messages import at
from sim.scenario.model import Scenario
from sim.scenario.refusals.units import in_words_of


def flown(scenario: Scenario) -> Prepared:
    """A scenario as it is flown here; raises ``ScenarioError``."""
    kind = route_kind(scenario)
    place = functools.partial(at, scenario.name)
    asked = functools.partial(in_words_of, type(scenario.aircraft), scenario.tables["aircraft"])
    with place("[aircraft]", asked):
        aircraft = data_of(scenario)
        flaps, landing = configured(scenario, aircraft)
    with place("[route]"):
        route = kind.route(landing)
    with place("[aircraft]"):
        found = gains_of(scenario, route, flaps, landing)
        gains = found.designed
        turn_speed, fastest = extremes(scenario)
        if len(route.legs) > 1:
            gains = shallower(gains, fastest, turn_speed - math.hypot(*route.wind))
        lead = gains.time_to_roll(turn_speed, scenario.autopilot.roll_rate_limit)
        route = dataclasses.replace(route, time_to_roll=lead, turning=gains.turning)
    with place("[autopilot.law]"):
        law = law_of(scenario, design_case(scenario, gains, route))
    with place("[autopilot]"):
        if landing is not None:
            landing = dataclasses.replace(landing, sideslip_bank=gains.bank_per_sideslip)
        rate_limit = scenario.autopilot.roll_rate_limit
        try:
            autopilot = Approach(
                route,
                law,
                landing,
                roll_rate_limit=rate_limit,
                **kind.decelerations._asdict(),
                flaps=flaps,
                allow_orbit=scenario.autopilot.allow_orbit,
                offset=kind.offset(route),
                bank_lag=scenario.autopilot.bank_lag,
                speeds=kind.speeds,
            )
        except ValueError as error:
            if law != gains.law or scenario.autopilot.estimate_lag > 0.0:  # slow for another reason
                raise
            why = swings.slowness(loop_on(scenario, gains, route.legs[0], flaps), gains, fastest, rate_limit)
            raise ValueError(f"{error}; {why}: allow a faster roll or less bank" if why else str(error)) from None
    with place("[start]"):
        initial = initial_of(scenario.start, kind, route, flaps, landing)
        vehicle = vehicle_of(scenario, gains)
    with place("[aircraft]"):
        vehicle.read(vehicle.begin(initial, air(scenario.wind, scenario.runway)))  # it trims, or says why not
        own = LateralNavigation.of(law)
        swing = ""
        if own is not None and own != gains.law:
            swing = swings.cause(loop_on(scenario, gains, route.legs[initial.leg], flaps), own, rate_limit)
    with place("[[departures]]"):
        limits = Limits(scenario.until, scenario.runway, swing=swing, swing_bank=0.5 * law.bank_limit)
        told = (*found.remarks, *beyond_limits(scenario, autopilot, aircraft, gains))
        if swing:
            theory = f"the law swings by theory: {swing}"
            told += (f"{theory}; without its own numbers the design takes {gains.law.frequency:.3f} rad/s",)
        stall = landing_stall_speed(scenario, aircraft, autopilot)
        prepared = Prepared(scenario, autopilot, vehicle, initial, limits, found, gains, aircraft.rate, told, stall)
        _ = prepared.controller  # it can be left like that, or says why not
    return prepared
