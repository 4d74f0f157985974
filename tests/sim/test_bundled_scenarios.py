"""The bundled scenarios that join flights, sensors and trackers: they hold together, show what they say, take abuse.

Full size with intervals: tests/acceptance, closed_loop, conformance, default_scenario and papers_on_jsbsim.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Annotated, Any

import numpy as np
import pytest

import sim
from aircraft.state import AircraftState
from sim.errors import ScenarioError
from sim.estimation.navigator import _straight
from sim.estimation.prior import prior
from sim.estimation.setup import check
from sim.experiment import fly
from sim.files import plain
from sim.flight.preparation import prepare
from sim.metrics.flight import flight_metrics
from sim.scenario import catalogue
from sim.scenario.reading import read
from tracking.gaussian import Gaussian

POINT_MASS = {"aircraft": {"model": "point_mass"}, "checks": [], "contrasts": []}
SUFFICES = {"draws": 8, "seed": 4}


def only(name, *trackers):
    """The tables of some trackers of a bundled scenario."""
    tables = read(name).tables["trackers"]
    return {tracker: tables[tracker] for tracker in trackers}


def overall(result, channel):
    """RMSE of every tracker in one channel."""
    return {name: found["overall"][channel]["rmse"] for name, found in result.metrics["trackers"].items()}


@pytest.mark.parametrize("name", catalogue.scenarios())
def test_every_bundled_scenario_can_be_tracked(name):
    """Every sensor is heard by a tracker or completes a height, and every figure that a check asks is one there is."""
    scenario = read(name, {"aircraft": {"model": "point_mass"}})  # the catalogue judges the aircraft elsewhere
    assert scenario.name == name
    check(prepare(scenario))
    heard = {sensor for tracker in scenario.trackers.values() for sensor in tracker.sensors}
    if scenario.autopilot.navigation != "truth":
        heard |= {n for n, sensor in scenario.sensors.items() if {"range", "height"} & {*sensor.channels}}
    assert set(scenario.sensors) <= heard
    asked = [one.metric.split(".")[1] for one in scenario.checks if one.metric.startswith("trackers.")]
    assert set(asked) <= set(scenario.trackers)


# ---- what the scenarios show, in small ---------------------------------------------------------------------------


@pytest.fixture(scope="module")
def captured():
    names = ("linear_feedback_published", "saturated_control_published", "saturated_control", "intent_imm")
    names += ("saturated_control_told_wrong", "intent_imm_told_wrong", "constant_velocity")
    changes = {**POINT_MASS, "trackers": only("vasylyev2003_jsbsim", *names), "until_s": 160.0}
    return sim.run("vasylyev2003_jsbsim", overrides=changes, **SUFFICES)


def test_saturated_control_holds_where_linear_feedback_breaks(captured):
    rmse = overall(captured, "cross_track_m")
    assert rmse["linear_feedback_published"] > 10 * rmse["saturated_control_published"]  # 34 at full size
    assert rmse["saturated_control_published"] < 60.0  # raw is 100 m


def test_a_law_told_wrongly_costs_and_the_intent_model_costs_least(captured):
    rmse = overall(captured, "cross_track_m")
    assert rmse["saturated_control_told_wrong"] > 3 * rmse["saturated_control"]  # 8 at full size
    assert rmse["intent_imm_told_wrong"] < 0.5 * rmse["saturated_control_told_wrong"]


def test_linear_feedback_wins_where_nothing_saturates():
    trackers = only("vasylyev2003_jsbsim", "linear_feedback_published", "saturated_control_published")
    changes = {**POINT_MASS, "trackers": trackers, "until_s": 160.0, "start.cross_track_m": 500.0}
    rmse = overall(sim.run("vasylyev2003_jsbsim", overrides=changes, **SUFFICES), "cross_track_m")
    assert rmse["saturated_control_published"] > 1.4 * rmse["linear_feedback_published"]  # 2.2 at full size


@pytest.mark.parametrize(("side", "across"), [("left", 150.0), ("right", -150.0)])
def test_the_improved_set_turns_either_way_and_the_published_one_to_the_left(side, across):
    changes = {
        **POINT_MASS,
        "route.side": side,
        "sensors.radar.position_m": [1200, across, 3],
        "start.distance_m": 3500.0,
        "until_s": 110.0,
        "trackers": only("volovyk2022_jsbsim", "imm_published", "imm"),
    }
    rmse = overall(sim.run("volovyk2022_jsbsim", overrides=changes, **SUFFICES), "position_m")
    assert rmse["imm"] < 100.0  # raw is 240 m here
    assert (rmse["imm_published"] < 130.0) == (side == "left")


def test_two_radars_cross_their_ranges():
    changes = {**POINT_MASS, "start.distance_m": 3500.0, "until_s": 110.0}
    rmse = overall(sim.run("two_radars", overrides=changes, **SUFFICES), "position_m")
    assert rmse["both"] < 0.6 * min(rmse["approach"], rmse["abeam"])  # 0.38 at full size


def test_bursts_are_survived_by_who_knows_that_they_last():
    trackers = only("kychak2011_jsbsim", "two_hypotheses_bursts", "markov_bursts")
    sensors = {"bursts": read("kychak2011_jsbsim").tables["sensors"]["bursts"]}
    changes = {**POINT_MASS, "trackers": trackers, "sensors": sensors, "until_s": 30.0}
    result = sim.run("kychak2011_jsbsim", overrides=changes, seed=4, draws=20)
    rmse = overall(result, "bursts.elevation_deg")
    assert rmse["markov_bursts"] < 0.5 * rmse["two_hypotheses_bursts"]  # 0.26 at full size


@pytest.mark.soak
def test_load_factors_help_in_the_turn():
    changes = {
        **POINT_MASS,
        "start.distance_m": 3500.0,
        "until_s": 80.0,
        "trackers": only("glistin_jsbsim", "kinematic", "corrected_residual"),
    }
    result = sim.run("glistin_jsbsim", overrides=changes, seed=4, draws=30)
    turn = {
        name: found["by_phase"]["final_turn"]["radar.azimuth_deg"]["rmse"]
        for name, found in result.metrics["trackers"].items()
    }
    assert turn["kinematic"] > 1.2 * turn["corrected_residual"]  # 1.56 at full size


# ---- the loop closed ---------------------------------------------------------------------------------------------


def approach(name, navigation, **changes):
    tables = only(name, navigation)
    scenario = read(name, {"autopilot.navigation": navigation, "trackers": tables, "checks": [], **changes})
    prepared = prepare(scenario)
    flight = fly(prepared)
    return flight, flight_metrics(flight, scenario.runway, prepared.law.bank_limit)


def test_a_talk_down_lands_in_the_box():
    low = {"route.height_m": 150.0, "route.downwind_speed_mps": 60.0, "route.turn_speed_mps": 60.0}
    place = {"start.distance_m": 5000.0, "start.cross_track_m": 30.0}  # just before the glide path begins
    _, figures = approach("an26_talkdown", "saturated_control", **low, **place)
    assert figures["outcome"] == "landed"
    assert abs(figures["touchdown"]["cross_track_m"]) <= 21.0
    assert abs(figures["cross_track_at_decision_height_m"]) <= 30.0
    assert abs(figures["height_error_at_decision_height_m"]) <= 7.5


@pytest.mark.soak
def test_a_localiser_and_a_dme_lead_into_the_box_in_a_crosswind():
    low = {"route.height_m": 150.0, "route.downwind_speed_mps": 60.0, "route.turn_speed_mps": 60.0}
    place = {"start.distance_m": 5000.0, "start.cross_track_m": 30.0}  # just before the glide path begins
    _, figures = approach("an26_localiser", "line_of_approach", **low, **place)
    assert figures["outcome"] == "landed"
    assert abs(figures["touchdown"]["cross_track_m"]) <= 17.0
    assert abs(figures["cross_track_at_decision_height_m"]) <= 30.0


@pytest.mark.soak
def test_a_course_line_that_is_not_aligned_is_flown_beside_the_runway():
    """On straight flight the estimate is off by the bias times the distance to the antenna, and so is the aircraft."""
    changes = {**POINT_MASS, "wind": {}, "until_s": 60.0, "start.distance_m": 9000.0, "start.cross_track_m": 0.0}
    beside = {}
    for bias in (0.0, 0.5):
        flight, _ = approach("an26_localiser", "line_of_approach", **changes, **{"sensors.localiser.bias_deg": bias})
        beside[bias] = flight.deviation.cross_track[-1]
    to_antenna = 9000.0 + 2800.0 - 60.0 * 70.0  # the aiming point is 300 m on, the speed about 70 m/s
    assert beside[0.5] - beside[0.0] == pytest.approx(to_antenna * math.radians(0.5), rel=0.25)


@pytest.mark.soak
def test_a_glide_path_through_an_elevation_holds_its_height_among_anomalies():
    changes = {"aircraft": {"model": "point_mass"}, "start.distance_m": 4500.0, "until_s": 12.0}
    errors = {"two_hypotheses": [], "kalman": []}
    for navigation, found in errors.items():
        for seed in (1, 2, 3):
            flight, _ = approach("an26_mls_anomalies", navigation, **changes, seed=seed)
            seen = flight.command.height - flight.state.height  # the error of the height that the autopilot sees
            found.append(np.std(np.diff(seen)))
    assert np.median(errors["two_hypotheses"]) < 0.2 * np.median(errors["kalman"])


# ---- bad input ---------------------------------------------------------------------------------------------------

LINE = {
    "name": "line",
    "draws": 3,
    "until_s": 60.0,
    "route": {"kind": "legs", "legs": [{"from_m": [0, 0], "to_m": [9000, 0], "speed_mps": 90, "height_m": 500}]},
    "start": {"leg": 0, "cross_track_m": 0.0},
}
RADAR = {"radar": {"kind": "surveillance_radar"}}


@pytest.mark.parametrize("kind", [kind for kind in catalogue.kinds("sensors") if kind != "recorded"])  # has no period
def test_sensors_faster_than_the_flight_are_refused(kind):
    with pytest.raises(ScenarioError, match="steps finer than 1/120 s") as caught:
        read({**LINE, "sensors": {"fast": {"kind": kind, "period_s": 0.008}}})
    assert str(caught.value).count("\n") == 0


def test_a_tracker_without_sensors_is_refused():
    with pytest.raises(ScenarioError, match="needs at least one sensor"):
        read({**LINE, "trackers": {"t": {"kind": "kalman"}}})


@pytest.mark.parametrize("kind", ["elevation", "load_factor", "load_factor_cartesian", "switching_noise"])
def test_a_tracker_whose_channels_no_sensor_gives_is_refused_in_one_sentence(kind):
    prepared = prepare(read({**LINE, "sensors": RADAR, "trackers": {"t": {"kind": kind}}}))
    with pytest.raises(ScenarioError, match=r"\[trackers.t\]") as caught:
        check(prepared)
    assert str(caught.value).count("\n") == 0


@pytest.mark.parametrize(
    "radar",
    [
        {"kind": "surveillance_radar", "period_s": 1.0, "position_m": [3600.0, 0.0, 500.0]},
        {"kind": "precision_radar", "period_s": 1.0, "position_m": [3600.0, 0.0, 500.0], "sector_deg": 360},
    ],
)
def test_a_radar_on_the_route_is_flown_over(radar):
    """90 m/s and a look each second: the look at 40 s is taken at range zero."""
    kinds = ("kalman", "saturated_control", "intent_imm", "imm", "filterpy_constant_velocity")
    tables = {**LINE, "sensors": {"radar": radar}, "trackers": {kind: {"kind": kind} for kind in kinds}}
    result = sim.run(tables)
    for kind, figures in result.metrics["trackers"].items():
        held = figures["overall"]["position_m"]
        assert held["rmse"] < held["raw"], kind
        assert figures["lost_fraction"] == 0.0, kind
    (warning,) = result.metrics["warnings"]
    assert warning == (
        "sensor 'radar' is on the flight path: at 40 s the aircraft passed its antenna at 0 m, where an azimuth "
        "says nothing"
    )


def test_no_measurement_at_all_is_no_figure_and_no_error():
    blind = {"blind": {"kind": "precision_radar", "coverage_m": 10}}
    result = sim.run({**LINE, "sensors": blind, "trackers": {"t": {"kind": "saturated_control"}}})
    assert result.metrics["trackers"]["t"]["overall"] == {}
    said = [
        "sensor 'blind' never saw the aircraft",
        "tracker 't' got no measurement of the aircraft: it has no figures",
    ]
    assert result.metrics["warnings"] == said
    never = {"blind": {"kind": "precision_radar", "sector_deg": 360, "detection": 0.0}}
    result = sim.run({**LINE, "sensors": never, "trackers": {"t": {"kind": "imm"}}})
    assert result.metrics["trackers"]["t"]["overall"] == {}
    assert result.metrics["warnings"] == said


def test_a_navigating_tracker_that_sees_nothing_flies_on_its_prior():
    blind = {"blind": {"kind": "precision_radar", "coverage_m": 10}}
    blinded = {**LINE, "seed": 3, "draws": 1, "sensors": blind, "trackers": {"t": {"kind": "saturated_control"}}}
    result = sim.run({**blinded, "autopilot": {"navigation": "t"}})  # a seed of a prior that is far out, and inwards
    assert result.metrics["flight"]["outcome"] == "completed"
    start = _straight(AircraftState(*(float(column[0]) for column in result.flight.state)), result.flight.route)
    wrong = prior(start, result.scenario.sensors, ("east", "east_rate"), 0.0, result.scenario.seed, 0, 1).mean[:, 0]
    error = wrong[0] + 60.0 * wrong[1]  # of the place that it believes after a minute, when that is nearly on the leg
    assert abs(error) > 100.0
    assert result.flight.deviation.cross_track[-1] == pytest.approx(-error, rel=0.25)


def test_what_arrives_after_the_flight_was_never_heard():
    sensors = {
        "radar": {"kind": "precision_radar", "sector_deg": 360},
        "late": {"kind": "downlink", "latency_s": 10_000.0},
        "never": {"kind": "downlink", "silent_from_s": 0.0},
    }
    trackers = {link: {"kind": "load_factor_cartesian", "sensors": ["radar", link]} for link in ("late", "never")}
    result = sim.run({**LINE, "sensors": sensors, "trackers": trackers})
    assert result.tracks["late"].track.time[-1] <= result.flight.time[-1]
    np.testing.assert_array_equal(result.tracks["late"].track.mean, result.tracks["never"].track.mean)
    assert result.metrics["warnings"] == [
        "sensor 'late' delivers nothing before the flight of 60 s is over: its latency is longer",
        "sensor 'never' never saw the aircraft",
    ]


@dataclass(frozen=True)
class Diverging:
    """Right until a time, then away: to a wrong place, or to no number at all."""

    after: float
    value: float
    channels = ("north", "north_rate", "east", "east_rate")

    def begin(self, prior):
        return 0.0, prior

    def step(self, state, dt, z, R):
        time, gaussian = state
        mean = np.array(gaussian.mean)
        if time + dt > self.after:
            mean[:] = self.value
        elif z is not None:
            mean[0::2] = z
        return (time + dt, Gaussian(mean, gaussian.cov)), None

    def estimate(self, state):
        return state[1]


@pytest.mark.parametrize("value", [1e6, math.nan, math.inf])
def test_a_tracker_that_diverges_is_a_result_with_its_time(value):
    sensors = {"radar": {"kind": "surveillance_radar", "period_s": 1.0, "position_sigma_m": 50.0}}
    result = sim.run({**LINE, "sensors": sensors}, trackers={"mine": Diverging(20.0, value)})
    figures = plain(result.metrics["trackers"]["mine"])
    assert figures["lost_fraction"] == 1.0
    # begun at the first look at 1 s; at once where there is no number, after ten epochs outside where there is
    assert 21.0 < figures["lost_time_s"] <= (31.5 if math.isfinite(value) else 22.5)
    held = figures["overall"]["position_m"]
    assert held["rmse"] is None or held["rmse"] > 1e5
    assert held["raw"] < 100.0


def test_a_flight_that_never_loses_its_track_has_no_such_time(captured):
    figures = captured.metrics["trackers"]
    assert figures["saturated_control"]["lost_time_s"] is None
    assert figures["linear_feedback_published"]["lost_fraction"] == 1.0
    assert 4.0 < figures["linear_feedback_published"]["lost_time_s"] < 100.0


# ---- hand-over ---------------------------------------------------------------------------------------------------

WATCHED = {
    "far": {"kind": "surveillance_radar", "position_m": [-3000, 4000, 10]},
    "near": {"kind": "precision_radar", "position_m": [9500, 100, 3], "coverage_m": 6000},
}


def test_a_track_that_is_handed_over_begins_where_the_other_was():
    trackers = {
        "watch": {"kind": "imm", "sensors": ["far"]},
        "handed": {"kind": "imm", "sensors": ["near"], "handover": "watch"},
        "cold": {"kind": "imm", "sensors": ["near"]},
    }
    result = sim.run({**LINE, "draws": 60, "sensors": WATCHED, "trackers": trackers})
    watch, handed, cold = (result.tracks[name].track for name in trackers)
    start = handed.time[0]
    assert start == cold.time[0] > watch.time[3]
    # 60 m along and 10 m across after a few looks of 4 s, against a prior of 100 m: it is known better, and honestly so
    errors, spreads = [], []
    for track in (handed, cold):
        truth = np.interp(start, result.flight.time, result.flight.state.north)
        errors.append(float(np.sqrt(np.mean((track.mean[0, 0] - truth) ** 2))))
        spreads.append(float(np.sqrt(np.mean(track.cov[0, 0, 0]))))
        assert 0.6 * spreads[-1] < errors[-1] < 1.5 * spreads[-1]
    assert spreads[0] < spreads[1]
    speed = [float(np.mean(np.sqrt(track.cov[0, 1, 1]))) for track in (handed, cold)]
    assert speed[0] < speed[1]


@pytest.mark.parametrize(
    ("trackers", "said"),
    [
        ({"a": {"kind": "kalman", "handover": "b"}, "b": {"kind": "kalman", "handover": "a"}}, "round in a circle"),
        (
            {"a": {"kind": "kalman"}, "b": {"kind": "elevation", "sensors": ["near"], "handover": "a"}},
            "'a' does not estimate near.elevation",
        ),
    ],
)
def test_a_handover_that_cannot_be_is_refused(trackers, said):
    with pytest.raises(ScenarioError, match=said):
        check(prepare(read({**LINE, "sensors": WATCHED, "trackers": trackers})))


@dataclass(frozen=True)
class OfPlaces:
    """It reads positions as this scenario's radars give them."""

    measurement: Annotated[Any, "given"] = None
    channels = ("north", "north_rate", "east", "east_rate")


def test_trackers_of_the_caller_without_a_sensor_are_answered_before_anything_flies(monkeypatch):
    line = {**LINE, **POINT_MASS}
    monkeypatch.setattr("sim.experiment.fly", lambda *given: pytest.fail("it flew"))
    with pytest.raises(ScenarioError) as caught:
        sim.run({**line, "sensors": {}}, trackers={"mine": Diverging(20.0, 0.0)})
    assert "tracker 'mine' has nothing to listen to: the scenario has no sensors; add a table" in str(caught.value)
    height = {"altimeter": {"kind": "radio_altimeter"}}
    with pytest.raises(ScenarioError, match="the scenario has no sensor that gives a position"):
        sim.run({**line, "sensors": height}, trackers={"mine": OfPlaces()})
    false = {"radar": {"kind": "precision_radar", "clutter": 1.0}}
    with pytest.raises(ScenarioError, match="a tracker of the caller cannot listen to 'radar'"):
        sim.run({**line, "sensors": false}, trackers={"mine": Diverging(20.0, 0.0)})
