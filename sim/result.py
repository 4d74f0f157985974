"""What a run found out."""

from __future__ import annotations

import time
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from typing import Any

from sim.estimation.tracking_run import Tracked
from sim.flight.preparation import Prepared
from sim.flight.record import Flight
from sim.observation.record import SensorRecord
from sim.reporting.text.broken_checks import broken_checks
from sim.reporting.text.contrast_sentence import contrast_sentences
from sim.reporting.text.reasons import Flown
from sim.scenario.model import Scenario


@dataclass(frozen=True)
class Result:
    """What a run found out: figures and verdicts of all flights, everything of one."""

    prepared: Prepared
    number: int  # of the flight that is here as a whole: the first, or the only one
    flight: Flight
    records: dict[str, SensorRecord]  # of that flight
    tracks: dict[str, Tracked]  # of that flight
    metrics: dict[str, Any]
    timing: dict[str, float]
    own: dict[str, Any]  # trackers that the caller brought

    @property
    def scenario(self) -> Scenario:
        """The scenario that was run."""
        return self.prepared.scenario

    @property
    def contrasted(self) -> list[str]:
        """Sentences about each pair of trackers that are set against each other, over all flights: how far apart they
        are, which is lost; and why, on the flight that is here."""
        each = {one["flight"]: one["metrics"].get("trackers", {}) for one in self.metrics.get("each_flight", ())}
        flown = Flown(self.scenario, self.prepared.law, self.flight, self.tracks)
        return contrast_sentences(self.metrics, flown, each.get(self.number))

    @property
    def broken(self) -> list[str]:
        """A sentence for each check that failed, over all flights; empty where all passed."""
        return broken_checks(self.metrics, lambda flight, _: f"sim.run(..., flight={flight})")


@contextmanager
def timed(timing: dict[str, float], name: str) -> Iterator[None]:
    """Write down how long a part of the work takes, s."""
    started = time.perf_counter()
    yield
    timing[name] = time.perf_counter() - started
