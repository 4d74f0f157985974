"""The linear model of a scenario's route loop, from which margins and limit cycles are predicted."""

from __future__ import annotations

from autopilot.modes.lateral_navigation import LateralNavigation
from autopilot.route_loop import RouteLoop
from sim.errors import ScenarioError
from sim.flight.preparation import Prepared
from sim.flight.vehicles import JsbsimVehicle, leg_loop


def has_route_loop(prepared: Prepared) -> bool:
    """Whether a route law flies an aircraft that has inner loops."""
    return LateralNavigation.of(prepared.law) is not None and isinstance(prepared.vehicle, JsbsimVehicle)


def scenario_loop(prepared: Prepared) -> RouteLoop:
    """The loop that flies the leg on which the flight begins; raises ``ScenarioError`` where there is none."""
    if not has_route_loop(prepared):
        name = prepared.scenario.name
        raise ScenarioError(f"{name}: margins need a JSBSim aircraft under a route law, such as 'lateral_navigation'")
    leg = prepared.route.legs[prepared.initial.leg]
    flaps, gear = prepared.autopilot.flaps, prepared.autopilot.gear
    return leg_loop(prepared.airframe, prepared.designed, leg.speed, leg.height, flaps, gear)
