"""The system of a JSBSim aircraft that flies a scenario: the text of autopilot and inner loops, translated.

JSBSim moves the aircraft at the beginning of a frame, then runs its systems, then works out what depends on the motion.
The autopilot steps between two frames: so its system runs at the beginning of the next frame, before the controls, on
the motion that was kept a frame ago and on the air data of the frame before, and both see the same numbers.
"""

from __future__ import annotations

import xml.etree.ElementTree as ElementTree
from typing import Any

from aircraft import properties
from aircraft.airframe import Wind, Wiring
from aircraft.state import AircraftState
from aircraft.wind import SteadyWind
from sim.flight.jsbsim_root.crew import Crew, CrewState, Orders
from sim.interchange.jsbsim_system.components import Element, Written, written
from sim.interchange.jsbsim_system.terms import PROPERTY, Refused, Term, Terms
from sim.interchange.jsbsim_system.translation import translated
from sim.interchange.jsbsim_system.values import leaves, rebuilt

NAME = "shortfinal"  # of the system, and of all its properties
FLYING, DUE, WAITS, CLOCK = (f"{NAME}/rhythm/{name}" for name in ("flying", "due", "frames-to-wait", "clock-s"))
KEPT, REMEMBERED, ORDERED, TOUCHDOWN, AIR = (
    f"{NAME}/{name}" for name in ("kept", "remembered", "command", "touchdown", "air-seen-from")
)
WHEELS = f"{TOUCHDOWN}/main-wheels"
AIR_DATA = (
    "airspeed",
    "equivalent_airspeed",
    "angle_of_attack",
    "sideslip",
)  # worked out behind the systems of a frame
LATER = AircraftState._fields.index("specific_force_forward")  # of what comes then, the autopilot looks at three fields
PLACE = ("north", "east", "height")

Outputs = list[tuple[str, Term]]  # properties, and what they are set to


class _Unseen:
    """Forces and contacts, which no autopilot looks at."""


UNSEEN = _Unseen()


