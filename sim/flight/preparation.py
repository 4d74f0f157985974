"""prepare(): from a scenario to what flies; everything that can be refused is refused here, before the first step."""

from __future__ import annotations

from sim.flight.preparing.flown import flown
from sim.flight.preparing.prepared import Prepared
from sim.flight.preparing.recorded import recorded
from sim.scenario.model import Scenario
from sim.workers.isolation import run_isolated

__all__ = ["MODEL_TIME_LIMIT", "Prepared", "prepare"]

MODEL_TIME_LIMIT = 120.0  # s; an aircraft that is not ours may never trim


def prepare(scenario: Scenario) -> Prepared:
    """Route, law, aircraft and limits of a scenario; raises ``ScenarioError`` with one sentence for each fault."""
    return run_isolated(scenario, MODEL_TIME_LIMIT, _prepared, scenario)


def _prepared(scenario: Scenario) -> Prepared:
    return flown(scenario) if scenario.record is None else recorded(scenario, scenario.record)
