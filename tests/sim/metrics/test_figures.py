"""Figures of a coupled approach against arithmetic, and figures of channels whose names hold points."""

from __future__ import annotations

import math

import numpy as np
import pytest

from sim.errors import ScenarioError
from sim.metrics.checks import evaluate_checks
from sim.metrics.ensemble.verdict import refuse_unfit
from sim.metrics.figures import DECISION_HEIGHT, GLIDE_CAPTURE
from sim.metrics.flight import flight_metrics
from sim.scenario.tables import Check, Runway
from tests.sim.one_flight import judged

GRAVITY = 9.80665
RUNWAY = Runway()
TIME = np.arange(0.0, 130.0, 1 / 30)


def glide(make_flight, **signals):
    """Down the glide path at 58 m/s, from 390 m to 39 m, with what is laid over it."""
    past = -8000.0 + 58.0 * TIME
    height = (RUNWAY.aiming_point - past) * math.tan(RUNWAY.glide_path)
    columns = {"north": past, "height": height, "velocity_north": np.full(len(TIME), 58.0)}
    columns |= {"specific_force_down": np.full(len(TIME), -GRAVITY)}
    for name, added in signals.items():
        columns[name] = columns.get(name, np.zeros(len(TIME))) + added
    return make_flight(TIME, ["glide"] * len(TIME), **columns)


def figures(flight):
    return flight_metrics(flight, RUNWAY, math.radians(15.0))


def test_decision_height_is_where_the_path_passes_it(make_flight):
    found = figures(glide(make_flight, east=12.0, height=1.5))
    assert found["cross_track_at_decision_height_m"] == pytest.approx(12.0)
    assert found["height_error_at_decision_height_m"] == pytest.approx(1.5, abs=1e-9)
    offset = TIME / 10.0  # to the right at 0.1 m/s: the moment tells itself
    moment = figures(glide(make_flight, east=offset))["cross_track_at_decision_height_m"] * 10.0
    expected = (8000.0 + RUNWAY.aiming_point - DECISION_HEIGHT / math.tan(RUNWAY.glide_path)) / 58.0
    assert moment == pytest.approx(expected, abs=1 / 30)  # one record


def test_an_approach_that_stays_above_has_no_decision_height(make_flight):
    found = figures(glide(make_flight, height=100.0))
    assert found["cross_track_at_decision_height_m"] is None
    assert found["height_error_at_decision_height_m"] is None


def test_normal_acceleration_is_what_the_lift_has_beyond_the_weight(make_flight):
    assert figures(glide(make_flight))["normal_acceleration_rms_final_mps2"] == pytest.approx(0.0, abs=1e-12)
    settled = TIME >= GLIDE_CAPTURE
    wave = np.where(settled, 0.3 * np.sin(2 * np.pi * TIME / 2.0), 5.0)  # the capture does not count
    found = figures(glide(make_flight, specific_force_down=-wave))
    assert found["normal_acceleration_rms_final_mps2"] == pytest.approx(0.3 / math.sqrt(2.0), rel=1e-3)  # 45 periods


def test_bank_rate_is_the_roll_rate_in_level_flight(make_flight):
    wave = math.radians(2.0) * np.sin(2 * np.pi * TIME / 3.0)
    found = figures(glide(make_flight, roll_rate=wave))
    assert found["bank_rate_rms_final_degps"] == pytest.approx(2.0 / math.sqrt(2.0), rel=1e-3)  # 30 periods


TRACKERS = {
    "mine": {"overall": {"radar.azimuth_deg": {"rmse": 0.25}, "position_m": {"rmse": 40.0}}, "lost_fraction": 0.0},
    "blind": {"overall": {}},
}


@pytest.mark.parametrize(
    ("metric", "value"),
    [
        ("trackers.mine.overall.radar.azimuth_deg.rmse", 0.25),
        ("trackers.mine.overall.position_m.rmse", 40.0),
        ("trackers.mine.lost_fraction", 0.0),
    ],
)
def test_a_figure_of_a_tracker_is_found_whatever_its_channel_is_called(metric, value, make_flight):
    (result,) = evaluate_checks((Check(metric, max=50.0),), glide(make_flight), RUNWAY, {"trackers": TRACKERS})
    assert result["value"] == value
    assert result["passed"]


@pytest.mark.parametrize(
    ("metric", "said"),
    [
        ("trackers.mine.overall.radar.azimuth_m.rmse", "did you mean 'trackers.mine.overall.radar.azimuth_deg.rmse'?"),
        ("trackers.mine.lost_fractoin", "did you mean 'trackers.mine.overall.position_m.rmse'?"),
    ],
)
def test_a_figure_that_is_not_there_is_answered_by_what_is(metric, said, make_flight):
    with pytest.raises(ScenarioError) as caught:
        judged((Check(metric, max=1.0),), glide(make_flight), RUNWAY, {"trackers": TRACKERS})
    assert said in str(caught.value)


@pytest.mark.parametrize("metric", ["trackers.blind.overall.position_m.rmse", "trackers.mine.lost_time_s"])
def test_a_figure_that_this_flight_does_not_have_fails(metric, make_flight):
    """A tracker that never saw the aircraft has no errors, and one that was never lost no time of it."""
    trackers = {**TRACKERS, "mine": {**TRACKERS["mine"], "lost_time_s": None}}
    (result,) = judged((Check(metric, max=1.0),), glide(make_flight), RUNWAY, {"trackers": trackers})
    assert (result["value"], result["passed"]) == (None, False)


def test_a_tracker_that_no_scenario_has_is_told_before_anything_flies():
    with pytest.raises(ScenarioError, match=r"entry 0 \('a'\) metric: no tracker 'mien'; did you mean 'mine'\?"):
        refuse_unfit("s", (Check("trackers.mien.anees", name="a", max=1.0),), 1, ["mine"])
