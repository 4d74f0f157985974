"""A route of straight legs, which ends in no landing."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

from autopilot.approach import Approach
from autopilot.design import Designed
from autopilot.landing import Landing
from autopilot.route import Leg, Route
from sim.flight.routes.kind import Decelerations, wind_of_turns
from sim.flight.vehicles import Initial
from sim.scenario.model import Scenario
from sim.scenario.tables import LegsTable


@dataclass(frozen=True)
class StraightLegs:
    """The legs as they are listed; see `sim.flight.routes.kind.RouteKind`."""

    scenario: Scenario
    table: LegsTable

    def route(self, landing: Landing | None) -> Route:
        """Each with its own speed and height."""
        legs = tuple(Leg(leg.from_, leg.to, leg.speed, leg.height) for leg in self.table.legs)
        return Route(legs, wind_of_turns(self.scenario))

    @property
    def decelerations(self) -> Decelerations:
        """As the autopilot is made."""
        return Decelerations()

    @property
    def speeds(self) -> tuple[tuple[float, float], ...]:
        """Those of the legs."""
        return ()

    def offset(self, route: Route) -> float:
        """Of a single leg that of the start; a turn leads to others from anywhere."""
        return abs(self.scenario.start.cross_track) if len(route.legs) == 1 else math.inf

    def first_leg(self) -> int:
        """By its number."""
        return numbered_leg(self.scenario)

    def begins(self, on_leg: Initial, level: Initial) -> Initial:
        """On the leg."""
        return on_leg

    @property
    def localiser(self) -> float | None:
        """None: it leads to no runway."""
        return None

    def controller(self, approach: Approach, gains: Designed, leaving: Callable[[Approach], Any]) -> Any:
        """The approach."""
        return leaving(approach)


def numbered_leg(scenario: Scenario) -> int:
    """The leg of a ``[start]``, which must name no phase."""
    if scenario.start.phase is not None:
        raise ValueError("'phase' belongs to a pattern; say 'leg' on a route of legs")
    return scenario.start.leg or 0
