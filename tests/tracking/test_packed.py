"""Mixtures as one array against the general algebra, for what all runs share and for what they do not."""

from __future__ import annotations

import numpy as np
import pytest

from tracking import gaussian
from tracking.gaussian import Gaussian, Mixture, lift
from tracking.packed import interact, pack, predict, predict_shared, shared_motion, unpack, update

N, MODELS, CHANNELS = 4, 3, 2
SWITCHING = np.array([[0.9, 0.08, 0.02], [0.3, 0.6, 0.1], [0.0, 0.25, 0.75]])  # not symmetric
BATCHES = [(), (1,), (7,)]


@pytest.fixture
def rng():
    return np.random.default_rng(20261129)


def covariance(rng, n, *batch):
    A = rng.standard_normal((n, n, *batch))
    return np.einsum("ij...,kj...->ik...", A, A) + 0.1 * lift(np.eye(n), 2, len(batch))


def mixture(rng, batch):
    weights = rng.random((MODELS, *batch))
    return Mixture(
        weights / weights.sum(axis=0), rng.standard_normal((N, MODELS, *batch)), covariance(rng, N, MODELS, *batch)
    )


def constant(matrix):
    matrix.flags.writeable = False
    return matrix


def assert_alike(packed, general):
    """Of numbers near one: agreement to some hundred roundings, and symmetry to the last bit."""
    for ours, theirs in zip(unpack(packed), general, strict=True):
        np.testing.assert_allclose(ours, theirs, rtol=1e-11, atol=1e-12)
    np.testing.assert_array_equal(packed.cov, packed.cov.swapaxes(0, 1))


@pytest.mark.parametrize("batch", BATCHES)
def test_what_is_packed_is_unpacked_as_it_was(rng, batch):
    whole = mixture(rng, batch)
    for ours, theirs in zip(unpack(pack(whole)), whole, strict=True):
        np.testing.assert_array_equal(ours, theirs)


@pytest.mark.parametrize("batch", BATCHES)
def test_mixing(rng, batch):
    whole = mixture(rng, batch)
    assert_alike(interact(pack(whole), SWITCHING), gaussian.interact(whole, SWITCHING))


@pytest.mark.parametrize("batch", BATCHES)
def test_prediction_by_a_motion_that_all_runs_share(rng, batch):
    whole, F, Q = mixture(rng, batch), rng.standard_normal((N, N, MODELS)), covariance(rng, N, MODELS)
    general = gaussian.predict(Gaussian(whole.mean, whole.cov), *(lift(matrix, 3, len(batch)) for matrix in (F, Q)))
    assert_alike(predict_shared(pack(whole), shared_motion(F, Q)), (whole.weights, *general))


@pytest.mark.parametrize("batch", BATCHES)
def test_prediction_by_a_motion_of_each_run_with_an_input(rng, batch):
    whole, F, Q = mixture(rng, batch), rng.standard_normal((N, N, MODELS, *batch)), covariance(rng, N, MODELS, *batch)
    u = rng.standard_normal((N, MODELS, *batch))
    general = gaussian.predict(Gaussian(whole.mean, whole.cov), F, Q, u)
    assert_alike(predict(pack(whole), F, Q, u), (whole.weights, *general))


@pytest.mark.parametrize("seen", ["all", "R of all runs", "H of each run", "one channel absent", "nothing"])
@pytest.mark.parametrize("batch", BATCHES)
def test_update(rng, batch, seen):
    whole = mixture(rng, batch)
    z, H = rng.standard_normal((CHANNELS, *batch)), rng.standard_normal((CHANNELS, N))
    R = covariance(rng, CHANNELS, *((1,) * len(batch) if "R" in seen else batch))
    if "absent" in seen:
        z[(1, *(0,) * len(batch))] = np.nan
    if seen == "nothing":
        z[:] = np.nan
    H = H[:, :, None] * (1.0 + rng.random(batch)) if "H" in seen and batch else constant(H)
    updated, innovation = update(pack(whole), z, H, R)
    general, expected = gaussian.update_mixture(whole, z, H, R)
    assert_alike(updated, general)
    for ours, theirs in zip(innovation, expected, strict=True):
        np.testing.assert_allclose(ours, theirs, rtol=1e-10, atol=1e-12)


def test_a_prior_of_all_runs_meets_their_measurements(rng):
    whole, z = mixture(rng, (1,)), rng.standard_normal((CHANNELS, 7))
    H, R = constant(rng.standard_normal((CHANNELS, N))), covariance(rng, CHANNELS, 7)
    assert_alike(update(pack(whole), z, H, R)[0], gaussian.update_mixture(whole, z, H, R)[0])


def test_a_measurement_that_is_written_to_is_not_taken_for_what_it_was(rng):
    whole, z, R = mixture(rng, ()), rng.standard_normal(CHANNELS), covariance(rng, CHANNELS)
    H = rng.standard_normal((CHANNELS, N))
    first, _ = update(pack(whole), z, constant(H), R)
    H.flags.writeable = True
    H *= 2.0
    again, _ = update(pack(whole), 2.0 * z, constant(H), 4.0 * R)  # the same measurement in another unit
    np.testing.assert_allclose(again.mean, first.mean, rtol=1e-12)
