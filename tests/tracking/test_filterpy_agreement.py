"""filterpy as judge: posteriors of KF, EKF and IMM to 1e-9 relative, and its own objects as trackers."""

from __future__ import annotations

import copy
import math

import numpy as np
import pytest
from filterpy.common import Q_continuous_white_noise
from filterpy.kalman import ExtendedKalmanFilter, IMMEstimator, KalmanFilter, UnscentedKalmanFilter

from tracking.filterpy_adapter import from_filterpy, prior_of
from tracking.gaussian import Gaussian
from tracking.measurement import ExtendedPolar, LinearMeasurement
from tracking.motion import ConstantVelocity
from tracking.track import Measurements, track
from tracking.trackers.filterpy_constant_velocity import FilterpyConstantVelocity
from tracking.trackers.imm import InteractingMultipleModel, published_set
from tracking.trackers.kalman import Kalman

DT = 0.7
POSITION = LinearMeasurement(((1.0, 0.0, 0.0, 0.0), (0.0, 0.0, 1.0, 0.0)))
PRIOR = Gaussian(np.array([12_000.0, -50.0, 300.0, 40.0]), np.diag([1e3, 25.0, 1e3, 25.0]))
EPOCHS = 300


@pytest.fixture(scope="module")
def record():
    """Straight, then turning, with an accuracy that differs from epoch to epoch."""
    rng = np.random.default_rng(41)
    time = DT * (1.0 + np.arange(EPOCHS))  # filterpy predicts before its first update
    course = 2.5 - 0.04 * np.maximum(time - 100.0, 0.0)
    truth = PRIOR.mean[[0, 2]] + np.cumsum(64.0 * DT * np.stack([np.cos(course), np.sin(course)], axis=1), axis=0)
    A = 30.0 * rng.standard_normal((EPOCHS, 2, 2))
    R = A @ A.swapaxes(1, 2) + 1000.0 * np.eye(2)
    z = truth + np.einsum("kij,kj->ki", np.linalg.cholesky(R), rng.standard_normal((EPOCHS, 2)))
    return Measurements(("radar.north", "radar.east"), time, time, z, R)


def kalman_filter(F, Q):
    judge = KalmanFilter(dim_x=4, dim_z=2)
    judge.F, judge.Q, judge.H = F.copy(), Q.copy(), np.array(POSITION.H)
    judge.x, judge.P = PRIOR.mean.reshape(4, 1).copy(), PRIOR.cov.copy()
    return judge


def imm_estimator(model_set):
    filters = [kalman_filter(*model.transition(DT, None)[:2]) for model in model_set.models]
    return IMMEstimator(filters, np.array(model_set.probabilities), np.array(model_set.switching))


def test_kalman_filter(record):
    motion = ConstantVelocity(0.3)
    judge = kalman_filter(*motion.transition(DT, None)[:2])
    ours = track(Kalman(POSITION, motion), record, PRIOR, start=0.0)
    for k in range(EPOCHS):
        judge.predict()
        judge.update(record.z[k].reshape(2, 1), R=record.R[k])
        np.testing.assert_allclose(ours.mean[k], judge.x[:, 0], rtol=1e-9)
        np.testing.assert_allclose(ours.cov[k], judge.P, rtol=1e-9, atol=1e-9 * np.abs(judge.P).max())
        assert ours.log_likelihood[k] == pytest.approx(judge.log_likelihood, rel=1e-9)


def test_interacting_multiple_model(record):
    model_set = published_set(0.3)
    judge = imm_estimator(model_set)
    ours = track(InteractingMultipleModel(POSITION, model_set), record, PRIOR, start=0.0)
    for k in range(EPOCHS):
        for member in judge.filters:
            member.R = record.R[k]
        judge.predict()
        judge.update(record.z[k].reshape(2, 1))
        np.testing.assert_allclose(ours.mean[k], judge.x[:, 0], rtol=1e-9)
        np.testing.assert_allclose(ours.cov[k], judge.P, rtol=1e-9, atol=1e-9 * np.abs(judge.P).max())
        np.testing.assert_allclose(ours.model_probabilities[k], judge.mu, rtol=1e-9, atol=1e-12)


