"""Linear feedback: judged by the matrix exponential, the Riccati equation and the page's printed values."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest
from scipy.linalg import expm, solve_discrete_are

from autopilot.modes.radio_beacon import RadioBeacon
from tests.tracking.law_truth import (
    BASE_TO_FINAL,
    CROSS_TRACK,
    DENSITY,
    GRAVITY,
    LINE,
    NOMINAL,
    ONE_LEG,
    PATTERN_LAW,
    PLANE,
    SIGMA,
    errors,
    flown_by,
    line_truth,
    prior,
    record,
)
from tracking.gaussian import Gaussian
from tracking.motion import van_loan
from tracking.reference_path import SPEED_TIME, Line
from tracking.track import track
from tracking.trackers.linear_feedback import LinearFeedback
from tracking.trackers.saturated_control import SaturatedControl


def closed_loop_matrix(law):
    return np.array([[0.0, 1.0], [-GRAVITY * law.k1, -GRAVITY * law.k2]])


def damped(ratio, frequency=0.0585):
    return replace(NOMINAL, k1=frequency**2 / GRAVITY, k2=2.0 * ratio * frequency / GRAVITY)


def transition_of(law, dt, line=LINE):
    """What the tracker does to the unit vectors in a look-ahead of dt."""
    tracker = LinearFeedback(law, line, CROSS_TRACK)
    state, innovation = tracker.step(tracker.begin(Gaussian(np.eye(2), np.eye(2))), dt, None, None)
    assert innovation is None
    return tracker.estimate(state).mean


@pytest.mark.parametrize("period", [0.1, 1.0, 4.0, 10.0])
@pytest.mark.parametrize("ratio", [0.3, 0.73, 0.8165, 1.0 - 1e-9, 1.0, 1.0 + 1e-9, 1.02, 3.0])
def test_prediction_is_the_matrix_exponential(ratio, period):
    """1e-12: rounding of a handful of operations on numbers of order one; a wrong omega misses by 1e-3 and more."""
    law = damped(ratio)
    np.testing.assert_allclose(transition_of(law, period), expm(closed_loop_matrix(law) * period), rtol=0, atol=1e-12)


def test_prediction_has_the_printed_values():
    """The page gives six decimals."""
    printed = {4.0: [[0.975598, 3.356459], [-0.01149, 0.688355]], 10.0: [[0.872261, 6.347176], [-0.021727, 0.329075]]}
    for period, matrix in printed.items():
        np.testing.assert_allclose(transition_of(NOMINAL, period), matrix, rtol=0, atol=6e-7)


@pytest.mark.parametrize(("period", "printed"), [(1.0, 11.54), (4.0, 12.55), (10.0, 12.81)])
def test_steady_state_is_that_of_the_riccati_equation(period, printed):
    """4 %: the sampling error of 300 runs over 40 half-independent scans is 1 %; a lost factor 2 in Q moves it 8 %."""
    F, Q = van_loan(closed_loop_matrix(NOMINAL), np.diag([0.0, DENSITY]), period)
    H, R = np.array([[1.0, 0.0]]), np.array([[SIGMA**2]])
    P = solve_discrete_are(F.T, H.T, Q, R)
    analytic = math.sqrt((P - P @ H.T @ H @ P / (P[0, 0] + R))[0, 0])
    assert analytic == pytest.approx(printed, abs=0.006)  # rounding of the print
    rng = np.random.default_rng(21)
    truth = line_truth(flown_by(NOMINAL), (0.0, 0.0), 40 * period + 120.0, rng, 300, period=period, dt=0.2)
    result = errors(LinearFeedback(NOMINAL, LINE, CROSS_TRACK, DENSITY), truth, 22, period=period)
    assert result.rmse(slice(-40, None)) == pytest.approx(analytic, rel=0.04)
    assert result.cov[-1, 0, 0, 0] == pytest.approx(analytic**2, rel=1e-3)


def test_beacon_gains_follow_distance_and_speed():
    """k1 = k3 / D and k2 = k4 / V; over 0.1 s D hardly changes, so that the frozen exponential is right to 1e-6."""
    law = RadioBeacon(6.0, 1.2, math.radians(20.0), math.radians(5.0))
    for distance, speed in ((40e3, 100.0), (8e3, 72.0)):
        A = np.array([[0.0, 1.0], [-GRAVITY * 6.0 / (distance - 0.05 * speed), -GRAVITY * 1.2 / speed]])
        found = transition_of(law, 0.1, Line(speed, distance))
        np.testing.assert_allclose(found, expm(0.1 * A), rtol=1e-6, atol=1e-9)


def test_one_covariance_serves_all_runs_of_a_line():
    rng = np.random.default_rng(1)
    truth = line_truth(flown_by(NOMINAL), (500.0, 0.0), 20.0, rng, 7)
    found = track(LinearFeedback(NOMINAL, LINE, CROSS_TRACK), record(truth, rng), prior(truth, rng), start=0.0)
    assert found.cov.shape == (6, 2, 2, 1)


def test_one_leg_of_a_route_is_the_line():
    """Feedback over a sub-step is exact, the noise within it right to the second order: (0.5 s)^2 of a 107 s period."""
    rng = np.random.default_rng(2)
    line = line_truth(flown_by(NOMINAL), (800.0, 0.0), 120.0, rng, 5, density=0.0)
    along = np.broadcast_to(100.0 * 4.0 * np.arange(len(line))[:, None], line[:, 0].shape)
    plane = np.stack([along, np.full_like(along, 100.0), line[:, 0], line[:, 1]], axis=1)
    measured = record(line, rng)
    start = Gaussian(np.array([800.0, 0.0]), np.diag([1e4, 25.0]))
    alone = track(LinearFeedback(NOMINAL, LINE, CROSS_TRACK), measured, start, start=0.0)
    z = np.stack([plane[:, 0], measured.z[:, 0]], axis=1)
    R = np.broadcast_to(SIGMA**2 * np.eye(2), (len(z), 2, 2))
    both = replace(measured, channels=("radar.north", "radar.east"), z=z, R=R)
    start = Gaussian(np.array([0.0, 100.0, 800.0, 0.0]), np.diag([1e4, 25.0, 1e4, 25.0]))
    routed = track(LinearFeedback(NOMINAL, ONE_LEG, PLANE), both, start, start=0.0)
    np.testing.assert_allclose(routed.mean[:, 2:], alone.mean, rtol=5e-3, atol=0.5)
    scale = np.sqrt(np.einsum("kii->ki", alone.cov[..., 0]))
    difference = (routed.cov[:, 2:, 2:, 0] - alone.cov[..., 0]) / (scale[:, :, None] * scale[:, None])
    np.testing.assert_allclose(difference, 0.0, atol=1e-2)


def test_on_a_route_it_is_told_what_saturated_control_is():
    """Else their comparison would be one of what they are told."""
    route = replace(BASE_TO_FINAL, time_to_roll=3.0, wind=(4.0, -7.0), chart=((1, 8000.0, 58.0),))
    linear, saturated = (kind(PATTERN_LAW, route, PLANE) for kind in (LinearFeedback, SaturatedControl))
    assert linear.path == saturated.path


@pytest.mark.parametrize(("chart", "kept"), [(None, 1.0), ((), math.exp(-30.0 / SPEED_TIME))])
def test_the_speed_along_a_leg_comes_to_the_charted_one(chart, kept):
    """Over the ground, on a leg that is held: 100 m/s through the air, of which 6 m/s go against the wind across."""
    route = replace(ONE_LEG, wind=(8.0, -6.0), chart=chart)
    tracker = LinearFeedback(NOMINAL, route, PLANE, acceleration_density=0.0)
    begun = tracker.begin(Gaussian(np.array([[0.0], [60.0], [0.0], [0.0]]), np.diag([1.0, 4.0, 1.0, 1.0])[..., None]))
    state, _ = tracker.step(begun, 30.0, None, None)
    found = tracker.estimate(state)
    held = math.sqrt(route.legs[0].speed ** 2 - 6.0**2) + 8.0
    assert found.mean[1, 0] == pytest.approx(held + (60.0 - held) * kept, rel=1e-9)
    assert found.cov[1, 1, 0] == pytest.approx(4.0 * kept**2, rel=1e-9)
