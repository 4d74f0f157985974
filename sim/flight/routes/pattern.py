"""The landing pattern: downwind, base and final."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

from autopilot.approach import Approach
from autopilot.design import Designed
from autopilot.landing import REFERENCE_MARGIN, Landing
from autopilot.route import Route, pattern_route
from sim.flight.airspeeds import REFERENCE_ADDITION
from sim.flight.routes.kind import Decelerations, falling, wind_of_turns
from sim.flight.vehicles import Initial
from sim.scenario.model import Scenario
from sim.scenario.tables import STARTS, PatternTable


@dataclass(frozen=True)
class LandingPattern:
    """The pattern by its distances from the runway; see `sim.flight.routes.kind.RouteKind`."""

    scenario: Scenario
    table: PatternTable

    def route(self, landing: Landing | None) -> Route:
        """Speeds must fall along it, down to that of the landing."""
        table, runway = self.table, self.scenario.runway
        wind = wind_of_turns(self.scenario)
        assert landing is not None
        if not table.downwind_speed >= table.turn_speed >= landing.approach_speed:
            speeds = table.downwind_speed, table.turn_speed, landing.approach_speed
            true, shown = (
                "downwind {:.1f}, turn {:.1f}, approach {:.1f} m/s".format(*(share * speed for speed in speeds))
                for share in (1.0, self.scenario.air.equivalent_share(table.height))
            )
            raise ValueError(
                f"speeds must fall along the pattern, but they are {true} true, which an indicator shows there as "
                f"{shown}; the approach has at least {REFERENCE_MARGIN} of the stall speed and {REFERENCE_ADDITION} "
                "m/s as indicated: raise the others, or give all three as charts do, with indicated_turn_speed_mps "
                "for turn_speed_mps"
            )
        return pattern_route(
            table.side,
            height=table.height,
            downwind_abeam=table.downwind_abeam,
            base_distance=table.base_distance,
            downwind_speed=table.downwind_speed,
            turn_speed=table.turn_speed,
            aiming_point=runway.aiming_point,
            runway_heading=runway.heading,
            wind=wind,
        )

    @property
    def decelerations(self) -> Decelerations:
        """As the table says."""
        return falling(self.table.deceleration, self.table.glide_deceleration)

    @property
    def speeds(self) -> tuple[tuple[float, float], ...]:
        """Those of the legs."""
        return ()

    @property
    def localiser(self) -> float | None:
        """None: its final is flown by the route."""
        return None

    def offset(self, route: Route) -> float:
        """Unlimited: a turn leads to a leg from anywhere."""
        return math.inf

    def first_leg(self) -> int:
        """By its phase, or by its number."""
        start = self.scenario.start
        if start.phase is None:
            return start.leg or 0
        if start.phase not in STARTS:
            raise ValueError(f"phase must be one of {', '.join(STARTS)}, not '{start.phase}'")
        return STARTS[start.phase]

    def begins(self, on_leg: Initial, level: Initial) -> Initial:
        """On the leg."""
        return on_leg

    def controller(self, approach: Approach, gains: Designed, leaving: Callable[[Approach], Any]) -> Any:
        """The approach."""
        return leaving(approach)
