"""An autopilot that is not flown to the end: from stated times on the bank follows something else than the route law.

The trackers know nothing of it. Speed, height and the sequence of legs stay those of the approach.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Annotated, Any

from aircraft.state import AircraftState, Command
from autopilot.approach import Approach, ApproachState
from autopilot.route import PathDeviation, Route


@dataclass(frozen=True)
class HeldBank:
    """A bank that the crew holds by hand, wherever the aircraft is."""

    bank: Annotated[float, "rad"]
    bank_limit: Annotated[float, "rad"]  # of the turns between legs

    def __call__(self, deviation: PathDeviation) -> float:
        """Bank command, rad."""
        return self.bank

    def check_convergence(self, ground_speed: float, offset: float = math.inf, turns: bool = False) -> None:
        """Nothing: the crew knows that it leaves the leg."""


@dataclass(frozen=True)
class Displaced:
    """A law that flies a line beside the leg: the wrong runway, another waypoint, an offset that was typed in."""

    law: Annotated[Any, "given"]
    offset: Annotated[float, "m"]  # + right of the leg

    @property
    def bank_limit(self) -> float:
        """rad."""
        limit: float = self.law.bank_limit
        return limit

    def __call__(self, deviation: PathDeviation) -> Any:
        """Bank command, rad."""
        return self.law(deviation._replace(cross_track=deviation.cross_track - self.offset))

    def check_convergence(self, ground_speed: float, offset: float = math.inf, turns: bool = False) -> None:
        """As the law."""
        self.law.check_convergence(ground_speed, offset, turns)


@dataclass(frozen=True)
class Departing:
    """An approach whose law is replaced at stated times."""

    approach: Approach
    later: tuple[tuple[float, Approach], ...]  # (s, the same approach under another law), by rising time

    @property
    def route(self) -> Route:
        """The route that was to be flown."""
        return self.approach.route

    def begin(self, state: AircraftState, leg: int = 0) -> ApproachState:
        """As the approach."""
        return self.approach.begin(state, leg)

    def step(self, s: ApproachState, state: AircraftState, dt: float) -> tuple[ApproachState, Command]:
        """Command for the next ``dt`` seconds of whatever is flown now."""
        flown = self.approach
        for since, other in self.later:
            if state.time >= since:
                flown = other
        return flown.step(s, state, dt)
