"""The Kalman filter against the recursion in plain NumPy, the Riccati equation, and its statistics."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.linalg import solve_discrete_are

from tracking.gaussian import Gaussian
from tracking.measurement import LinearMeasurement
from tracking.motion import ConstantVelocity, CoordinatedTurn
from tracking.track import Measurements, track
from tracking.trackers.gated import Gated
from tracking.trackers.huber import Huber
from tracking.trackers.kalman import Kalman

POSITION = LinearMeasurement(((1.0, 0.0, 0.0, 0.0), (0.0, 0.0, 1.0, 0.0)))
PRIOR = Gaussian(np.array([0.0, 60.0, 0.0, 30.0]), np.diag([1e4, 25.0, 1e4, 25.0]))


def simulated(motion, rng, k, runs, dt=0.7, sigma=100.0):
    """Truth drawn from the filter's own model, start included, and its measurements."""
    F, Q, _ = motion.transition(dt, None)
    root = np.linalg.cholesky(Q)
    x = PRIOR.mean[:, None] + np.linalg.cholesky(PRIOR.cov) @ rng.standard_normal((4, runs))
    truth = [x]
    for _ in range(k - 1):
        truth.append(F @ truth[-1] + root @ rng.standard_normal((4, runs)))
    truth = np.array(truth)
    z = truth[:, [0, 2]] + sigma * rng.standard_normal((k, 2, runs))
    R = np.broadcast_to(sigma**2 * np.eye(2)[None, :, :, None], (k, 2, 2, 1))
    time = dt * np.arange(k)
    return truth, Measurements(("radar.north", "radar.east"), time, time, z, R)


def test_steady_state_is_the_riccati_equation():
    motion = ConstantVelocity(0.3)
    _, measurements = simulated(motion, np.random.default_rng(31), 600, 1)
    result = track(Kalman(POSITION, motion), measurements, PRIOR)
    F, Q, _ = motion.transition(0.7, None)
    H, R = np.array(POSITION.H), 1e4 * np.eye(2)
    predicted = solve_discrete_are(F.T, H.T, Q, R)
    gain = predicted @ H.T @ np.linalg.inv(H @ predicted @ H.T + R)
    # the solver couples the axes by some 1e-12 of its largest entry, how much depends on the processor
    rounding = 1e-11 * predicted.max()
    np.testing.assert_allclose(result.cov[-1, ..., 0], (np.eye(4) - gain @ H) @ predicted, rtol=1e-9, atol=rounding)


def test_a_shared_accuracy_keeps_one_covariance_for_all_runs():
    _, measurements = simulated(ConstantVelocity(0.3), np.random.default_rng(32), 20, 50)
    result = track(Kalman(POSITION, ConstantVelocity(0.3)), measurements, PRIOR)
    assert result.cov.shape == (20, 4, 4, 1)
    assert result.mean.shape == (20, 4, 50)


def test_on_its_own_model_errors_and_innovations_have_their_chi_square_means():
    """NEES is correlated in time, so its scatter is taken between the 400 independent runs."""
    motion = CoordinatedTurn(0.045, 0.5)
    truth, measurements = simulated(motion, np.random.default_rng(33), 60, 400)
    result = track(Kalman(POSITION, motion), measurements, PRIOR)
    error = result.mean - truth
    information = np.linalg.inv(result.cov[..., 0])
    nees = np.einsum("kin,kij,kjn->kn", error, information, error)
    per_run = nees.mean(axis=0)  # independent between runs
    assert abs(per_run.mean() - 4.0) < 4.0 * per_run.std() / np.sqrt(400)
    assert abs(result.nis.mean() - 2.0) < 4.0 * np.sqrt(4.0 / result.nis.size)  # white: variance 2 m per sample
    white = result.white
    lag = (white[1:] * white[:-1]).mean()
    assert abs(lag) < 4.0 / np.sqrt(white[1:].size)


def test_zero_noise_is_the_truth():
    motion = ConstantVelocity(0.0)
    rng = np.random.default_rng(34)
    x = PRIOR.mean[:, None] + np.linalg.cholesky(PRIOR.cov) @ rng.standard_normal((4, 5))
    F = motion.transition(0.7, None).F
    truth = [x]
    for _ in range(9):
        truth.append(F @ truth[-1])
    truth = np.array(truth)
    R = np.broadcast_to(1e-6 * np.eye(2)[None, :, :, None], (10, 2, 2, 1))
    time = 0.7 * np.arange(10)
    result = track(Kalman(POSITION, motion), Measurements(("r.n", "r.e"), time, time, truth[:, [0, 2]], R), PRIOR)
    np.testing.assert_allclose(result.mean[-1], truth[-1], atol=1e-3)  # sigma of the measurement


@pytest.mark.parametrize("kind", [Kalman, Gated, Huber])
def test_without_a_motion_it_is_straight_flight_of_the_given_density(kind):
    _, measurements = simulated(ConstantVelocity(2.0), np.random.default_rng(35), 10, 3)
    by_density, by_motion, other = (
        track(tracker, measurements, PRIOR).mean
        for tracker in (
            kind(POSITION, acceleration_density=2.0),
            kind(POSITION, ConstantVelocity(2.0)),
            kind(POSITION, acceleration_density=20.0),
        )
    )
    np.testing.assert_array_equal(by_density, by_motion)
    assert np.abs(by_density - other).max() > 1.0
    with pytest.raises(ValueError, match="acceleration_density must not be negative"):
        kind(POSITION, acceleration_density=-1.0)
