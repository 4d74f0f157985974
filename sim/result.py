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
from sim.scenario.model import Scenario


@dataclass(frozen=True)
class Result:
    """What a run found out."""

    prepared: Prepared
    flights: tuple[Flight, ...]
    records: dict[str, SensorRecord]  # of flight 0
    tracks: dict[str, Tracked]  # of flight 0
    metrics: dict[str, Any]
    timing: dict[str, float]

    @property
    def scenario(self) -> Scenario:
        """The scenario that was run."""
        return self.prepared.scenario

    @property
    def flight(self) -> Flight:
        """Flight 0, which figures and trackers are about."""
        return self.flights[0]


@contextmanager
def timed(timing: dict[str, float], name: str) -> Iterator[None]:
    """Write down how long a part of the work takes, s."""
    started = time.perf_counter()
    yield
    timing[name] = time.perf_counter() - started
