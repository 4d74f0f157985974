"""Alarms of what watches a tracker: false ones and delays against counts by hand, then in flights that go wrong."""

from __future__ import annotations

import math

import numpy as np
import pytest

import sim
from sim.errors import ScenarioError
from sim.metrics.alarms.detection import detection, onsets
from sim.metrics.alarms.monitoring import figures
from sim.metrics.alarms.operating_curve import STATED, WINDOWS, operating_curves
from sim.metrics.checks import unit_of
from sim.reporting.tracker_figures.monitor_strip import _corners
from sim.reporting.tracker_figures.operating_curves import drawn_curves
from tests.capture import CAPTURE
from tracking.track import Track


def made(nis, time=None) -> Track:
    """A record of one channel with these NIS (k, draws), a look each second from 1 s on."""
    nis = np.asarray(nis, float)
    time = np.arange(1.0, len(nis) + 1.0) if time is None else np.asarray(time)
    return Track((), time, nis[:, None], nis[:, None, None], np.sqrt(nis)[:, None], nis, nis, None)


def test_the_delay_after_a_jump_is_that_of_a_sum_by_hand():
    """Ten looks of 1 sum to 10; each of 8 adds 7, and 31 is the first above 29.59, chi-square's 1e-3 of ten degrees.

    The fault is at 21 s, the time of the first larger look, so that the third comes 2 s after it.
    """
    found = figures(made([[1.0]] * 20 + [[8.0]] * 5), 21.0)
    assert found["delay_s"] == {"p5": 2.0, "p50": 2.0, "p95": 2.0}
    assert (found["detected_fraction"], found["fault_s"]) == (1.0, 21.0)
    assert (found["alarms_per_1000"], found["onsets_per_1000"], found["stated_per_1000"]) == (0.0, 0.0, 1.0)


def test_alarms_before_the_fault_are_counted_by_look_and_by_onset():
    """A look of 30 is alarmed as long as nine others of 1 beside it sum beyond the limit: ten looks, one onset."""
    nis = np.ones((40, 2))
    nis[14, 0] = 30.0
    nis[35:, :] = 20.0
    found = figures(made(nis), 36.0)
    assert found["alarms_per_1000"] == pytest.approx(1000.0 * 10 / 70)
    assert found["onsets_per_1000"] == pytest.approx(1000.0 * 1 / 70)
    assert found["delay_s"]["p50"] == 1.0  # 29 is below the limit, 48 is beyond
    flown = figures(made(nis), None)
    assert (flown["delay_s"], flown["detected_fraction"], flown["fault_s"]) == (None, None, None)
    assert flown["onsets_per_1000"] == pytest.approx(1000.0 * 3 / 80)


def test_a_draw_that_is_alarmed_when_the_fault_comes_has_no_delay():
    nis = np.ones((30, 2))
    nis[18:, 0] = 20.0
    nis[22:, 1] = 20.0
    found = figures(made(nis), 22.0)
    assert found["detected_fraction"] == 1.0
    assert found["delay_s"]["p5"] == found["delay_s"]["p95"] == 2.0  # draw 1 alone: alarmed at 24 s


def test_where_nothing_was_seen_before_the_fault_there_is_no_rate():
    found = figures(made([[1.0]] * 5), 0.5)
    assert (found["alarms_per_1000"], found["onsets_per_1000"]) == (None, None)
    assert found["detected_fraction"] == 0.0
    assert found["delay_s"] is None


def test_a_draw_that_is_never_alarmed_is_infinitely_late():
    alarm = np.zeros((10, 3), bool)
    alarm[6:, 0] = alarm[8, 1] = True
    assert detection(alarm, np.arange(10.0), 5.0).median_delay == 3.0
    alarm[8, 1] = False
    assert math.isinf(detection(alarm, np.arange(10.0), 5.0).median_delay)
    assert onsets(alarm).sum() == 1


