"""False plots of a precision radar: counted against the Poisson law, and a scenario that tracks among them."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest

import sim
from aircraft.state import AircraftState
from sim.errors import ScenarioError
from sim.estimation.navigator import navigator
from sim.estimation.setup import build, check
from sim.estimation.tracking_run import track
from sim.flight.preparation import prepare
from sim.observation.record import SensorRecord, observe
from sim.observation.sensors.precision_radar import REACH, PrecisionRadar
from sim.reporting.replay import false_plots
from sim.reporting.run_files import measurement_arrays
from sim.scenario.reading import read
from sim.scenario.tables import Runway
from tracking.association import clutter_density
from tracking.measurement import to_ground

RUNWAY = Runway(heading=math.radians(80.0))
CLUTTER = 3.0
RADAR = PrecisionRadar(clutter=CLUTTER, detection=0.9, runway=RUNWAY)


@pytest.fixture
def final(make_flight):
    """Down the final approach, 9 km to 3 km before the threshold."""
    time = np.arange(0.0, 100.0, 1 / 30)
    past = -9000.0 + 60.0 * time
    north, east = RUNWAY.to_local(past, np.zeros(len(time)))
    along = {"velocity_north": np.full(len(time), 60.0 * math.cos(RUNWAY.heading))}
    along["velocity_east"] = np.full(len(time), 60.0 * math.sin(RUNWAY.heading))
    along["velocity_up"] = np.full(len(time), -60.0 * math.tan(RUNWAY.glide_path))
    height = (RUNWAY.aiming_point - past) * math.tan(RUNWAY.glide_path)
    return make_flight(time, ["glide"] * len(time), north=north, east=east, height=height, **along)


def truth(sensor, flight, time):
    s = flight.state
    return sensor.truth(AircraftState(*(np.interp(time, s.time, column) for column in s)))


# ---- the radar ---------------------------------------------------------------------------------------------------


def test_clutter_changes_no_byte_of_the_targets_own_plots(final):
    plain, cluttered = (
        observe(final, {"x": replace(RADAR, clutter=clutter)}, seed=3, draws=4)["x"] for clutter in (0.0, CLUTTER)
    )
    assert plain.candidates is None
    for one, other in zip(plain[1:5], cluttered[1:5], strict=True):
        assert one.tobytes() == other.tobytes()
    np.testing.assert_array_equal(cluttered.candidates[:, 0], cluttered.z)


def test_false_plots_inside_three_sigma_are_poisson_and_as_many_as_said(final):
    record = observe(final, {"x": RADAR}, seed=11, draws=30)["x"]
    exact = truth(RADAR, final, record.time)
    normal = (record.candidates[:, 1:] - exact.T[:, None, :, None]) / RADAR.sigmas(*exact).T[:, None, :, None]
    counts = (np.hypot(normal[:, :, 0], normal[:, :, 1]) < 3.0).sum(axis=1).ravel()
    spread = math.sqrt(CLUTTER / counts.size)  # of the mean of Poisson counts
    assert abs(counts.mean() - CLUTTER) < 5.0 * spread
    # the variance of a sample variance of Poisson counts is (mean + 2 mean^2) / n
    assert abs(counts.var() - CLUTTER) < 5.0 * math.sqrt((CLUTTER + 2.0 * CLUTTER**2) / counts.size)
    assert np.nanmax(np.abs(normal)) <= REACH * (1.0 + 1e-9)
    assert np.nanmin(np.nanmax(np.abs(normal), axis=(0, 1, 3))) > 0.99 * REACH  # thousands of plots reach the edge


def test_false_plots_of_a_draw_do_not_depend_on_the_other_draws(final):
    few, many = (observe(final, {"x": RADAR}, seed=5, draws=draws)["x"].candidates for draws in (1, 3))
    np.testing.assert_array_equal(few, many[..., :1])


def test_clutter_of_an_epoch_belongs_to_it_whether_the_target_is_in_the_sector_or_not(final):
    all_round, narrow = (replace(RADAR, coverage=coverage) for coverage in (20_000.0, 8000.0))
    whole, late = (observe(final, {"x": radar}, seed=5, draws=2)["x"] for radar in (all_round, narrow))
    assert 0 < len(late.time) < len(whole.time)
    np.testing.assert_array_equal(whole.candidates[-len(late.time) :], late.candidates)


@pytest.mark.parametrize("clutter", [-1.0, math.nan, 1e6])
def test_impossible_clutter_is_refused(clutter):
    with pytest.raises(ValueError, match=r"clutter must be at (least 0|most 10)"):
        PrecisionRadar(clutter=clutter)


def test_density_on_the_ground_is_that_of_the_stated_accuracy_on_the_ground(final):
    place = np.array((7000.0, 0.05, math.radians(2.5)))
    R = np.diag(RADAR.sigmas(*place) ** 2)
    plot = to_ground(place, np.diag((R[0, 0], R[1, 1], 0.0)), None)  # clutter counts in range and azimuth alone
    ground = np.diag((plot.distance_variance, plot.distance**2 * plot.azimuth_variance))
    assert RADAR.clutter_density(*place) == pytest.approx(clutter_density(CLUTTER, ground), rel=1e-12)


# ---- trackers ----------------------------------------------------------------------------------------------------

SENSORS = {
    "radar": {
        "kind": "precision_radar",
        "sector_deg": 360,
        "position_m": [-9000, 900, 3],
        "period_s": 1,
        "detection": 0.9,
        "clutter": CLUTTER,
    },
    "clean": {"kind": "surveillance_radar", "position_m": [-3000, 4000, 10]},
}
ASSOCIATED = {"sensors": ["radar"], "association": "probabilistic"}


def scenario(trackers, **more):
    tables = {
        "name": "among_false_plots",
        "draws": 10,
        "until_s": 90,
        "route": {
            "kind": "legs",
            "legs": [{"from_m": [0, 0], "to_m": [9000, 0], "speed_mps": 90, "height_m": 800}],
        },
        "aircraft": {"model": "point_mass"},
        "start": {"leg": 0, "cross_track_m": 400},
        "sensors": SENSORS,
        "trackers": trackers,
    }
    return read({**tables, **more})


@pytest.fixture(scope="module")
def result():
    kinds = ("saturated_control", "imm")
    return sim.run(scenario({kind: {"kind": kind, **ASSOCIATED} for kind in kinds}))


@pytest.mark.parametrize("name", ["saturated_control", "imm"])
def test_association_keeps_most_draws(name, result):
    figures = result.metrics["trackers"][name]
    assert figures["lost_fraction"] < 0.3
    assert np.isfinite(result.tracks[name].track.mean).all()


def test_raw_is_the_targets_own_plot(result):
    record, flight = result.records["radar"], result.flight
    radar = result.scenario.sensors["radar"]
    error = (record.z - truth(radar, flight, record.time).T[:, :, None])[:, 1]
    raw = result.metrics["trackers"]["saturated_control"]["overall"]["radar.azimuth_deg"]["raw"]
    # a record at 30 Hz interpolated linearly is a decimetre beside the cubic; plots before the track begins: none
    assert raw == pytest.approx(math.degrees(math.sqrt(np.nanmean(error**2))), rel=1e-3)


def test_a_track_does_not_hang_on_which_candidate_is_the_targets(result):
    prepared, record = result.prepared, result.records["radar"]
    turned = record._replace(candidates=record.candidates[:, ::-1]).until(30.0)
    tracks, _ = track(prepared, result.flight, {"radar": turned, "clean": result.records["clean"].until(30.0)}, {})
    for name, one in result.tracks.items():
        count = len(tracks[name].track.mean)
        assert count > 20
        # the sum over hypotheses in another order: rounding, which some 30 updates amplify little
        np.testing.assert_allclose(tracks[name].track.mean, one.track.mean[:count], rtol=1e-6, atol=1e-6)


# ---- what is refused ---------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("table", "told"),
    [
        ({"kind": "kalman", "sensors": ["radar"]}, "'radar' has clutter; set association"),
        ({"kind": "kalman", "sensors": ["radar", "clean"]}, "'radar' has clutter; set association"),
        ({"kind": "kalman", "sensors": ["clean"], "association": "probabilistic"}, "needs exactly one sensor"),
        ({"kind": "kalman", "association": "probabilistic"}, "needs exactly one sensor"),
        ({"kind": "load_factor", **ASSOCIATED}, "does not track on the ground plane"),
        ({"kind": "kalman", "sensors": ["radar"], "association": "nearest"}, "association"),
    ],
)
def test_what_cannot_be_associated_is_told_before_anything_flies(table, told):
    with pytest.raises(ScenarioError, match=told) as caught:
        check(prepare(scenario({"mine": table})))
    assert "mine" in str(caught.value)
    assert len(str(caught.value).splitlines()) == 1


def test_a_radar_that_never_detects_is_refused():
    sensors = {"radar": {**SENSORS["radar"], "detection": 0}}
    with pytest.raises(ScenarioError, match="never detects"):
        check(prepare(scenario({"mine": {"kind": "kalman", **ASSOCIATED}}, sensors=sensors)))


def test_nobody_navigates_among_false_plots():
    flown = {"draws": 1, "autopilot": {"navigation": "mine"}}
    prepared = prepare(scenario({"mine": {"kind": "kalman", **ASSOCIATED}}, **flown))
    with pytest.raises(ScenarioError, match="associates plots"):
        navigator(prepared, 0)
    prepared = prepare(scenario({"mine": {"kind": "kalman", "sensors": ["radar"]}}, **flown))
    with pytest.raises(ScenarioError, match="has clutter"):
        navigator(prepared, 0)


def test_a_callers_own_tracker_is_not_handed_the_targets_plot(result):
    clean = scenario({"mine": {"kind": "kalman", "sensors": ["clean"]}})
    prepared = prepare(clean)
    own, _ = build(prepared, "mine", clean.trackers["mine"])
    with pytest.raises(ScenarioError, match="tracker of the caller cannot listen to 'radar'"):
        track(prepared, result.flight, result.records, {"own": own})


def test_false_plots_are_kept_one_row_each_and_drawn_apart():
    """Counted by hand: a look with its own plot and one false, a look that missed it among two false ones."""
    plots = np.full((2, 4, 3, 2), np.nan)
    plots[0, 0, :, 0], plots[0, 1, :, 0] = (9000.0, 0.01, 0.05), (9100.0, 0.02, 0.05)
    plots[1, 1, :, 0], plots[1, 2, :, 0] = (8900.0, 0.03, 0.05), (8950.0, -0.01, 0.05)
    plots[1, 0, :, 1] = (8940.0, 0.0, 0.05)
    time = np.array((1.0, 2.0))
    record = SensorRecord(
        ("range", "azimuth", "elevation"), time, time, plots[:, 0], np.tile(np.eye(3), (2, 1, 1)), plots
    )
    arrays = measurement_arrays({"radar": record})
    kept = {name.removeprefix("radar.plots."): values for name, values in arrays.items() if ".plots." in name}
    assert kept["time_s"].tolist() == [1.0, 1.0, 2.0, 2.0, 2.0]
    assert kept["draw"].tolist() == [0, 0, 1, 0, 0]
    assert kept["target"].tolist() == [1, 0, 1, 0, 0]
    assert kept["range_m"].tolist() == [9000.0, 9100.0, 8940.0, 8900.0, 8950.0]
    assert sorted(kept) == ["arrival_s", "azimuth_rad", "draw", "elevation_rad", "range_m", "target", "time_s"]
    apart = false_plots(record)
    assert apart.time.tolist() == [1.0, 2.0, 2.0]
    assert apart.z[:, 0, 0].tolist() == [9100.0, 8900.0, 8950.0]
    assert false_plots(record._replace(candidates=None)) is None
