"""Trackers in a scenario: they see measurements and nothing of the truth, and are judged in common channels."""

from __future__ import annotations

from dataclasses import replace
from itertools import pairwise
from typing import NamedTuple

import numpy as np
import pytest

from aircraft.state import AircraftState
from sim.errors import ScenarioError
from sim.estimation import prior as components
from sim.estimation.navigator import navigator
from sim.estimation.setup import build, check, told
from sim.estimation.tracked.beginning import begins
from sim.estimation.tracking_run import track
from sim.experiment import fly
from sim.flight.interpolation import truth_at
from sim.flight.preparation import prepare
from sim.metrics import comparison
from sim.observation.record import measurements, observe
from sim.scenario.reading import read
from tracking.gaussian import Gaussian
from tracking.track import follow
from tracking.tree import narrowed

LEGS = [
    {"from_m": [0, 0], "to_m": [9000, 0], "speed_mps": 90, "height_m": 800},
    {"from_m": [9000, 0], "to_m": [9000, 12000], "speed_mps": 90, "height_m": 800},
]
SENSORS = {
    "radar": {"kind": "surveillance_radar", "position_m": [-3000, 4000, 10]},
    "approach": {"kind": "precision_radar", "sector_deg": 360, "course_deg": 0, "position_m": [-8000, 900, 3]},
    "link": {"kind": "downlink", "period_s": 1.0},
}


def scenario(trackers, **more):
    tables = {
        "name": "two_legs",
        "draws": 6,
        "until_s": 200,
        "route": {"kind": "legs", "legs": LEGS},
        "start": {"leg": 0, "cross_track_m": 400},
        "sensors": SENSORS,
        "trackers": trackers,
        **more,
    }
    return prepare(read(tables))


RADARS = ["radar", "approach"]
ALL = {
    "kalman": {"kind": "kalman", "sensors": RADARS},
    "saturated": {"kind": "saturated_control", "sensors": RADARS},
    "wrong": {
        "kind": "saturated_control",
        "sensors": RADARS,
        "law": {"k1_factor": 1.3, "cross_track_limit_factor": 1.3},
    },
    "route": {"kind": "saturated_control", "sensors": RADARS},
    "intent": {"kind": "intent_imm", "sensors": RADARS},
    "imm": {"kind": "imm", "sensors": RADARS},
    "aided": {"kind": "load_factor_cartesian", "sensors": ["approach", "link"]},
    "polar": {"kind": "load_factor", "sensors": ["approach", "link"]},
}


@pytest.fixture(scope="module")
def flown():
    prepared = scenario(ALL)
    flight = fly(prepared)
    s = prepared.scenario
    return prepared, flight, observe(flight, s.sensors, s.seed, 0, s.draws)


@pytest.fixture(scope="module")
def tracked(flown):
    return track(*flown, {})


def test_every_tracker_beats_its_plots_and_says_so(tracked):
    _, figures = tracked
    for name in ("saturated", "route", "intent", "imm", "aided", "polar"):
        assert figures[name]["overall"]["position_m"]["gain"] > 1.0, name
        assert set(figures[name]["by_phase"]) <= {"intercept", "downwind", "base_turn", "base", "final_turn", "final"}


def test_trackers_are_blind_to_everything_but_their_measurements(flown, tracked):
    """The flight after its first seconds is replaced by nonsense; the measurements stay; every estimate stays."""
    prepared, flight, records = flown
    late = flight.time > 8.0
    lie = {
        name: np.where(late, column + 777.0, column)
        for name, column in flight.state._asdict().items()
        if name not in ("time",)
    }
    other = replace(
        flight,
        state=flight.state._replace(**lie),
        leg=np.zeros_like(flight.leg),
        phase=np.zeros_like(flight.phase),
        command=flight.command._replace(bank=-flight.command.bank),
    )
    blind, _ = track(prepared, other, {name: record.until(60.0) for name, record in records.items()}, {})
    for name, one in tracked[0].items():
        blinded = blind[name].track
        assert blinded.time[-1] > 55.0
        np.testing.assert_array_equal(one.track.mean[: len(blinded.time)], blinded.mean)


