"""The filter with a manoeuvre detector against its two limits, and its detector against the rate that it is given."""

from __future__ import annotations

import numpy as np
import pytest

from tracking.gaussian import Gaussian
from tracking.measurement import LinearMeasurement
from tracking.motion import ConstantVelocity
from tracking.track import Measurements, follow, track
from tracking.trackers.kalman import Kalman
from tracking.trackers.manoeuvre_detector import ManoeuvreDetector

POSITION = LinearMeasurement(((1.0, 0.0, 0.0, 0.0), (0.0, 0.0, 1.0, 0.0)))
PRIOR = Gaussian(np.array([9000.0, -60.0, 500.0, 30.0]), np.diag([1e4, 25.0, 1e4, 25.0]))
QUIET, MANOEUVRE, RUNS, SCANS, SCAN, TURN = 0.01, 10.0, 40, 120, 0.7, 50
NEVER, ALWAYS = 1e-300, 1.0 - 1e-15


@pytest.fixture(scope="module")
def record():
    """A straight flight in the quiet noise of the model, then a turn that it does not know; radar noise of 20 m."""
    rng = np.random.default_rng(3)
    F, Q, _ = ConstantVelocity(QUIET).transition(SCAN, None)
    root = np.linalg.cholesky(Q)
    turn = np.eye(4)
    turn[np.ix_([1, 3], [1, 3])] = [[np.cos(0.07), -np.sin(0.07)], [np.sin(0.07), np.cos(0.07)]]
    x = PRIOR.mean[:, None] + np.sqrt(np.diag(PRIOR.cov))[:, None] * rng.standard_normal((4, RUNS))
    truth = []
    for k in range(SCANS):
        x = F @ x + root @ rng.standard_normal((4, RUNS))
        x = turn @ x if k >= TURN else x
        truth.append(x)
    z = np.array(truth)[:, [0, 2]] + 20.0 * rng.standard_normal((SCANS, 2, RUNS))
    time = SCAN * np.arange(1, SCANS + 1)
    R = np.broadcast_to(np.diag([400.0, 400.0]), (SCANS, 2, 2))
    return Measurements(("radar.north", "radar.east"), time, time, z, R), np.array(truth)


@pytest.mark.parametrize(("rate", "density"), [(NEVER, QUIET), (ALWAYS, MANOEUVRE)])
def test_a_detector_that_fires_never_or_always_is_the_kalman_filter_of_that_noise(record, rate, density):
    """Never with the quiet one, up to the turn; always with that of the manoeuvre, from the first measurement on."""
    measurements, _ = record
    part = Measurements(*(value[:TURN] if np.ndim(value) else value for value in vars(measurements).values()))
    ours = track(ManoeuvreDetector(POSITION, QUIET, MANOEUVRE, 5, rate), part, PRIOR, 0.0)
    judge = track(Kalman(POSITION, ConstantVelocity(density)), part, PRIOR, 0.0)
    for own, his in zip(ours[2:7], judge[2:7], strict=True):
        np.testing.assert_allclose(own, np.broadcast_to(his, own.shape), rtol=1e-12, atol=1e-12)


def test_false_alarms_come_at_the_stated_rate_and_the_turn_is_found_and_left_again(record):
    measurements, truth = record
    tracker = ManoeuvreDetector(POSITION, QUIET, MANOEUVRE, 5, 0.02)
    alarms, errors = [], []
    for epoch in follow(tracker, measurements, PRIOR, 0.0):
        alarms.append(epoch.state.alarm)
        errors.append(((epoch.estimate.mean[[0, 2]] - truth[epoch.row, [0, 2]]) ** 2).sum(axis=0))
    quiet = np.mean(alarms[:TURN])  # 2000 samples of which five in a row are one: sd .007
    assert 0.005 < quiet < 0.04
    found = np.array(alarms[TURN:])
    assert (np.argmax(found, axis=0) < 12).all()
    assert found.any(axis=0).all()
    stiff = track(Kalman(POSITION, ConstantVelocity(QUIET)), measurements, PRIOR, 0.0)
    lost = ((stiff.mean[TURN:, [0, 2]] - truth[TURN:, [0, 2]]) ** 2).sum(axis=1)
    assert np.mean(errors[TURN:]) < 0.02 * lost.mean()


def test_a_run_that_is_not_measured_keeps_both_predictions_and_its_alarm(record):
    measurements, _ = record
    tracker = ManoeuvreDetector(POSITION, QUIET, MANOEUVRE, 5, 0.02)
    *_, last = follow(tracker, measurements, PRIOR, 0.0)
    assert last.state.alarm.any()
    ahead, _ = tracker.step(last.state, SCAN, None, None)
    z = np.array(measurements.z[-1])
    z[:, ::2] = np.nan
    part, _ = tracker.step(ahead, 0.0, z, measurements.R[-1][..., None])
    for own, predicted in zip(
        (part.mean, part.quiet, part.raised), (ahead.mean, ahead.quiet, ahead.raised), strict=True
    ):
        np.testing.assert_array_equal(own[..., ::2], np.broadcast_to(predicted, own.shape)[..., ::2])
    np.testing.assert_array_equal(part.alarm[::2], ahead.alarm[::2])


@pytest.mark.parametrize(
    ("wrong", "told"),
    [
        ({"quiet_density": 1.0, "manoeuvre_density": 0.5}, "must not be below quiet_density"),
        ({"window": 0}, "window must be at least 1"),
        ({"false_alarm_rate": 1.0}, "false_alarm_rate must lie between"),
        ({"quiet_density": -1.0}, "density"),
    ],
)
def test_parameters_are_checked(wrong, told):
    with pytest.raises(ValueError, match=told):
        ManoeuvreDetector(POSITION, **wrong)
