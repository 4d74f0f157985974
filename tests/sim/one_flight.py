"""The verdicts of a run with a single flight, for tests that have the flight and no run."""

from __future__ import annotations

from sim.metrics.checks import evaluate_checks
from sim.metrics.ensemble.verdict import verdicts


def record(checks, flight, runway, figures, number=0):
    """What is kept of a flight."""
    found = evaluate_checks(tuple(checks), flight, runway, figures)
    return {"flight": number, "metrics": {"outcome": flight.outcome, **figures}, "checks": found}


def judged(checks, flight, runway, figures):
    """The checks of metrics.json."""
    return verdicts(tuple(checks), [record(checks, flight, runway, figures)])