def test_a_told_law_changes_the_estimate_and_its_origin_is_named(tracked):
    tracks, figures = tracked
    assert figures["saturated"]["law_from"] == "autopilot"
    assert figures["wrong"]["law_from"] == "told wrong"
    assert figures["kalman"]["law_from"] is None
    assert not np.allclose(tracks["saturated"].track.mean, tracks["wrong"].track.mean)


@pytest.mark.parametrize(("table", "deg"), [({}, 20.0), ({"bank_deg": 12}, 12.0)])
def test_the_turns_of_the_imm_are_flown_at_the_bank_limit_unless_set(table, deg):
    prepared = scenario({"imm": {"kind": "imm", "sensors": RADARS, **table}}, autopilot={"bank_limit_deg": 20})
    tracker, _ = build(prepared, "imm", prepared.scenario.trackers["imm"])
    turning = np.array([[0.0], [80.0], [0.0], [0.0]])
    turned = tracker.step(tracker.begin(Gaussian(turning, np.eye(4))), 1.0, None, None)[0]
    right = tracker.modes.index("right turn")
    course = np.arctan2(turned.mean[3, right], turned.mean[1, right])[0]
    assert course == pytest.approx(9.80665 * np.tan(np.radians(deg)) / 80.0, rel=1e-6)
    assert told(prepared, type(tracker)) == "bank limit 20 deg"


def test_perfect_estimates_have_no_error_in_any_channel(flown):
    prepared, flight, _ = flown
    sensors = {name: prepared.scenario.sensors[name] for name in RADARS}
    time = np.linspace(5.0, 100.0, 40)
    truth = truth_at(flight, time)
    mean = np.stack((truth.position[0], truth.velocity[0], truth.position[1], truth.velocity[1]), axis=1)[..., None]
    cov = np.broadcast_to(np.eye(4)[None, ..., None], (40, 4, 4, 1))
    names = ("north", "north_rate", "east", "east_rate")
    errors = comparison.compare(flight, truth, names, mean, cov, sensors)
    assert {"position_m", "cross_track_m", "radar.azimuth_deg", "approach.azimuth_deg"} == set(errors)
    for name, compared in errors.items():
        assert np.abs(compared.error).max() < 1e-9, name  # rounding of metres and degrees


def test_an_error_across_the_leg_is_cross_track_to_the_right(flown):
    _, flight, _ = flown
    time = np.array([20.0, flight.time[flight.leg == 1][300]])  # northwards, then eastwards
    truth = truth_at(flight, time)
    assert truth.leg.tolist() == [0, 1]
    mean = np.stack((truth.position[0] + 3.0, np.zeros(2), truth.position[1] + 5.0, np.zeros(2)), axis=1)[..., None]
    cov = np.broadcast_to(np.diag((4.0, 1.0, 9.0, 1.0))[None, ..., None], (2, 4, 4, 1))
    errors = comparison.compare(flight, truth, ("north", "north_rate", "east", "east_rate"), mean, cov, {})
    assert errors["cross_track_m"].error[:, 0, 0] == pytest.approx([5.0, -3.0])  # right of east is south
    assert errors["cross_track_m"].cov[:, 0, 0, 0] == pytest.approx([9.0, 4.0])
    assert comparison.normalised(errors["position_m"])[0, 0] == pytest.approx(9 / 4 + 25 / 9)


def test_rates_of_angles_are_their_derivatives(flown):
    prepared, flight, _ = flown
    sensor = prepared.scenario.sensors["approach"]
    time = np.array([50.0])
    truth = truth_at(flight, time)
    north, east = truth.position[0] - sensor.antenna[0], truth.position[1] - sensor.antenna[1]
    rate = (north * truth.velocity[1] - east * truth.velocity[0]) / (north**2 + east**2)
    found = components.true_values(flight, prepared.scenario.sensors, "approach.azimuth_rate", time)
    assert found == pytest.approx(rate, rel=1e-4)  # the difference over 0.2 s of a smooth course


