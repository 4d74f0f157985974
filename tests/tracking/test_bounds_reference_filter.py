"""The reference filter judged by enumeration of all mode histories, and its thinning by what defines it."""

from __future__ import annotations

import itertools

import numpy as np
import pytest

from tracking.gaussian import Gaussian, merge
from tracking.intervals import gain
from tracking.measurement import LinearMeasurement
from tracking.motion import ConstantVelocity, CoordinatedTurn
from tracking.reference_filter import ReferenceFilter, optimal_resampling
from tracking.track import Measurements, follow
from tracking.trackers.imm import InteractingMultipleModel, ModelSet

POSITION = LinearMeasurement(((1.0, 0.0, 0.0, 0.0), (0.0, 0.0, 1.0, 0.0)))
H = np.array(POSITION.H)
MODELS = ModelSet(
    (ConstantVelocity(0.5), CoordinatedTurn(0.1, 0.5), CoordinatedTurn(-0.1, 2.0)),
    ((0.8, 0.15, 0.05), (0.1, 0.85, 0.05), (0.3, 0.2, 0.5)),
    (0.6, 0.3, 0.1),
)
PRIOR = Gaussian(np.array([0.0, 70.0, 0.0, 10.0]), np.diag([900.0, 25.0, 900.0, 25.0]))


def record(epochs: int, runs: int, seed: int) -> Measurements:
    generator = np.random.default_rng(seed)
    time = np.arange(1.0, epochs + 1.0)
    path = np.stack([70.0 * time, 10.0 * time + 2.0 * time**2], axis=1)
    z = path[..., None] + 30.0 * generator.standard_normal((epochs, 2, runs))
    return Measurements(("north", "east"), time, time, z, np.broadcast_to(900.0 * np.eye(2), (epochs, 2, 2)))


def enumerated(measurements: Measurements, run: int) -> tuple[np.ndarray, np.ndarray, float]:
    """Mean, covariance and log-likelihood of the last epoch: one textbook Kalman filter per mode history."""
    steps = len(measurements.time)
    matrices = [model.transition(1.0, None) for model in MODELS.models]
    logs, means, covs = [], [], []
    for history in itertools.product(range(3), repeat=steps + 1):
        x, P, log = PRIOR.mean, PRIOR.cov, np.log(MODELS.probabilities[history[0]])
        for k, mode in enumerate(history[1:]):
            log += np.log(MODELS.switching[history[k]][mode])
            F, Q = matrices[mode].F, matrices[mode].Q
            x, P = F @ x, F @ P @ F.T + Q
            S = H @ P @ H.T + measurements.R[k]
            v = measurements.z[k, :, run] - H @ x
            K = P @ H.T @ np.linalg.inv(S)
            log += -0.5 * (v @ np.linalg.solve(S, v) + np.linalg.slogdet(2 * np.pi * S)[1])
            x, P = x + K @ v, P - K @ S @ K.T
        logs.append(log)
        means.append(x)
        covs.append(P)
    logs = np.array(logs)
    weights = np.exp(logs - logs.max())
    total = weights.sum()
    weights /= total
    mean = np.einsum("h,hi->i", weights, means)
    deviation = np.array(means) - mean
    cov = np.einsum("h,hij->ij", weights, covs) + np.einsum("h,hi,hj->ij", weights, deviation, deviation)
    return mean, cov, logs.max() + np.log(total)


def test_without_thinning_it_is_the_exact_posterior():
    """4 epochs, 243 histories: 1e-9 relative is rounding of a mixture of that size."""
    measurements = record(4, 3, seed=1)
    log_likelihood = np.zeros(3)
    for epoch in follow(ReferenceFilter(POSITION, MODELS, 243), measurements, PRIOR, start=0.0):
        log_likelihood += epoch.innovation.log_likelihood
    posterior = merge(epoch.estimate)
    for run in range(3):
        mean, cov, log = enumerated(measurements, run)
        np.testing.assert_allclose(posterior.mean[:, run], mean, rtol=1e-9)
        np.testing.assert_allclose(posterior.cov[..., run], cov, rtol=1e-9, atol=1e-9)
        assert log_likelihood[run] == pytest.approx(log, rel=1e-9)


def test_thinning_stays_near_the_exact_posterior():
    """The estimate from 40 of 729 histories within a tenth of its own standard deviation of the exact one."""
    measurements = record(5, 1, seed=2)
    exact, cov, _ = enumerated(measurements, 0)
    *_, last = follow(ReferenceFilter(POSITION, MODELS, 40), measurements, PRIOR, start=0.0)
    assert last.estimate.mean.shape == (4, 40, 1)
    assert (np.abs(merge(last.estimate).mean[:, 0] - exact) < 0.1 * np.sqrt(np.diag(cov))).all()


