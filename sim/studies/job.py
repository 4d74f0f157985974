"""One flight of a study, in any process: resolved tables in, a plain record out."""

from __future__ import annotations

import contextlib
import json
from pathlib import Path
from typing import Any, NamedTuple

from sim import experiment
from sim.errors import ScenarioError
from sim.estimation.own_trackers import OwnTrackers, unpacked
from sim.flight.preparation import Prepared
from sim.flight.record import Flight
from sim.metrics.ensemble.verdict import CRASHED, REFUSED
from sim.scenario.plugins import Part
from sim.scenario.reading import override
from sim.studies.kept import flight_cache


class Job(NamedTuple):
    """One flight: its place in the study, and the tables and the number that determine it."""

    cell: int
    sample: int
    flight: int  # addresses turbulence and noise; the same numbers in every cell
    values: dict[str, Any]  # of all axes
    tables: dict[str, Any]  # of the cell, with the gains designed for it
    drawn: dict[str, float]  # what the sample changes
    cache: str | None = None  # folder of flights that cells share
    parts: tuple[Part, ...] = ()  # kinds from outside that the study names
    own: bytes | None = None  # trackers of the caller, packed


def fly(job: Job) -> dict[str, Any]:
    """The record of one flight, that of a run with its place in the study; one that cannot begin is a record too."""
    try:
        own = unpacked(job.own) if job.own else {}
        tables = json.dumps(with_values(job.tables, job.drawn))
        prepared = experiment.prepared_from(tables, tuple(job.parts), bool(own))
    except ScenarioError as error:
        return lost(job, str(error), REFUSED)
    place, name = _kept_at(prepared, job)
    kept = None if place is None else flight_cache.load(place, name, prepared)
    if kept is not None:
        with contextlib.suppress(Exception):  # a record that fails may be at fault itself: it is flown again
            return _judged(prepared, kept, job, own)
    try:
        flight = experiment.fly(prepared, job.flight)
        if place is not None:
            flight_cache.store(place, name, flight)
        return _judged(prepared, flight, job, own)
    except ScenarioError as error:
        return lost(job, str(error))


def _judged(prepared: Prepared, flight: Flight, job: Job, own: OwnTrackers) -> dict[str, Any]:
    found = experiment.evaluate(prepared, flight, job.flight, own)
    return _placed(job, experiment.record_of(job.flight, found))


def lost(job: Job, reason: str, outcome: str = CRASHED) -> dict[str, Any]:
    """The record of a flight without a result."""
    return _placed(job, experiment.lost_record(job.flight, reason, outcome))


def _placed(job: Job, record: dict[str, Any]) -> dict[str, Any]:
    return {"cell": job.cell, "sample": job.sample, "values": job.values, **record}


def with_values(tables: dict[str, Any], values: dict[str, Any]) -> dict[str, Any]:
    """The tables with the values of axes in their places."""
    for address, value in values.items():
        tables = override(tables, address, value)
    return tables


def _kept_at(prepared: Prepared, job: Job) -> tuple[Path | None, str]:
    """Where a flight is kept for other cells of the study, and under which name; None = nowhere."""
    if job.cache is None or not flight_cache.shared(prepared):
        return None, ""
    return Path(job.cache), flight_cache.key(prepared, job.flight)
