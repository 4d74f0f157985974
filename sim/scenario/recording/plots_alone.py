"""Sensors that recorded their looks, and what cannot be asked where they alone tell of a flight."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
from typing import Any

from sim.scenario.recording.table import RecordTable

TRACKERS = "trackers."


def located(tables: dict[str, Any], folder: Path) -> dict[str, Any]:
    """The tables with the files of sensors and trackers counted from a folder, by their absolute paths."""
    found = {
        family: {name: _located(table, folder) for name, table in tables[family].items()}
        for family in ("sensors", "trackers")
        if isinstance(tables.get(family), dict)
    }
    return {**tables, **found}


def _located(table: Any, folder: Path) -> Any:
    file = table.get("file") if isinstance(table, dict) else None
    return {**table, "file": str((folder / file).absolute())} if isinstance(file, str) and file else table


def recorded(sensors: dict[str, Any]) -> list[str]:
    """Names of the sensors that recorded their looks; one that could not be made is not among them."""
    return [name for name, sensor in sensors.items() if sensor is not None and sensor.recording is not None]


def faults_of_plots(tables: dict[str, Any], record: RecordTable | None, sensors: dict[str, Any]) -> Iterator[str]:
    """What is wrong with sensors that recorded their looks, and with what is asked where nothing else is known."""
    plots = recorded(sensors)
    for number, entry in enumerate(tables.get("sensor_faults", [])):
        if entry["sensor"] in plots:
            yield f"[[sensor_faults]] entry {number}: '{entry['sensor']}' is recorded, and errs as it did"
    if plots and tables.get("autopilot", {}).get("navigation", "truth") != "truth":
        yield "[autopilot] navigation: no tracker can fly on plots that were recorded of another flight"
    if record is None or record.known:
        return
    for name, sensor in sensors.items():
        if plots and sensor is not None and name not in plots:
            yield f"[sensors.{name}] sees a flight, and [record] names none: only recorded plots can be tracked"
    for number, entry in enumerate(tables.get("contrasts", [])):
        yield f"[[contrasts]] entry {number}: '{entry['of']}' has no errors where [record] names no file"
    for number, entry in enumerate(tables.get("checks", [])):
        if not entry["metric"].startswith(TRACKERS):
            yield (
                f"[[checks]] entry {number} metric: '{entry['metric']}' is of a flight, and [record] names no file; "
                "figures of trackers can be asked for, such as trackers.NAME.anis"
            )
