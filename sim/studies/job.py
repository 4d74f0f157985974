"""One flight of a study, in any process: resolved tables in, a plain record out."""

from __future__ import annotations

import dataclasses
import functools
import json
from pathlib import Path
from typing import Any, NamedTuple

from sim import experiment
from sim.errors import ScenarioError
from sim.flight.preparation import Prepared, prepare
from sim.flight.record import Flight
from sim.scenario.plugins import Part
from sim.scenario.reading import override
from sim.studies import flight_cache

CRASHED = "crashed"  # the outcome of a flight that could not be flown to any end
REFUSED = "refused"  # of one that could not begin: its values make no flight, and the reason says why


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


def fly(job: Job) -> dict[str, Any]:
    """The record of one flight; a flight that cannot begin is a record too."""
    try:
        prepared = _prepared(json.dumps(job.tables), json.dumps(job.drawn), tuple(job.parts))
    except ScenarioError as error:
        return lost(job, str(error), REFUSED)
    try:
        return _evaluated(job, prepared)
    except ScenarioError as error:
        return lost(job, str(error))


def _evaluated(job: Job, prepared: Prepared) -> dict[str, Any]:
    found = experiment.evaluate(prepared, _flight(prepared, job), job.flight)
    metrics = found.flight
    if prepared.scenario.trackers:
        metrics |= {"trackers": found.trackers, "navigated": found.navigated}
    kept = ("value", "margin", "time_s", "passed")
    return _record(job, metrics, [{key: check[key] for key in kept} for check in found.checks])


def lost(job: Job, reason: str, outcome: str = CRASHED) -> dict[str, Any]:
    """The record of a flight without a result."""
    return _record(job, {"outcome": outcome, "reason": reason}, [])


def with_values(tables: dict[str, Any], values: dict[str, Any]) -> dict[str, Any]:
    """The tables with the values of axes in their places."""
    for address, value in values.items():
        tables = override(tables, address, value)
    return tables


def _record(job: Job, metrics: dict[str, Any], checks: list[dict[str, Any]]) -> dict[str, Any]:
    return {
        "cell": job.cell,
        "sample": job.sample,
        "flight": job.flight,
        "values": job.values,
        "metrics": metrics,
        "checks": checks,
    }


@functools.lru_cache(maxsize=1)
def _prepared(tables: str, drawn: str, parts: tuple[Part, ...]) -> Prepared:
    """The preparation, shared by the flights of one sample, which come one after another."""
    scenario = experiment.read(with_values(json.loads(tables), json.loads(drawn)), plugins=parts)
    if not scenario.trackers:
        scenario = dataclasses.replace(scenario, sensors={})  # nobody listens to them
    return prepare(scenario)


def _flight(prepared: Prepared, job: Job) -> Flight:
    """The flight of a job, flown unless another cell of the study has flown it."""
    if job.cache is None or not flight_cache.shared(prepared):
        return experiment.fly(prepared, job.flight)
    place, name = Path(job.cache), flight_cache.key(prepared, job.flight)
    flight = flight_cache.load(place, name, prepared)
    if flight is None:
        flight = experiment.fly(prepared, job.flight)
        flight_cache.store(place, name, flight)
    return flight
