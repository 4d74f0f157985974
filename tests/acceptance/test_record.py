"""Recordings in, at full size: read again what was flown, damaged files, a million rows, the time of smoothing."""

from __future__ import annotations

import gc
import json
import math
import subprocess
import sys
import time
import warnings
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import sim
from aircraft.runway import Runway
from sim.errors import ScenarioError
from sim.flight.recording.flight import recorded_flight
from sim.interchange.track_record import TrackRecord
from sim.studies.study import study
from sim.workers.executors import LocalExecutor
from tests import recordings
from tests.damaged_recordings import DAMAGED
from tracking.measurement import wrap

pytestmark = pytest.mark.acceptance
ROOT = Path(__file__).resolve().parents[2]
FLOWN = ("an26_pattern", "a320", "b747", "c172x")  # left and right, 30 to 130 m/s, by another heading each


def as_recorded(scenario: Any, flight: Any, step: int = 30) -> TrackRecord:
    """A flown flight as a receiver without errors hears it, a row every ``step`` records of 1/30 s."""
    own = scenario.runway
    runway = Runway(own.latitude, own.longitude, own.elevation, own.heading)
    s, some = flight.state, slice(None, None, step)
    latitude, longitude = runway.geodetic(s.north[some], s.east[some], s.height[some])
    altitude = scenario.air.pressure_altitude(s.height[some])
    return TrackRecord("flown", 1.77e9 + s.time[some], latitude, longitude, altitude)


def test_flown_runs_read_in_again(row):
    place, course = {}, {}
    for name in FLOWN:
        scenario = sim.read(name)
        flight = sim.fly(scenario)
        found = recorded_flight(as_recorded(scenario, flight), scenario.runway, scenario.air)
        true = [np.interp(found.time, flight.time, getattr(flight.state, axis)) for axis in ("north", "east", "height")]
        off = np.array((found.state.north, found.state.east, found.state.height)) - np.array(true)
        place[name] = math.sqrt(float(np.mean(np.sum(off**2, axis=0))))
        established = found.during(("established", "glide"))
        assert established.any()
        flown = np.interp(found.time, flight.time, np.unwrap(flight.state.course))
        course[name] = math.degrees(float(np.abs(wrap(found.state.course - flown))[established].max()))
    row(
        "an exported run, read in again: position, rms",
        "within 1 m where ADS-B errors are off",
        ", ".join(f"{name} {error:.2f} m" for name, error in place.items()),
        max(place.values()) <= 1.0,
    )
    row(
        "an exported run, read in again: course of the established aircraft, largest error",
        "within .05 deg",
        ", ".join(f"{name} {error:.4f} deg" for name, error in course.items()),
        max(course.values()) <= 0.05,
    )
    assert max(place.values()) <= 1.0
    assert max(course.values()) <= 0.05


def test_damaged_recordings(row, tmp_path):
    """An answer each: a flight, with remarks where rows were damaged, or one sentence."""
    runway = tmp_path / "runway.toml"
    flights, sentences, without = 0, 0, []
    for number, (name, damage) in enumerate(DAMAGED.items()):
        path = tmp_path / f"{number}.csv"
        told, columns = damage(path, runway)
        with warnings.catch_warnings():
            warnings.simplefilter("error")
            try:
                found = sim.recorded(path, runway, columns)
                flight = found[next(iter(found))]
            except ScenarioError as error:
                answer = str(error)
                sentences += 1
                good = told not in ("", None) and told in answer and "\n" not in answer and "Traceback" not in answer
            else:
                remarks = " ".join(event.detail for event in flight.events)
                flights += 1
                state = np.array((flight.state.north, flight.state.east, flight.state.height, flight.state.bank))
                good = bool(np.isfinite(state).all()) and (told is None or told in remarks)
                answer = remarks
        if not good:
            without.append(f"{name}: {answer}")
    row(
        "damaged recordings",
        "100, an answer each",
        f"{len(DAMAGED)}: {flights} flights, with remarks where something was left out; {sentences} sentences",
        not without and len(DAMAGED) >= 100,
    )
    assert without == []
    assert len(DAMAGED) >= 100


# processor time, since others may be at work on the machine: neither reading nor smoothing waits for anything
MILLION = """
import json, resource, sys, time
from sim.interchange.tracks import read_tracks
begun = time.process_time()
tracks = read_tracks(sys.argv[1])
print(json.dumps([time.process_time() - begun, resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024,
                  len(tracks), sum(len(one.time) for one in tracks.values())]))
"""


def test_a_million_rows(row, tmp_path):
    """Flights side by side, as a receiver hears them."""
    path, flights, each = tmp_path / "million.csv", 1600, 625
    body = [",".join(map(str, one.values())) for one in recordings.rows("ID", step=recordings.LENGTH / each)][:each]
    with path.open("w") as file:
        file.write(",".join(recordings.COLUMNS) + "\n")
        for line in body:
            before, after = line.split(",ID,")
            file.writelines(f"{before},{number:06d},{after}\n" for number in range(flights))
    done = subprocess.run(
        [sys.executable, "-c", MILLION, str(path)], cwd=ROOT, capture_output=True, text=True, check=True, timeout=300
    )
    seconds, megabytes, found, total = json.loads(done.stdout)
    row(
        "10^6 rows read, split and converted",
        "<= 10 s and < 1 GB",
        f"{total} rows of {found} flights in {seconds:.1f} s, {megabytes:.0f} MB",
        seconds <= 10.0 and megabytes < 1024.0,
    )
    assert (total, found) == (flights * len(body), flights)
    assert seconds <= 10.0
    assert megabytes < 1024.0


def test_a_study_over_the_flights_of_a_file(row, tmp_path):
    """Cells in worker processes read the file by its path and digest, the page is that of any study."""
    table = recordings.rows("FIRST") + recordings.rows("SECOND", pressure=-100.0)
    (tmp_path / "tracks.csv").write_text(recordings.text(table))
    (tmp_path / "runway.toml").write_text(recordings.RUNWAY_FILE)
    scenario = {
        "name": "flights",
        "draws": 10,
        "record": {"file": str(tmp_path / "tracks.csv"), "runway": str(tmp_path / "runway.toml")},
        "sensors": {"radar": {"kind": "surveillance_radar", "height": "mode_c"}},
        "trackers": {"imm": {"kind": "imm"}},
        "study": {"axes": {"record.flight": ["FIRST", "SECOND"]}},
    }
    executor = LocalExecutor(1)
    try:
        found = study(scenario, tmp_path / "study", executor)
    finally:
        executor.close()
    outcomes = found["outcomes"]  # the second reads 100 m low, and is never near the glide path or down
    row("a study over the flights of a recording", "as of any flight", str(outcomes), sum(outcomes.values()) == 2)
    assert outcomes == {"completed": 1, "landed": 1}
    assert (tmp_path / "study" / "report.html").is_file()


def test_smoothing(row, tmp_path):
    path, runway = tmp_path / "one.csv", tmp_path / "runway.toml"
    path.write_text(recordings.text(recordings.rows(step=recordings.LENGTH / 600)[:600]))
    runway.write_text(recordings.RUNWAY_FILE)
    took = []
    for _ in range(5):
        flights = sim.recorded(path, runway)
        gc.collect()
        begun = time.process_time()
        _ = flights["MADE1_001"]
        took.append(time.process_time() - begun)
    row("a flight of 600 rows smoothed", "<= .3 s", f"{min(took):.2f} s, the least of 5", min(took) <= 0.3)
    assert min(took) <= 0.3
