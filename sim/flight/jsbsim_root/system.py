"""The system of a JSBSim aircraft that flies a scenario: the text of autopilot and inner loops, translated.

JSBSim moves the aircraft at the beginning of a frame, then runs its systems, then works out what depends on the motion.
The autopilot steps between two frames: so its system runs at the beginning of the next frame, before the controls, on
the motion that was kept a frame ago and on the air data of the frame before, and both see the same numbers.
"""

from __future__ import annotations

import xml.etree.ElementTree as ElementTree
from typing import Any

from aircraft import properties
from aircraft.airframe import Wiring
from aircraft.state import AircraftState
from sim.flight.jsbsim_root.crew import Crew, CrewState, Orders
from sim.interchange.jsbsim_system.components import Element, Written, written
from sim.interchange.jsbsim_system.terms import PROPERTY, Refused, Term, Terms
from sim.interchange.jsbsim_system.translation import translated
from sim.interchange.jsbsim_system.values import leaves, rebuilt

NAME = "shortfinal"  # of the system, and of all its properties
FLYING, DUE, WAITS = (f"{NAME}/rhythm/{name}" for name in ("flying", "due", "frames-to-wait"))
KEPT, REMEMBERED, ORDERED = (f"{NAME}/{name}" for name in ("kept", "remembered", "orders"))
WHEELS = f"{NAME}/main-wheels"
AIR_DATA = ("airspeed", "equivalent_airspeed", "angle_of_attack", "sideslip")  # worked out behind the systems of a frame
LATER = AircraftState._fields.index("specific_force_forward")  # from here on no autopilot looks at anything but these:
CONFIGURATION = ("flaps", "gear", "main_wheels")


def system(crew: Crew, s: CrewState, wiring: Wiring, rate: float, elevation: float) -> Element:
    """The ``<system>`` that begins with a state of the crew; raises ``Refused`` for what cannot be translated.

    ``rate`` (Hz) is that of the frames, ``elevation`` (m) the threshold's.
    """
    terms, writer = Terms(), Written(NAME)
    root = Element("system", {"name": NAME})
    remembered = rebuilt(s, lambda place, number: terms.property(f"{REMEMBERED}/{place}", type(number)))
    now, orders = translated(terms, crew.step, remembered, _state(terms, wiring, elevation))
    for place, number in leaves(s):
        _declare(root, f"{REMEMBERED}/{place}", terms.of(number).data)
    for name in (FLYING, DUE, WAITS, WHEELS, *(f"{KEPT}/{field}" for field in _moving())):
        _declare(root, name, 0.0)
    waits = terms.property(WAITS)
    flying = terms.apply("ge", terms.property("simulation/sim-time-sec"), 0.5 / rate, kind=bool)
    still = terms.apply("le", waits, 0.5, kind=bool)
    root.append(writer.channel("rhythm", [(FLYING, flying), (DUE, terms.all([flying, still]))]))
    law = [*_controls(terms, orders, wiring), *_changes(terms, s, now, remembered), *_told(terms, orders)]
    law.append((WAITS, terms.apply("product", rate, orders.lasts)))
    root.append(writer.channel("autopilot", law, DUE))
    root.append(writer.channel("frame", _at_the_end(terms, wiring, waits)))
    return root


def _moving() -> list[str]:
    """Fields that JSBSim has moved on before its systems run."""
    return [name for name in AircraftState._fields[:LATER] if name not in AIR_DATA]


def _state(terms: Terms, wiring: Wiring, elevation: float) -> AircraftState:
    """What the autopilot sees, in SI: the motion as it was kept, the rest as it is."""
    seen: dict[str, Any] = {}
    for name, of in zip(AircraftState._fields[:LATER], wiring.state, strict=True):
        kept = terms.property(f"{KEPT}/{name}") if name not in AIR_DATA else terms.property(of.name)
        seen[name] = kept if of.factor == 1.0 else terms.apply("product", kept, of.factor)
    if elevation:
        seen["height"] = terms.apply("difference", seen["height"], elevation)
    seen["flaps"] = terms.apply("product", terms.property(wiring.flaps.name), wiring.flaps.factor)
    seen["gear"] = terms.property(properties.GEAR.name)
    seen["main_wheels"] = _main_wheels(terms, wiring)
    for name, value in seen.items():
        if not value.is_leaf:
            value.label = f"state/{name}"
    return AircraftState(*(seen.get(name, UNSEEN) for name in AircraftState._fields))


def _main_wheels(terms: Terms, wiring: Wiring) -> Term:
    """The share of the main wheels that are on the ground."""
    wheels = [terms.property(name) for name in wiring.main_wheels]
    share: Term = terms.apply("quotient", terms.apply("sum", *wheels), float(max(len(wheels), 1)))
    return share if wheels else terms.of(0.0)


class _Unseen:
    """Forces and contacts, which no autopilot looks at."""


UNSEEN = _Unseen()


def _controls(terms: Terms, orders: Orders, wiring: Wiring) -> list[tuple[str, Term]]:
    """Properties of the aircraft and what is written to them, as ``aircraft.airframe`` does."""
    controls = orders.controls
    surfaces = zip(properties.SURFACES, (controls.aileron, controls.elevator, controls.rudder), strict=True)
    set_ = [(of.name, value if of.factor == 1.0 else terms.apply("product", value, of.factor)) for of, value in surfaces]
    set_ += [(name, controls.throttle) for name in wiring.throttles]
    if wiring.full_flaps:
        set_.append((properties.FLAPS_COMMAND.name, terms.apply("quotient", controls.flaps, wiring.full_flaps)))
    set_.append((properties.GEAR_COMMAND.name, controls.gear))
    return [(name, terms.of(value)) for name, value in set_]


def _changes(terms: Terms, s: CrewState, now: CrewState, before: CrewState) -> list[tuple[str, Term]]:
    """What is remembered and has changed."""
    old = dict(leaves(before))
    changed = []
    for place, value in leaves(now):
        if place not in old:
            raise Refused(f"what is remembered changes its form at '{place}'")
        if value is not old[place]:
            changed.append((f"{REMEMBERED}/{place}", terms.of(value)))
    if len(leaves(now)) != len(old):
        raise Refused("what is remembered changes its form")
    return changed


def _told(terms: Terms, orders: Orders) -> list[tuple[str, Term]]:
    """The command and how long it holds, for whoever looks."""
    told = [(f"{ORDERED}/{place}", value) for place, value in leaves(orders.command)]
    return [(name, terms.of(value)) for name, value in told]


def _at_the_end(terms: Terms, wiring: Wiring, waits: Term) -> list[tuple[str, Term]]:
    """What every frame keeps for the next."""
    flying = terms.property(FLYING, bool)
    left = terms.choice(flying, terms.apply("difference", waits, 1.0), waits)
    kept = [
        (f"{KEPT}/{name}", terms.property(of.name))
        for name, of in zip(AircraftState._fields[:LATER], wiring.state, strict=True)
        if name not in AIR_DATA
    ]
    return [(WAITS, left), (WHEELS, _main_wheels(terms, wiring)), *kept]


def _declare(root: Element, name: str, value: float) -> None:
    """A property with its value at the start."""
    ElementTree.SubElement(root, PROPERTY, {"value": written(value)}).text = name
