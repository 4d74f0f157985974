"""Stored gains against the filter that they were taken from."""

from __future__ import annotations

import dataclasses

import numpy as np
import pytest

from tracking.gaussian import Gaussian
from tracking.measurement import DebiasedPolar, LinearMeasurement
from tracking.motion import AlongTrackAcceleration, ConstantVelocity
from tracking.schedule import schedule
from tracking.track import Measurements, track
from tracking.trackers.imm import InteractingMultipleModel, published_set
from tracking.trackers.kalman import Kalman

POSITION = LinearMeasurement(((1.0, 0.0, 0.0, 0.0), (0.0, 0.0, 1.0, 0.0)))
PRIOR = Gaussian(np.array([0.0, 60.0, 0.0, 30.0]), np.diag([1e4, 25.0, 1e4, 25.0]))
KALMAN = Kalman(POSITION, ConstantVelocity(0.3))


def record(runs=7, k=40):
    """Irregular epochs, an accuracy that changes, one epoch without a channel and one without any."""
    rng = np.random.default_rng(61)
    time = np.cumsum(rng.uniform(0.3, 3.0, k))
    z = np.stack([60.0 * time, 30.0 * time], axis=1)[:, :, None] + 100.0 * rng.standard_normal((k, 2, runs))
    A = 30.0 * rng.standard_normal((k, 2, 2, 1))
    R = np.einsum("kijr,kljr->kilr", A, A) + 4000.0 * np.eye(2)[None, :, :, None]
    z[9, 1], z[20] = np.nan, np.nan
    return Measurements(("radar.north", "radar.east"), time, time, z, R)


def test_stored_gains_are_the_filter_itself():
    measurements = record()
    stored = schedule(KALMAN, measurements.runs(slice(0, 1)), PRIOR)
    ours, judge = track(stored, measurements, PRIOR), track(KALMAN, measurements, PRIOR)
    np.testing.assert_allclose(ours.mean, judge.mean, rtol=1e-10, atol=1e-9)
    np.testing.assert_allclose(*np.broadcast_arrays(ours.cov, judge.cov), rtol=1e-10, atol=1e-9)
    np.testing.assert_allclose(ours.white, judge.white, rtol=1e-9, atol=1e-9)
    np.testing.assert_allclose(ours.nis, judge.nis, rtol=1e-9, atol=1e-9)
    np.testing.assert_allclose(ours.log_likelihood, judge.log_likelihood, rtol=1e-10)


def test_stored_gains_serve_a_prior_and_runs_of_their_own():
    """Only covariances are stored: other means, other noise, other chunks."""
    measurements = record()
    stored = schedule(KALMAN, measurements.runs(slice(0, 1)), PRIOR)
    means = PRIOR.mean[:, None] + np.random.default_rng(62).standard_normal((4, 7))
    judge = track(KALMAN, measurements, Gaussian(means, PRIOR.cov))
    for part in (slice(0, 3), slice(3, 7)):
        ours = track(stored, measurements.runs(part), Gaussian(means[:, part], PRIOR.cov))
        np.testing.assert_allclose(ours.mean, judge.mean[..., part], rtol=1e-10, atol=1e-9)


def test_what_has_no_schedule_is_refused_with_a_sentence():
    measurements = record()
    holes = measurements.z.copy()
    holes[3, 0, 2] = np.nan
    with pytest.raises(ValueError, match="absent in some runs only"):
        schedule(KALMAN, dataclasses.replace(measurements, z=holes), PRIOR)
    own = measurements.R * np.linspace(1.0, 2.0, 7)
    with pytest.raises(ValueError, match="accuracy differs between runs"):
        schedule(KALMAN, dataclasses.replace(measurements, R=own), PRIOR)
    with pytest.raises(ValueError, match="prior differs between runs"):
        schedule(KALMAN, measurements, Gaussian(PRIOR.mean, PRIOR.cov[:, :, None] * np.linspace(1.0, 2.0, 7)))
    with pytest.raises(ValueError, match="not linear"):
        schedule(Kalman(POSITION, AlongTrackAcceleration()), measurements, PRIOR)
    with pytest.raises(ValueError, match="no schedule"):
        schedule(Kalman(DebiasedPolar(height=0.0), ConstantVelocity()), measurements, PRIOR)
    with pytest.raises(ValueError, match="no schedule"):
        schedule(InteractingMultipleModel(POSITION, published_set()), measurements, PRIOR)


def test_a_record_that_does_not_fit_its_schedule_is_refused():
    measurements = record()
    short = dataclasses.replace(
        measurements,
        time=measurements.time[:5],
        arrival=measurements.arrival[:5],
        z=measurements.z[:5],
        R=measurements.R[:5],
    )
    with pytest.raises(ValueError, match="ends after 5 epochs"):
        track(schedule(KALMAN, short, PRIOR), measurements, PRIOR)
    stored = schedule(KALMAN, measurements, PRIOR)
    holes = measurements.z.copy()
    holes[4] = np.nan
    with pytest.raises(ValueError, match="the record has none"):
        track(stored, dataclasses.replace(measurements, z=holes), PRIOR)