def test_an_imm_is_worse_than_the_reference_by_less_than_a_tenth():
    """Truth from the models themselves; paired over 150 runs the interval is +-0.7 %."""
    generator, runs = np.random.default_rng(6), 150
    chance = np.array(MODELS.switching)
    pairs = [model.transition(1.0, None) for model in MODELS.models]
    F, root = np.stack([p.F for p in pairs]), np.stack([np.linalg.cholesky(p.Q) for p in pairs])
    mode = generator.choice(3, size=runs, p=MODELS.probabilities)
    x = PRIOR.mean[:, None] + np.sqrt(np.diag(PRIOR.cov))[:, None] * generator.standard_normal((4, runs))
    truth = []
    for _ in range(40):
        mode = (generator.random(runs)[:, None] > chance[mode].cumsum(axis=1)).sum(axis=1)
        x = np.einsum("Nij,jN->iN", F[mode], x)
        x = x + np.einsum("Nij,jN->iN", root[mode], generator.standard_normal((4, runs)))
        truth.append(x)
    truth, time = np.stack(truth), np.arange(1.0, 41.0)
    z = truth[:, [0, 2]] + 30.0 * generator.standard_normal((40, 2, runs))
    measurements = Measurements(("north", "east"), time, time, z, np.broadcast_to(900.0 * np.eye(2), (40, 2, 2)))

    def squares(tracker):
        errors = [merge(e.estimate).mean - truth[e.row] for e in follow(tracker, measurements, PRIOR, start=0.0)]
        return np.mean([e[0] ** 2 + e[2] ** 2 for e in errors], axis=0)

    excess = gain(squares(InteractingMultipleModel(POSITION, MODELS)), squares(ReferenceFilter(POSITION, MODELS, 40)))
    assert excess.high > 1.0
    assert excess.high < 1.10


def test_runs_of_an_ensemble_do_not_see_each_other():
    measurements = record(8, 3, seed=3)
    *_, together = follow(ReferenceFilter(POSITION, MODELS, 20), measurements, PRIOR, start=0.0)
    for run in range(3):
        *_, alone = follow(
            ReferenceFilter(POSITION, MODELS, 20), measurements.runs(slice(run, run + 1)), PRIOR, start=0.0
        )
        np.testing.assert_allclose(merge(alone.estimate).mean[:, 0], merge(together.estimate).mean[:, run], rtol=1e-12)


def test_an_absent_measurement_is_a_pure_prediction():
    measurements = record(3, 2, seed=4)
    z = measurements.z.copy()
    z[2] = np.nan
    blind = Measurements(measurements.channels, measurements.time, measurements.arrival, z, measurements.R)
    estimates = [merge(e.estimate) for e in follow(ReferenceFilter(POSITION, MODELS, 50), blind, PRIOR, start=0.0)]
    assert np.isfinite(estimates[2].mean).all()
    assert (
        np.linalg.det(np.moveaxis(estimates[2].cov, -1, 0)) > np.linalg.det(np.moveaxis(estimates[1].cov, -1, 0))
    ).all()


def test_resampling_keeps_the_heavy_and_is_unbiased_on_the_light():
    """Averaged over an even grid of offsets the weights are the old ones, to the grid's 4e-3."""
    generator = np.random.default_rng(5)
    weights = generator.exponential(size=(30, 4)) ** 3
    weights /= weights.sum(axis=0)
    mean = np.zeros_like(weights)
    for offset in (np.arange(500) + 0.5) / 500:
        index, thinned = optimal_resampling(weights, 8, offset)
        assert index.shape == (8, 4)
        assert all(len(set(column)) == 8 for column in index.T)
        full = np.zeros_like(weights)
        np.put_along_axis(full, index, thinned, axis=0)
        mean += full / 500
        np.testing.assert_allclose(thinned.sum(axis=0), 1.0, rtol=1e-12)
        # one common weight below, the own weight above
        common = thinned.min(axis=0)
        own = np.isclose(thinned, np.take_along_axis(weights, index, axis=0), rtol=1e-9)
        assert (own | np.isclose(thinned, common, rtol=1e-9)).all()
    np.testing.assert_allclose(mean, weights, atol=4e-3)


def test_resampling_equal_and_vanishing_weights():
    index, thinned = optimal_resampling(np.full((6, 1), 1 / 6), 3, 0.3)
    np.testing.assert_allclose(thinned, 1 / 3)
    assert len(set(index[:, 0])) == 3
    sparse = np.array([0.0, 0.7, 0.0, 0.3, 0.0])[:, None]
    index, thinned = optimal_resampling(sparse, 3, 0.3)
    full = np.zeros((5, 1))
    np.put_along_axis(full, index, thinned, axis=0)
    np.testing.assert_allclose(full, sparse)


def test_no_history_is_refused():
    with pytest.raises(ValueError, match="at least 1"):
        ReferenceFilter(POSITION, MODELS, 0)
