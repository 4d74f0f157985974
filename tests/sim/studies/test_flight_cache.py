"""Flights that cells share: what names them, what damages them, and that no figure depends on them."""

from __future__ import annotations

import dataclasses
import json
from types import SimpleNamespace

import numpy as np
import pytest

from sim import experiment
from sim.flight.preparation import prepare
from sim.scenario.reading import read
from sim.studies import study as studies
from sim.studies.job import Job, fly
from sim.studies.kept import flight_cache
from tests.capture import CAPTURE
from tests.hostile.foreign import FOREIGN

TABLES = {
    **CAPTURE,
    "name": "shared",
    "until_s": 5.0,
    "flights": 2,
    "draws": 3,
    "wind": {"turbulence": "light"},
    "sensors": {"radar": {"kind": "surveillance_radar", "position_sigma_m": 100.0}},
    "trackers": {"plain": {"kind": "kalman"}},
}
RADAR = {"sensors.radar.position_sigma_m": [50.0, 100.0, 200.0]}


@pytest.fixture
def flown(monkeypatch):
    """Numbers of the flights that were really flown."""
    numbers, fly = [], experiment.fly
    monkeypatch.setattr(experiment, "fly", lambda prepared, number: numbers.append(number) or fly(prepared, number))
    return numbers


@pytest.fixture
def study(inline):
    def call(folder, axes, anew=False, **more):
        return studies.study({**TABLES, **more, "study": {"axes": axes}}, folder, inline(), anew=anew)

    return call


def log(folder):
    return (folder / "flights.jsonl").read_bytes()


def kept(folder):
    return sorted((folder / "cache/flights").iterdir())


def test_cells_that_differ_in_sensors_share_their_flights_and_no_figure_knows(study, flown, tmp_path, monkeypatch):
    study(tmp_path / "shared", RADAR)
    assert flown == [0, 1]
    monkeypatch.setattr(flight_cache, "shared", lambda prepared: False)
    study(tmp_path / "alone", RADAR)
    assert flown == [0, 1] + [0, 1] * 3
    for name in ("flights.jsonl", "metrics.json"):
        assert (tmp_path / "shared" / name).read_bytes() == (tmp_path / "alone" / name).read_bytes()


def test_a_second_study_of_other_trackers_flies_nothing(study, flown, tmp_path):
    study(tmp_path, RADAR)
    other = {"trackers": {"second": {"kind": "linear_feedback"}}, "draws": 5}
    metrics = study(tmp_path, RADAR, anew=True, **other)
    assert flown == [0, 1]
    assert metrics["rows"][0]["trackers.second.overall.cross_track_m.rmse"]["n"] == 2
    assert len(kept(tmp_path)) == 2


def test_what_no_flight_asks_for_any_more_is_dropped(study, flown, tmp_path):
    study(tmp_path, RADAR)
    before = kept(tmp_path)
    study(tmp_path, RADAR, anew=True, until_s=4.0)
    assert flown == [0, 1, 0, 1]
    assert len(kept(tmp_path)) == 2
    assert not set(kept(tmp_path)) & set(before)


def cut(path):
    path.write_bytes(path.read_bytes()[:-100])


