"""Checks: judged by signals whose worst moment is known by construction."""

from __future__ import annotations

import math

import numpy as np
import pytest

import sim
from sim.metrics.checks import unit_of, unknown_names
from sim.metrics.ensemble.spread import summary
from sim.metrics.flight import flight_metrics
from sim.scenario.tables import Check, Runway
from tests.sim.one_flight import judged

TIME = np.arange(0.0, 60.0, 1 / 30)
FINAL = ["final"] * len(TIME)


def only(check, flight, metrics=None):
    (result,) = judged((check,), flight, Runway(), metrics or {})
    return result


def bank_pulse(start, length, size, background=5.0):
    return np.radians(np.where((start <= TIME) & (start + length > TIME), size, background))


def test_a_maximum_tells_value_margin_and_time(make_flight):
    flight = make_flight(TIME, FINAL, bank=bank_pulse(20.0, 2.0, -18.0))
    result = only(Check("bank_deg", max=15.0, source="autopilot"), flight)
    assert result["value"] == pytest.approx(18.0)  # the magnitude: the pulse is to the left
    assert result["margin"] == pytest.approx(-3.0)
    assert result["time_s"] == pytest.approx(20.0, abs=1 / 30)
    assert result["passed"] is False
    assert (result["unit"], result["source"]) == ("deg", "autopilot")


@pytest.mark.parametrize(("length", "passed"), [(2.9, True), (3.2, False)])
def test_for_s_forgives_what_is_shorter(make_flight, length, passed):
    flight = make_flight(TIME, FINAL, bank=bank_pulse(20.0, length, 18.0))
    assert only(Check("bank_deg", max=15.0, for_=3.0), flight)["passed"] is passed


def test_for_s_reports_the_value_that_lasted(make_flight):
    ramp = np.radians(np.clip(TIME - 20.0, 0.0, 10.0))  # reaches 10 deg at 30 s and stays
    flight = make_flight(TIME[: 30 * 32], FINAL[: 30 * 32], bank=ramp[: 30 * 32])
    result = only(Check("bank_deg", max=20.0, for_=5.0), flight)
    # the last window is the 5 s before the end at 31.97 s; its minimum is its first value, 26.97 - 20
    assert result["value"] == pytest.approx(6.967, abs=0.04)  # a step of the record


def test_during_cuts_the_record(make_flight):
    phase = ["final"] * 900 + ["glide"] * 900
    flight = make_flight(TIME, phase, bank=bank_pulse(10.0, 5.0, 30.0))
    assert only(Check("bank_deg", max=15.0, during="glide"), flight)["passed"] is True
    assert only(Check("bank_deg", max=15.0, during=("final", "flare")), flight)["passed"] is False


def test_windows_do_not_reach_across_a_gap_between_phases(make_flight):
    phase = ["glide"] * 600 + ["final"] * 600 + ["glide"] * 600
    bank = np.radians(np.where((TIME > 19.0) & (TIME < 41.0), 20.0, 0.0))  # 1 s on each side of the gap
    flight = make_flight(TIME, phase, bank=bank)
    assert only(Check("bank_deg", max=15.0, during="glide", for_=1.5), flight)["passed"] is True


def test_a_phase_that_was_not_flown_is_not_judged(make_flight):
    result = only(Check("bank_deg", max=15.0, during="flare"), make_flight(TIME, FINAL))
    assert result["passed"] is None
    assert result["value"] is None


def test_two_limits_give_the_nearer_margin(make_flight):
    flight = make_flight(TIME, FINAL, airspeed=np.full(len(TIME), 73.0))
    result = only(Check("airspeed_error_mps", min=-2.0, max=10.0), flight)
    assert (result["limit"], result["value"]) == (-2.0, pytest.approx(3.0))
    assert result["margin"] == pytest.approx(5.0)
    slow = make_flight(TIME, FINAL, airspeed=np.full(len(TIME), 66.0))
    assert only(Check("airspeed_error_mps", min=-2.0, max=10.0), slow)["margin"] == pytest.approx(-2.0)


def test_the_mean_over_five_seconds_forgives_a_gust(make_flight):
    sink = np.where((TIME > 20) & (TIME < 21), 8.0, 3.0)  # one second at 8: a mean of 4
    flight = make_flight(TIME, FINAL, velocity_up=-sink)
    result = only(Check("sink_mps", max=5.08, statistic="mean_5_s"), flight)
    assert result["value"] == pytest.approx(4.0, abs=5 / 150)  # one sample of 150 more or less
    assert 20.0 <= result["time_s"] <= 26.0


def test_rms_and_percentile_of_a_sine(make_flight):
    flight = make_flight(TIME, FINAL, bank=np.radians(10.0) * np.sin(2 * np.pi * TIME / 10.0))
    found = only(Check("bank_deg", max=9.0, statistic="rms"), flight)["value"]
    assert found == pytest.approx(10 / math.sqrt(2), rel=1e-3)  # whole periods but one record
    least = only(Check("bank_deg", min=9.0, statistic="rms"), flight)
    assert (least["value"], least["margin"]) == (pytest.approx(found), pytest.approx(found - 9.0))
    # the magnitude of a sine is below sin(0.95 pi/2) of its peak 95 % of the time
    found = only(Check("bank_deg", max=9.0, statistic="p95"), flight)["value"]
    assert found == pytest.approx(10 * math.sin(0.95 * math.pi / 2), rel=2e-3)


