"""Huber's update judged by its limits, by its scalar closed form and by a general minimiser."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.optimize import minimize

from tracking.gaussian import Gaussian
from tracking.measurement import LinearMeasurement
from tracking.motion import ConstantVelocity
from tracking.trackers.huber import Huber
from tracking.trackers.kalman import Kalman

POSITION = LinearMeasurement(((1.0, 0.0, 0.0, 0.0), (0.0, 0.0, 1.0, 0.0)))
PRIOR = Gaussian(np.zeros((4, 1)), np.diag([400.0, 25.0, 900.0, 25.0])[..., None])
R = np.diag([100.0, 400.0])[..., None]


def test_without_outliers_it_is_the_kalman_filter():
    z = np.array([[5.0], [-8.0]])
    for tuning in (1.345, 1e6):
        huber, _ = Huber(POSITION, ConstantVelocity(), tuning).step(PRIOR, 1.0, z, R)
        kalman, _ = Kalman(POSITION, ConstantVelocity()).step(PRIOR, 1.0, z, R)
        np.testing.assert_array_equal(huber.mean, kalman.mean)
        np.testing.assert_array_equal(huber.cov, kalman.cov)


def test_scalar_closed_form():
    """A far residual pulls with the constant force tuning/sigma: x = P tuning / sigma."""
    z = np.array([[3000.0], [0.0]])
    posterior, _ = Huber(POSITION).step(PRIOR, 0.0, z, R)
    assert posterior.mean[0, 0] == pytest.approx(400.0 * 1.345 / 10.0, rel=1e-12)
    assert posterior.cov[0, 0] == pytest.approx(400.0)  # and says nothing about how far


def test_against_a_general_minimiser():
    """Two channels through a full prior; the minimiser stops at about 1e-6 relative."""
    generator = np.random.default_rng(1)
    root = generator.standard_normal((4, 4)) * 15.0
    cov = root @ root.T
    posterior, _ = Huber(POSITION).step(
        Gaussian(np.zeros((4, 1)), cov[..., None]), 0.0, np.array([[90.0], [-160.0]]), R
    )

    def loss(x):
        size = np.abs(np.array([90.0, -160.0]) - x[[0, 2]]) / np.array([10.0, 20.0])
        rho = np.where(size <= 1.345, 0.5 * size**2, 1.345 * size - 0.5 * 1.345**2)
        return x @ np.linalg.solve(cov, x) + 2.0 * rho.sum()

    best = minimize(loss, np.zeros(4), method="BFGS", options={"gtol": 1e-10, "maxiter": 5000})
    assert loss(posterior.mean[:, 0]) <= best.fun + 1e-9
    np.testing.assert_allclose(posterior.mean[:, 0], best.x, rtol=1e-4, atol=1e-4)


def test_runs_and_absent_channels_are_independent():
    z = np.array([[3000.0, 5.0, np.nan, np.nan], [0.0, 700.0, 700.0, np.nan]])
    together, innovation = Huber(POSITION).step(PRIOR, 1.0, z, R)
    for run in range(4):
        alone, _ = Huber(POSITION).step(PRIOR, 1.0, z[:, run : run + 1], R)
        np.testing.assert_allclose(alone.mean[:, 0], together.mean[:, run], rtol=1e-12, atol=1e-12)
    predicted, _ = Huber(POSITION).step(PRIOR, 1.0, None, None)
    np.testing.assert_allclose(together.mean[:, 3], predicted.mean[:, 0])
    assert np.isnan(innovation.white[:, 3]).all()


def test_the_pull_of_an_outlier_is_bounded():
    """Fifty and five thousand sigma pull alike, where the Kalman filter follows without limit."""
    means = [Huber(POSITION).step(PRIOR, 0.0, np.array([[far], [0.0]]), R)[0].mean[0, 0] for far in (1e3, 1e5)]
    assert means[1] == pytest.approx(means[0], rel=1e-12)


def test_tuning_must_be_positive():
    with pytest.raises(ValueError, match="positive"):
        Huber(POSITION, tuning=0.0)
