"""JSBSim flying a root alone, and the Python that its system was translated from, asked beside it."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

import jsbsim
import numpy as np

from aircraft import properties
from aircraft.state import AircraftState
from autopilot.approach import PHASES
from sim.flight.jsbsim_root.crew import Crew, Orders
from sim.flight.jsbsim_root.folder import SCRIPT
from sim.flight.preparation import Prepared
from sim.flight.record import Flight
from sim.flight.weather import air


class Alone:
    """A root that is flown by JSBSim's own executive, from its script, without a step of ours."""

    def __init__(self, prepared: Prepared, root: Path, rate: float | None = None) -> None:
        scenario = prepared.scenario
        self.elevation, self.rate = scenario.runway.elevation, prepared.rate
        body = prepared.vehicle.begin(prepared.initial, air(scenario.wind, scenario.runway))
        self.wiring = body.airframe.wiring
        self.crew = Crew(prepared.controller, body.inner_loops)
        self.state = self.crew.begin(body.state, prepared.initial.leg)
        jsbsim.FGJSBBase().debug_lvl = 0
        self.executive = jsbsim.FGFDMExec(str(root))
        assert self.executive.load_script(str(SCRIPT), 1.0 / (rate or prepared.rate))
        self.executive.disable_output()
        self.executive.run_ic()

    def __getitem__(self, name: str) -> float:
        return float(self.executive[name])

    @property
    def phase(self) -> str:
        """What the system says."""
        return PHASES[round(self["shortfinal/remembered/pilot/phase"])]

    def seen(self) -> AircraftState:
        """The state between two frames, as ``aircraft.airframe`` reads it."""
        fields = {
            name: self[of.name] * of.factor for name, of in zip(AircraftState._fields, self.wiring.state, strict=False)
        }
        fields["height"] -= self.elevation
        fields["flaps"] = self[self.wiring.flaps.name] * self.wiring.flaps.factor
        fields["gear"] = self[properties.GEAR.name]
        wheels = [self[name] for name in self.wiring.main_wheels]
        fields["main_wheels"] = sum(wheels) / len(wheels)
        return AircraftState(*(fields.get(name, np.nan) for name in AircraftState._fields))

    def frames(self) -> Iterator[AircraftState]:
        """The state before each frame from the start of the flight on, until JSBSim ends it."""
        while True:
            before = self.seen()
            if not self.executive.run():
                return
            if self["simulation/sim-time-sec"] > 0.25 / self.rate:
                yield before

    def steps(self) -> Iterator[Orders]:
        """What Python orders at each step of the autopilot, once the system has done the same."""
        for before in self.frames():
            if self["shortfinal/rhythm/due"]:
                self.state, orders = self.crew.step(self.state, before)
                yield orders

    def apart(self, orders: Orders) -> float:
        """The largest difference between what Python orders and what the system has set, of the controls' full range
        and of the commands in SI."""
        controls, command = orders.controls, orders.command
        wanted = {of.name: value * of.factor for of, value in zip(properties.SURFACES, controls[:3], strict=True)}
        wanted |= dict.fromkeys(self.wiring.throttles, controls.throttle)
        wanted |= {properties.FLAPS_COMMAND.name: controls.flaps / self.wiring.full_flaps}
        wanted |= {properties.GEAR_COMMAND.name: controls.gear}
        wanted |= {f"shortfinal/command/{name}": getattr(command, name) for name in ("bank", "flight_path_angle")}
        relative = {f"shortfinal/command/{name}": getattr(command, name) for name in ("height", "airspeed")}
        return max(
            *(abs(self[name] - value) for name, value in wanted.items()),
            *(abs(self[name] / value - 1.0) for name, value in relative.items()),
        )


def departures(alone: Alone, flight: Flight) -> tuple[float, float]:
    """The largest distance in m, and difference of bank in rad, from a flight of ours at the instants of its record."""
    path = [(one.north, one.east, one.height, one.bank) for one in alone.frames()]
    step = round((flight.time[1] - flight.time[0]) * alone.rate)
    there = np.array(path)[: step * len(flight.time) : step].T
    ours = np.array([flight.state.north, flight.state.east, flight.state.height, flight.state.bank])[
        :, : there.shape[1]
    ]
    assert abs(there.shape[1] - len(flight.time)) <= 1
    return float(np.linalg.norm((there - ours)[:3], axis=0).max()), float(np.abs((there - ours)[3]).max())
