"""A run with a track that was made elsewhere from its plots: the scenario that judges it beside the run's own."""

from __future__ import annotations

from pathlib import Path
from typing import Any

from sim.errors import OutputError, did_you_mean
from sim.results.loading import load
from sim.scenario.plugins import Plugins


def verdict(name: str, metrics: dict[str, Any]) -> str:
    """What was found of a recorded tracker, in one line."""
    found = metrics["trackers"][name]
    whole, place = found.get("track"), found["overall"].get("position_m")
    if whole is None or place is None:
        return f"{name}: has no estimate at a look of its sensors, so it has no errors"
    parts = [f"position {place['rmse']:.1f} m RMS"]
    if place["gain"] is not None:
        parts[0] += f", {place['gain']:.2f} times better than the plots"
    if found["anees"] is not None:
        parts.append(f"ANEES {found['anees']:.2f}")
    parts.append(f"{100 * whole['completeness']:.0f} % of the looks taken up")
    if whole["initiation_s"] is not None:
        parts.append(f"first estimate {whole['initiation_s']:.1f} s after the first look")
    if whole["number_changes"]:
        parts.append(f"its number changes {whole['number_changes']:.2g} times")
    return f"{name}: {'; '.join(parts)}"


def with_track(folder: Path, name: str, file: Path, sensors: list[str] | None, plugins: Plugins = ()) -> dict[str, Any]:
    """The tables of a run's scenario with a recorded tracker ``name``; run again, its flight and plots are the same.

    ``sensors`` are those that the tracker listened to; None = all.

    Raises ``OutputError`` in one sentence for a folder that is not of a run, or whose plots would come out otherwise
    here, and for a name or a sensor that cannot be.
    """
    result = load(folder, plugins=plugins)
    scenario = result.scenario
    if name in scenario.trackers:
        raise OutputError(f"--name {name}: the run has a tracker of that name; choose another")
    for sensor in sensors or ():
        if sensor not in scenario.sensors:
            raise OutputError(f"--sensors: the run has no sensor '{sensor}'; {did_you_mean(sensor, scenario.sensors)}")
    if not scenario.sensors:
        raise OutputError(f"{folder}: the run has no sensors, so nothing could be tracked")
    _ = dict(result.records)  # held against the file: what differs here is an error
    brought = {"kind": "recorded", "file": str(file.absolute()), **({} if sensors is None else {"sensors": sensors})}
    trackers = {**scenario.tables.get("trackers", {}), name: brought}
    return {**scenario.tables, "trackers": trackers, "study": None}
