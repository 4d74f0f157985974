"""What a flight needs to know of its route, whatever kind of ``[route]`` a scenario has: the contract of a kind."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, NamedTuple, Protocol

from autopilot.approach import Approach
from autopilot.design import Designed
from autopilot.landing import Landing
from autopilot.route import Route
from sim.flight.vehicles import Initial
from sim.scenario.model import Scenario


class RouteKind(Protocol):
    """A route of one kind, of one scenario. What its table alone says (``final``, ``levels``, ``approach_speed``) it
    says itself; see ``sim.scenario.tables``."""

    def route(self, landing: Landing | None) -> Route:
        """The legs for an approach that ends in this landing; None = it ends in none.

        Raises ``ValueError``, in a sentence, where no aircraft should fly it.
        """
        ...

    @property
    def decelerations(self) -> Decelerations:
        """How fast the speed falls."""
        ...

    @property
    def speeds(self) -> tuple[tuple[float, float], ...]:
        """(m to go on the last leg, m/s from there on) of speeds that are no leg's; empty = each leg has its own."""
        ...

    @property
    def localiser(self) -> float | None:
        """Where the antenna stands whose line is captured, m behind the aiming point; None = half scale is a length."""
        ...

    def offset(self, route: Route) -> float:
        """The largest distance, m, from which a leg is approached under the law."""
        ...

    def first_leg(self) -> int:
        """The leg on which the flight begins, by the scenario's ``[start]``.

        Raises ``ValueError`` for a start that this kind does not know; whether the leg exists is not asked here.
        """
        ...

    def begins(self, on_leg: Initial, level: Initial) -> Initial:
        """Where the flight begins, before ``[start]`` sets height, speed and course.

        ``on_leg`` is on the first leg, or down on the glide path there; ``level`` is the same before the glide path.
        """
        ...

    def controller(self, approach: Approach, gains: Designed, leaving: Callable[[Approach], Any]) -> Any:
        """What flies: the approach as its crew leaves it, and what is flown before it. An autopilot, as `Approach`."""
        ...


class Decelerations(NamedTuple):
    """m/s2, in level flight and on the glide path."""

    deceleration: float = Approach.deceleration
    glide_deceleration: float = Approach.glide_deceleration


def falling(deceleration: float, glide_deceleration: float | None) -> Decelerations:
    """Those of a table that may leave the second one out, which is then the same."""
    return Decelerations(deceleration, deceleration if glide_deceleration is None else glide_deceleration)


def wind_of_turns(scenario: Scenario) -> tuple[float, float]:
    """The way the air moves, m/s (north, east), where the turns are flown: at the highest level."""
    wind: tuple[float, float] = scenario.wind.at(max(height for _, _, height in scenario.route.levels))
    return wind
