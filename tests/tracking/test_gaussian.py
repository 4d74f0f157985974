"""The algebra against textbook formulas written out run by run, and against its own limits."""

from __future__ import annotations

import math

import numpy as np
import pytest

from tracking.gaussian import Gaussian, Mixture, interact, lift, merge, predict, reweigh, update, update_mixture

RUNS = 5


@pytest.fixture
def rng():
    return np.random.default_rng(20220101)


def covariance(rng, n, *batch):
    A = rng.standard_normal((n, n, *batch))
    return np.einsum("ij...,kj...->ik...", A, A) + 0.1 * lift(np.eye(n), 2, len(batch))


def log_density(y, S):
    """Of a zero-mean normal, by determinant and inverse."""
    return -0.5 * (y @ np.linalg.inv(S) @ y + math.log(np.linalg.det(2.0 * math.pi * S)))


@pytest.mark.parametrize("m", [1, 2, 3, 4])
def test_update_is_the_textbook_gain_form(rng, m):
    n = 4
    prior = Gaussian(rng.standard_normal((n, RUNS)), covariance(rng, n, RUNS))
    z, H, R = rng.standard_normal((m, RUNS)), rng.standard_normal((m, n, RUNS)), covariance(rng, m, RUNS)
    posterior, innovation = update(prior, z, H, R)
    for run in range(RUNS):
        x, P, h, r = prior.mean[:, run], prior.cov[:, :, run], H[:, :, run], R[:, :, run]
        y, S = z[:, run] - h @ x, h @ P @ h.T + r
        K = P @ h.T @ np.linalg.inv(S)
        # well conditioned 4 x 4 algebra: agreement to some hundred roundings
        np.testing.assert_allclose(posterior.mean[:, run], x + K @ y, rtol=1e-11, atol=1e-11)
        np.testing.assert_allclose(posterior.cov[:, :, run], (np.eye(n) - K @ h) @ P, rtol=1e-11, atol=1e-11)
        np.testing.assert_allclose(innovation.nis[run], y @ np.linalg.inv(S) @ y, rtol=1e-11)
        np.testing.assert_allclose(innovation.log_likelihood[run], log_density(y, S), rtol=1e-11)
        np.testing.assert_allclose(innovation.white[:, run], np.linalg.solve(np.linalg.cholesky(S), y), rtol=1e-11)


@pytest.mark.parametrize("shared", ["F", "P", "F and P", "nothing"])
def test_predict_serves_every_mixture_of_shared_and_own_matrices(rng, shared):
    n = 3
    F = rng.standard_normal((n, n) if "F" in shared else (n, n, RUNS))
    P = covariance(rng, n) if "P" in shared else covariance(rng, n, RUNS)
    Q, u, x = covariance(rng, n), rng.standard_normal((n, RUNS)), rng.standard_normal((n, RUNS))
    moved = predict(Gaussian(x, P), F, Q, u)
    for run in range(RUNS):
        f, p = (matrix if matrix.ndim == 2 else matrix[:, :, run] for matrix in (F, P))
        cov = moved.cov if moved.cov.ndim == 2 else moved.cov[:, :, run]
        np.testing.assert_allclose(moved.mean[:, run], f @ x[:, run] + u[:, run], rtol=1e-12)
        np.testing.assert_allclose(cov, f @ p @ f.T + Q, rtol=1e-12)
    assert (moved.cov.ndim == 2) == (shared == "F and P")  # a run axis only once something run-dependent entered


def test_batch_is_the_single_run(rng):
    n, m = 4, 2
    mean, cov = rng.standard_normal((n, RUNS)), covariance(rng, n, RUNS)
    F, Q, H, R = rng.standard_normal((n, n)), covariance(rng, n), rng.standard_normal((m, n)), covariance(rng, m, RUNS)
    z = rng.standard_normal((m, RUNS))
    posterior, innovation = update(predict(Gaussian(mean, cov), F, Q), z, H, R)
    for run in range(RUNS):
        one, said = update(predict(Gaussian(mean[:, run], cov[:, :, run]), F, Q), z[:, run], H, R[:, :, run])
        np.testing.assert_allclose(posterior.mean[:, run], one.mean, rtol=1e-12, atol=1e-12)
        np.testing.assert_allclose(posterior.cov[:, :, run], one.cov, rtol=1e-12, atol=1e-12)
        np.testing.assert_allclose(innovation.log_likelihood[run], said.log_likelihood, rtol=1e-12)


