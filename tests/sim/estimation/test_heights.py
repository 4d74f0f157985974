"""A route at two heights is tracked as one at one height, by the chart or by the transponder, never by the truth."""

from __future__ import annotations

import math
import re

import numpy as np
import pytest

from sim.estimation.assumed_height import remarks
from sim.estimation.navigator import navigator
from sim.estimation.setup import build, height_profile
from sim.experiment import evaluate, fly
from sim.flight.preparation import prepare
from sim.scenario.reading import read
from tracking.height_profile import LEVEL_SIGMA

TRACKERS = {kind: {"kind": kind} for kind in ("imm", "kalman")}
LINE = ((0, 0), (9000, 0), (22_000, 0.1))
RADAR = (17_000, 2500, 10)


def legs(points, heights):
    return [
        {"from_m": list(start), "to_m": list(end), "speed_mps": 80, "height_m": height}
        for start, end, height in zip(points, points[1:], heights, strict=False)
    ]


def planned(heights, points=LINE, radar=RADAR, sensor=None, **more):
    """A point mass that is to fly along a route, watched by 10 draws of a radar."""
    tables = {
        "name": "heights",
        "draws": 10,
        "aircraft": {"model": "point_mass"},
        "route": {"kind": "legs", "legs": legs(points, heights)},
        "sensors": {"radar": {"kind": "surveillance_radar", "position_m": list(radar), **(sensor or {})}},
        **{"trackers": TRACKERS, **more},
    }
    return prepare(read(tables))


@pytest.fixture(scope="module")
def descending():
    return fly(planned((2000, 600)), 0)


@pytest.fixture(scope="module")
def level():
    prepared = planned((2000, 2000))
    return evaluate(prepared, fly(prepared, 0)).trackers


@pytest.mark.parametrize("sensor", [{}, {"height": "mode_c"}, {"height": "mode_c", "height_step_ft": 100}])
def test_two_heights_cost_no_more_than_one(level, descending, sensor):
    prepared = planned((2000, 600), sensor=sensor)
    found = evaluate(prepared, descending)
    assert np.ptp(descending.state.height) > 400.0
    for name in TRACKERS:
        figures, of_level = (trackers[name]["overall"]["position_m"] for trackers in (found.trackers, level))
        assert figures["rmse"] <= 1.3 * of_level["rmse"]
        assert figures["raw"] == pytest.approx(of_level["raw"], rel=0.1)
        assert found.trackers[name]["anees"] <= 1.5
        assert found.trackers[name]["lost_fraction"] == 0.0
    assert remarks(prepared, descending, found.records) == []


def test_a_flight_that_leaves_the_plan_is_told_of(descending):
    """It descends and the plan is level: the range near the radar is wrong, unless the transponder says the height."""
    prepared = planned((2000, 2000))
    found = evaluate(prepared, descending)
    (told,) = remarks(prepared, descending, found.records)
    assert re.fullmatch(
        r"sensor 'radar' measures no height: at \d+ s the height that was assumed was \d+ m too high, which costs "
        r"[\d.]+ standard deviations of its range; more than 0.5 in \d+% of its looks",
        told,
    )
    assert found.trackers["imm"]["anees"] > 1.5  # the remark is of an error that matters
    prepared = planned((2000, 2000), sensor={"height": "mode_c"})
    found = evaluate(prepared, descending)
    assert remarks(prepared, descending, found.records) == []
    assert found.trackers["imm"]["anees"] <= 1.5


def test_an_answer_in_hot_air_is_told_of(descending):
    """At 45 C, 30 K above the standard, 10 % of the height lack on the screen of every radar."""
    prepared = planned((2000, 600), sensor={"height": "mode_c"}, air={"temperature_c": 45})
    (told,) = remarks(prepared, descending, evaluate(prepared, descending).records)
    off = int(re.search(r"is told the height: .* answered was (\d+) m too low", told).group(1))
    assert off == pytest.approx(30.0 / 318.0 * descending.state.height.mean(), rel=0.25)  # at the worst of its looks


