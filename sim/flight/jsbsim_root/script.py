"""How JSBSim begins and ends the flight: initial conditions and script.

A script of JSBSim cannot begin in a trim with levers, flaps and engines where they belong. So its clock begins before 0
with the motion frozen, and all else runs until it stands where the trim has it.
"""

from __future__ import annotations

import xml.etree.ElementTree as ElementTree
from collections.abc import Callable
from typing import NamedTuple

from aircraft import properties
from aircraft.airframe import Wiring
from aircraft.power_plant import FROZEN, INTEGRATORS, LEVERS
from aircraft.state import AircraftState
from sim.flight.jsbsim_root.system import FLYING, KEPT, ORDERED, REMEMBERED, TOUCHDOWN, WHEELS
from sim.flight.outcomes import SUNK
from sim.interchange.jsbsim_system.components import Element, written

SETTLING = 60.0  # s; flaps, gear and engines are where they shall be
START = "start"  # name of the initial conditions
MOST_ENGINES = 8
TIME, TERMINATE = "simulation/sim-time-sec", "simulation/terminate"
ENGINES = (("propulsion/set-running", -1.0), ("propulsion/fuel_freeze", 1.0))  # all run, on fuel that weighs the same
RECORDED = (
    *("position/lat-gc-rad", "position/long-gc-rad", "position/h-sl-ft", "velocities/v-north-fps"),
    *("velocities/v-east-fps", "velocities/v-down-fps", "attitude/phi-rad", "attitude/theta-rad", "attitude/psi-rad"),
    *("velocities/vt-fps", "fcs/aileron-cmd-norm", "fcs/elevator-cmd-norm", "fcs/rudder-cmd-norm"),
    *("fcs/throttle-cmd-norm[0]", f"{ORDERED}/bank", f"{ORDERED}/height", f"{ORDERED}/airspeed"),
    *(f"{REMEMBERED}/pilot/phase", f"{REMEMBERED}/pilot/leg", WHEELS),
)


class Start(NamedTuple):
    """How a flight begins."""

    state: AircraftState
    air: tuple[float, float] | None  # what ``properties.AIR`` are set to, in SI; None = the standard atmosphere
    wind: tuple[float, float, float]  # m/s (north, east, up)
    elevation: float  # m, of the threshold


def initial(start: Start) -> Element:
    """``<initialize>``: where the flight begins, and at which velocity over the ground."""
    state, root = start.state, Element("initialize", {"name": START})
    _said(root, "elevation", "FT", start.elevation / properties.FOOT)
    _said(root, "altitudeMSL", "FT", (state.height + start.elevation) / properties.FOOT)
    _said(root, "latitude", "RAD", state.north / properties.EARTH_RADIUS).set("type", "geoc")
    _said(root, "longitude", "RAD", state.east / properties.EARTH_RADIUS)
    for name, angle in (("phi", state.bank), ("theta", state.pitch), ("psi", state.heading)):
        _said(root, name, "RAD", angle)
    velocity = ("vnorth", state.velocity_north), ("veast", state.velocity_east), ("vdown", -state.velocity_up)
    for name, speed in velocity:
        _said(root, name, "FT/SEC", speed / properties.FOOT)
    return root


def script(
    name: str, model: str, start: Start, wiring: Wiring, has: Callable[[str], bool], rate: float, end: float
) -> Element:
    """``<runscript>``, to be flown at ``rate`` (Hz) until ``end`` (s); ``has`` says which properties the model has."""
    root = Element("runscript", {"name": name})
    ElementTree.SubElement(root, "use", {"aircraft": model, "initialize": START})
    times = {"start": written(-SETTLING), "end": written(end), "dt": written(1.0 / rate)}
    run = ElementTree.SubElement(root, "run", times)
    for of, value in zip(properties.AIR, start.air or (), strict=False):
        ElementTree.SubElement(run, "property", {"value": written(value / of.factor)}).text = of.name
    levers = _levers(start.state, wiring) + _engine_levers(has)
    for lever, value in levers:
        ElementTree.SubElement(run, "property", {"value": written(value)}).text = lever
    blowing = [(of.name, speed / of.factor) for of, speed in zip(properties.WIND, start.wind, strict=True)]
    frozen = [(integrator, float(FROZEN)) for integrator, _ in INTEGRATORS]
    engines = list(ENGINES) if has(ENGINES[0][0]) else []
    _event(run, "settle", [f"{TIME} le 0"], [*frozen, *engines, *blowing, *levers])
    wrong = [f"simulation/dt {than} {written(share / rate)}" for than, share in (("lt", 0.999), ("gt", 1.001))]
    stop = [(TERMINATE, 1.0)]
    _notify(_event(run, f"the step must be 1/{rate:g} s", wrong, stop, "OR"), "simulation/dt")
    methods = [(integrator, float(method)) for integrator, method in INTEGRATORS]
    _event(run, "fly", [f"{TIME} ge {written(0.5 / rate)}"], methods)
    figures = [f"{TOUCHDOWN}/{name}" for name in ("time-s", "past-threshold-m", "right-of-centreline-m", "sink-mps")]
    _notify(_event(run, "touchdown", [f"{FLYING} gt 0", f"{WHEELS} gt 0"], []), *figures)
    _notify(_event(run, "landed", [f"{WHEELS} ge 1"], stop), TIME)
    _notify(_event(run, "the autopilot is at its end", [f"{REMEMBERED}/pilot/finished gt 0"], stop), TIME)
    sunk = [f"{FLYING} gt 0", f"{KEPT}/height lt {written((SUNK + start.elevation) / properties.FOOT)}"]
    _notify(_event(run, "below the ground", sunk, stop), TIME)
    output = ElementTree.SubElement(root, "output", {"name": f"{name}.csv", "type": "CSV", "rate": "30"})
    for recorded in RECORDED:
        ElementTree.SubElement(output, "property").text = recorded
    return root


def _levers(state: AircraftState, wiring: Wiring) -> list[tuple[str, float]]:
    """The controls as the trim has them, by property."""
    surfaces = (state.aileron, state.elevator, state.rudder)
    levers = [(of.name, value * of.factor) for of, value in zip(properties.SURFACES, surfaces, strict=True)]
    levers += [(throttle, state.throttle) for throttle in wiring.throttles]
    if wiring.full_flaps:
        levers.append((properties.FLAPS_COMMAND.name, state.flaps / wiring.full_flaps))
    return [*levers, (properties.GEAR_COMMAND.name, state.gear)]


def _engine_levers(has: Callable[[str], bool]) -> list[tuple[str, float]]:
    """Propeller levers forward and mixture rich, of every engine that has them."""
    names = [f"{lever}[{number}]" for lever in LEVERS for number in range(MOST_ENGINES)]
    return [(name, 1.0) for name in names if has(name)]


def _said(root: Element, tag: str, unit: str, value: float) -> Element:
    element = ElementTree.SubElement(root, tag, {"unit": unit})
    element.text = written(value)
    return element


def _event(
    run: Element, name: str, conditions: list[str], sets: list[tuple[str, float]], logic: str = "AND"
) -> Element:
    """What is set once, when the conditions are first met."""
    event = ElementTree.SubElement(run, "event", {"name": name})
    ElementTree.SubElement(event, "condition", {"logic": logic}).text = "\n".join(conditions)
    for target, value in sets:
        ElementTree.SubElement(event, "set", {"name": target, "value": written(value)})
    return event


def _notify(event: Element, *shown: str) -> None:
    """Say on the console that it happened, with some properties."""
    notify = ElementTree.SubElement(event, "notify")
    for name in shown:
        ElementTree.SubElement(notify, "property").text = name
