"""The kind of a scenario's route, by the table that says it."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from sim.flight.routes.kind import RouteKind
from sim.flight.routes.legs import StraightLegs
from sim.flight.routes.pattern import LandingPattern
from sim.flight.routes.vectored import VectoredFinal
from sim.scenario.arrivals.vectored import VectoredTable
from sim.scenario.model import Scenario
from sim.scenario.tables import LegsTable, PatternTable

KINDS: dict[type, Callable[[Scenario, Any], RouteKind]] = {
    PatternTable: LandingPattern,
    LegsTable: StraightLegs,
    VectoredTable: VectoredFinal,
}


def route_kind(scenario: Scenario) -> RouteKind:
    """The route of a scenario as its kind prepares it."""
    return KINDS[type(scenario.route)](scenario, scenario.route)
