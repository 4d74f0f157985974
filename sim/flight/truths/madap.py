"""One flight of the MADAP benchmark of operational trackers."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Annotated

import numpy as np

from autopilot.route import Leg, Route
from sim.flight.record import RECORD_STEP, Flight
from sim.flight.truths._motion import prescribed_flight
from sim.flight.truths._turns import Turn, TurningFlight

NAUTICAL_MILE = 1852.0  # m
KNOT = NAUTICAL_MILE / 3600.0  # m/s

SPEEDS = tuple(knots * KNOT for knots in (240.0, 360.0, 480.0, 600.0))
BANKS = tuple(math.radians(degrees) for degrees in (15.0, 30.0, 45.0, 60.0))


@dataclass(frozen=True)
class Madap:
    """A straight of 20 nautical miles, then a turn of 175 degrees, level and at constant speed [MADAP, flights].

    The sixteen flights are those of `SPEEDS` by `BANKS`. Where the aircraft starts, which way it turns, how fast it
    rolls and how long it flies on are not published: ours.
    """

    speed: Annotated[float, "m/s"] = SPEEDS[0]
    bank: Annotated[float, "rad"] = BANKS[0]
    roll_rate: Annotated[float, "rad/s"] = math.radians(5.0)
    straight: Annotated[float, "m"] = 20.0 * NAUTICAL_MILE
    turn: Annotated[float, "rad"] = math.radians(175.0)  # + right
    after: Annotated[float, "s"] = 60.0  # of straight flight behind the turn
    north: Annotated[float, "m"] = -20000.0  # where the straight begins
    east: Annotated[float, "m"] = -30000.0
    height: Annotated[float, "m"] = 6000.0
    course: Annotated[float, "rad"] = math.radians(45.0)

    def __post_init__(self) -> None:
        for name in ("straight", "after", "height"):
            if not getattr(self, name) > 0.0:
                raise ValueError(f"{name} of a MADAP flight must be above 0")

    def fly(self, *, step: float = RECORD_STEP) -> Flight:
        """Phases straight, turn, after."""
        turns = (Turn(self.straight / self.speed, self.turn),)
        start = (self.north, self.east, self.height)
        flown = TurningFlight(self.speed, self.bank, self.roll_rate, turns, self.after, start, self.course)
        state = flown.state(step)
        end = (
            self.north + self.straight * math.cos(self.course),
            self.east + self.straight * math.sin(self.course),
        )
        route = Route((Leg(start[:2], end, self.speed, self.height),))
        knots, _ = flown.knots
        phase = np.searchsorted([knots[1], knots[4]], state.time, side="right")
        return prescribed_flight(state, route, 0, phase, ("straight", "turn", "after"), "end of the prescribed path")
