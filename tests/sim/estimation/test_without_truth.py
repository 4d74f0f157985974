"""Tracks of recorded plots without a truth: begun by two of them, as of the sensor's own looks, judged by the plots."""

from __future__ import annotations

import dataclasses
import json
import math

import numpy as np
import pytest

import sim
from sim.errors import ScenarioError
from sim.estimation.setup import build
from sim.estimation.without_truth.places import places
from sim.estimation.without_truth.two_plots import two_plot_start
from sim.experiment import evaluate
from sim.flight.preparation import prepare
from sim.metrics.without_truth.agreement import Positions, agreement
from sim.metrics.without_truth.innovations import innovation_figures
from sim.metrics.without_truth.predicted import Predicted, predicted_figures
from sim.observation.record import measurements, observe
from sim.scenario.reading import read
from tests.capture import CAPTURE
from tracking.gaussian import Gaussian
from tracking.track import Measurements, Track
from tracking.track import track as run_tracker

RADAR = {"kind": "surveillance_radar", "period_s": 4.0, "position_m": [-6000, 0, 10]}
SAME = ("kalman", "imm", "saturated_control")  # the rival laws of intent_imm are designed for what flies
TRACKERS = {name: {"kind": name} for name in (*SAME, "intent_imm")}
AUTOPILOT = {
    "bank_limit_deg": 15.0,
    "law": {
        "k1_deg_per_m": 0.15,
        "k2_deg_per_mps": 1.8,
        "cross_track_limit_m": 420.0,
        "cross_track_rate_limit_mps": 50.0,
    },
}
RUNWAY = {"latitude_deg": 50.0, "longitude_deg": 30.0, "heading_deg": 0.0}
FLOWN = {
    **CAPTURE,
    "runway": RUNWAY,
    "autopilot": AUTOPILOT,
    "until_s": 130.0,
    "draws": 1,
    "seed": 3,
    "sensors": {"radar": RADAR},
    "trackers": TRACKERS,
}
PLOTS = {
    "kind": "recorded", "position_m": [-6000, 0, 10], "range_sigma_m": 60.0, "azimuth_sigma_deg": 0.15
}  # fmt: skip


@pytest.fixture(scope="module")
def flown():
    """A capture that was flown, what a radar saw of it, and how it was prepared."""
    prepared = prepare(read(FLOWN))
    flight = sim.fly(prepared)
    return prepared, flight, observe(flight, prepared.scenario.sensors, 3, draws=1)


def written(path, record, rows=slice(None)):
    """A file of plots, whole to the last bit."""
    lines = [
        f"{time!r},{slant!r},{azimuth!r}"
        for time, slant, azimuth in zip(record.time.tolist(), *record.z[:, :, 0].T.tolist(), strict=True)
    ]
    path.write_text("\n".join(["time,range_m,theta_rad", *lines[rows]]) + "\n")
    return str(path)


def alone(file, **more):
    """A scenario that knows these plots and the route, and no flight."""
    known = {key: FLOWN[key] for key in ("name", "seed", "route", "runway", "trackers")}
    return {**known, "record": {}, "autopilot": AUTOPILOT, "sensors": {"radar": {**PLOTS, "file": file}}, **more}


@pytest.fixture(scope="module")
def result(flown, tmp_path_factory):
    """A run over the plots alone."""
    return sim.run(alone(written(tmp_path_factory.mktemp("plots") / "plots.csv", flown[2]["radar"])))


