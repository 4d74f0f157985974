"""What all trackers of a flight share, and what each takes in of it."""

from __future__ import annotations

import math
from typing import Any, NamedTuple

import numpy as np

from sim.flight.preparation import Prepared
from sim.flight.record import Flight
from sim.observation.record import SensorRecord, measurements, of_draws
from sim.scenario.budget import TOGETHER
from tracking.track import Measurements, chunks


class Watch(NamedTuple):
    """A flight with the records of its sensors: what all its trackers share."""

    prepared: Prepared
    flight: Flight
    records: dict[str, SensorRecord]
    trackers: dict[str, Any]  # of the scenario, which may hand over to each other
    number: int  # of the flight
    parts: tuple[slice, ...]  # of the draws, which go through a tracker one after the other


class SetUp(NamedTuple):
    """A tracker, its assumed law's origin and its sensors."""

    name: str
    kind: str
    tracker: Any
    law_from: str | None
    sensors: tuple[str, ...]
    handover: str | None


class Entry(NamedTuple):
    """A tracker that has measurements, and when its track begins."""

    name: str
    kind: str
    tracker: Any
    law_from: str | None
    sensors: tuple[str, ...]
    handover: str | None
    start: float  # s


Since = dict[tuple[tuple[str, ...], float], Measurements]
"""What trackers take in, by their sensors and the time of their start."""


def sensors_of(watch: Watch, names: tuple[str, ...]) -> dict[str, Any]:
    return {name: watch.prepared.scenario.sensors[name] for name in names}


def parts_of(flight: Flight, records: dict[str, SensorRecord]) -> tuple[slice, ...]:
    """The draws that go through a tracker at once; without a truth, all."""
    draws = next((record.z.shape[2] for record in records.values()), 0)
    return tuple(chunks(draws, TOGETHER)) if flight.known and draws else (slice(0, draws),)


def arrived_at(watch: Watch, sensors: tuple[str, ...], chosen: slice) -> Measurements:
    """What some draws of sensors measured; what would arrive after the flight and its roll-out is left out."""
    record = measurements(of_draws(watch.records, chosen), sensors)
    return between(record, -math.inf, float(watch.flight.whole.time[-1]))


def taken_in(watch: Watch, since: Since, entry: Entry, chosen: slice) -> Measurements:
    """What some draws of a tracker take in, from its start on."""
    whole = since.get((entry.sensors, entry.start))
    if whole is not None:
        return whole
    return between(arrived_at(watch, entry.sensors, chosen), first_taken(watch.flight, entry.start), math.inf)


def looked_at(watch: Watch, since: Since, entry: Entry) -> Measurements:
    """What all draws of a tracker take in; where that is not put together once, with the accuracies of one draw."""
    if since:
        return since[entry.sensors, entry.start]
    plain = {
        name: record._replace(R=record.R[..., 0] if record.R.ndim == 4 else record.R)
        for name, record in watch.records.items()
    }
    return taken_in(watch._replace(records=plain), since, entry, slice(0, watch.parts[-1].stop))


def first_taken(flight: Flight, start: float) -> float:
    """From when on a track takes in what arrives: two plots with which it begins are in it already."""
    return start if flight.known else math.nextafter(start, math.inf)


def between(record: Measurements, first: float, last: float) -> Measurements:
    """What arrives from ``first`` to ``last`` (s): views, since a record is in order of arrival."""
    arrival = record.arrival
    return record.rows(
        slice(int(np.searchsorted(arrival, first, "left")), int(np.searchsorted(arrival, last, "right")))
    )
