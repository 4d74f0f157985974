"""What interacting models cost more than one Kalman filter: counted operations, measured computing time."""

from __future__ import annotations

import time as clock
from typing import Any

import numpy as np

from sim.claims.papers.volovyk2022.experiment import experiment
from sim.claims.papers.volovyk2022.filters import DENSITY, FILTERS, ONE_FILTER
from sim.claims.papers.volovyk2022.landing_paths import SCAN
from tracking.intervals import Interval, mean_interval
from tracking.operations import counted_interacting, full_filter_operations
from tracking.track import follow

STATES, CHANNELS, MODELS = 4, 2, 3
SCANS, REPEATS = slice(0, 60), 6  # timed, and how often: the two filters take turns


def more_operations() -> float:
    """Operations of a cycle of three interacting models above those of one filter, in per cent of these."""
    one = sum(full_filter_operations(STATES, CHANNELS))
    return 100.0 * (sum(counted_interacting(MODELS, STATES, CHANNELS)) / one - 1.0)


def seconds(name: str, data: Any, runs: int) -> float:
    """CPU time of a scan of so many runs."""
    some = data.measurements.runs(slice(0, runs))
    seen = type(some)(some.channels, some.time[SCANS], some.arrival[SCANS], some.z[SCANS], some.R[SCANS])
    began = clock.process_time()
    for _ in follow(FILTERS[name], seen, data.prior, start=0.0):
        pass
    return (clock.process_time() - began) / len(seen.time)


def more_time(beside: int, of_the_scan: bool = False) -> Any:
    """Measure of the CPU time of the models above that of one filter, in per cent of this or of the time between scans.

    ``beside`` runs are worked out side by side. The interval is over repetitions, each a ratio within a moment, so that
    what else the machine does hardly enters.
    """

    def measured(seed: int, runs: int) -> Interval:
        data = experiment(seed, beside)
        pairs = np.array([[seconds(name, data, beside) for name in (DENSITY, ONE_FILTER)] for _ in range(REPEATS + 1)])
        models, one = pairs[1:].T  # the first fills caches
        return mean_interval(100.0 * (models - one) / (SCAN * beside if of_the_scan else one))

    return measured
