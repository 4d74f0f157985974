"""What the autopilot, the inner loops and the record cost beside JSBSim's own steps from the same trim."""

from __future__ import annotations

import statistics
import time
from dataclasses import replace

from aircraft.state import Controls
from sim.flight import loop as flight
from sim.flight.preparation import Prepared, prepare
from sim.scenario.reading import read

SPAN, PAIRS = 100.0, 7  # s flown, measured pairs


class Begun:
    """A vehicle that was begun before the clock started."""

    def __init__(self, vehicle, body):
        self.begin = lambda initial, wind: body
        self.step, self.read = vehicle.step, vehicle.read


def bodies(prepared: Prepared):
    """A fresh aircraft at its trim."""
    return prepared.vehicle.begin(prepared.initial, None)


def bare(prepared: Prepared) -> float:
    """Seconds of ``for _ in range(n): fdm.run()``."""
    airframe = bodies(prepared).airframe
    executive = airframe._executive
    airframe._command(Controls(*airframe._controls))
    steps = round(SPAN * 120)
    run = executive.run
    started = time.perf_counter()
    for _ in range(steps):
        run()
    return time.perf_counter() - started


def closed(prepared: Prepared) -> float:
    """Seconds of the closed loop with its 30 Hz record, over as many steps."""
    vehicle = Begun(prepared.vehicle, bodies(prepared))
    limits = replace(prepared.limits, until=SPAN)
    started = time.perf_counter()
    flown = flight.fly(vehicle, prepared.autopilot, prepared.initial, None, limits, prepared.phases)
    elapsed = time.perf_counter() - started
    assert flown.outcome == "completed"
    return elapsed


def main() -> list[tuple[str, str, str]]:
    """Rows: what, measured, asked."""
    started = time.perf_counter()
    scenario = read("an26_pattern")
    prepared = prepare(scenario)
    prepared_in = time.perf_counter() - started
    started = time.perf_counter()
    bodies(prepared)
    begun_in = time.perf_counter() - started
    pairs = [(closed(prepared), bare(prepared)) for _ in range(PAIRS)]
    ratio = statistics.median(c / b for c, b in pairs)
    rate = SPAN * 120 / statistics.median(b for _, b in pairs)
    return [
        ("closed loop with 30 Hz record / bare run(), median of 7 pairs", f"{ratio:.2f}", "<= 1.5, aim 1.25"),
        ("bare run(), steps/s", f"{rate:.0f}", "-"),
        ("design of all gains, s", f"{prepared_in:.2f}", "apart"),
        ("load and trim of one flight, s", f"{begun_in:.3f}", "apart"),
    ]
