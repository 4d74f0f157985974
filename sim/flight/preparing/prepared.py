"""All that one flight needs."""

from __future__ import annotations

import functools
from dataclasses import dataclass
from typing import Any

from aircraft.airframe import Wind
from autopilot.approach import PHASES, Approach
from autopilot.departure import Departing
from autopilot.design import Designed
from autopilot.mode import DesignCase, Mode
from autopilot.modes.lateral_navigation import LateralNavigation
from autopilot.route import Route
from autopilot.route_loop import RouteLoop
from autopilot.vectored import Vectored
from sim.errors import ScenarioError, did_you_mean
from sim.flight import departures
from sim.flight.gains import Gains
from sim.flight.outcomes import Limits
from sim.flight.preparing.aircraft import airframe_of, loop_on
from sim.flight.preparing.law import design_case
from sim.flight.record import Flight
from sim.flight.routes.kinds import route_kind
from sim.flight.vehicles import AirframeChoice, Initial, JsbsimVehicle
from sim.flight.weather import air
from sim.randomness import Streams
from sim.scenario import catalogue
from sim.scenario.model import Scenario
from sim.scenario.plugins import BUNDLED


@dataclass(frozen=True)
class Prepared:
    """All that one flight needs; built once in the parent, flown anywhere."""

    scenario: Scenario
    autopilot: Approach
    vehicle: Any
    initial: Initial
    limits: Limits
    gains: Gains  # as they travel in the scenario's file
    designed: Designed  # as they fly: intercepts may be shallower in this wind
    rate: float  # Hz, of the equations of motion
    warnings: tuple[str, ...]
    stall_speed: float | None = None  # m/s, equivalent, as it lands; None where none is known
    recording: Flight | None = None  # a flight that was flown elsewhere, in place of one that is flown here

    def __repr__(self) -> str:
        """One line; all that it holds fills pages."""
        scenario = self.scenario
        return f"<Prepared {scenario.name}: {scenario.aircraft.model} on {len(self.route.legs)} legs, {self.law!r}>"

    @property
    def design(self) -> dict[str, Any] | None:
        """The gains as they travel in the scenario's file; None = nothing is flown by them."""
        return None if self.recording is not None else self.gains.to_table()

    @property
    def controller(self) -> Approach | Departing | Vectored:
        """The autopilot, and from the stated departure times on what is flown instead of it; vectors before it."""
        leaving = functools.partial(
            departures.controller, law_called=self.law_called, departures=self.scenario.departures
        )
        controller: Approach | Departing | Vectored = route_kind(self.scenario).controller(
            self.autopilot, self.designed, leaving
        )
        return controller

    @property
    def departure(self) -> float | None:
        """When the law that trackers assume is first left, s; None = never."""
        return min((one.at for one in self.scenario.departures), default=None)

    def fault(self, sensors: tuple[str, ...]) -> float | None:
        """When something first goes wrong that a tracker of these sensors is not told, s; None = never."""
        worse = [one.at for one in self.scenario.sensor_faults if one.sensor in sensors and one.error_factor != 1.0]
        return min((one for one in (self.departure, *worse) if one is not None), default=None)

    @property
    def airframe(self) -> AirframeChoice:
        """The aircraft model, its loading, its runway and its rate."""
        return airframe_of(self.scenario, self.rate)

    @property
    def route(self) -> Route:
        """The route that is flown."""
        return self.autopilot.route

    @property
    def law(self) -> Mode:
        """The law that flies it."""
        law: Mode = self.autopilot.law
        return law

    @property
    def has_route_loop(self) -> bool:
        """Whether a route law flies an aircraft that has inner loops."""
        return LateralNavigation.of(self.law) is not None and isinstance(self.vehicle, JsbsimVehicle)

    def route_loop(self) -> RouteLoop:
        """The linear loop, for margins and limit cycles, that flies the leg on which the flight begins.

        Raises ``ScenarioError`` where there is none.
        """
        if not self.has_route_loop:
            wanted = "margins need a JSBSim aircraft under a route law, such as 'lateral_navigation'"
            raise ScenarioError(f"{self.scenario.name}: {wanted}")
        return loop_on(self.scenario, self.designed, self.route.legs[self.initial.leg], self.autopilot.flaps)

    @property
    def alternative_laws(self) -> tuple[Mode, ...]:
        """The laws that the autopilot could be switched to: of its other standard modes, as designed.

        Modes that are not standard are left out, so that a mode from outside changes no scenario but those that name
        it; so are laws with the same intent as an earlier one, because a tracker could not tell them apart.
        """
        laws: dict[str, Mode] = {self.law.intent: self.law}
        for mode in self._modes.values():
            if mode.standard and mode.intent not in laws:
                laws[mode.intent] = mode.designed({}, self.case)
        return tuple(laws.values())[1:]

    @property
    def case(self) -> DesignCase:
        """What a law of this flight is designed for."""
        return design_case(self.scenario, self.designed, self.route)

    def law_called(self, name: str) -> Mode:
        """The law of a mode, by its kind or by its intent without the word "law": the flown one, else as designed.

        Raises ``ValueError`` where no mode is called so.
        """
        modes = self._modes
        named = [name] if name in modes else [kind for kind in modes if modes[kind].intent == f"{name} law"]
        if self.scenario.mode in named:
            return self.law
        if not named:
            short = [mode.intent.removesuffix(" law") for mode in modes.values()]
            raise ValueError(f"flies: no law '{name}'; {did_you_mean(name, ['bank', 'offset', *short, *modes])}")
        return modes[named[0]].designed({}, self.case)

    @property
    def _modes(self) -> dict[str, type[Mode]]:
        """Every mode of the catalogue by its kind, and those from outside that the scenario names."""
        return {kind: BUNDLED.load("modes", kind) for kind in catalogue.kinds("modes")} | self.scenario.modes

    @property
    def gate_height(self) -> float | None:
        """Where the stabilised-approach gate begins, m; None = the route does not end in a landing."""
        landing = self.autopilot.landing
        return None if landing is None else landing.gate.height

    @property
    def phases(self) -> tuple[str, ...]:
        """Names of the phases by index."""
        return PHASES

    def wind(self, flight: int) -> Wind:
        """The air of one flight: turbulence has its own stream."""
        scenario = self.scenario
        noise = Streams(scenario.seed, flight, 1, "wind").generator("turbulence")
        return air(scenario.wind, scenario.runway, noise, self.rate)
