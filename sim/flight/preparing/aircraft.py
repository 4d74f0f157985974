"""The aircraft of a scenario: its data, its model over the runway, what flies it, and the loop it closes on a leg."""

from __future__ import annotations

from typing import Any

from aircraft.data import AircraftData
from aircraft.errors import ModelError
from aircraft.point_mass import PointMass
from aircraft.runway import Runway as Place
from aircraft.slowest import complete
from autopilot.approach import Approach
from autopilot.design import Designed
from autopilot.route import Leg
from autopilot.route_loop import RouteLoop, lag_loop
from sim.flight.gains import known_flap_settings
from sim.flight.vehicles import AirframeChoice, JsbsimVehicle, PointMassVehicle, leg_loop
from sim.scenario.model import Scenario


def data_of(scenario: Scenario) -> AircraftData:
    """Its data; raises ``ModelError`` where mass or balance lie beyond them."""
    model = scenario.aircraft.model
    known = (
        AircraftData("point mass")
        if model == "point_mass"
        else complete(model, scenario.aircraft.repairs, known_flap_settings)
    )
    if model == "point_mass" and scenario.aircraft.factors:
        raise ModelError("the point mass has no factors")
    mass = scenario.aircraft.mass
    if mass is not None and not known.mass_min <= mass <= known.mass_max:
        raise ModelError(
            f"mass of {known.title} must lie within {known.mass_min:.0f} and {known.mass_max:.0f} kg, not {mass:.0f} kg"
        )
    balance = scenario.aircraft.centre_of_gravity_mac
    low, high = known.centre_of_gravity_min, known.centre_of_gravity_max
    if balance is not None and not low <= balance <= high:
        raise ModelError(f"centre_of_gravity_mac of {known.title} must lie within {low} and {high}, not {balance}")
    return known


def airframe_of(scenario: Scenario, rate: float | None = None) -> AirframeChoice:
    """Model, loading and runway; ``rate`` (Hz) of the equations of motion is the aircraft's where it is None."""
    choice, runway = scenario.aircraft, scenario.runway
    return AirframeChoice(
        choice.model,
        choice.mass,
        choice.centre_of_gravity_mac,
        choice.factors,
        Place(runway.latitude, runway.longitude, runway.elevation, runway.heading),
        scenario.air,
        rate,
        scenario.aircraft.repairs,
    )


def vehicle_of(scenario: Scenario, gains: Designed) -> Any:
    """What flies by these gains."""
    if scenario.aircraft.model == "point_mass":
        return PointMassVehicle(PointMass(air=scenario.air))
    return JsbsimVehicle(gains, airframe_of(scenario))


def loop_on(scenario: Scenario, gains: Designed, leg: Leg, flaps: float) -> RouteLoop:
    """The loop that the gains close on a leg."""
    if scenario.aircraft.model == "point_mass":
        return lag_loop(1.0 / gains.bank_bandwidth, leg.speed)
    return leg_loop(airframe_of(scenario), gains, leg.speed, leg.height, flaps, Approach.gear)