@pytest.mark.parametrize("name", SAME)
def test_a_track_of_recorded_plots_is_that_of_the_looks_themselves(name, flown, result):
    """From the second plot on, to the rounding of an azimuth that is counted from another zero."""
    prepared, _, records = flown
    record = measurements(records, ("radar",))
    tracker, _ = build(prepared, name, prepared.scenario.trackers[name])
    start = two_plot_start(prepared, name, prepared.scenario.sensors, record, tracker.channels)
    after = record.arrival > start.time
    rest = Measurements(record.channels, record.time[after], record.arrival[after], record.z[after], record.R[after])
    own, found = run_tracker(tracker, rest, start.prior, start.time), result.tracks[name].track
    assert start.time == record.time[1]
    np.testing.assert_array_equal(found.time, own.time)
    np.testing.assert_allclose(found.mean, own.mean, rtol=0, atol=1e-6)
    np.testing.assert_allclose(found.nis, own.nis, rtol=1e-6, atol=1e-9)
    assert result.metrics["trackers"][name]["anis"] == pytest.approx(own.nis.sum() / np.isfinite(own.white).sum())


def test_two_plots_give_the_state_with_an_error_as_large_as_its_covariance(flown):
    """Straight and level at a constant speed: normalised squares of 4 components over 600 draws, 4 +- 4 sigma."""
    prepared, flight, _ = flown
    state = flight.state
    last = flight.time[-1]
    straight = dataclasses.replace(
        flight,
        state=state._replace(
            north=-20_000.0 + 72.0 * state.time, east=3000.0 + 10.0 * state.time, height=600.0 + 0.0 * state.time,
            velocity_north=72.0 + 0.0 * state.time, velocity_east=10.0 + 0.0 * state.time, velocity_up=0.0 * state.time,
        ),
    )  # fmt: skip
    records = observe(straight, prepared.scenario.sensors, 7, draws=600)
    names = ("north", "north_rate", "east", "east_rate")
    record = measurements(records, ("radar",))
    start = two_plot_start(prepared, "x", prepared.scenario.sensors, record, names)
    true = np.array([-20_000.0 + 72.0 * start.time, 72.0, 3000.0 + 10.0 * start.time, 10.0])
    error = start.prior.mean - true[:, None]
    squares = np.einsum("in,nij,jn->n", error, np.linalg.inv(np.moveaxis(start.prior.cov, 2, 0)), error)
    assert last > start.time
    assert squares.mean() == pytest.approx(4.0, abs=4 * math.sqrt(8 / 600))
    # known to some tens of m, and through the difference to as much over 4 s: sqrt(2) 60 m / 4 s along the beam
    assert np.sqrt(start.prior.cov[1, 1]).mean() == pytest.approx(math.sqrt(2) * 60.0 / 4.0, rel=0.02)


def test_a_start_of_two_sensors_reaches_to_the_later_second_plot():
    """Quantities by hand: 2 and 5 at 1 s and 3 s are 8 at 5 s, where the other quantity has its second value."""
    nan = np.nan
    z = np.array([[2.0, nan], [5.0, nan], [nan, 1.0], [nan, 0.0]])[:, :, None]
    R = np.broadcast_to(np.diag((4.0, 1.0)), (4, 2, 2))[..., None]
    time = np.array((1.0, 3.0, 4.0, 5.0))
    record = Measurements(("a.slope", "b.slope"), time, time, z, R)
    start = two_plot_start(None, "x", {}, record, ("a.slope", "a.slope_rate", "b.slope", "b.slope_acceleration"))
    assert start.time == 5.0
    np.testing.assert_allclose(start.prior.mean[:, 0], [8.0, 1.5, 0.0, 0.0])
    # 2 v2 - v1 and (v2 - v1) / 2 of two variances of 4
    expected = [[20.0, 6.0, 0.0, 0.0], [6.0, 2.0, 0.0, 0.0], [0.0, 0.0, 1.0, 0.0], [0.0, 0.0, 0.0, 4.0]]
    np.testing.assert_allclose(start.prior.cov[..., 0], expected)
    with pytest.raises(ScenarioError, match=r"\[trackers.x\] no plot says anything of its component height"):
        two_plot_start(None, "x", {}, record, ("height",))