def test_a_lower_threshold_is_sooner_and_more_often_wrong():
    """Chi-square looks that triple at 100 s: every point of the curve follows from the figures at that threshold."""
    rng = np.random.default_rng(7)
    nis = rng.chisquare(1.0, (200, 20))
    nis[99:] *= 3.0
    curves = operating_curves(None, made(nis), 100.0)
    assert [curve.test for curve in curves] == [f"NIS of {window} looks" for window in WINDOWS]
    for curve in curves:
        assert curve.looks == 99 * 20
        assert 0.0 <= curve.delay[0] < curve.delay[len(STATED) // 2] < curve.delay[-1]
        assert (np.diff(curve.detected) <= 0.0).all()
        np.testing.assert_allclose(curve.stated, 1000.0 * np.array(STATED))
        at = int(np.argmin(np.abs(curve.stated - 10.0)))
        assert 0.0 < curve.false_alarms[at] < 10.0  # onsets are rarer than alarmed looks
    ours, known = curves[WINDOWS.index(10)], figures(made(nis), 100.0)
    at = int(np.argmin(np.abs(ours.stated - 1.0)))
    assert ours.false_alarms[at] == pytest.approx(known["onsets_per_1000"])
    assert ours.detected[at] == known["detected_fraction"]
    figure = drawn_curves({"mine": curves})
    assert [panel.title for panel in figure.panels] == ["mine"]
    assert drawn_curves({}) is None


def test_level_stretches_of_a_strip_keep_their_ends():
    assert _corners(np.array([0.0, 0.0, 0.0, 0.5, 1.0, 1.0, 1.0])).tolist() == [
        True,
        False,
        True,
        True,
        True,
        False,
        True,
    ]


@pytest.mark.parametrize(("figure", "unit"), [("alarms_per_1000", ""), ("delay_s.p50", "s"), ("fault_s", "s")])
def test_checks_know_the_units(figure, unit):
    assert unit_of(f"trackers.mine.monitor.{figure}") == unit


# ---- flights ------------------------------------------------------------------------------------------------------

MONITOR = "trackers.kalman_like.monitor"
WATCHED = {
    **CAPTURE,
    "aircraft": {"model": "point_mass"},
    "start": {"leg": 0, "cross_track_m": 0},
    "until_s": 70,
    "draws": 20,
    "sensors": {"radar": {"kind": "surveillance_radar", "period_s": 1, "position_sigma_m": 40}},
    "trackers": {"kalman_like": {"kind": "saturated_control"}},
}
WORSE = [{"at_s": 40, "sensor": "radar", "error_factor": 3}]


def test_a_sensor_that_errs_more_is_noticed_and_checks_can_ask_how_soon():
    checks = [
        {"metric": f"{MONITOR}.delay_s.p95", "max": 15},
        {"metric": f"{MONITOR}.alarms_per_1000", "max": 20},
        {"metric": f"{MONITOR}.detected_fraction", "min": 1},
        {"metric": f"{MONITOR}.delay_s.p5", "min": 30},
    ]
    result = sim.run({**WATCHED, "sensor_faults": WORSE, "checks": checks}, flights=2)
    assert [one["passed"] for one in result.metrics["checks"]] == [True, True, True, False]
    assert result.metrics["checks"][0]["unit"] == "s"
    found = result.metrics["trackers"]["kalman_like"]["monitor"]
    each = [record["metrics"]["trackers"]["kalman_like"]["monitor"] for record in result.metrics["each_flight"]]
    assert found["delay_s"]["p50"] == pytest.approx(np.mean([one["delay_s"]["p50"] for one in each]))
    assert found["alarms_per_1000"] == pytest.approx(np.mean([one["alarms_per_1000"] for one in each]))
    assert f"{MONITOR}.delay_s.p50" in result.metrics["flights_summary"]
    assert [event.name for event in result.flight.events if event.name == "sensor_fault"] == ["sensor_fault"]


def test_without_a_fault_a_check_of_a_delay_has_no_figure():
    check = {"metric": f"{MONITOR}.delay_s", "max": 15}
    result = sim.run({**WATCHED, "checks": [check], "until_s": 10, "draws": 2})
    (said,) = result.metrics["checks"]
    assert (said["value"], said["passed"]) == (None, False)


def test_a_misspelt_figure_of_the_monitor_is_named():
    check = {"metric": f"{MONITOR}.alarm_per_1000", "max": 15}
    with pytest.raises(ScenarioError, match=f"no such figure; did you mean '{MONITOR}.alarms_per_1000'"):
        sim.run({**WATCHED, "checks": [check], "until_s": 10, "draws": 2})


def test_a_fault_of_a_sensor_that_a_tracker_does_not_hear_is_none_of_its_faults():
    own = {"deaf": {"kind": "saturated_control", "sensors": ["other"]}, **WATCHED["trackers"]}
    own["kalman_like"] = {**own["kalman_like"], "sensors": ["radar"]}
    sensors = {"other": WATCHED["sensors"]["radar"], **WATCHED["sensors"]}
    tables = {**WATCHED, "sensors": sensors, "trackers": own, "sensor_faults": WORSE, "until_s": 45, "draws": 2}
    found = sim.run(tables).metrics["trackers"]
    assert found["deaf"]["monitor"]["fault_s"] is None
    assert found["kalman_like"]["monitor"]["fault_s"] == 40.0
