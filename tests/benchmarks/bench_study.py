"""What a study costs beside bare processes: gain of a second worker, and all that is not flying."""

from __future__ import annotations

import importlib
import json
import os
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any, NamedTuple

from sim.flight.preparation import prepare
from sim.scenario.reading import read
from sim.studies import study as studies
from sim.studies.job import Job, fly
from sim.workers.executors import LocalExecutor

HERE = Path(__file__).resolve()
SCENARIO = "an26_turbulence"
BASE = {"start.phase": "base"}  # half of the pattern's time with all of its turns but the first
BARE = "import sys; sys.path[:0] = [{place!r}]; from bench_study import bare; bare(*map(int, sys.argv[1:]))"


class Stamped(NamedTuple):
    """A job with the clocks of its worker before and after."""

    record: Any
    process: int
    began: float  # s, of the system
    ended: float
    cpu_began: float  # s, of the process
    cpu_ended: float


class Timing(NamedTuple):
    """A study or bare processes: flights, their time from the first step to the last, and CPU seconds."""

    flights: int
    elapsed: float  # s
    flying: float  # CPU s within flights
    beside: float  # CPU s of workers between flights, and of the parent

    def __add__(self, other: Any) -> Timing:
        return Timing(*(a + b for a, b in zip(self, other, strict=True)))

    @property
    def rate(self) -> float:
        """Flights per second."""
        return self.flights / self.elapsed


def stamped(function: Callable[..., Any], *arguments: Any) -> Stamped:
    """In a worker: a job between clocks."""
    began, cpu = time.time(), time.process_time()
    record = function(*arguments)
    return Stamped(record, os.getpid(), began, time.time(), cpu, time.process_time())


class Clocked:
    """The three calls of an executor, with stamps about every job."""

    def __init__(self, workers: int) -> None:
        self.inner, self.stamps, self.parent = LocalExecutor(workers), [], 0.0

    def submit(self, number: int, function: Callable[..., Any], *arguments: Any) -> None:
        """Take a job."""
        self.inner.submit(number, stamped, function, *arguments)

    def finished(self) -> Iterator[tuple[int, Any]]:
        """Results as they end; what the study does with each is on the parent's clock."""
        began = time.process_time()
        for number, found in self.inner.finished():
            self.stamps.append(found)
            yield number, found.record
        self.parent = time.process_time() - began

    def close(self) -> None:
        """End all workers."""
        self.inner.close()


def study(workers: int, flights: int) -> Timing:
    """A study of one cell, in a folder that is thrown away."""
    tables = read(SCENARIO, {**BASE, "flights": flights}).tables
    axes = {"wind.speed_mps": [8.0]}
    executor = Clocked(workers)
    with tempfile.TemporaryDirectory() as place:
        studies.study({**tables, "study": {"axes": axes}}, Path(place) / "o", executor)
    stamps = executor.stamps
    flying = sum(one.cpu_ended - one.cpu_began for one in stamps)
    living = 0.0
    for process in {one.process for one in stamps}:
        mine = [one for one in stamps if one.process == process]
        living += max(one.cpu_ended for one in mine) - min(one.cpu_began for one in mine)
    elapsed = max(one.ended for one in stamps) - min(one.began for one in stamps)
    return Timing(flights, elapsed, flying, living - flying + executor.parent)


def bare(first: int, flights: int) -> None:
    """A process that does nothing but fly; prints its clocks."""
    scenario = read(SCENARIO, BASE)
    tables = {key: value for key, value in scenario.tables.items() if value is not None}
    tables["designed"] = prepare(scenario).designed.to_table()
    fly(Job(0, 0, 10_000, {}, tables, {}))  # everything is imported and prepared
    began, cpu = time.time(), time.process_time()
    for number in range(first, first + flights):
        fly(Job(0, 0, number, {}, tables, {}))
    print(json.dumps([began, time.time(), time.process_time() - cpu]))


def processes(count: int, flights: int) -> Timing:
    """Bare processes side by side that share the flights."""
    each = flights // count
    command = [sys.executable, "-c", BARE.format(place=str(HERE.parent))]
    started = [
        subprocess.Popen([*command, str(i * each), str(each)], stdout=subprocess.PIPE, text=True) for i in range(count)
    ]
    told = [json.loads(one.communicate()[0]) for one in started]
    elapsed = max(ended for _, ended, _ in told) - min(began for began, _, _ in told)
    return Timing(each * count, elapsed, sum(cpu for *_, cpu in told), 0.0)


def measure(rounds: int, flights: int) -> dict[str, Timing]:
    """All four by turns, so that each meets the same machine; ``flights`` of each in every round."""
    sys.path[:0] = [str(HERE.parent)]  # workers import this module by its name
    module = importlib.import_module("bench_study")
    found: dict[str, Timing] = {}
    for _ in range(rounds):
        for name, call in (
            ("bare 1", lambda: processes(1, flights)),
            ("study 1", lambda: module.study(1, flights)),
            ("bare 2", lambda: processes(2, flights)),
            ("study 2", lambda: module.study(2, flights)),
        ):
            timing = call()
            found[name] = found[name] + timing if name in found else timing
    return found


def figures(found: dict[str, Timing]) -> tuple[float, float, float]:
    """Gain of the second worker, gain of the second bare process, CPU beside the flights as a share of them."""
    gains = [found[f"{what} 2"].rate / found[f"{what} 1"].rate for what in ("study", "bare")]
    one = found["study 1"]
    return gains[0], gains[1], one.beside / one.flying


def main() -> list[tuple[str, str, str]]:
    """Rows: what, measured, asked."""
    found = measure(2, 6)
    study_gain, bare_gain, overhead = figures(found)
    each = found["bare 1"].flying / found["bare 1"].flights
    return [
        ("one flight from the base leg, bare", f"{each:.2f} CPU s", ""),
        ("two workers against one", f"{study_gain:.2f}", ""),
        ("two bare processes against one", f"{bare_gain:.2f}", ""),
        ("gain of the workers over that of bare processes", f"{study_gain / bare_gain:.2f}", ">= 0.85"),
        ("CPU beside the flights over that of the flights", f"{100 * overhead:.1f} %", "<= 5 %"),
    ]