class System:
    """Writes one system; ``rate`` (Hz) is that of the frames, ``runway`` where the threshold lies."""

    def __init__(self, wiring: Wiring, rate: float, runway: Any) -> None:
        self.wiring, self.rate, self.runway = wiring, rate, runway
        self.terms = Terms()
        self.root = Element("system", {"name": NAME})

    def element(self, crew: Crew, s: CrewState, wind: Wind) -> Element:
        """``<system>``, beginning with a state of the crew; raises ``Refused`` for what cannot be translated."""
        terms, writer = self.terms, Written(NAME)
        remembered = rebuilt(s, lambda place, number: terms.property(f"{REMEMBERED}/{place}", type(number)))
        now, orders = translated(terms, crew.step, remembered, self._state())
        for place, number in leaves(s):
            self._declare(f"{REMEMBERED}/{place}", terms.of(number).data)
        for name in (FLYING, DUE, WAITS, CLOCK, WHEELS, *(f"{KEPT}/{field}" for field in _moving(self.wiring))):
            self._declare(name, 0.0)
        waits = terms.property(WAITS)
        flying = terms.apply("ge", terms.property("simulation/sim-time-sec"), 0.5 / self.rate, kind=bool)
        due = terms.all([flying, terms.apply("le", waits, 0.5, kind=bool)])
        flying.label = "rhythm/since-half-a-frame"
        clock = terms.property(CLOCK)  # JSBSim's own began before 0, and rounds otherwise
        clock = terms.choice(flying, terms.apply("sum", clock, 1.0 / self.rate), clock)
        self.root.append(writer.channel("rhythm", [(FLYING, flying), (DUE, due), (CLOCK, clock)]))
        law = [*self._controls(orders), *self._changes(now, remembered)]
        law += [(f"{ORDERED}/{place}", terms.of(value)) for place, value in leaves(orders.command)]
        law.append((WAITS, terms.apply("product", self.rate, orders.lasts)))
        self.root.append(writer.channel("autopilot", law, DUE))
        self.root.append(writer.channel("frame", [*self._touchdown(), *self._wind(wind, waits), *self._kept(waits)]))
        return self.root

    def _declare(self, name: str, value: float) -> Term:
        """A property with its value at the start."""
        ElementTree.SubElement(self.root, PROPERTY, {"value": written(value)}).text = name
        return self.terms.property(name)

    def _in_si(self, value: Term, factor: float) -> Term:
        """A property in its SI unit."""
        product: Term = value if factor == 1.0 else self.terms.apply("product", value, factor)
        return product

    def _height(self, value: Term) -> Term:
        """Above the threshold, of that above sea level."""
        elevation = self.runway.elevation
        height: Term = self.terms.apply("difference", value, elevation) if elevation else value
        return height

    def _state(self) -> AircraftState:
        """What the autopilot sees, in SI: the motion as it was kept, the rest as it is."""
        terms, seen = self.terms, {}
        for name, of in zip(AircraftState._fields[:LATER], self.wiring.state, strict=True):
            seen[name] = self._in_si(terms.property(of.name if name in AIR_DATA else f"{KEPT}/{name}"), of.factor)
        seen["height"] = self._height(seen["height"])
        seen["flaps"] = self._in_si(terms.property(self.wiring.flaps.name), self.wiring.flaps.factor)
        seen["gear"] = terms.property(properties.GEAR.name)
        seen["main_wheels"] = self._main_wheels()
        for name, value in seen.items():
            if not value.is_leaf:
                value.label = f"state/{name}"
        state: Any = [seen.get(name, UNSEEN) for name in AircraftState._fields]
        return AircraftState(*state)

    def _main_wheels(self) -> Term:
        """The share of the main wheels that are on the ground."""
        wheels = [self.terms.property(name) for name in self.wiring.main_wheels]
        share: Term = self.terms.apply("quotient", self.terms.apply("sum", *wheels), float(max(len(wheels), 1)))
        return share if wheels else self.terms.of(0.0)

    def _controls(self, orders: Orders) -> Outputs:
        """Properties of the aircraft and what is written to them, as ``aircraft.airframe`` does."""
        terms, controls, wiring = self.terms, orders.controls, self.wiring
        surfaces = zip(properties.SURFACES, (controls.aileron, controls.elevator, controls.rudder), strict=True)
        outputs = [(of.name, self._in_si(terms.of(value), of.factor)) for of, value in surfaces]
        outputs += [(name, terms.of(controls.throttle)) for name in wiring.throttles]
        if wiring.full_flaps:
            outputs.append((properties.FLAPS_COMMAND.name, terms.apply("quotient", controls.flaps, wiring.full_flaps)))
        return [*outputs, (properties.GEAR_COMMAND.name, terms.of(controls.gear))]

    def _changes(self, now: CrewState, before: CrewState) -> Outputs:
        """What is remembered and has changed."""
        old, new = dict(leaves(before)), dict(leaves(now))
        if old.keys() != new.keys():
            raise Refused("what the autopilot remembers changes its form from step to step")
        return [
            (f"{REMEMBERED}/{place}", self.terms.of(value)) for place, value in new.items() if value is not old[place]
        ]

    def _kept(self, waits: Term) -> Outputs:
        """The motion, and how long the controls are held, for the next frame."""
        names = _moving(self.wiring)
        return [(WAITS, self._left(waits)), *((f"{KEPT}/{name}", self.terms.property(names[name])) for name in names)]

    def _left(self, waits: Term) -> Term:
        """Frames to wait after this one."""
        flying = self.terms.property(FLYING, bool)
        left: Term = self.terms.choice(flying, self.terms.apply("difference", waits, 1.0), waits)
        return left

    def _wind(self, wind: Wind, waits: Term) -> Outputs:
        """The wind of the next frame, seen from where the controls were last set; a steady one is the script's."""
        if isinstance(wind, SteadyWind):
            return []
        terms, names = self.terms, dict(zip(AircraftState._fields, self.wiring.state, strict=False))
        due = terms.apply("le", self._left(waits), 0.5, kind=bool)
        here, airspeed = (
            {name: self._in_si(terms.property(names[name].name), names[name].factor) for name in of}
            for of in (PLACE, ("airspeed",))
        )
        here["height"] = self._height(here["height"])
        place = {name: terms.choice(due, here[name], self._declare(f"{AIR}/{name}", 0.0)) for name in PLACE}
        velocity = translated(terms, wind.velocity, terms.property(CLOCK), tuple(place.values()), airspeed["airspeed"])
        outputs = [(f"{AIR}/{name}", place[name]) for name in PLACE]
        soon = terms.apply("ge", terms.property("simulation/sim-time-sec"), -0.5 / self.rate, kind=bool)
        north, east, up = velocity  # a trim is in horizontal wind; what blows up or down comes with the first step
        blowing = zip(properties.WIND, (north, east, terms.choice(soon, up, 0.0)), strict=True)
        return outputs + [(of.name, terms.apply("quotient", terms.of(speed), of.factor)) for of, speed in blowing]

    def _touchdown(self) -> Outputs:
        """Where and how the first main wheel met the ground; of the frame before, on which it did not act yet."""
        terms, names = self.terms, dict(zip(AircraftState._fields, self.wiring.state, strict=False))
        before = terms.apply("gt", terms.property(WHEELS), 0.0, kind=bool)
        kept = {name: self._in_si(terms.property(f"{KEPT}/{name}"), names[name].factor) for name in names}
        past, right = translated(terms, self.runway.from_local, kept["north"], kept["east"])
        figures = {
            "past-threshold-m": past,
            "right-of-centreline-m": right,
            "sink-mps": terms.apply("product", -1.0, kept["velocity_up"]),
            "time-s": kept["time"],
        }
        outputs = [
            (f"{TOUCHDOWN}/{name}", terms.choice(before, self._declare(f"{TOUCHDOWN}/{name}", 0.0), value))
            for name, value in figures.items()
        ]
        return [*outputs, (WHEELS, terms.apply("max", terms.property(WHEELS), self._main_wheels()))]


def _moving(wiring: Wiring) -> dict[str, str]:
    """Fields that JSBSim has moved on before its systems run, with their properties."""
    pairs = zip(AircraftState._fields[:LATER], wiring.state, strict=True)
    return {name: of.name for name, of in pairs if name not in AIR_DATA} | {"time": CLOCK}