def test_extended_kalman_filter(record):
    """Range and azimuth, linearised at the prediction by both."""
    motion = ConstantVelocity(0.3)
    north, east = record.z[:, 0], record.z[:, 1]
    z = np.stack([np.hypot(north, east), np.arctan2(east, north)], axis=1)
    R = np.diag([30.0**2, math.radians(1.0) ** 2])
    polar = Measurements(("r.range", "r.azimuth"), record.time, record.time, z, np.broadcast_to(R, (EPOCHS, 2, 2)))
    ours = track(Kalman(ExtendedPolar(height=0.0), motion), polar, PRIOR, start=0.0)
    judge = ExtendedKalmanFilter(dim_x=4, dim_z=2)
    judge.F, judge.Q = (matrix.copy() for matrix in motion.transition(DT, None)[:2])
    judge.x, judge.P, judge.R = PRIOR.mean.reshape(4, 1).copy(), PRIOR.cov.copy(), R

    def polar_of(x):
        return np.array([[math.hypot(x[0, 0], x[2, 0])], [math.atan2(x[2, 0], x[0, 0])]])

    def jacobian(x):
        n, e = x[0, 0], x[2, 0]
        r = math.hypot(n, e)
        return np.array([[n / r, 0.0, e / r, 0.0], [-e / r**2, 0.0, n / r**2, 0.0]])

    def residual(a, b):
        y = a - b
        y[1] = (y[1] + math.pi) % (2.0 * math.pi) - math.pi
        return y

    for k in range(EPOCHS):
        judge.predict()
        judge.update(z[k].reshape(2, 1), jacobian, polar_of, residual=residual)
        scale = np.abs(judge.x).max()
        np.testing.assert_allclose(ours.mean[k], judge.x[:, 0], rtol=1e-9, atol=1e-9 * scale)
        np.testing.assert_allclose(ours.cov[k], judge.P, rtol=1e-9, atol=1e-9 * np.abs(judge.P).max())


def test_a_users_kalman_filter_is_the_tracker_it_describes(record):
    source = kalman_filter(*ConstantVelocity(0.3).transition(DT, None)[:2])
    tracker = from_filterpy(source)
    ours = track(tracker, record, prior_of(source), start=0.0)
    judge = copy.deepcopy(source)
    for k in range(EPOCHS):
        judge.predict()
        judge.update(record.z[k].reshape(2, 1), R=record.R[k])
    np.testing.assert_allclose(ours.mean[-1], judge.x[:, 0], rtol=1e-9)
    np.testing.assert_array_equal(source.x[:, 0], PRIOR.mean)  # only read


def test_a_users_imm_is_the_tracker_it_describes(record):
    source = imm_estimator(published_set(0.3))
    ours = track(from_filterpy(source), record, PRIOR, start=0.0)
    judge = imm_estimator(published_set(0.3))
    for k in range(EPOCHS):
        for member in judge.filters:
            member.R = record.R[k]
        judge.predict()
        judge.update(record.z[k].reshape(2, 1))
    np.testing.assert_allclose(ours.mean[-1], judge.x[:, 0], rtol=1e-9)
    np.testing.assert_allclose(ours.model_probabilities[-1], judge.mu, rtol=1e-9)


def test_a_missed_scan_is_two_predictions_of_the_users_filter(record):
    source = kalman_filter(*ConstantVelocity(0.3).transition(DT, None)[:2])
    tracker = from_filterpy(source, period=DT)
    state, _ = tracker.step(PRIOR, 2.0 * DT, None, None)
    source.predict()
    source.predict()
    np.testing.assert_allclose(state.mean, source.x[:, 0], rtol=1e-13)
    np.testing.assert_allclose(state.cov, source.P, rtol=1e-12)
    with pytest.raises(ValueError, match=r"designed for 0\.7 s; 1 s is no multiple"):
        tracker.step(PRIOR, 1.0, None, None)


def test_the_baseline_is_filterpys_own_design(record):
    ours = track(FilterpyConstantVelocity(POSITION, 0.5), record, PRIOR, start=0.0)
    judge = kalman_filter(np.kron(np.eye(2), [[1.0, DT], [0.0, 1.0]]), Q_continuous_white_noise(2, DT, 0.5, 2))
    for k in range(EPOCHS):
        judge.predict()
        judge.update(record.z[k].reshape(2, 1), R=record.R[k])
    np.testing.assert_allclose(ours.mean[-1], judge.x[:, 0], rtol=1e-9)


def test_what_cannot_be_batched_is_refused_with_the_reason():
    unscented = object.__new__(UnscentedKalmanFilter)
    with pytest.raises(TypeError, match="UnscentedKalmanFilter cannot be batched"):
        from_filterpy(unscented)
    with pytest.raises(TypeError, match="ExtendedKalmanFilter cannot be batched"):
        from_filterpy(ExtendedKalmanFilter(dim_x=4, dim_z=2))
    fading = kalman_filter(np.eye(4), np.eye(4))
    fading.alpha = 1.02
    with pytest.raises(ValueError, match="fading memory"):
        from_filterpy(fading)
    with pytest.raises(ValueError, match=r"\(2, 2\) for the channels"):
        from_filterpy(kalman_filter(np.eye(4), np.eye(4)), channels=("a", "b"))
    lopsided = kalman_filter(np.eye(4), np.eye(4))
    lopsided.Q[0, 1] = 0.3
    with pytest.raises(ValueError, match="Q must be symmetric"):
        from_filterpy(lopsided)
    negative = kalman_filter(np.eye(4), -np.eye(4))
    with pytest.raises(ValueError, match="no negative variance"):
        from_filterpy(negative)
    different = imm_estimator(published_set(0.3))
    different.filters[1].R = 9.0 * different.filters[1].R
    with pytest.raises(ValueError, match="share R"):
        from_filterpy(different)
