"""Turns to both sides of the final course."""

from __future__ import annotations

import math
from dataclasses import dataclass
from itertools import pairwise
from typing import Annotated

import numpy as np

from autopilot.route import Leg, Route
from sim.flight.record import RECORD_STEP, Flight
from sim.flight.truths._motion import prescribed_flight
from sim.flight.truths._turns import Turn, TurningFlight


@dataclass(frozen=True)
class STurn:
    """Straight, a swing to the right and to the left of the course as often as asked, straight [Glistin, fig. 1].

    The paper gives no scenario; the geometry is ours. A signless acceleration formula cannot follow it.
    """

    speed: Annotated[float, "m/s"] = 72.0
    bank: Annotated[float, "rad"] = math.radians(20.0)
    roll_rate: Annotated[float, "rad/s"] = math.radians(5.0)
    swing: Annotated[float, "rad"] = math.radians(40.0)  # of the course to either side
    swings: int = 2  # to the right and to the left, alternating
    distance: Annotated[float, "m"] = 10000.0  # from the antenna at the start
    height: Annotated[float, "m"] = 400.0
    straight: Annotated[float, "s"] = 25.0  # before and behind

    def __post_init__(self) -> None:
        if not 0.0 < self.swing <= 0.5 * math.pi:
            raise ValueError(f"swing must lie between 0 and 90 deg, not {math.degrees(self.swing):.1f} deg")
        if self.swings < 1:
            raise ValueError(f"swings must be at least 1, not {self.swings}")
        for name in ("distance", "height", "straight"):
            if not getattr(self, name) > 0.0:
                raise ValueError(f"{name} of the S-turn must be above 0")

    def fly(self, *, step: float = RECORD_STEP) -> Flight:
        """Phases straight, turn, final."""
        side = [self.swing * (-1) ** i for i in range(self.swings)]
        courses = [0.0, *side, 0.0]
        changes = [after - before for before, after in pairwise(courses)]
        turns = tuple(Turn(self.straight if i == 0 else 0.0, change) for i, change in enumerate(changes))
        start = (-self.distance, 0.0, self.height)
        flown = TurningFlight(self.speed, self.bank, self.roll_rate, turns, self.straight, start, 0.0)
        state = flown.state(step)
        route = Route((Leg((-self.distance, 0.0), (0.0, 0.0), self.speed, self.height),))
        knots, _ = flown.knots
        phase = np.searchsorted([knots[1], knots[-2]], state.time, side="right")
        return prescribed_flight(state, route, 0, phase, ("straight", "turn", "final"), "end of the prescribed path")
