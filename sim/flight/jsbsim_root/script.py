"""How JSBSim begins and ends the flight: initial conditions and script.

JSBSim's script cannot start in a trimmed state with levers, flaps and engines where they belong. So the clock begins
before 0 with the motion frozen, and everything but the motion runs until it stands where the trim has it.
"""

from __future__ import annotations

import math
import xml.etree.ElementTree as ElementTree

from aircraft import properties
from aircraft.airframe import Wiring
from aircraft.power_plant import FROZEN, INTEGRATORS
from aircraft.state import AircraftState
from sim.flight.jsbsim_root import system
from sim.interchange.jsbsim_system.components import Element, written

SETTLING = 60.0  # s; flaps, gear and engines are where they shall be
START = "start"  # name of the initial conditions
EVERY_STEP = ("simulation/sim-time-sec",)


def initial(state: AircraftState, elevation: float) -> Element:
    """``<initialize>``: where the flight begins, and at which velocity over the ground."""
    root = Element("initialize", {"name": START})
    _said(root, "elevation", "FT", elevation / properties.FOOT)
    _said(root, "altitudeMSL", "FT", (state.height + elevation) / properties.FOOT)
    _said(root, "latitude", "RAD", state.north / properties.EARTH_RADIUS).set("type", "geoc")
    _said(root, "longitude", "RAD", state.east / properties.EARTH_RADIUS)
    for name, angle in (("phi", state.bank), ("theta", state.pitch), ("psi", state.heading)):
        _said(root, name, "RAD", angle)
    velocity = ("vnorth", state.velocity_north), ("veast", state.velocity_east), ("vdown", -state.velocity_up)
    for name, speed in velocity:
        _said(root, name, "FT/SEC", speed / properties.FOOT)
    return root


def script(
    name: str,
    model: str,
    state: AircraftState,
    wiring: Wiring,
    rate: float,
    end: float,
    air: tuple[float, float] | None,
    wind: tuple[float, float, float],
    finished: int | None,
) -> Element:
    """``<runscript>``.

    ``end`` in s; ``air`` is what ``properties.AIR`` are set to, in SI; ``wind`` in m/s (north, east, up); ``finished``
    the place in what is remembered that is not 0 once the autopilot is at its end.
    """
    root = Element("runscript", {"name": name})
    ElementTree.SubElement(root, "use", {"aircraft": model, "initialize": START})
    run = ElementTree.SubElement(
        root, "run", {"start": written(-SETTLING), "end": written(end), "dt": written(1.0 / rate)}
    )
    for wanted, value in zip(properties.AIR, air or (), strict=False):
        ElementTree.SubElement(run, "property", {"value": written(value / wanted.factor)}).text = wanted.name
    levers = _levers(state, wiring)
    for lever, value in levers:
        ElementTree.SubElement(run, "property", {"value": written(value)}).text = lever
    blowing = [(of.name, speed / of.factor) for of, speed in zip(properties.WIND, wind, strict=True)]
    frozen = [(integrator, FROZEN) for integrator, _ in INTEGRATORS]
    fuel = []
    _event(run, "settle", [f"simulation/sim-time-sec ge {written(-2.0 * SETTLING)}"], [*frozen, *fuel, *blowing, *levers])
    _event(run, "fly", [f"simulation/sim-time-sec ge {written(0.5 / rate)}"], list(INTEGRATORS))
    return root


def _levers(state: AircraftState, wiring: Wiring) -> list[tuple[str, float]]:
    """The controls as the trim has them, by property."""
    surfaces = (state.aileron, state.elevator, state.rudder)
    levers = [(of.name, value * of.factor) for of, value in zip(properties.SURFACES, surfaces, strict=True)]
    levers += [(throttle, state.throttle) for throttle in wiring.throttles]
    if wiring.full_flaps:
        levers.append((properties.FLAPS_COMMAND.name, state.flaps / wiring.full_flaps))
    return [*levers, (properties.GEAR_COMMAND.name, state.gear)]


def _said(root: Element, tag: str, unit: str, value: float) -> Element:
    element = ElementTree.SubElement(root, tag, {"unit": unit})
    element.text = written(value)
    return element


def _event(run: Element, name: str, conditions: list[str], sets: list[tuple[str, float]]) -> Element:
    """Something that is set once when all conditions are first met."""
    event = ElementTree.SubElement(run, "event", {"name": name})
    ElementTree.SubElement(event, "condition").text = "\n".join(conditions)
    for target, value in sets:
        ElementTree.SubElement(event, "set", {"name": target, "value": written(value)})
    return event
