"""A small experiment for any class of tracker, with which `tracking.contract` tests it."""

from __future__ import annotations

import functools
from collections.abc import Callable, Iterator
from itertools import combinations
from typing import Any

import numpy as np

from sim.errors import ScenarioError
from sim.estimation.prior import prior
from sim.estimation.setup import untried
from sim.flight.loop import fly
from sim.flight.preparation import Prepared, prepare
from sim.flight.record import Flight
from sim.observation.record import SensorRecord, measurements, observe
from sim.scenario import catalogue
from sim.scenario.model import TrackerChoice
from sim.scenario.reading import read
from tracking.contract import Trial, missing_members
from tracking.track import Measurements, TrackerError

RUNS = 3
EPOCHS = 12
MOST_SENSORS = 2  # that a kind needs at once
LEGS = [
    {"from_m": [-12000, 0], "to_m": [-7000, 0], "speed_mps": 80, "height_m": 600},
    {"from_m": [-7000, 0], "to_m": [-7000, 6000], "speed_mps": 80, "height_m": 600},
]


def maker(cls: type, kind: str = "it") -> Callable[[], Trial]:
    """What makes trials of a class, each the same, for `tracking.contract.broken_promises`.

    The tracker runs in a small scenario, with the fewest sensors of the catalogue that it can be built with; its
    parameters are its ``example``, else its defaults. Making raises ``ScenarioError`` where no sensors serve, and
    ``TrackerError`` where a member is missing.
    """

    def make() -> Trial:
        prepared, flight, records = _toy()
        refused = ScenarioError("there are no sensors")
        for sensors in _choices(tuple(records)):
            choice = TrackerChoice(kind, cls, sensors, None, getattr(cls, "example", {}), {})
            try:
                tracker, _ = untried(prepared, kind, choice)
            except ScenarioError as error:
                refused = error
                continue
            for missing in missing_members(tracker):
                raise TrackerError(missing)
            record = _first(measurements(records, sensors))
            scenario = prepared.scenario
            begun = prior(flight, scenario.sensors, tracker.channels, float(record.arrival[0]), scenario.seed, 0, RUNS)
            return Trial(tracker, record, begun)
        raise refused

    return make


def _choices(names: tuple[str, ...]) -> Iterator[tuple[str, ...]]:
    """Sets of sensors, the smallest first."""
    for count in range(1, MOST_SENSORS + 1):
        yield from combinations(names, count)


@functools.cache
def _toy() -> tuple[Prepared, Flight, dict[str, SensorRecord]]:
    """A turn flown by the point mass, watched by one sensor of every kind that sees it."""
    sensors: dict[str, Any] = {}
    for kind in catalogue.kinds("sensors"):
        cls = catalogue.load("sensors", kind)
        sensors[kind] = {"kind": kind, **getattr(cls, "example", {})}
    tables = {"name": "trial", "draws": RUNS, "until_s": 60, "start": {"leg": 0, "cross_track_m": 150}}
    prepared = prepare(read({**tables, "route": {"kind": "legs", "legs": LEGS}, "sensors": sensors}))
    flight = fly(
        prepared.vehicle, prepared.controller, prepared.initial, prepared.wind(0), prepared.limits, prepared.phases
    )
    records = observe(flight, prepared.scenario.sensors, prepared.scenario.seed, 0, RUNS)
    return prepared, flight, {name: record for name, record in records.items() if len(record.time) >= EPOCHS}


def _first(record: Measurements) -> Measurements:
    """The first epochs in the order of arrival."""
    order = np.argsort(record.arrival, kind="stable")[:EPOCHS]
    return Measurements(record.channels, record.time[order], record.arrival[order], record.z[order], record.R[order])