def test_the_prior_error_has_its_stated_spread_and_is_common(flown):
    prepared, flight, _ = flown
    sensors = prepared.scenario.sensors
    names = ("north", "north_rate", "approach.azimuth")
    prior = components.prior(flight, sensors, names, 10.0, seed=9, number=0, draws=4000)
    truth = np.array([components.true_values(flight, sensors, name, np.array([10.0]))[0] for name in names])
    spread = (prior.mean - truth[:, None]).std(axis=1) / np.sqrt(np.diag(prior.cov))
    assert spread == pytest.approx(np.ones(3), abs=0.05)  # 4000 draws: a standard deviation of 1.1 %
    fewer = components.prior(flight, sensors, names[::-1], 10.0, seed=9, number=0, draws=3)
    np.testing.assert_array_equal(fewer.mean, prior.mean[::-1, :3])


def test_sight_in_the_loop_is_the_track_of_the_record():
    """The navigating tracker sees in the loop what it sees on the record of the same flight."""
    table = {"route": {"kind": "saturated_control", "sensors": RADARS}}
    prepared = scenario(table, autopilot={"navigation": "route"}, draws=1, until_s=40)
    flight = fly(prepared)
    s = prepared.scenario
    records = observe(flight, s.sensors, s.seed, 0, 1)
    record = measurements(records, ("radar", "approach"))
    tracker, _ = build(prepared, "route", s.trackers["route"])
    start = begins(prepared, "route", ("radar", "approach"), record, flight)
    prior = components.prior(flight, s.sensors, tracker.channels, start, s.seed, 0, 1)
    guide = navigator(prepared, 0)
    rows = [AircraftState(*row) for row in np.column_stack(flight.state).tolist()]
    sight, _ = guide.begin(rows[0])
    for before, after in pairwise(rows):
        sight, _ = guide.step(sight, before, after)
    last = list(follow(tracker, record, prior, start=start))[-1]
    assert sight.time == last.time
    # the prior in the loop is taken from straight flight about the start, on the record from the record itself
    np.testing.assert_allclose(sight.tracker.gaussian.mean, last.estimate.mean, rtol=0, atol=1e-3)


def test_flying_on_a_tracker_is_not_flying_on_the_truth():
    table = {"route": {"kind": "saturated_control", "sensors": RADARS}}
    on_truth = fly(scenario(table, until_s=30))
    on_tracker = fly(scenario(table, autopilot={"navigation": "route"}, draws=1, until_s=30))
    assert np.abs(on_truth.command.bank - on_tracker.command.bank).max() > 0.01


@pytest.mark.parametrize(
    ("trackers", "more", "said"),
    [
        ({"t": {"kind": "kalman", "sensors": ["link"]}}, {}, "which is no position"),
        ({"t": {"kind": "load_factor", "sensors": ["approach"]}}, {}, "load_factor_forward"),
        ({"t": {"kind": "elevation", "sensors": ["radar"]}}, {}, "elevation"),
        (
            {"t": {"kind": "saturated_control", "sensors": ["radar"], "law": {"k9_factor": 2.0}}},
            {},
            "k9_factor: no such key",
        ),
        ({"t": {"kind": "kalman", "sensors": ["radar"]}}, {"autopilot": {"navigation": "t"}}, "must be 1 where"),
    ],
)
def test_trackers_that_cannot_be_are_told_before_the_flight(trackers, more, said):
    with pytest.raises(ScenarioError, match=said):
        check(scenario(trackers, **more))


def test_a_tracker_that_sees_nothing_has_no_figures():
    prepared = scenario(
        {"t": {"kind": "kalman", "sensors": ["blind"]}},
        sensors={"blind": {"kind": "precision_radar", "coverage_m": 10}},
    )
    flight = fly(prepared)
    tracks, figures = track(prepared, flight, observe(flight, prepared.scenario.sensors, 1, 0, 6), {})
    assert tracks == {}
    assert figures["t"]["overall"] == {}


def test_looking_ahead_is_the_tracker_s_own_prediction(flown, tracked):
    """That of a constant-velocity filter is a straight line from its estimate, at 12 instants of a flight."""
    _, flight, _ = flown
    one = tracked[0]["kalman"].track
    first, last = flight.time[0], flight.time[-1] - 20.0
    even = first + (last - first) * np.arange(1, 13) / 12
    squares = []
    for epoch in {np.flatnonzero(one.time <= instant)[-1] for instant in even if instant > one.time[0] + 1.0}:
        truth = truth_at(flight, one.time[[epoch]] + 20.0)
        mean = one.mean[epoch][:, :16]
        error = mean[[0, 2]] + 20.0 * mean[[1, 3]] - truth.position[:2]
        squares.append((error**2).sum(axis=0))
    assert len(squares) > 4
    expected = np.sqrt(np.mean(squares))
    assert tracked[1]["kalman"]["look_ahead"]["20_s"]["position_m"] == pytest.approx(expected, rel=1e-9)


