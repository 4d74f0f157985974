"""The trackers of an26_pattern on one flight: processor time of the flight, and of trackers as one and one by one."""

from __future__ import annotations

import math
import time
from collections.abc import Callable
from dataclasses import replace

from sim.estimation.tracking_run import track
from sim.experiment import fly, read
from sim.flight.preparation import prepare
from sim.observation.record import observe

Row = tuple[str, str, str]  # what, measured, asked

DENSITIES = (0.03, 0.1, 0.3, 1.0)  # m2/s3


def main() -> list[Row]:
    """Smallest of interleaved rounds, as ratios."""
    scenario = read("an26_pattern")
    prepared = prepare(scenario)
    flight = fly(prepared)
    records = observe(flight, scenario.sensors, scenario.seed, 0, scenario.draws, scenario.sensor_faults)
    choice = scenario.trackers["saturated_control"]
    copies = {
        f"at {density}": replace(choice, table={**choice.table, "acceleration_density_m2ps3": density})
        for density in DENSITIES
    }

    def tracked(trackers: dict) -> Callable[[], object]:
        among = replace(prepared, scenario=replace(scenario, trackers=trackers, contrasts=()))
        return lambda: track(among, flight, records, {})

    alone = [tracked({name: one}) for name, one in copies.items()]
    works = {
        "flight": lambda: fly(prepared),
        "all": lambda: track(prepared, flight, records, {}),
        "one": tracked(copies),
        "each": lambda: [work() for work in alone],
    }
    best = dict.fromkeys(works, math.inf)
    for _ in range(2):
        for name, work in works.items():
            begun = time.process_time()
            work()
            best[name] = min(best[name], time.process_time() - begun)
    return [
        (
            f"{len(scenario.trackers)} trackers, {scenario.draws} draws, over their flight",
            f"{best['all'] / best['flight']:.2f} ({best['all']:.2f} s of CPU)",
            "",
        ),
        (
            f"{len(DENSITIES)} saturated_control of other densities, as one over one by one",
            f"{best['one'] / best['each']:.2f}",
            "",
        ),
    ]
