"""A final approach to which vectors lead; ``sim.flight.arrivals.vectoring`` lays them out."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

from autopilot.approach import Approach
from autopilot.design import Designed
from autopilot.landing import REFERENCE_MARGIN, Landing
from autopilot.route import Route
from sim.flight.airspeeds import REFERENCE_ADDITION, extremes
from sim.flight.arrivals import vectoring
from sim.flight.routes.kind import Decelerations, falling
from sim.flight.routes.legs import numbered_leg
from sim.flight.vehicles import Initial
from sim.scenario.arrivals.vectored import VectoredTable
from sim.scenario.model import Scenario


@dataclass(frozen=True)
class VectoredFinal:
    """The final as the one leg, and the headings that are held before it; see `sim.flight.routes.kind.RouteKind`."""

    scenario: Scenario
    table: VectoredTable

    def route(self, landing: Landing | None) -> Route:
        """The final; speeds must fall along it, down to that of the landing."""
        assert landing is not None
        slowest = extremes(self.scenario)[0]
        if slowest < landing.approach_speed:
            raise ValueError(
                f"speeds must fall along the route, but {slowest:.1f} m/s true are flown before the glide path and "
                f"{landing.approach_speed:.1f} on it; the approach has at least {REFERENCE_MARGIN} of the stall speed "
                f"and {REFERENCE_ADDITION} m/s as indicated: raise 'speed' and its schedule"
            )
        return vectoring.final(self.scenario, self.table)

    @property
    def decelerations(self) -> Decelerations:
        """As the table says."""
        return falling(self.table.deceleration, self.table.glide_deceleration)

    @property
    def speeds(self) -> tuple[tuple[float, float], ...]:
        """The schedule of the table."""
        return vectoring.schedule(self.table)

    @property
    def localiser(self) -> float | None:
        """That of the autopilot's receiver."""
        return vectoring.localiser(self.scenario)

    def offset(self, route: Route) -> float:
        """None: the law captures where it turns in already, there is nothing from which it could orbit."""
        return 0.0

    def first_leg(self) -> int:
        """The final, whatever is flown before it."""
        return numbered_leg(self.scenario)

    def begins(self, on_leg: Initial, level: Initial) -> Initial:
        """Where the first heading is given, or on it from the stated distance; at the speed of the vectors."""
        north, east, course = vectoring.begins(self.scenario, self.table)
        begun = level._replace(north=north, east=east) if self.scenario.start.distance is None else on_leg
        return begun._replace(course=course, airspeed=self.table.speed)

    def controller(self, approach: Approach, gains: Designed, leaving: Callable[[Approach], Any]) -> Any:
        """The headings, from where the law takes over the approach, and once it is captured that which tracks it."""
        tracking = leaving(vectoring.tracking(self.scenario, gains, approach))
        return vectoring.vectored(self.scenario, self.table, approach, leaving(approach), tracking)