@pytest.mark.parametrize(
    "kind",
    ["intent_imm", *(pytest.param(kind, marks=pytest.mark.soak) for kind in ("linear_feedback", "saturated_control"))],
)
def test_twins_track_as_each_of_them_does_alone(flown, kind):
    """The right and a mismatched law, side by side in one tracker and each by itself."""
    _, flight, whole = flown
    records = {name: record.until(60.0) for name, record in whole.items()}
    wrong = {"k1_factor": 1.3, "cross_track_limit_factor": 1.3}
    twins = {"right": {"kind": kind, "sensors": RADARS}, "wrong": {"kind": kind, "sensors": RADARS, "law": wrong}}
    together, figures = track(scenario(twins), flight, records, {})
    assert not np.allclose(together["right"].track.mean, together["wrong"].track.mean, rtol=0.0, atol=1.0)
    for name, choice in twins.items():
        alone, figures_alone = track(scenario({name: choice}), flight, records, {})
        one, other = together[name].track, alone[name].track
        for field in ("mean", "cov", "white", "nis", "log_likelihood", "model_probabilities"):
            expected = getattr(other, field)
            if expected is not None:  # long and short loops of one function may round differently, a track amplifies it
                largest = np.nanmax(np.abs(expected))
                np.testing.assert_allclose(getattr(one, field), expected, rtol=1e-7, atol=1e-9 * largest)
        for span, by_channel in figures_alone[name]["look_ahead"].items():
            assert figures[name]["look_ahead"][span] == pytest.approx(by_channel, rel=1e-6)


@pytest.mark.parametrize("detection", [0.6, 0.1])
def test_plots_that_single_draws_miss_leave_huber_its_limits(detection):
    radar = {"approach": {**SENSORS["approach"], "detection": detection}}
    prepared = scenario({"huber": {"kind": "huber"}}, sensors=radar, aircraft={"model": "point_mass"}, until_s=60)
    flight = fly(prepared)
    _, figures = track(prepared, flight, observe(flight, prepared.scenario.sensors, 1, 0, 6), {})
    assert 0.0 < figures["huber"]["anees_low"] < figures["huber"]["anees"] < figures["huber"]["anees_high"]


def test_states_are_narrowed_to_some_draws_whatever_they_hold():
    class Held(NamedTuple):
        mean: np.ndarray
        table: dict
        clock: float

    held = Held(np.arange(12.0).reshape(2, 6), {"a": (np.ones((3, 3, 6)), np.ones((3, 3)))}, 2.0)
    cut = narrowed(held, 6, np.arange(4))
    assert cut.mean.shape == (2, 4)
    assert [part.shape for part in cut.table["a"]] == [(3, 3, 4), (3, 3)]
    assert cut.clock == 2.0


def test_a_filterpy_object_reads_the_radars_of_the_scenario(flown):
    from filterpy.kalman import KalmanFilter

    from tracking.filterpy_adapter import from_filterpy

    prepared, flight, records = flown
    kf = KalmanFilter(dim_x=4, dim_z=2)
    kf.F = np.kron(np.eye(2), [[1.0, 4.0], [0.0, 1.0]])
    kf.H = np.array([[1.0, 0.0, 0.0, 0.0], [0.0, 0.0, 1.0, 0.0]])
    kf.Q = np.kron(np.eye(2), 3.0 * np.array([[64 / 3, 8.0], [8.0, 4.0]]))
    mine = from_filterpy(kf, channels=("north", "north_rate", "east", "east_rate"), period=4.0)
    alone = replace(prepared, scenario=replace(prepared.scenario, trackers={}))
    only = {name: records[name] for name in ("radar", "link")}
    _, figures = track(alone, flight, only, {"mine": mine})
    assert figures["mine"]["overall"]["position_m"]["gain"] > 0.8
