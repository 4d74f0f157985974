"""fly(): vehicle and autopilot in closed loop, recorded at 30 Hz until something ends the flight."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np

from aircraft.state import AircraftState, Command
from autopilot.route import PathDeviation, Route
from sim.outcomes import Judge, Limits

RECORD_STEP = 1.0 / 30.0  # s, of the record and of the autopilot
NEAR_GROUND = 60.0  # m; below, the autopilot runs at twice the rate for the flare


class Event(NamedTuple):
    """Something that happened once."""

    time: float  # s
    name: str
    detail: str = ""


@dataclass(frozen=True)
class Flight:
    """One closed-loop flight; every array has the record's k instants in front."""

    route: Route
    state: AircraftState  # of arrays (k,)
    command: Command  # of arrays (k,)
    leg: np.ndarray  # (k,) int
    phase: np.ndarray  # (k,) index into phases
    phases: tuple[str, ...]
    wind: np.ndarray  # (3, k) m/s, the way the air moves: north, east, up
    events: tuple[Event, ...]
    outcome: str
    reason: str

    @property
    def time(self) -> np.ndarray:
        """(k,) s."""
        return self.state.time

    @property
    def deviation(self) -> PathDeviation:
        """Deviation from the leg that was active, of arrays (k,)."""
        s = self.state
        return self.route.deviation(self.leg, (s.north, s.east), (s.velocity_north, s.velocity_east), s.heading)

    def during(self, phases: str | tuple[str, ...]) -> np.ndarray:
        """(k,) bool: where one of the phases was flown; ``all`` is everywhere."""
        wanted = (phases,) if isinstance(phases, str) else phases
        if "all" in wanted:
            return np.ones(len(self.time), bool)
        return np.isin(self.phase, [i for i, name in enumerate(self.phases) if name in wanted])


def fly(
    vehicle: Any, autopilot: Any, initial: Any, wind: Any, limits: Limits, route: Route, phases: tuple[str, ...]
) -> Flight:
    """Fly one flight to its end.

    ``vehicle`` and ``autopilot`` are begun here and stepped by turns: the autopilot sees the state, the vehicle flies
    the command. A flight that diverges is an outcome with its time, never an exception.
    """
    body = vehicle.begin(initial, wind)
    state = vehicle.read(body)
    pilot = autopilot.begin(state)
    judge = Judge(limits, route)
    states, commands, legs, modes, winds, events = [], [], [], [], [], []
    half = RECORD_STEP / 2
    pilot_phase = -1
    while True:
        dt = RECORD_STEP
        pilot, command = autopilot.step(pilot, state, dt if state.height > NEAR_GROUND else half)
        states.append(state)
        commands.append(command)
        legs.append(pilot.leg)
        modes.append(pilot.phase)
        winds.append(wind.last)
        if pilot.phase != pilot_phase:
            events.append(Event(state.time, phases[pilot.phase]))
            pilot_phase = pilot.phase
        verdict = judge(state, pilot)
        if verdict is not None:
            break
        if state.height > NEAR_GROUND:
            body = vehicle.step(body, command, dt)
        else:
            body = vehicle.step(body, command, half)
            pilot, command = autopilot.step(pilot, vehicle.read(body), half)
            body = vehicle.step(body, command, half)
        state = vehicle.read(body)
        if not math.isfinite(state.north + state.east + state.height + state.bank):
            verdict = (
                "diverged",
                f"the motion is no longer finite at {states[-1].time:.2f} s; last state {states[-1]}",
            )
            break
    outcome, reason = verdict
    events.append(Event(states[-1].time, outcome, reason))
    return Flight(
        route,
        AircraftState(*np.array(states, float).T),
        Command(*np.array(commands, float).T),
        np.array(legs),
        np.array(modes),
        phases,
        np.array(winds, float).T,
        tuple(events),
        outcome,
        reason,
    )
