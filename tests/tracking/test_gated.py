"""The gate judged by its limits (wide open = Kalman), its rate of rejection and what an outlier does."""

from __future__ import annotations

import numpy as np
import pytest

from tracking.gaussian import Gaussian
from tracking.measurement import LinearMeasurement
from tracking.motion import ConstantVelocity, planar_constant_velocity
from tracking.track import Measurements, track
from tracking.trackers.gated import Gated
from tracking.trackers.kalman import Kalman

POSITION = LinearMeasurement(((1.0, 0.0, 0.0, 0.0), (0.0, 0.0, 1.0, 0.0)))
PRIOR = Gaussian(np.zeros(4), np.diag([400.0, 25.0, 400.0, 25.0]))


def record(epochs: int, runs: int, seed: int) -> Measurements:
    """Measurements drawn from constant velocity of density 0.3 with noise of 20 m."""
    generator = np.random.default_rng(seed)
    F, Q = planar_constant_velocity(1.0, 0.3, 0.3)
    x = np.sqrt(np.diag(PRIOR.cov))[:, None] * generator.standard_normal((4, runs))
    z = []
    for _ in range(epochs):
        x = F @ x + np.linalg.cholesky(Q) @ generator.standard_normal((4, runs))
        z.append(x[[0, 2]] + 20.0 * generator.standard_normal((2, runs)))
    time = np.arange(1.0, epochs + 1.0)
    return Measurements(("a", "b"), time, time, np.stack(z), np.broadcast_to(400.0 * np.eye(2), (epochs, 2, 2)))


def changed(measurements: Measurements, z) -> Measurements:
    return Measurements(measurements.channels, measurements.time, measurements.arrival, z, measurements.R)


def test_wide_open_it_is_the_kalman_filter():
    measurements = record(20, 5, seed=1)
    kalman = track(Kalman(POSITION, ConstantVelocity(0.3)), measurements, PRIOR, start=0.0)
    gated = track(Gated(POSITION, ConstantVelocity(0.3), 1.0 - 1e-15), measurements, PRIOR, start=0.0)
    np.testing.assert_array_equal(gated.mean, kalman.mean)
    np.testing.assert_array_equal(gated.cov, kalman.cov)


def test_an_outlier_of_fifty_sigma_is_as_good_as_absent():
    measurements = record(20, 3, seed=2)
    z = measurements.z.copy()
    z[10, 0, 1] += 1000.0
    hit = track(Gated(POSITION, ConstantVelocity(0.3)), changed(measurements, z), PRIOR, start=0.0)
    z[10, :, 1] = np.nan
    absent = track(Gated(POSITION, ConstantVelocity(0.3)), changed(measurements, z), PRIOR, start=0.0)
    np.testing.assert_allclose(hit.mean, absent.mean, rtol=1e-12, atol=1e-9)
    assert hit.nis[10, 1] > 100.0


def test_runs_are_independent():
    """Batched equals single, also where only some runs reject."""
    measurements = record(15, 3, seed=4)
    z = measurements.z.copy()
    z[5:8, 0, 1] += 500.0
    z[9, 1, 2] = np.nan
    tracker = Gated(POSITION, ConstantVelocity(0.3))
    together = track(tracker, changed(measurements, z), PRIOR, start=0.0)
    for run in range(3):
        alone = track(tracker, changed(measurements, z).runs(slice(run, run + 1)), PRIOR, start=0.0)
        np.testing.assert_allclose(alone.mean[..., 0], together.mean[..., run], rtol=1e-12, atol=1e-12)
        np.testing.assert_allclose(alone.cov[..., 0], together.cov[..., run], rtol=1e-12, atol=1e-12)


def test_it_rejects_as_often_as_it_says():
    """One epoch, 20,000 runs, also where only one channel is present: 1 % +- 4 standard errors (0.28 %)."""
    measurements = record(1, 20_000, seed=3)
    tracker = Gated(POSITION, ConstantVelocity(0.3), gate_probability=0.99)
    for z in (measurements.z, np.where([[[0.0], [1.0]]], np.nan, measurements.z)):
        result = track(tracker, changed(measurements, z), PRIOR, start=0.0)
        rejected = result.cov[0, 0, 0] > 300.0  # predicted 425, updated 206
        assert rejected.mean() == pytest.approx(0.01, abs=0.0028)


@pytest.mark.parametrize("probability", [0.0, 1.0, float("nan")])
def test_a_gate_must_be_a_probability(probability):
    with pytest.raises(ValueError, match="between 0 and 1"):
        Gated(POSITION, gate_probability=probability)
