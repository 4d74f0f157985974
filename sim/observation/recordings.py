"""Sensors that recorded their looks, brought to a flight: nothing of a recording is left out without a word."""

from __future__ import annotations

from typing import Any

from sim.errors import ScenarioError
from sim.flight.record import Flight
from sim.interchange.clocks import in_words
from sim.observation.sensor import Recording
from sim.scenario.catalogue import completed


def recordings(sensors: dict[str, Any]) -> dict[str, Recording]:
    """What the sensors have recorded, of those that have."""
    return {name: found for name, sensor in sensors.items() if (found := sensor.recording) is not None}


def dated(flight: Flight, sensors: dict[str, Any]) -> dict[str, Any]:
    """The sensors at the date of a flight.

    Raises ``ScenarioError`` for a recording of which nothing falls into the flight and its roll-out.
    """
    found = _at(flight, sensors)
    begin, end = float(flight.time[0]), float(flight.whole.time[-1])
    for name, one in recordings(found).items():
        if one.last <= begin or one.first > end:
            since = flight.utc if one.dated and flight.utc is not None else 0.0
            plots, flown = (
                f"from {in_words(since + first, is_date)} to {in_words(since + last, is_date)}"
                for first, last, is_date in (
                    (one.first, one.last, one.dated), (begin, end, one.dated and flight.utc is not None)
                )
            )  # fmt: skip
            at = "" if flight.utc is not None else " at no date"
            raise ScenarioError(
                f"[sensors.{name}] none of its {one.looks} plots, {plots}, falls into the flight{at}, {flown}"
            )
    return found


def remarks(flight: Flight, sensors: dict[str, Any], records: dict[str, Any]) -> list[str]:
    """One sentence for each recording that may be meant otherwise, of which a part lies outside the flight, or that is
    the same in several draws.

    ``records`` are what the sensors saw of the flight.
    """
    found = []
    for name, one in recordings(_at(flight, sensors)).items():
        found += [f"sensor '{name}': {remark}" for remark in one.remarks]
        seen, draws = len(records[name].time), records[name].z.shape[2]
        if draws > 1:
            found.append(f"sensor '{name}' is recorded: all {draws} draws see the same plots of it")
        if seen < one.looks:
            found.append(
                f"sensor '{name}': {one.looks - seen} of its {one.looks} plots lie outside the flight and are "
                f"left out: they are from {one.first:.1f} s to {one.last:.1f} s of it"
            )
    return found


def _at(flight: Flight, sensors: dict[str, Any]) -> dict[str, Any]:
    """The sensors at the date of a flight; of a class that was never read from a scenario too."""
    for sensor in sensors.values():
        completed("sensors", type(sensor))
    return {name: sensor.dated(flight.utc) for name, sensor in sensors.items()}