def test_figures_need_no_truth_and_the_others_are_absent(result):
    metrics = result.metrics
    assert metrics["flight"]["outcome"] == "unknown"
    assert metrics["flight"]["reason"] == "no truth: figures from the plots alone"
    known = {key for key, value in metrics["flight"].items() if value is not None}
    assert known == {"outcome", "reason", "duration_s"}
    for name, figures in metrics["trackers"].items():
        absent = ("anees", "anees_low", "anees_high", "lost_fraction", "lost_time_s")
        assert [figures[key] for key in absent] == [None] * 5
        assert (figures["overall"], figures["by_phase"], figures["look_ahead"]) == ({}, {}, {})
        plots = figures["plots"]
        assert plots["anis_low"] < 1.0 < plots["anis_high"]
        assert plots["looks"] == len(result.tracks[name].track.time)
        assert plots["continuity"] > 0.9
        assert set(plots["agreement_m"]) == {*TRACKERS} - {name}
        assert plots["look_ahead"]["20_s"]["predictions"] > 5
        json.dumps(plots, allow_nan=False)
    assert metrics["trackers"]["intent_imm"]["conformance"]["false_alarm_fraction"] is None


def test_a_prediction_is_judged_by_the_plot_that_came(flown, tmp_path):
    """The look-ahead of a straight-line filter, done again by hand from its own track."""
    prepared, _, records = flown
    few = written(tmp_path / "plots.csv", records["radar"], slice(0, 40))
    result = sim.run(alone(few, trackers={"kalman": {"kind": "kalman"}}))
    track = result.tracks["kalman"].track
    plots = places(prepared, prepared.scenario.sensors, measurements(records, ("radar",)))
    squares = []
    for row, time in enumerate(track.time):
        later = np.flatnonzero(np.isclose(plots.time[:40], time + 20.0))
        if later.size:
            ahead = track.mean[row, [0, 2], 0] + 20.0 * track.mean[row, [1, 3], 0]
            squares.append(np.sum((ahead - plots.place[later[0], :, 0]) ** 2))
    found = result.metrics["trackers"]["kalman"]["plots"]["look_ahead"]["20_s"]
    assert found["predictions"] == len(squares)
    assert found["rmse_m"] == pytest.approx(math.sqrt(np.mean(squares)), rel=1e-5)


def test_predicted_figures_are_one_where_covariances_are_right():
    generator = np.random.default_rng(4)
    cov = np.array([[400.0, 150.0], [150.0, 100.0]])
    error = generator.multivariate_normal((0.0, 0.0), cov, 5000)[:, :, None]
    found = predicted_figures({"20_s": Predicted(error, np.broadcast_to(cov, (5000, 2, 2))[..., None])})["20_s"]
    assert found["rmse_m"] == pytest.approx(math.sqrt(500.0), rel=0.05)  # 4 sigma are 4 / sqrt(2 x 5000)
    assert found["normalised"] == pytest.approx(1.0, rel=0.06)  # 4 / sqrt(5000)


def made(white, time=None):
    """A track of whitened innovations (k, m)."""
    white = np.asarray(white)[:, :, None]
    k = len(white)
    time = 4.0 * np.arange(1.0, k + 1.0) if time is None else time
    nothing = np.zeros((k, 1, 1))
    return Track(("north",), time, nothing, nothing[..., None], white, np.nansum(white**2, axis=1), nothing[:, 0], None)


def test_innovations_of_a_consistent_tracker_are_within_their_bounds_and_others_are_not():
    white = np.random.default_rng(1).standard_normal((400, 2))
    good = innovation_figures(made(white), 0.0, 0.0, 1600.0)
    assert good["anis_low"] < np.mean(white**2) < good["anis_high"]
    assert abs(good["whiteness"]) < good["whiteness_limit"]
    assert (good["lost_time_s"], good["continuity"], good["gap_max_s"]) == (None, 1.0, 4.0)
    lagging = innovation_figures(made(white[1:] + white[:-1]), 0.0, 0.0, 1600.0)
    assert lagging["whiteness"] == pytest.approx(0.5, abs=0.1)
    assert lagging["whiteness"] > lagging["whiteness_limit"]


