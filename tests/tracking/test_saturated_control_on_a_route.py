"""Route control: judged on course kinematics through a turn, flown on the truth and flown on its own estimate."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest

from autopilot.modes.radio_beacon import RadioBeacon
from autopilot.route import Leg, Route
from tests.tracking.law_truth import (
    BASE_START,
    BASE_TO_FINAL,
    PATTERN_LAW,
    PATTERN_SPEED,
    PLANE,
    SIGMA,
    cross_track_error,
    errors,
    phases,
    route_truth,
    talk_down,
)
from tracking.gaussian import Gaussian
from tracking.motion import ConstantVelocity
from tracking.trackers.kalman import Kalman
from tracking.trackers.route_control import RouteControl
from tracking.trackers.saturated_control import SaturatedControl

SECONDS = 224.0  # base leg, turn and the final well established


def route_control(covariance="known_control", density=0.1):
    return RouteControl(PATTERN_LAW, BASE_TO_FINAL, PLANE, covariance, density)


def by_phase(tracker, flown, seed):
    """RMSE across the active leg on base, in the turn and on final."""
    error = cross_track_error(BASE_TO_FINAL, flown, errors(tracker, flown.x, seed).error)
    return {name: math.sqrt((error[mask] ** 2).mean()) for name, mask in phases(BASE_TO_FINAL, flown).items()}


@pytest.fixture(scope="module")
def pattern():
    """60 aircraft on their own from the base leg to the final."""
    return route_truth(PATTERN_LAW, BASE_TO_FINAL, BASE_START, SECONDS, np.random.default_rng(41), 60)


def test_known_control_through_the_turn(pattern):
    """Asked: 45 / 50 / 35 m on base, turn and final. 60 runs: sampling error 2 %, 3 % in the turn."""
    found = by_phase(route_control(), pattern, 42)
    assert found["base"] <= 45.0
    assert found["turn"] <= 50.0
    assert found["final"] <= 35.0


def test_course_kinematics_are_what_the_turn_needs(pattern):
    """A law that belongs to one line is void at a course error of 90 deg, and straight flight never turns."""
    found = by_phase(route_control(), pattern, 44)["turn"]
    on_lines = SaturatedControl(PATTERN_LAW, BASE_TO_FINAL, PLANE, sub_step=0.5)
    assert by_phase(on_lines, pattern, 44)["turn"] > 1.5 * found
    assert min(by_phase(Kalman(PLANE, ConstantVelocity(q)), pattern, 44)["turn"] for q in (0.3, 1.0, 3.0)) > 1.5 * found


def test_the_slope_of_the_law_sharpens_the_straight_legs():
    """Flown on the truth, dlaw/dx belongs in F: less than two thirds of the error on base and on final."""
    rng = np.random.default_rng(45)
    flown = route_truth(PATTERN_LAW, BASE_TO_FINAL, BASE_START, SECONDS, rng, 40, density=0.0)
    known, slope = (by_phase(route_control(form), flown, 46) for form in ("known_control", "jacobian"))
    assert slope["base"] < 0.66 * known["base"]
    assert slope["final"] < 0.66 * known["final"]


def test_turns_in_the_air_that_the_route_tells():
    """10 m/s against the final: over the ground the turn is no circle, and who thinks so is lost along the track."""
    windy = replace(BASE_TO_FINAL, wind=(-10.0, 0.0), time_to_roll=1.5)
    start = (-13500.0, 0.0, -7000.0, math.sqrt(PATTERN_SPEED**2 - 10.0**2))
    rng = np.random.default_rng(61)
    flown = route_truth(PATTERN_LAW, windy, start, SECONDS, rng, 40, roll_lag=1.5)
    told, untold = (RouteControl(PATTERN_LAW, route, PLANE) for route in (windy, replace(windy, wind=(0.0, 0.0))))
    assert errors(told, flown.x, 62).rmse() < 0.8 * errors(untold, flown.x, 62).rmse()


def test_a_law_on_the_heading_flies_the_homing_curve():
    """In a crosswind it drifts off the line; a tracker that takes the track for the heading expects it on the line."""
    law = RadioBeacon(6.0, 1.2, math.radians(20.0), math.radians(5.0), course="heading")
    route = Route((Leg((0.0, 0.0), (30e3, 0.0), 100.0, 400.0),), wind=(0.0, 14.0))
    rng = np.random.default_rng(63)
    flown = route_truth(law, route, (0.0, 100.0, 0.0, 0.0), 200.0, rng, 30)
    settled = math.degrees(np.median(np.arctan2(flown.x[-1, 2], 30e3 - flown.x[-1, 0])))
    # no bank where k3 eps = k4 (drift + eps): flying towards the beacon at a constant bearing, the track is off by eps
    assert settled == pytest.approx(1.2 / (6.0 - 1.2) * math.degrees(math.asin(0.14)), abs=0.15)
    told, mistaken = (RouteControl(each, route, PLANE) for each in (law, replace(law, course="track")))
    assert errors(told, flown.x, 64).rmse(slice(20, None)) < 0.8 * errors(mistaken, flown.x, 64).rmse(slice(20, None))


def test_talk_down_needs_the_control_as_known():
    """Asked: ANEES 0.6 to 1.2 (30 runs x 70 scans: sampling error 0.05)."""
    assert 0.6 < talk_down(route_control("known_control"), 47) < 1.2


def test_talk_down_breaks_the_slope_of_the_law():
    """Flown on the estimate the error obeys the open loop: the check above must fail, and by orders of magnitude."""
    assert talk_down(route_control("jacobian"), 47) > 100.0


def test_a_look_ahead_sees_the_turn():
    """From the base leg, 90 s ahead and beyond the corner: the aircraft will be on final, within four of its sigmas."""
    rng = np.random.default_rng(48)
    flown = route_truth(PATTERN_LAW, BASE_TO_FINAL, BASE_START, 160.0, rng, 20, density=0.0)
    tracker = route_control()
    measured = flown.x[:, 0::2] + SIGMA * rng.standard_normal(flown.x[:, 0::2].shape)
    state = tracker.begin(Gaussian(flown.x[0], np.diag([1e4, 25.0, 1e4, 25.0])))
    for z in measured[1:16]:
        state, _ = tracker.step(state, 4.0, z, SIGMA**2 * np.eye(2))
    assert (state.place == 0).all()
    later, _ = tracker.step(state, 96.0, None, None)
    assert (later.place == 1).all()
    mean, cov = tracker.estimate(later)
    miss = np.abs(mean - flown.x[39])[0::2] / np.sqrt(np.stack([cov[0, 0], cov[2, 2]]))
    assert miss.max() < 4.0
    assert np.sqrt((np.hypot(*(mean - flown.x[39])[0::2]) ** 2).mean()) < 500.0


def test_a_target_at_rest_does_not_break_the_course():
    tracker = route_control("jacobian")
    state = tracker.begin(Gaussian(np.array([[-13500.0], [0.0], [-3000.0], [0.0]]), np.diag([1e4, 25.0, 1e4, 25.0])))
    for _ in range(3):
        state, _ = tracker.step(state, 4.0, np.array([[-13500.0], [-3000.0]]), SIGMA**2 * np.eye(2))
    assert np.isfinite(tracker.estimate(state).mean).all()


def test_another_covariance_is_refused():
    with pytest.raises(ValueError, match="known_control"):
        route_control("both")
