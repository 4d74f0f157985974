"""A pass close to the antenna, with a turn around it."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Annotated

import numpy as np

from autopilot.route import Leg, Route
from sim.flight.record import RECORD_STEP, Flight
from sim.flight.truths._motion import prescribed_flight
from sim.flight.truths._turns import Turn, TurningFlight


@dataclass(frozen=True)
class NearPass:
    """Inbound beside the antenna, then a left turn of a quarter circle around it [Glistin, fig. 1].

    The paper gives no scenario; the geometry is ours. The line of sight turns fast, so the Coriolis term dominates.
    """

    speed: Annotated[float, "m/s"] = 72.0
    bank: Annotated[float, "rad"] = math.radians(15.0)
    roll_rate: Annotated[float, "rad/s"] = math.radians(5.0)
    distance: Annotated[float, "m"] = 3000.0  # along the course before the antenna at the start
    offset: Annotated[float, "m"] = 1500.0  # to the right of it
    height: Annotated[float, "m"] = 300.0
    inbound: Annotated[float, "s"] = 30.0  # of straight flight before the turn
    outbound: Annotated[float, "s"] = 25.0  # and behind it

    def __post_init__(self) -> None:
        for name in ("distance", "offset", "height", "inbound", "outbound"):
            if not getattr(self, name) > 0.0:
                raise ValueError(f"{name} of the near pass must be above 0")

    def fly(self, *, step: float = RECORD_STEP) -> Flight:
        """Phases inbound, turn, outbound."""
        start = (-self.distance, self.offset, self.height)
        turns = (Turn(self.inbound, -0.5 * math.pi),)
        flown = TurningFlight(self.speed, self.bank, self.roll_rate, turns, self.outbound, start, 0.0)
        state = flown.state(step)
        last = (float(state.north[-1]), float(state.east[-1]))
        corner = (last[0], self.offset)
        route = Route((Leg(start[:2], corner, self.speed, self.height), Leg(corner, last, self.speed, self.height)))
        knots, _ = flown.knots
        leg = (state.time >= knots[1]).astype(int)
        phase = np.searchsorted([knots[1], knots[4]], state.time, side="right")
        return prescribed_flight(
            state, route, leg, phase, ("inbound", "turn", "outbound"), "end of the prescribed path"
        )