def test_covariance_stays_symmetric_and_positive_over_5000_steps(rng):
    """The gain form without symmetrising has lost four digits by then (asymmetry 2e-4 at 2000 steps)."""
    dt = 0.7
    F = np.kron(np.eye(2), [[1.0, dt], [0.0, 1.0]])
    Q = 0.01 * np.kron(np.eye(2), [[dt**3 / 3, dt**2 / 2], [dt**2 / 2, dt]])
    H = np.array([[1.0, 0.0, 0.0, 0.0], [0.0, 0.0, 1.0, 0.0]])
    R = covariance(rng, 2, 3) * 1e4
    state = Gaussian(np.zeros((4, 3)), lift(np.diag([1e6, 1e2, 1e6, 1e2]), 2, 1))
    for _ in range(5000):
        state, _ = update(predict(state, F, Q), 100.0 * rng.standard_normal((2, 3)), H, R)
    asymmetry = np.abs(state.cov - state.cov.swapaxes(0, 1)) / np.abs(state.cov).max()
    assert asymmetry.max() <= 1e-13
    assert (np.linalg.eigvalsh(np.moveaxis(state.cov, -1, 0)) > 0.0).all()


def test_absent_channels_equal_an_update_without_them(rng):
    n, m = 4, 3
    prior = Gaussian(rng.standard_normal((n, RUNS)), covariance(rng, n))
    z, H, R = rng.standard_normal((m, RUNS)), rng.standard_normal((m, n)), covariance(rng, m)
    absent = np.array([[0, 0, 1, 1, 1], [0, 1, 0, 1, 1], [0, 0, 0, 0, 1]], dtype=bool)
    posterior, innovation = update(prior, np.where(absent, np.nan, z), H, R)
    for run in range(RUNS):
        keep = ~absent[:, run]
        one = Gaussian(prior.mean[:, run], prior.cov)
        if keep.any():
            one, said = update(one, z[keep, run], H[keep], R[np.ix_(keep, keep)])
            np.testing.assert_allclose(innovation.log_likelihood[run], said.log_likelihood, rtol=1e-12)
            np.testing.assert_allclose(innovation.nis[run], said.nis, rtol=1e-12)
        else:
            assert innovation.log_likelihood[run] == pytest.approx(0.0, abs=1e-15)
            assert innovation.nis[run] == 0.0
        np.testing.assert_allclose(posterior.mean[:, run], one.mean, rtol=1e-12, atol=1e-14)
        np.testing.assert_allclose(posterior.cov[:, :, run], one.cov, rtol=1e-12, atol=1e-14)
        np.testing.assert_array_equal(np.isnan(innovation.white[:, run]), absent[:, run])


def test_merge_has_the_moments_of_the_mixture(rng):
    weights = np.array([0.2, 0.5, 0.3])
    means, covs = rng.standard_normal((2, 3)), covariance(rng, 2, 3)
    merged = merge(Mixture(weights, means, covs))
    mean = sum(weights[i] * means[:, i] for i in range(3))
    second = sum(weights[i] * (covs[:, :, i] + np.outer(means[:, i], means[:, i])) for i in range(3))
    np.testing.assert_allclose(merged.mean, mean, rtol=1e-13)
    np.testing.assert_allclose(merged.cov, second - np.outer(mean, mean), rtol=1e-12, atol=1e-13)


def two_runs(*arrays):
    """The same for two runs, whose axis is the last."""
    return [np.repeat(array[..., None], 2, axis=-1) for array in arrays]


def test_interact_is_the_textbook_mixing_with_rows_as_from(rng):
    switching = np.array([[0.9, 0.08, 0.02], [0.3, 0.6, 0.1], [0.0, 0.25, 0.75]])  # not symmetric
    weights = np.array([0.2, 0.5, 0.3])
    means, covs = 50.0 * rng.standard_normal((2, 3)), covariance(rng, 2, 3)
    mixed = interact(Mixture(weights, means, covs), switching)
    for one, among_runs in zip(mixed, interact(Mixture(*two_runs(weights, means, covs)), switching), strict=True):
        np.testing.assert_allclose(among_runs, *two_runs(one), rtol=1e-12)
    for j in range(3):
        total = sum(switching[i, j] * weights[i] for i in range(3))
        share = [switching[i, j] * weights[i] / total for i in range(3)]
        mean = sum(share[i] * means[:, i] for i in range(3))
        spread = [np.outer(means[:, i] - mean, means[:, i] - mean) for i in range(3)]
        cov = sum(share[i] * (covs[:, :, i] + spread[i]) for i in range(3))
        assert mixed.weights[j] == pytest.approx(total, rel=1e-14)
        np.testing.assert_allclose(mixed.mean[:, j], mean, rtol=1e-12)
        np.testing.assert_allclose(mixed.cov[:, :, j], cov, rtol=1e-11)  # two outer products are subtracted