def test_a_track_ends_where_ten_looks_running_are_far_outside():
    white = np.full((50, 2), 0.5)
    white[20:29] = 9.0  # nine are not yet enough
    white[35:] = 9.0
    white[40] = np.nan  # nothing was measured: that breaks no row of ten
    found = innovation_figures(made(white), 4.0, 0.0, 200.0)
    assert found["lost_time_s"] == 4.0 * (45 + 1)  # 35 to 45 without 40
    assert found["continuity"] == pytest.approx((found["lost_time_s"] - 4.0) / 200.0)
    assert found["gap_max_s"] == 8.0


def test_agreement_is_the_distance_at_common_epochs():
    one = Positions(np.array((0.0, 4.0, 8.0)), np.zeros((3, 2, 1)))
    other = Positions(np.array((4.0, 8.0, 9.0)), np.array([[[3.0], [4.0]], [[0.0], [0.0]], [[99.0], [0.0]]]))
    apart = math.sqrt(25.0 / 2.0)
    never = Positions(np.array((1.0,)), np.zeros((1, 2, 1)))
    assert agreement({"a": one, "b": other, "c": never}) == {"a": {"b": apart}, "b": {"a": apart}, "c": {}}


def test_a_handed_over_track_begins_with_the_estimate_of_the_other(flown, tmp_path):
    record = flown[2]["radar"]
    files = [
        written(tmp_path / f"{n}.csv", record, rows) for n, rows in enumerate((slice(0, None, 2), slice(9, None, 2)))
    ]
    sensors = {name: {**PLOTS, "file": file} for name, file in zip(("first", "second"), files, strict=True)}
    handed = {
        "early": {"kind": "kalman", "sensors": ["first"]},
        "late": {"kind": "kalman", "sensors": ["second"], "handover": "early"},
        "cold": {"kind": "kalman", "sensors": ["second"]},
    }
    tracks = sim.run({**alone(files[0]), "sensors": sensors, "trackers": handed}).tracks
    early, late, cold = (tracks[name].track for name in ("early", "late", "cold"))
    np.testing.assert_array_equal(late.time, cold.time)
    start = record.time[11]  # the second plot of the second sensor
    before = int(np.searchsorted(early.time, start, side="right")) - 1
    tracker = tracks["late"].tracker
    seen = tracks["late"].measurements
    state = tracker.begin(Gaussian(early.mean[before], early.cov[before].astype(float)))
    state, _ = tracker.step(state, start - early.time[before], None, None)
    state, _ = tracker.step(state, late.time[0] - start, seen.z[0], seen.R[0])
    np.testing.assert_allclose(
        tracker.estimate(state).mean, late.mean[0], rtol=0, atol=0.01
    )  # of a covariance in single
    assert np.abs(cold.mean[0] - late.mean[0]).max() > 1.0


def test_with_a_flight_recorded_plots_are_judged_by_its_truth(flown, tmp_path):
    file = written(tmp_path / "plots.csv", flown[2]["radar"])
    few = {**FLOWN, "trackers": {"kalman": TRACKERS["kalman"]}}
    recorded = prepare(read({**few, "sensors": {"radar": {**PLOTS, "file": file}}}))
    seen, simulated = (evaluate(one, flown[1]).trackers["kalman"] for one in (recorded, prepare(read(few))))
    assert seen["overall"]["position_m"]["rmse"] == pytest.approx(simulated["overall"]["position_m"]["rmse"], rel=1e-6)
    assert seen["anees"] == pytest.approx(simulated["anees"], rel=1e-6)
    assert "plots" not in seen


def test_a_resolved_scenario_repeats_the_run_and_refuses_another_file(flown, tmp_path):
    file = written(tmp_path / "plots.csv", flown[2]["radar"])
    first = sim.run(alone(file, trackers={"kalman": TRACKERS["kalman"]}))
    tables = first.scenario.tables
    assert tables["sensors"]["radar"]["file"] == file
    assert sim.run(tables).metrics == first.metrics
    written(tmp_path / "plots.csv", flown[2]["radar"], slice(1, None))
    with pytest.raises(ScenarioError, match=r"\[sensors.radar\] file .* has changed since"):
        read(tables)


