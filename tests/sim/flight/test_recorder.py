"""What a flight writes while it is flown."""

from __future__ import annotations

import gc
import itertools

import numpy as np

from aircraft.state import AircraftState, Command
from sim.experiment import fly
from sim.flight import record
from sim.flight.preparation import prepare
from sim.scenario.reading import read


def test_rows_come_back_as_they_were_also_beyond_the_memory_set_aside(monkeypatch):
    monkeypatch.setattr(record, "SET_ASIDE", 2)
    recorder, numbers = record.Recorder(), itertools.count(1)
    rows = [
        (
            AircraftState(*(next(numbers) / 3.0 for _ in AircraftState._fields)),
            Command(*(next(numbers) / 7.0 for _ in Command._fields)),
            row % 3,
            row // 2,
        )
        for row in range(5)
    ]
    for row in rows:
        recorder.add(*row)
    state, command, leg, phase = recorder.columns()
    for k, row in enumerate(rows):
        assert tuple(column[k] for column in state) == row[0]
        assert tuple(column[k] for column in command) == row[1]
    assert leg.tolist() == [0, 1, 2, 0, 1]
    assert phase.tolist() == [0, 0, 1, 1, 2]
    assert leg.dtype == phase.dtype == np.int64


def test_a_flight_leaves_nothing_for_the_cyclic_collector_to_walk_over():
    """It would come back every few records and cost a tenth of the time, as it did over a growing list of states."""
    prepared = prepare(read("route_capture_point_mass", {"until_s": 60.0}))
    fly(prepared, 0)
    gc.collect()
    before = [one["collections"] for one in gc.get_stats()]
    flown = fly(prepared, 0)
    after = [one["collections"] for one in gc.get_stats()]
    assert len(flown.time) > 1000
    assert sum(after) - sum(before) <= 2