def test_a_scalar_that_the_flight_lacks_fails(make_flight):
    flight = make_flight(TIME, FINAL)
    metrics = flight_metrics(flight, Runway(), math.radians(15))
    result = only(Check("touchdown.sink_mps", max=3.05), flight, metrics)
    assert (result["value"], result["passed"]) == (None, False)


def test_unknown_metrics_and_phases_get_suggestions():
    checks = [{"metric": "bank_dge"}, {"metric": "bank_deg", "during": ["final", "glied"]}, {"metric": "sink_mps"}]
    told = unknown_names({"checks": checks})
    assert [fault.partition(";")[0] for fault in told] == [
        "[[checks]] entry 0 metric: no metric 'bank_dge'",
        "[[checks]] entry 1 during: no phase 'glied'",
    ]
    assert "did you mean 'bank_deg'?" in told[0]
    assert "did you mean 'glide'?" in told[1]


@pytest.mark.parametrize("wind", [{"sped_mps": 3.0}, {"speed_mps": 300.0}], ids=["a key", "a value"])
def test_unknown_names_are_told_among_all_other_faults_of_a_file(wind):
    with pytest.raises(sim.ScenarioError) as caught:
        sim.read({"name": "bad", "wind": wind, "checks": [{"metric": "bank_dge", "max": 1.0}]})
    faults = str(caught.value).splitlines()
    assert len(faults) == 2
    assert any(fault.startswith("scenario: [[checks]] entry 0 metric: no metric 'bank_dge'") for fault in faults)
    assert any(fault.startswith("scenario: [wind] ") for fault in faults)


@pytest.mark.parametrize("checks", [None, 3, "bank", [1], [[]], [{"metric": 4, "during": 5}], [{"during": [6]}], [{}]])
def test_names_are_looked_for_in_whatever_a_file_says(checks):
    assert unknown_names({"checks": checks, "study": checks}) == []


@pytest.mark.parametrize(
    ("metric", "unit"),
    [
        ("bank_rate_degps", "degps"),
        ("glide_dots", "dots"),
        ("landed", ""),
        ("cross_track_at_30_m_m", "m"),
        ("touchdown.sink_mps", "mps"),
        ("trackers.mls_s.overall.mls.elevation_deg.rmse", "deg"),
        ("trackers.mine.look_ahead.20_s.position_m.gain", "gain"),
        ("trackers.mine.overall.position_m.gain_low", "gain"),
        ("trackers.mine.lost_fraction", ""),
        ("trackers.mine.lost_time_s", "s"),
        ("trackers.mine_m", ""),
    ],
)
def test_a_check_has_the_unit_of_what_it_is_about(metric, unit):
    assert unit_of(metric) == unit


def test_overshoot_is_what_lies_on_the_other_side(make_flight):
    offset = 100.0 * np.exp(-TIME / 10.0) * np.cos(TIME / 5.0)
    flight = make_flight(TIME, FINAL, east=offset)
    metrics = flight_metrics(flight, Runway(), math.radians(15))
    # minimum of exp(-t/10) cos(t/5): tan(t/5) = -1/2, t = 5 (pi - atan 1/2)
    t = 5 * (math.pi - math.atan(0.5))
    assert metrics["overshoot_m"] == pytest.approx(-100 * math.exp(-t / 10) * math.cos(t / 5), rel=1e-3)
    # the deviation last leaves the band of 5 m; found here from the envelope's own samples
    assert abs(offset[metrics["settling_s"] + 1 / 30 < TIME]).max() <= 5.0


def test_touchdown_is_measured_in_the_runway_frame(make_flight):
    heading = math.radians(30.0)
    runway = Runway(heading=heading)
    along = 400.0 + 60.0 * (TIME - 50.0)
    wheels = (TIME >= 50.0).astype(float)
    north, east = runway.to_local(along, np.full(len(TIME), 1.5))
    flight = make_flight(
        TIME,
        ["flare"] * len(TIME),
        north=north,
        east=east,
        velocity_north=np.full(len(TIME), 60 * math.cos(heading)),
        velocity_east=np.full(len(TIME), 60 * math.sin(heading)),
        velocity_up=np.where(wheels, 0.0, -0.7),
        heading=np.full(len(TIME), heading + math.radians(2.0)),
        main_wheels=wheels,
    )
    touchdown = flight_metrics(flight, runway, math.radians(15))["touchdown"]
    assert touchdown["past_threshold_m"] == pytest.approx(400.0, abs=2.0)  # one record is 2 m
    assert touchdown["cross_track_m"] == pytest.approx(1.5)
    assert touchdown["sink_mps"] == pytest.approx(0.7)
    assert touchdown["crab_deg"] == pytest.approx(2.0)
    assert touchdown["drift_mps"] == pytest.approx(0.0, abs=1e-9)


def test_several_flights_are_summarised():
    flights = [{"outcome": "landed", "duration_s": float(i), "touchdown": {"sink_mps": 1.0}} for i in range(1, 102)]
    flights.append({"outcome": "ground", "duration_s": 51.0, "touchdown": None})
    found = summary([{"metrics": metrics} for metrics in flights])
    assert found["outcomes"] == {"landed": 101, "ground": 1}
    assert found["duration_s"]["p50"] == 51.0
    assert found["duration_s"]["p50_low"] < 51.0 < found["duration_s"]["p50_high"]
    assert found["touchdown.sink_mps"]["p95"] == 1.0
    assert found["touchdown.sink_mps"]["n"] == 101
