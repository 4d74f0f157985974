"""What a run would take of the machine, refused before anything is flown."""

from __future__ import annotations

import shutil
import tempfile
from pathlib import Path

from sim.errors import OutputError, ScenarioError
from sim.scenario.model import Scenario

USUAL_FLIGHT = 600.0  # s, where the scenario does not say until when
MOST_FLIGHTS = 10_000  # of one run, which starts anew when it is stopped
WORKER_SIZE = 350 << 20  # bytes of one worker, measured below this
TOGETHER = 512  # draws that go through a tracker at once
LOOK = 200  # bytes of one look in one draw of one tracker, at least: measurement, estimate, innovation
FILED = 160  # bytes of it in a file, where draws do not go through a tracker at once: estimate, covariance, innovation
RECORDED, JUDGED = 60, 250  # bytes of one look in one draw that stay: of a sensor, and of the tracker that is judged


def refuse_too_much(scenario: Scenario) -> None:
    """Raise ``ScenarioError`` for too many flights, or for more draws than memory and temporary folder can hold."""
    if scenario.repetitions > MOST_FLIGHTS:
        raise ScenarioError(
            f"{scenario.name}: flights: {scenario.repetitions} are more than the {MOST_FLIGHTS} of one run; "
            f"take fewer, or 'study' on a scenario with [study], which goes on where it was stopped"
        )
    seconds = scenario.until or USUAL_FLIGHT
    looks = {name: seconds / sensor.period for name, sensor in scenario.sensors.items()}
    of_trackers = [sum(looks[name] for name in one.sensors) for one in scenario.trackers.values()]
    longest, parted = max(of_trackers, default=0.0), scenario.draws > TOGETHER
    needed = min(scenario.draws, TOGETHER) * LOOK * (sum(looks.values()) + (longest if parted else sum(of_trackers)))
    if parted:  # one tracker after the other
        needed += scenario.draws * (sum(looks.values()) * RECORDED + longest * JUDGED)
    free = available_memory()
    if free is not None and needed > free:
        raise ScenarioError(
            f"{scenario.name}: draws: {scenario.draws} need about {needed / 1e9:.1f} GB of memory and "
            f"{free / 1e9:.1f} GB are free; take fewer, or a study"
        )
    folder = tempfile.gettempdir()
    room, filed = shutil.disk_usage(folder).free, scenario.draws * sum(of_trackers) * FILED
    if parted and filed > room:
        raise ScenarioError(
            f"{scenario.name}: draws: {scenario.draws} need about {filed / 1e9:.1f} GB in {folder} and "
            f"{room / 1e9:.1f} GB are free; take fewer, or name another folder by TMPDIR"
        )


def refuse_workers(workers: int) -> None:
    """Raise ``OutputError`` where so many worker processes cannot fit into the free memory."""
    available = available_memory()
    if available is not None and workers * WORKER_SIZE > available:
        raise OutputError(
            f"{workers} workers need {workers * WORKER_SIZE >> 20} MB of memory and {available >> 20} MB are free; "
            f"use -j {max(1, available // WORKER_SIZE)}"
        )


def available_memory() -> int | None:
    """Bytes that new data can have; None where the system does not say."""
    try:
        rows = dict(line.split(":", 1) for line in Path("/proc/meminfo").read_text(encoding="utf-8").splitlines())
        return int(rows["MemAvailable"].split()[0]) << 10
    except (OSError, KeyError, ValueError):
        return None
