"""What a scenario cannot ask where plots were recorded, and where nothing else is known of the flight."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

from sim.scenario.recording.record_table import RecordTable
from sim.scenario.tables import LegsTable, LegTable, Runway

# The final course that stands for a route where none is told: an airliner's final, as a radar sees most of it.
FINAL, SPEED, HEIGHT = 40e3, 75.0, 1000.0  # m, m/s, m
TRACKERS = "trackers."
NOTHING_KNOWN = (
    "[record] names no file, so there is no flight to see: name one, or give the plots that were made of it, "
    '[sensors.NAME] kind = "recorded"'
)


def final_as_route(runway: Runway) -> LegsTable:
    """The final course as one leg."""
    north, east = runway.to_local(-FINAL, 0.0)
    return LegsTable((LegTable((north, east), (0.0, 0.0), SPEED, HEIGHT),))


def recorded(sensors: dict[str, Any]) -> list[str]:
    """Names of the sensors that recorded their looks; one that could not be made is not among them."""
    return [name for name, sensor in sensors.items() if sensor is not None and sensor.recording is not None]


def faults_of_recordings(tables: dict[str, Any], record: RecordTable | None, sensors: dict[str, Any]) -> Iterator[str]:
    """What is wrong beside a ``[record]``, or with sensors that recorded their looks."""
    plots = recorded(sensors)
    for number, entry in enumerate(tables.get("sensor_faults", [])):
        if entry["sensor"] in plots:
            yield f"[[sensor_faults]] entry {number}: '{entry['sensor']}' is recorded, and errs as it did"
    if plots and tables.get("autopilot", {}).get("navigation", "truth") != "truth":
        yield "[autopilot] navigation: no tracker can fly on plots that were recorded of another flight"
    if record is None:
        return
    for name in ("aircraft", "start", "departures"):
        if tables.get(name):
            yield f"[record] stands in place of [{name}]: take one of them out"
    if not record.known:
        yield from _unknown_flight(tables, sensors, plots)


def _unknown_flight(tables: dict[str, Any], sensors: dict[str, Any], plots: list[str]) -> Iterator[str]:
    """Faults of a scenario that knows no flight."""
    for name, sensor in sensors.items():
        if plots and sensor is not None and name not in plots:
            yield f"[sensors.{name}] sees a flight, and [record] names none: only recorded plots can be tracked"
    if tables.get("flights", 1) != 1:
        yield "flights: must be 1 where only plots are known: all would be the same"
    for number, entry in enumerate(tables.get("contrasts", [])):
        yield f"[[contrasts]] entry {number}: '{entry['of']}' has no errors where [record] names no file"
    for number, entry in enumerate(tables.get("checks", [])):
        if not entry["metric"].startswith(TRACKERS):
            yield (
                f"[[checks]] entry {number} metric: '{entry['metric']}' is of a flight, and [record] names no file; "
                "figures of trackers can be asked for, such as trackers.NAME.anis"
            )
