"""export --tracks: what a run kept, what a study flies again, and what is refused before anything is written."""

from __future__ import annotations

import csv
import tomllib

import pytest

from sim.errors import OutputError
from sim.experiment import fly, prepare, read
from sim.files import MARK, write_npz
from sim.observation.record import observe
from sim.reporting.run_files import flight_arrays, measurement_arrays
from sim.scenario.toml_writer import dumps
from sim.studies import recordings
from sim.studies.folder import open_study
from sim.studies.recordings import write_recordings

TABLES = {
    "name": "short",
    "seed": 4,
    "until_s": 6,
    "runway": {"latitude_deg": 52, "longitude_deg": 8, "heading_deg": 70},
    "air": {"qnh_hpa": 1030},
    "aircraft": {"model": "point_mass"},
    "start": {"leg": 0},
    "route": {
        "kind": "legs",
        "legs": [{"from_m": [-30000, -20000], "to_m": [0, 0], "speed_mps": 90, "height_m": 800}],
    },
    "autopilot": {"kind": "lateral_navigation"},
}
ADSB = {"sensors": {"receiver": {"kind": "adsb", "gap_share": 0}}}


class Here:
    """An executor that computes when it is asked, last job first."""

    def __init__(self, workers):
        self.jobs = []

    def submit(self, number, function, *arguments):
        self.jobs.append((number, function, arguments))

    def finished(self):
        for number, function, arguments in reversed(self.jobs):
            yield number, function(*arguments)

    def close(self):
        pass


def rows(path):
    with path.open(newline="") as file:
        return list(csv.DictReader(file))


def run_folder(folder, tables):
    """What a run of the tables leaves, as far as it is read."""
    scenario = read(tables)
    flight = fly(prepare(scenario))
    folder.mkdir()
    (folder / MARK).write_text("")
    (folder / "scenario.toml").write_text(dumps(scenario.tables))
    (folder / "metrics.json").write_text("{}")
    write_npz(folder / "flight.npz", flight_arrays(flight))
    write_npz(folder / "measurements.npz", measurement_arrays(observe(flight, scenario.sensors, 4, 0, 2)))
    return folder


def test_the_flight_of_a_run_is_written_with_its_runway(tmp_path):
    folder = run_folder(tmp_path / "run", TABLES)
    found = write_recordings(folder)
    assert found.files == (folder / "recordings.csv", folder / "runway.toml")
    assert (found.flights, found.rows, found.lost) == (1, 7, ())
    first = rows(found.files[0])[0]
    assert (first["flight_id"], first["timestamp"]) == ("short", "2026-01-01T12:00:00.000000Z")
    assert float(first["altitude"]) * 0.3048 == pytest.approx(float(first["geoaltitude"]) * 0.3048 - 138.0, abs=2.0)
    again = read({**TABLES, **tomllib.loads(found.files[1].read_text())})
    assert (again.runway, again.air) == (read(TABLES).runway, read(TABLES).air)
    assert sorted(path.name for path in folder.iterdir() if "partial" in path.name) == []


def test_a_sensor_for_it_gives_its_errors(tmp_path):
    folder = run_folder(tmp_path / "run", {**TABLES, **ADSB, "trackers": {}})
    found = write_recordings(folder, tmp_path / "seen.csv", date=0.0)
    seen = rows(found.files[0])
    assert [row["timestamp"][17:19] for row in seen][:5] == ["01", "02", "03", "04", "05"]
    assert all(row["geoaltitude"] == "" for row in seen)
    assert all((float(row["altitude"]) / 25.0).is_integer() for row in seen)


def study_folder(folder, monkeypatch, **tables):
    scenario = read({**TABLES, **tables})
    open_study(folder, dumps(scenario.tables), scenario.seed)
    monkeypatch.setattr(recordings, "LocalExecutor", Here)
    return folder


def test_flights_of_a_study_are_flown_again_and_stand_in_order(tmp_path, monkeypatch):
    axes = {"start.cross_track_m": {"uniform": [0, 500]}}
    folder = study_folder(tmp_path / "study", monkeypatch, study={"samples": 3, "axes": axes}, **ADSB)
    found = write_recordings(folder, date=0.0)
    written = rows(found.files[0])
    names = list(dict.fromkeys(row["flight_id"] for row in written))
    assert names == ["short_0", "short_1", "short_2"]
    firsts = [next(row for row in written if row["flight_id"] == name) for name in names]
    assert [row["timestamp"][11:16] for row in firsts] == ["00:00", "00:30", "01:00"]
    assert len({row["latitude"] for row in firsts}) == 3


def test_a_study_over_the_air_has_no_one_runway_file(tmp_path, monkeypatch):
    folder = study_folder(tmp_path / "study", monkeypatch, study={"axes": {"air.qnh_hpa": [990, 1030]}})
    with pytest.raises(OutputError, match=r"differ in air.qnh_hpa"):
        write_recordings(folder)
    assert not (folder / "recordings.csv").exists()


def test_what_stands_there_is_not_overwritten(tmp_path):
    folder = run_folder(tmp_path / "run", TABLES)
    (tmp_path / "mine.csv").write_text("mine")
    with pytest.raises(OutputError, match=r"mine.csv: exists already"):
        write_recordings(folder, tmp_path / "mine.csv")
    (tmp_path / "runway.toml").write_text("[runway]\n")
    with pytest.raises(OutputError, match="another runway"):
        write_recordings(folder, tmp_path / "other.csv")
    with pytest.raises(OutputError, match="no such folder"):
        write_recordings(folder, tmp_path / "nowhere" / "other.csv")
    assert (tmp_path / "mine.csv").read_text() == "mine"
    assert not (tmp_path / "other.csv").exists()


def test_a_folder_that_is_not_whole_is_one_sentence(tmp_path):
    with pytest.raises(OutputError, match="no such folder"):
        write_recordings(tmp_path / "nothing")
    folder = run_folder(tmp_path / "run", TABLES)
    (folder / "flight.npz").unlink()
    with pytest.raises(OutputError, match=r"flight.npz: missing; run the scenario again"):
        write_recordings(folder)
    (folder / "flight.npz").write_bytes(b"PK")
    with pytest.raises(OutputError, match="damaged; run the scenario again"):
        write_recordings(folder)
    assert not (folder / "recordings.csv").exists()


def test_a_flight_that_cannot_be_flown_is_told_and_the_others_stand(tmp_path, monkeypatch):
    study = {"axes": {"start.cross_track_m": [0, 100]}}
    folder = study_folder(tmp_path / "study", monkeypatch, study=study)
    flown = recordings._flown

    def sometimes(wanted):
        return recordings.Lost("its model aborts") if wanted.name == "short_0_0" else flown(wanted)

    monkeypatch.setattr(recordings, "_flown", sometimes)
    found = write_recordings(folder)
    assert found.flights == 1
    assert found.lost == ("short_0_0: its model aborts",)
    assert {row["flight_id"] for row in rows(found.files[0])} == {"short_1_0"}
