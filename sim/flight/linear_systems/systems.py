"""linear(): the aircraft of a scenario and its loops about the leg on which the flight begins, for python-control."""

from __future__ import annotations

from typing import Any, NamedTuple

from aircraft.linearise import linearise
from aircraft.trim import trim
from autopilot.linear_systems import aircraft_system, bank_system, closed_system, opened_system
from autopilot.modes.lateral_navigation import LateralNavigation
from autopilot.route import Leg
from autopilot.route_loop import RouteLoop
from sim.flight.preparation import MODEL_TIME_LIMIT, Prepared, prepare
from sim.scenario.model import Scenario
from sim.workers.isolation import run_isolated


class LinearSystems(NamedTuple):
    """Each a ``control.StateSpace`` with named signals; SI and radians, controls as shares of full travel."""

    leg: Leg  # at whose airspeed and height they hold
    aircraft: Any  # throttle, elevator, aileron, rudder -> its ten states; continuous, without lags of actuators
    bank: Any  # bank command -> bank, cross-track, its rate, aileron; sampled at 30 Hz
    opened: Any  # the route loop opened at the bank command
    closed: Any  # line, m right of the leg -> the outputs of ``bank``; inside the limits of the law
    loop: RouteLoop  # and the matrices that they were made of
    law: LateralNavigation


def linear(scenario: Prepared | Scenario | str) -> LinearSystems:
    """Linear models of a prepared scenario, a scenario, a file or a bundled name.

    Raises ``ScenarioError`` where there is no JSBSim aircraft under a route law.
    """
    if isinstance(scenario, str):
        from sim.scenario.reading import read

        scenario = read(scenario)
    prepared = scenario if isinstance(scenario, Prepared) else prepare(scenario)
    leg, model, loop, law = run_isolated(prepared.scenario, MODEL_TIME_LIMIT, _models, prepared)
    return LinearSystems(
        leg,
        aircraft_system(model.A, model.B, model.states, model.inputs),
        bank_system(loop),
        opened_system(loop, law),
        closed_system(loop, law),
        loop,
        law,
    )


def _models(prepared: Prepared) -> tuple[Any, ...]:
    """What the aircraft itself has to be asked for."""
    loop = prepared.route_loop()
    leg, autopilot = prepared.route.legs[prepared.initial.leg], prepared.autopilot
    airframe = prepared.airframe.load()
    model = linearise(airframe, trim(airframe, leg.speed, 0.0, leg.height, autopilot.flaps, autopilot.gear))
    return leg, model, loop, LateralNavigation.of(prepared.law)