def flip(path):
    content = bytearray(path.read_bytes())
    content[len(content) // 2] ^= 1
    path.write_bytes(content)


def empty(path):
    path.write_bytes(b"")


def swap(path):
    other = next(one for one in sorted(path.parent.iterdir()) if one != path)
    path.write_bytes(other.read_bytes())


def replace(path):
    path.unlink()
    path.mkdir()


@pytest.mark.parametrize("damage", [cut, flip, empty, swap, replace])
def test_a_damaged_flight_costs_one_flight_and_no_figure(study, flown, inline, tmp_path, damage):
    study(tmp_path, RADAR)
    whole = log(tmp_path)
    (tmp_path / "flights.jsonl").unlink()
    damage(kept(tmp_path)[0])
    studies.resume(tmp_path, inline())
    assert len(flown) == 2 + (1 if damage is not replace else 3)  # a folder in its place is nobody's to take away
    assert log(tmp_path) == whole


def test_no_room_costs_time_only(study, flown, tmp_path, monkeypatch):
    monkeypatch.setattr(flight_cache, "LARGEST_CACHE", 1000)
    study(tmp_path, RADAR)
    assert flown == [0, 1] * 3
    assert not kept(tmp_path)


def test_without_trackers_or_with_one_at_the_controls_nothing_is_kept(study, tmp_path):
    study(tmp_path / "o", {"wind.speed_mps": [1.0]}, trackers={}, sensors={}, until_s=1.0)
    assert not kept(tmp_path / "o")
    flies = {"kind": "lateral_navigation", "navigation": "plain"}
    prepared = prepare(read({**TABLES, "autopilot": flies, "draws": 1}))
    assert not flight_cache.shared(prepared)


def prepared(**more):
    return prepare(read({**TABLES, "aircraft": {"model": "point_mass"}, **more}))


def test_what_decides_a_flight_decides_its_name(monkeypatch):
    name = flight_cache.key(prepared(), 0)
    assert flight_cache.key(prepared(), 0) == name
    same = {"sensors": {"radar": {"kind": "surveillance_radar"}}, "draws": 9, "name": "other", "flights": 7}
    assert flight_cache.key(prepared(**same), 0) == name
    others = [
        flight_cache.key(prepared(), 1),
        flight_cache.key(prepared(seed=2), 0),
        flight_cache.key(dataclasses.replace(prepared(), rate=60.0), 0),
        flight_cache.key(prepared(wind={"turbulence": "light", "speed_mps": 1.0}), 0),
        flight_cache.key(prepared(until_s=6.0), 0),
        flight_cache.key(prepared(aircraft={"model": "an26"}), 0),
        flight_cache.key(prepared(autopilot={"kind": "lateral_navigation", "bank_limit_deg": 14}), 0),
    ]
    monkeypatch.setattr(flight_cache, "versions", lambda parts: {"shortfinal": "another"})
    others.append(flight_cache.key(prepared(), 0))
    monkeypatch.undo()
    monkeypatch.setattr(flight_cache, "program", lambda: "edited")
    others.append(flight_cache.key(prepared(), 0))
    assert len({name, *others}) == 1 + len(others)


def test_a_changed_file_of_a_model_is_another_aircraft(tmp_path):
    home = FOREIGN["root with systems"].write(tmp_path)
    found = [flight_cache._model(str(home))]
    changes = {
        home / "plane.toml": 'title = "data beside it"',
        home / "plane.xml": (home / "plane.xml").read_text().replace(">20000<", ">20001<"),
        tmp_path / "root" / "systems" / "my_system.xml": '<system name="other"/>',
    }
    for path, text in changes.items():
        flight_cache._model.cache_clear()
        path.write_text(text)
        found.append(flight_cache._model(str(home)))
    flight_cache._model.cache_clear()
    (home / "note.xml").write_text("<of_no_model/>")
    assert flight_cache._model(str(home)) == found[-1]
    assert len(set(found)) == len(found)


def test_a_flight_comes_back_as_it_was_left(tmp_path):
    ready = prepared()
    flight = experiment.fly(ready, 0)
    flight_cache.store(tmp_path, "name", flight)
    again = flight_cache.load(tmp_path, "name", ready)
    assert vars(again).keys() == vars(flight).keys()
    for part in ("state", "command"):
        for one, other in zip(getattr(flight, part), getattr(again, part), strict=True):
            np.testing.assert_array_equal(one, other)
            assert one.strides == other.strides  # sums depend on the order in memory
    np.testing.assert_array_equal(flight.leg, again.leg)
    np.testing.assert_array_equal(flight.phase, again.phase)
    rest = ("route", "phases", "events", "outcome", "reason", "gate_height", "utc")
    assert flight.rollout is again.rollout is None  # tests of the roll-out look at one that there is
    parts = {"state", "command", "leg", "phase", "rollout"}
    assert set(vars(flight)) == {*parts, *rest}  # whatever a flight has is looked at
    assert [getattr(flight, name) for name in rest] == [getattr(again, name) for name in rest]
    low = SimpleNamespace(route=ready.route, gate_height=150.0)
    assert flight_cache.load(tmp_path, "name", low).gate_height == 150.0


def test_a_folder_without_a_cache_is_flown_all_the_same(tmp_path, flown):
    cell = studies.designed_cells(studies.plan(read({**TABLES, "study": {"axes": {"wind.speed_mps": [1.0]}}})))[0]
    job = Job(0, 0, 0, {}, {**cell, "until_s": 1.0}, {}, str(tmp_path / "nowhere"))
    assert json.loads(json.dumps(fly(job)))["metrics"]["outcome"] == "completed"
    assert flown == [0]
    assert not (tmp_path / "nowhere").exists()