@pytest.mark.parametrize(
    ("more", "wind"), [({}, (0, 0)), ({"start": {"leg": 0, "cross_track_m": 1500}}, (0, 0)), ({}, (300, 10))]
)
def test_the_plan_is_what_is_flown(more, wind):
    """Round a corner, from beside the leg, in wind: within one standard deviation of a level that is kept."""
    corner = ((0, 0), (12_000, 0), (12_000, 14_000))
    prepared = planned((800, 1300), corner, trackers={}, wind={"from_deg": wind[0], "speed_mps": wind[1]}, **more)
    s = fly(prepared, 0).state
    assert np.ptp(s.height) > 400.0
    chart = height_profile(prepared).at(s.north, s.east, s.velocity_north, s.velocity_east)
    assert np.abs(chart.height - s.height).max() < LEVEL_SIGMA


def test_the_plan_begins_where_the_flight_is_filed_to_begin():
    prepared = planned((2000, 600), trackers={}, start={"leg": 1, "height_m": 900})
    s = fly(prepared, 0).state
    chart = height_profile(prepared).at(s.north, s.east, s.velocity_north, s.velocity_east)
    assert s.height[0] == pytest.approx(900.0, abs=1.0)
    assert np.abs(chart.height - s.height).max() < LEVEL_SIGMA


def test_the_plan_follows_the_glide_path():
    prepared = prepare(read("an26_pattern", {"sensors": {}, "trackers": {}, "autopilot.navigation": "truth"}))
    profile, runway = height_profile(prepared), prepared.scenario.runway
    past = np.array([-9000.0, -6000.0, -1000.0, 300.0, 900.0])
    wanted = np.clip((300.0 - past) * math.tan(runway.glide_path), 0.0, 400.0)
    along = 69.0 * np.array((math.cos(runway.heading), math.sin(runway.heading)))
    height = profile.at(*runway.to_local(past, np.zeros(5)), *along).height
    assert height == pytest.approx(wanted, abs=1.0)


def test_an_assumed_height_is_that_of_the_believed_place():
    """Two plots from 2000 m, which is the plan at the first place; at the second it has descended for 4 km."""
    prepared = planned((2000, 600))
    tracker, _ = build(prepared, "imm", prepared.scenario.trackers["imm"])
    north = np.array([5000.0, 13_000.0])
    mean = np.array((north, np.full(2, 80.0), np.zeros(2), np.zeros(2)))
    true = np.hypot(north - 17_000.0, 2500.0)
    slant = np.hypot(true, 1990.0)
    z = np.array((slant, np.arctan2(-2500.0, north - 17_000.0)))
    R = np.diag((60.0**2, math.radians(0.15) ** 2))[..., None]
    linear = tracker.measurement.linearise(z, R, mean)
    believed = np.hypot(linear.z[0] - 17_000.0, linear.z[1] - 2500.0)
    assert believed[0] == pytest.approx(true[0], abs=2.0)
    # 4 km at 2.5 degrees, from 0.2 km before the corner, but for the 7 s until the descent is steady
    descended = 1990.0 - 3.9e3 * math.radians(2.5)
    assert believed[1] == pytest.approx(math.sqrt(slant[1] ** 2 - descended**2), abs=10.0)
    assert believed[1] - true[1] > 50.0


def test_a_height_that_the_ground_is_told_lands_nobody():
    """Below decision height the radio altimeter serves, whatever radar with Mode C stands before it in the file."""
    tables = dict(read("an26_mls_anomalies").tables)
    sensors = dict(tables["sensors"])
    (altimeter,) = (name for name, one in sensors.items() if one["kind"] == "radio_altimeter")
    last = {"told": {"kind": "surveillance_radar", "height": "mode_c"}, altimeter: sensors.pop(altimeter)}
    led = navigator(prepare(read({**tables, "sensors": sensors | last})), 0)
    assert led.altimeter[0] == altimeter
