"""What passes between a run and Stone Soup; with the package itself in tests/acceptance/test_views.py."""

from __future__ import annotations

import dataclasses
import importlib.util
from datetime import datetime, timedelta
from types import SimpleNamespace

import numpy as np
import pytest

import sim
from sim.interchange.estimates import read_estimates
from sim.results.judging import with_track
from sim.results.stonesoup import START, plots_of


def states(track, draw, start=START):
    """A track as a sequence of states with the members that Stone Soup's have."""
    cov = np.broadcast_to(track.cov, (*track.cov.shape[:3], track.mean.shape[2]))
    return [
        SimpleNamespace(
            mean=track.mean[k, :, [draw]].T, covar=cov[k, :, :, draw], timestamp=start + timedelta(seconds=time)
        )
        for k, time in enumerate(track.time.tolist())
    ]


def test_tracks_come_back_as_draws_that_judge_takes(short_flown, short_folder, tmp_path):
    track = short_flown.tracks["kalman"].track
    found = sim.from_stonesoup(*(states(track, draw) for draw in range(3)))
    order = [np.flatnonzero(found.draw == draw) for draw in range(3)]
    for draw, rows in enumerate(order):
        np.testing.assert_array_equal(found.stamps.time[rows], track.time)  # whole tenths of a second: no rounding
        np.testing.assert_array_equal(found.local[rows], track.mean[:, [0, 2], draw])
        np.testing.assert_array_equal(found.velocity[rows], track.mean[:, [1, 3], draw])
    tables = with_track(short_folder, "back", found.save(tmp_path / "mine.csv"), ["radar"])
    judged = sim.run(tables).metrics["trackers"]
    assert judged["back"]["overall"]["position_m"]["rmse"] == pytest.approx(
        judged["kalman"]["overall"]["position_m"]["rmse"], rel=1e-9
    )
    assert judged["back"]["anees"] == pytest.approx(judged["kalman"]["anees"], rel=1e-6)  # kept in single precision


def test_what_a_track_does_not_say_is_not_said(tmp_path):
    start = datetime(2030, 1, 1)
    plain = [SimpleNamespace(mean=np.array([[1.0], [2.0]]), timestamp=start + timedelta(seconds=k)) for k in range(3)]
    plain[1].mean = np.array([[np.nan], [2.0]])
    found = sim.from_stonesoup(plain, start=start, mapping=(1, 0), velocity_mapping=None)
    assert (found.velocity, found.cov, found.number) == (None, None, None)
    assert found.local.tolist() == [[2.0, 1.0]] * 2
    assert found.stamps.time.tolist() == [0.0, 2.0]
    assert read_estimates(found.save(tmp_path / "a.csv").read_bytes()).local.tolist() == found.local.tolist()


@pytest.mark.parametrize("tracks", [(), ([],), ([SimpleNamespace(mean=np.full((4, 1), np.nan), timestamp=START)],)])
def test_tracks_without_a_place_are_refused(tracks):
    with pytest.raises(ValueError, match="the tracks have no state that says a place"):
        sim.from_stonesoup(*tracks)


@pytest.mark.parametrize("name", ["radar", "approach", "charted"])
def test_a_radar_is_brought_to_the_ground_with_the_slopes_of_its_own_function(short_flown, name):
    """Bearing and range on the ground, and their covariance by differences of the function itself."""
    sensors = short_flown.scenario.sensors
    sensor = sensors["approach" if name == "approach" else "radar"]
    channels = {
        "radar": ("range", "azimuth", "height"),
        "approach": ("range", "azimuth", "elevation"),
        "charted": ("range", "azimuth"),
    }[name]
    z = np.array((5000.0, 0.3, 600.0 if name == "radar" else 0.1))[: len(channels)]
    R = np.diag(np.array((60.0, 0.002, 30.0 if name == "radar" else 0.001))[: len(channels)] ** 2)
    found = plots_of(short_flown, sensor, channels, z[None, None], R[None])
    bearing, ground = found.value[0, 0]
    assert bearing == 0.3
    if name == "approach":
        assert ground == pytest.approx(5000.0 * np.cos(0.1), abs=1e-9)
    elif name == "radar":
        assert ground == pytest.approx(np.sqrt(5000.0**2 - (600.0 - sensor.antenna[2]) ** 2), abs=1e-9)
    steps = np.array((1e-2, 1e-6, 1e-2 if name == "radar" else 1e-6))[: len(channels)]
    ends = [
        plots_of(short_flown, sensor, channels, (z + side * np.diag(steps))[:, None], R[None]).value[:, 0]
        for side in (1, -1)
    ]
    J = ((ends[0] - ends[1]) / (2 * steps[:, None])).T
    if name == "charted":  # the plan's height changes along the way, which the slope leaves out
        J[1, 1] = 0.0
    np.testing.assert_allclose(found.cov[0, 0], J @ R @ J.T, rtol=1e-4, atol=1e-9)


def test_a_sensor_of_an_angle_alone_is_no_place(short_flown):
    record = short_flown.records["needle"]
    found = plots_of(
        short_flown, short_flown.scenario.sensors["needle"], record.channels, record.z[:, None, :, 0], record.R
    )
    assert found is None


def test_without_the_package_one_sentence_names_the_extra(short_flown, monkeypatch):
    there = importlib.util.find_spec
    monkeypatch.setattr(importlib.util, "find_spec", lambda name: None if name == "stonesoup" else there(name))
    with pytest.raises(sim.OutputError, match=r"to_stonesoup needs Stone Soup: pip install 'shortfinal\[stonesoup\]'"):
        sim.to_stonesoup(short_flown)


def test_with_the_package_a_run_becomes_its_objects(short_flown):
    pytest.importorskip("stonesoup", reason="Stone Soup is not installed: pip install 'shortfinal[stonesoup]'")
    with pytest.raises(sim.OutputError, match="--draw 3: the run has the draws 0 to 2"):
        sim.to_stonesoup(short_flown, draw=3)
    found = sim.to_stonesoup(short_flown, draw=2)
    assert {*found.detections} == {"radar", "cluttered", "approach"}
    assert {*found.tracks} == {"kalman", "imm"}
    assert len(found.left) == 2
    assert len(found.detections["cluttered"]) == len(short_flown.records["cluttered"].time)  # empty looks too
    bare = sim.to_stonesoup(dataclasses.replace(short_flown, tracks={}))
    assert bare.tracks == {}
