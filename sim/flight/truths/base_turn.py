"""Base leg, a left turn of a quarter circle, final."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from typing import Annotated

import numpy as np

from autopilot.route import Leg, Route
from sim.flight.record import RECORD_STEP, Flight
from sim.flight.truths._motion import prescribed_flight
from sim.flight.truths._turns import Turn, TurningFlight


@dataclass(frozen=True)
class BaseTurn:
    """The manoeuvre in which load factors help most: the turn onto final [Glistin, fig. 1].

    The paper gives no scenario; the geometry is ours. Final runs north along the runway's extended centreline.
    """

    speed: Annotated[float, "m/s"] = 72.0
    bank: Annotated[float, "rad"] = math.radians(15.0)
    roll_rate: Annotated[float, "rad/s"] = math.radians(5.0)
    distance: Annotated[float, "m"] = 8500.0  # of the base leg from the antenna
    height: Annotated[float, "m"] = 400.0
    base: Annotated[float, "s"] = 40.0  # of straight flight before the turn
    final: Annotated[float, "s"] = 40.0  # and behind it

    def __post_init__(self) -> None:
        for name in ("distance", "height", "base", "final"):
            if not getattr(self, name) > 0.0:
                raise ValueError(f"{name} of the base turn must be above 0")

    def fly(self, *, step: float = RECORD_STEP) -> Flight:
        """Phases base, final_turn, final."""
        turn = Turn(self.base, -0.5 * math.pi)
        start = (-self.distance, 0.0, self.height)
        flown = TurningFlight(self.speed, self.bank, self.roll_rate, (turn,), self.final, start, 0.5 * math.pi)
        east = -float(flown.state(step).east[-1])  # so that the turn ends on the centreline
        flown = replace(flown, start=(-self.distance, east, self.height))
        state = flown.state(step)
        corner = (-self.distance, 0.0)
        route = Route(
            (
                Leg((-self.distance, east), corner, self.speed, self.height),
                Leg(corner, (0.0, 0.0), self.speed, self.height),
            )
        )
        knots, _ = flown.knots
        leg = (state.time >= knots[1]).astype(int)
        phase = np.searchsorted([knots[1], knots[4]], state.time, side="right")
        return prescribed_flight(
            state, route, leg, phase, ("base", "final_turn", "final"), "end of the prescribed path"
        )