FAULTS = {
    "none of its 30 plots": {
        "record": None,
        "until_s": 20.0,
        **{k: CAPTURE[k] for k in ("start",)},
        "sensors": "later",
    },
    "[aircraft] stands beside [record]": {"aircraft": {"model": "an26"}},
    "latitude_deg is missing: a recording is placed by it": {"runway": {"heading_deg": 0, "longitude_deg": 30}},
    "[runway] heading_deg, its true course, is missing": {"runway": {"latitude_deg": 50, "longitude_deg": 30}},
    "[sensors.other] sees a flight, and [record] names none": {"sensors": "mixed"},
    "has no flight to see": None,
    "draws: must be 1 where all sensors are recorded": {"draws": 7},
    "flights: a recording is one flight": {"flights": 3},
    "sha256 is of a file of recorded tracks, and no file is named": {"record": {"sha256": "ab"}},
    "[[contrasts]] entry 0: 'imm' has no errors": {"contrasts": [{"of": "imm", "against": "kalman"}]},
    "[[checks]] entry 0 metric: 'overshoot_m' is of a flight": {"checks": [{"metric": "overshoot_m", "max": 1}]},
    "'radar' is recorded, and errs as it did": {
        "sensor_faults": [{"at_s": 1.0, "sensor": "radar", "error_factor": 2.0}]
    },
}


@pytest.mark.parametrize("said", [said for said, more in FAULTS.items() if more is not None])
def test_what_cannot_be_asked_of_plots_alone_is_one_sentence(said, flown, tmp_path):
    file = written(tmp_path / "plots.csv", flown[2]["radar"], slice(0, 30))
    more = dict(FAULTS[said])
    if more.get("sensors") == "mixed":
        more["sensors"] = {"radar": {**PLOTS, "file": file}, "other": RADAR}
    if more.get("sensors") == "later":
        late = flown[2]["radar"]._replace(time=flown[2]["radar"].time + 5000.0)
        more["sensors"] = {"radar": {**PLOTS, "file": written(tmp_path / "late.csv", late, slice(0, 30))}}
    with pytest.raises(ScenarioError) as error:
        sim.run(alone(file, **more))
    (line,) = str(error.value).splitlines()
    assert said in line


def test_no_tracker_flies_on_recorded_plots(flown, tmp_path):
    file = written(tmp_path / "plots.csv", flown[2]["radar"])
    navigated = {**FLOWN, "sensors": {"radar": {**PLOTS, "file": file}}, "autopilot": {"navigation": "imm"}}
    with pytest.raises(ScenarioError, match="no tracker can fly on plots that were recorded of another flight"):
        read(navigated)


@pytest.mark.parametrize("count", [1, 2])
def test_fewer_than_three_plots_begin_no_track(count, flown, tmp_path):
    file = written(tmp_path / "plots.csv", flown[2]["radar"], slice(0, count))
    with pytest.raises(
        ScenarioError, match=f"begins from two plots and is judged by those after, and radar gave {count}"
    ):
        sim.run(alone(file))


@pytest.mark.parametrize("sensors", [{}, {"radar": RADAR}])
def test_without_plots_there_is_nothing_to_run(sensors):
    with pytest.raises(ScenarioError, match=r"\[record\] names no file, so there is no flight to see"):
        sim.run({**alone("x"), "sensors": sensors, "trackers": {}})


def test_the_start_is_a_gaussian_of_all_draws():
    """Its shapes are those of a prior of any tracker."""
    time = np.array((0.0, 1.0, 2.0))
    record = Measurements(("a.x",), time, time, np.zeros((3, 1, 5)), np.ones((3, 1, 1, 1)))
    start = two_plot_start(None, "x", {}, record, ("a.x", "a.x_rate"))
    assert isinstance(start.prior, Gaussian)
    assert (start.prior.mean.shape, start.prior.cov.shape) == ((2, 5), (2, 2, 5))
