"""The cartesian relative of the load-factor tracker against exact flights, its kinematic self and single runs."""

from __future__ import annotations

import numpy as np
import pytest

from tests.tracking.radar_flights import DEGREE, MEASURED, base_turn, deaf, glide_turn, observed, rms
from tracking.gaussian import Gaussian
from tracking.measurement import DebiasedPolar
from tracking.track import Measurements, follow, track
from tracking.trackers.load_factor_cartesian import LoadFactorCartesian


def cartesian_prior(flight, runs, rng):
    sigmas = np.array([100.0, 5.0, 100.0, 5.0])
    mean = np.array([flight[name][0] for name in ("north", "north_rate", "east", "east_rate")])[:, None]
    return Gaussian(mean + sigmas[:, None] * rng.standard_normal((4, runs)), np.diag(sigmas**2))


def cartesian(**fields):
    return LoadFactorCartesian(DebiasedPolar((0.0, 0.0), 0.0, None), MEASURED, **fields)


def position_azimuths(tracker, flight, rows, measurements, prior):
    return np.array(
        [
            np.arctan2(epoch.estimate.mean[2], epoch.estimate.mean[0]) - flight["azimuth"][rows[epoch.row]]
            for epoch in follow(tracker, measurements, prior, start=0.0)
        ]
    )


def test_cartesian_state_takes_the_load_factors_as_input():
    flight, rng, angle, runs = base_turn(), np.random.default_rng(11), 0.15 * DEGREE, 40
    rows, measurements = observed(flight, 0.5, angle, runs, rng)
    prior = cartesian_prior(flight, runs, rng)
    turning = flight["turning"][rows]
    plain = position_azimuths(cartesian(), flight, rows, deaf(measurements), prior)[turning]
    aided = position_azimuths(cartesian(), flight, rows, measurements, prior)[turning]
    assert 1.5 < rms(plain) / rms(aided) < 2.6  # 2.0 at full size


def test_cartesian_input_is_exact_without_noise():
    """Only the prior and exact load factors: after a minute of turning the position is the flight's."""
    flight, rng = glide_turn(), np.random.default_rng(12)
    _, measurements = observed(flight, 0.5, DEGREE, 1, rng, scale=0.0)
    z = np.array(measurements.z[:, :, 0])
    z[:, :3] = np.nan
    names = ("north", "north_rate", "east", "east_rate")
    tracker = cartesian()
    state = tracker.begin(Gaussian(np.array([flight[name][0] for name in names]), np.eye(4)))
    for row in z:
        state, _ = tracker.step(state, 0.5, row, measurements.R[0])
    exact = [flight[name][-1] for name in names]
    np.testing.assert_allclose(tracker.estimate(state).mean, exact, rtol=0, atol=3.0)  # trapezoid over 0.5 s, of 4 km


def test_cartesian_batch_is_its_runs_with_measurements_missing():
    flight, rng = base_turn(), np.random.default_rng(13)
    _, measurements = observed(flight, 0.5, 0.15 * DEGREE, 3, rng)
    z = np.array(measurements.z[:80])
    z[rng.random(z.shape) < 0.05] = np.nan
    z[:10, 3:] = np.nan
    z[30:40, 3:, 1] = np.nan
    z[50] = np.nan
    time, R = measurements.time[:80], measurements.R[:80]
    prior = cartesian_prior(flight, 1, rng)
    prior = Gaussian(prior.mean[:, 0], prior.cov)
    batch = track(cartesian(), Measurements(MEASURED, time, time, z, R), prior)
    assert np.isfinite(batch.mean).all()
    for run in range(3):
        alone = track(cartesian(), Measurements(MEASURED, time, time, z[..., run], R), prior)
        np.testing.assert_allclose(batch.mean[..., run], alone.mean, rtol=1e-12, atol=1e-9)
        np.testing.assert_allclose(batch.cov[..., run], alone.cov, rtol=1e-10, atol=1e-12)


def test_cartesian_parameters_out_of_range_are_refused():
    with pytest.raises(ValueError, match="residual_density"):
        cartesian(residual_density=-1.0)
    with pytest.raises(ValueError, match="reads 2 rows"):
        LoadFactorCartesian(DebiasedPolar((0.0, 0.0), 0.0, 100.0), MEASURED)
