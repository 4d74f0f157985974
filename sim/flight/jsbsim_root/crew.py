"""One step of all that flies: autopilot and inner loops, at the rate that the height asks for."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, NamedTuple

from aircraft.state import AircraftState, Command, Controls
from autopilot.inner_loops import InnerLoops, LoopState
from sim.flight.loop import NEAR_GROUND
from sim.flight.record import RECORD_STEP


class CrewState(NamedTuple):
    """What is remembered from one step to the next."""

    pilot: Any  # of the autopilot
    loops: LoopState
    halved: bool  # whether the second half of a record is to be flown


class Orders(NamedTuple):
    """What a step gives: the controls, and how long they are held."""

    command: Command
    controls: Controls
    lasts: float  # s


@dataclass(frozen=True)
class Crew:
    """Flies as ``sim.flight.loop`` does: close to the ground a record is flown in two halves."""

    autopilot: Any
    inner_loops: InnerLoops

    def begin(self, state: AircraftState, leg: int) -> CrewState:
        """At the start of a flight."""
        return CrewState(self.autopilot.begin(state, leg), self.inner_loops.begin(state), False)

    def step(self, s: CrewState, state: AircraftState) -> tuple[CrewState, Orders]:
        """The controls from now on."""
        near = s.halved or state.height < NEAR_GROUND
        lasts = RECORD_STEP / 2 if near else RECORD_STEP
        pilot, command = self.autopilot.step(s.pilot, state, lasts)
        loops, controls = self.inner_loops.step(s.loops, command, state, lasts)
        return CrewState(pilot, loops, near and not s.halved), Orders(command, controls, lasts)