def test_mixing_keeps_its_digits_far_from_the_origin(rng):
    """Second moments about the origin would lose |x|^2 eps = 2e-6 here."""
    switching = np.array([[0.9, 0.1], [0.2, 0.8]])
    weights, means, covs = np.array([0.6, 0.4]), rng.standard_normal((2, 2)), covariance(rng, 2, 2)
    near, far = (interact(Mixture(weights, means + shift, covs), switching) for shift in (0.0, 1e5))
    np.testing.assert_allclose(far.cov, near.cov, rtol=1e-9)


def test_a_model_that_cannot_be_reached_keeps_its_own_estimate(rng):
    switching = np.array([[1.0, 0.0], [1.0, 0.0]])
    means, covs = rng.standard_normal((2, 2)), covariance(rng, 2, 2)
    mixed = interact(Mixture(np.array([0.4, 0.6]), means, covs), switching)
    np.testing.assert_array_equal(mixed.weights, [1.0, 0.0])
    np.testing.assert_allclose(mixed.mean[:, 1], means[:, 1], rtol=1e-12)
    np.testing.assert_allclose(mixed.cov[:, :, 1], covs[:, :, 1], rtol=1e-12)


def test_reweigh_is_bayes_rule(rng):
    weights, likelihoods = np.array([0.5, 0.3, 0.2]), np.array([0.02, 0.5, 0.9])
    posterior, total = reweigh(weights, np.log(likelihoods))
    np.testing.assert_allclose(posterior, weights * likelihoods / (weights @ likelihoods), rtol=1e-14)
    assert total == pytest.approx(math.log(weights @ likelihoods), rel=1e-14)


def test_reweigh_ranks_far_outliers():
    """Every likelihood underflows at these exponents; their ratio is e^10."""
    posterior, total = reweigh(np.array([0.5, 0.5]), np.array([-10_000.0, -10_010.0]))
    assert posterior[0] == pytest.approx(1.0 / (1.0 + math.exp(-10.0)), rel=1e-12)
    assert total == pytest.approx(-10_000.0 + math.log(0.5 * (1.0 + math.exp(-10.0))), rel=1e-14)


def test_reweigh_keeps_a_zero_weight_at_zero():
    posterior, _ = reweigh(np.array([0.0, 1.0]), np.array([5000.0, -5000.0]))
    np.testing.assert_array_equal(posterior, [0.0, 1.0])


def test_mixture_update_is_the_update_of_each_hypothesis(rng):
    weights = np.array([0.3, 0.7])
    mixture = Mixture(weights, rng.standard_normal((3, 2)), covariance(rng, 3, 2))
    z, H, R = rng.standard_normal(2), rng.standard_normal((2, 3)), covariance(rng, 2)
    posterior, innovation = update_mixture(mixture, z, H, R)
    each = [update(Gaussian(mixture.mean[:, i], mixture.cov[:, :, i]), z, H, R) for i in range(2)]
    likelihood = np.exp([said.log_likelihood for _, said in each])
    np.testing.assert_allclose(posterior.weights, weights * likelihood / (weights @ likelihood), rtol=1e-12)
    assert innovation.log_likelihood == pytest.approx(math.log(weights @ likelihood), rel=1e-12)
    for i, (one, _) in enumerate(each):
        np.testing.assert_allclose(posterior.mean[:, i], one.mean, rtol=1e-12, atol=1e-14)
        np.testing.assert_allclose(posterior.cov[:, :, i], one.cov, rtol=1e-12, atol=1e-14)
    matched = merge(Mixture(weights, mixture.mean, mixture.cov))  # NIS is that of the moment-matched prediction
    _, said = update(matched, z, H, R)
    np.testing.assert_allclose(innovation.white, said.white, rtol=1e-11)


def test_noise_may_differ_between_hypotheses_and_runs(rng):
    """Hypotheses about R, the shape of the switching-noise filter."""
    mean, cov = rng.standard_normal((2, RUNS)), covariance(rng, 2)
    factors, R = np.array([1.0, 900.0]), np.array([[0.5]])
    H, z = np.array([[1.0, 0.0]]), rng.standard_normal((1, RUNS))
    weights = np.array([[0.8], [0.2]])
    mixture = Mixture(weights, np.repeat(mean[:, None], 2, axis=1), np.repeat(cov[:, :, None, None], 2, axis=2))
    posterior, _ = update_mixture(mixture, z, H, (R[:, :, None] * factors)[..., None])
    for run in range(RUNS):
        each = [update(Gaussian(mean[:, run], cov), z[:, run], H, factor * R) for factor in factors]
        likelihood = np.exp([said.log_likelihood for _, said in each])
        np.testing.assert_allclose(
            posterior.weights[:, run], weights[:, 0] * likelihood / (weights[:, 0] @ likelihood), rtol=1e-12
        )
        for i, (one, _) in enumerate(each):
            np.testing.assert_allclose(posterior.mean[:, i, run], one.mean, rtol=1e-12, atol=1e-13)
