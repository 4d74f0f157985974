"""What the autopilot, the inner loops and the record cost beside JSBSim's own steps from the same trim."""

from __future__ import annotations

import time
from dataclasses import replace

from aircraft.state import Controls
from sim.experiment import fly
from sim.flight import loop as flight
from sim.flight.preparation import Prepared, prepare
from sim.scenario.reading import read

SPAN, PAIRS, WHOLE = 100.0, 7, 3  # s flown on level legs, measured pairs of them and of whole flights


class Begun:
    """A vehicle that was begun before the clock started."""

    def __init__(self, vehicle, body):
        self.begin = lambda initial, wind: body
        self.step, self.read = vehicle.step, vehicle.read
        self.rollout = lambda body: None  # the bare steps have none either


def bodies(prepared: Prepared):
    """A fresh aircraft at its trim."""
    return prepared.vehicle.begin(prepared.initial, None)


def bare(prepared: Prepared, span: float) -> float:
    """CPU seconds of ``for _ in range(n): fdm.run()``."""
    airframe = bodies(prepared).airframe
    executive = airframe._executive
    airframe._command(Controls(*airframe._controls))
    run = executive.run
    started = time.process_time()
    for _ in range(round(span * 120)):
        run()
    return time.process_time() - started


def closed(prepared: Prepared, span: float | None) -> tuple[float, float]:
    """CPU seconds of the closed loop with its 30 Hz record, and the seconds flown; no span = to the landing."""
    vehicle = Begun(prepared.vehicle, bodies(prepared))
    limits = replace(prepared.limits, until=span)
    started = time.process_time()
    flown = flight.fly(vehicle, prepared.autopilot, prepared.initial, None, limits, prepared.phases)
    elapsed = time.process_time() - started
    assert flown.outcome == ("landed" if span is None else "completed")
    return elapsed, float(flown.time[-1])


def ratio(prepared: Prepared, span: float | None, pairs: int) -> float:
    """Least CPU of the closed loop over the least of the bare steps of the same time, by turns: others only add."""
    loops, steps = [], []
    for _ in range(pairs):
        elapsed, flown = closed(prepared, span)
        loops.append(elapsed)
        steps.append(bare(prepared, flown))
    return min(loops) / min(steps)


def in_turbulence(count: int) -> float:
    """CPU seconds of one whole flight of ``an26_turbulence``, load, trim and roll-out with it."""
    prepared = prepare(read("an26_turbulence"))
    started = time.process_time()
    for number in range(count):
        fly(prepared, number)
    return (time.process_time() - started) / count


def main() -> list[tuple[str, str, str]]:
    """Rows: what, measured, asked."""
    started = time.perf_counter()
    scenario = read("an26_pattern")
    prepared = prepare(scenario)
    prepared_in = time.perf_counter() - started
    started = time.perf_counter()
    bodies(prepared)
    begun_in = time.perf_counter() - started
    level = ratio(prepared, SPAN, PAIRS)
    whole = ratio(prepared, None, WHOLE)
    rate = SPAN * 120 / min(bare(prepared, SPAN) for _ in range(PAIRS))
    turbulent = in_turbulence(2 * WHOLE)
    return [
        ("closed loop with 30 Hz record / bare run(), level legs", f"{level:.2f}", "<= 1.5, aim 1.35"),
        ("the same, whole an26_pattern at 120 Hz", f"{whole:.2f}", "<= 1.45, aim 0.9"),
        ("bare run(), steps/s of CPU", f"{rate:.0f}", "-"),
        ("an26_turbulence, flights/s of CPU and worker", f"{1.0 / turbulent:.2f}", ">= 1.1"),
        ("design of all gains, s", f"{prepared_in:.2f}", "apart"),
        ("load and trim of one flight, s", f"{begun_in:.3f}", "apart"),
    ]
