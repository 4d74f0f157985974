"""What a run would take of the machine, refused before anything is flown."""

from __future__ import annotations

from pathlib import Path

from sim.errors import ScenarioError
from sim.scenario.model import Scenario

USUAL_FLIGHT = 600.0  # s, where the scenario does not say until when
RECORD = 30 * 50 * 8  # bytes of one second of a flight: 30 Hz, some fifty doubles
LOOK = 200  # bytes of one look in one draw of one tracker, at least: measurement, estimate, innovation


def refuse_too_much(scenario: Scenario) -> None:
    """Raise ``ScenarioError`` where the records of all flights, or of all draws, cannot fit into the free memory."""
    seconds = scenario.until or USUAL_FLIGHT
    looks = {name: seconds / sensor.period for name, sensor in scenario.sensors.items()}
    each = sum(looks.values()) + sum(looks[name] for one in scenario.trackers.values() for name in one.sensors)
    free = available_memory()
    for what, count, needed in (
        ("flights", scenario.flights, scenario.flights * seconds * RECORD),
        ("draws", scenario.draws, scenario.draws * each * LOOK),
    ):
        if free is not None and needed > free:
            raise ScenarioError(
                f"{scenario.name}: {what}: {count} need about {needed / 1e9:.1f} GB of memory and "
                f"{free / 1e9:.1f} GB are free; take fewer, or a study"
            )


def available_memory() -> int | None:
    """Bytes that new data can have; None where the system does not say."""
    try:
        rows = dict(line.split(":", 1) for line in Path("/proc/meminfo").read_text().splitlines())
        return int(rows["MemAvailable"].split()[0]) << 10
    except (OSError, KeyError, ValueError):
        return None
