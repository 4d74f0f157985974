"""The interacting multiple model filter against a textbook cycle in scalar loops, and against its limits."""

from __future__ import annotations

import math

import numpy as np
import pytest

from tracking.gaussian import Gaussian, Mixture, merge
from tracking.measurement import LinearMeasurement
from tracking.motion import ConstantVelocity, CoordinatedTurn
from tracking.packed import pack
from tracking.track import Measurements, track
from tracking.trackers.imm import InteractingMultipleModel, ModelSet, improved_set, published_set, switching_over
from tracking.trackers.imm_published import PublishedModels
from tracking.trackers.kalman import Kalman

POSITION = LinearMeasurement(((1.0, 0.0, 0.0, 0.0), (0.0, 0.0, 1.0, 0.0)))
PRIOR = Gaussian(np.array([9000.0, -60.0, 500.0, 30.0]), np.diag([1e4, 25.0, 1e4, 25.0]))
MODELS = (CoordinatedTurn(-0.045, 0.1), CoordinatedTurn(0.02, 0.3), ConstantVelocity(0.01))
NOT_SYMMETRIC = ((0.9, 0.08, 0.02), (0.3, 0.6, 0.1), (0.0, 0.25, 0.75))


def record(rng, k=60, runs=None, dt=0.7):
    """Positions of a target that flies straight, then turns, with noise of 100 m."""
    batch = () if runs is None else (runs,)
    course = 2.7 + 0.04 * np.maximum(np.arange(k) * dt - 15.0, 0.0)
    steps = 67.0 * dt * np.stack([np.cos(course), np.sin(course)], axis=1)
    truth = PRIOR.mean[[0, 2]] + np.cumsum(steps, axis=0)
    z = truth.reshape(k, 2, *(1,) * len(batch)) + 100.0 * rng.standard_normal((k, 2, *batch))
    R = np.broadcast_to(1e4 * np.array([[1.0, 0.2], [0.2, 0.8]]), (k, 2, 2)).reshape(k, 2, 2, *(1,) * len(batch))
    time = np.arange(k) * dt
    return Measurements(("radar.north", "radar.east"), time, time, z, R)


def textbook_cycle(weights, means, covs, models, switching, dt, z, H, R):
    """One cycle in loops over models, matrices by model, likelihoods by determinant: no code in common."""
    count = len(models)
    predicted = [sum(switching[i][j] * weights[i] for i in range(count)) for j in range(count)]
    new_means, new_covs, likelihoods = [], [], []
    for j, model in enumerate(models):
        share = [switching[i][j] * weights[i] / predicted[j] for i in range(count)]
        x = sum(share[i] * means[i] for i in range(count))
        P = sum(share[i] * (covs[i] + np.outer(means[i] - x, means[i] - x)) for i in range(count))
        F, Q, _ = model.transition(dt, None)
        x, P = F @ x, F @ P @ F.T + Q
        S, y = H @ P @ H.T + R, z - H @ x
        K = P @ H.T @ np.linalg.inv(S)
        new_means.append(x + K @ y)
        new_covs.append(P - K @ S @ K.T)
        likelihoods.append(math.exp(-0.5 * y @ np.linalg.solve(S, y)) / (2.0 * math.pi * math.sqrt(np.linalg.det(S))))
    total = sum(predicted[j] * likelihoods[j] for j in range(count))
    return [predicted[j] * likelihoods[j] / total for j in range(count)], new_means, new_covs, math.log(total)


def test_every_cycle_is_the_textbook_cycle_with_a_switching_matrix_that_is_not_symmetric():
    rng = np.random.default_rng(11)
    measurements = record(rng, 40)
    tracker = InteractingMultipleModel(POSITION, ModelSet(MODELS, NOT_SYMMETRIC, (0.5, 0.2, 0.3)))
    state = tracker.begin(PRIOR)
    H = np.array(POSITION.H)
    for k in range(40):
        weights, means = list(state.weights), [state.mean[:, i] for i in range(3)]
        covs = [state.cov[:, :, i] for i in range(3)]
        judge = textbook_cycle(
            weights, means, covs, MODELS, NOT_SYMMETRIC, 0.7, measurements.z[k], H, measurements.R[k]
        )
        state, innovation = tracker.step(state, 0.7, measurements.z[k], measurements.R[k])
        np.testing.assert_allclose(state.weights, judge[0], rtol=1e-12, atol=1e-14)
        np.testing.assert_allclose(state.mean, np.transpose(judge[1]), rtol=1e-12, atol=1e-9)  # 1e-13 of 9 km
        np.testing.assert_allclose(state.cov, np.moveaxis(judge[2], 0, -1), rtol=1e-12, atol=1e-12 * np.max(judge[2]))
        assert innovation.log_likelihood == pytest.approx(judge[3], rel=1e-12)
        assert state.weights.sum() == pytest.approx(1.0, abs=1e-12)


def test_one_model_is_the_kalman_filter():
    measurements = record(np.random.default_rng(12))
    one = InteractingMultipleModel(POSITION, ModelSet(MODELS[:1], ((1.0,),), (1.0,)))
    several, single = track(one, measurements, PRIOR), track(Kalman(POSITION, MODELS[0]), measurements, PRIOR)
    for ours, judge in zip(several[2:7], single[2:7], strict=True):
        np.testing.assert_allclose(ours, judge, rtol=1e-11, atol=1e-11)


@pytest.mark.parametrize("certain", [0, 1, 2])
def test_without_switching_a_certain_model_is_its_own_kalman_filter(certain):
    measurements = record(np.random.default_rng(13))
    start = tuple(float(i == certain) for i in range(3))
    identity = tuple(tuple(float(i == j) for j in range(3)) for i in range(3))
    several = track(InteractingMultipleModel(POSITION, ModelSet(MODELS, identity, start)), measurements, PRIOR)
    single = track(Kalman(POSITION, MODELS[certain]), measurements, PRIOR)
    np.testing.assert_allclose(several.mean, single.mean, rtol=1e-10)
    np.testing.assert_allclose(several.cov, single.cov, rtol=1e-10, atol=1e-9)
    np.testing.assert_allclose(several.log_likelihood, single.log_likelihood, rtol=1e-10)


def test_identical_models_are_one_filter_and_their_probabilities_follow_the_chain():
    measurements = record(np.random.default_rng(14))
    start = (0.6, 0.3, 0.1)
    same = track(
        InteractingMultipleModel(POSITION, ModelSet(MODELS[1:2] * 3, NOT_SYMMETRIC, start)), measurements, PRIOR
    )
    single = track(Kalman(POSITION, MODELS[1]), measurements, PRIOR)
    np.testing.assert_allclose(same.mean, single.mean, rtol=1e-10)
    np.testing.assert_allclose(same.cov, single.cov, rtol=1e-10, atol=1e-8)
    expected = np.array(start)
    for k, probabilities in enumerate(same.model_probabilities):
        expected = expected if k == 0 else expected @ np.array(NOT_SYMMETRIC)
        np.testing.assert_allclose(probabilities, expected, rtol=1e-10)


def test_equal_rows_forget_the_model_at_every_step():
    """Independent models: every filter restarts from the merged estimate."""
    measurements = record(np.random.default_rng(15), 20)
    row = (0.2, 0.3, 0.5)
    tracker = InteractingMultipleModel(POSITION, ModelSet(MODELS, (row,) * 3, row))
    state = tracker.begin(PRIOR)
    for k in range(20):
        merged = merge(tracker.estimate(state))
        restarted = pack(
            Mixture(
                np.array(row), np.repeat(merged.mean[:, None], 3, axis=1), np.repeat(merged.cov[:, :, None], 3, axis=2)
            )
        )
        same, _ = tracker.step(restarted, 0.7, measurements.z[k], measurements.R[k])
        state, _ = tracker.step(state, 0.7, measurements.z[k], measurements.R[k])
        np.testing.assert_allclose(state.weights, same.weights, rtol=1e-11)
        np.testing.assert_allclose(state.mean, same.mean, rtol=1e-11)
        np.testing.assert_allclose(state.cov, same.cov, rtol=1e-10, atol=1e-9)


@pytest.mark.parametrize("model_set", [published_set(0.3), improved_set()], ids=["published", "improved"])
def test_ensemble_is_the_single_runs(model_set):
    """Relative to the size of each quantity: position errors of 1e-12 of 9 km are 1e-8 m."""
    measurements = record(np.random.default_rng(16), 50, runs=4)
    measurements.z[7, :, 1] = np.nan
    measurements.z[9, 0, 2] = np.nan
    measurements.z[12] = np.nan
    tracker = InteractingMultipleModel(POSITION, model_set)
    many = track(tracker, measurements, PRIOR)
    for run in range(4):
        part = measurements.runs(slice(run, run + 1))
        alone = Measurements(part.channels, part.time, part.arrival, part.z[..., 0], part.R[..., 0])
        one = track(tracker, alone, PRIOR)
        for ours, judge in zip(many[2:8], one[2:8], strict=True):
            scale = np.nanmax(np.abs(judge))
            np.testing.assert_allclose(ours[..., run], judge, rtol=1e-12, atol=1e-12 * scale)


def test_a_mirrored_approach_gives_the_mirrored_estimate():
    measurements = record(np.random.default_rng(17), 80, runs=3)
    mirror = np.array([1.0, 1.0, -1.0, -1.0])
    tracker = InteractingMultipleModel(POSITION, improved_set())
    R = measurements.R * np.array([[1.0, -1.0], [-1.0, 1.0]])[None, :, :, None]
    z = measurements.z * mirror[[0, 2]][None, :, None]
    mirrored = Measurements(measurements.channels, measurements.time, measurements.arrival, z, R)
    right = track(tracker, measurements, PRIOR)
    left = track(tracker, mirrored, Gaussian(PRIOR.mean * mirror, PRIOR.cov))
    np.testing.assert_allclose(left.mean * mirror[None, :, None], right.mean, rtol=1e-9, atol=1e-9)
    swapped = left.model_probabilities[:, [0, 1, 3, 2]]
    np.testing.assert_allclose(swapped, right.model_probabilities, rtol=1e-9, atol=1e-12)


def test_an_outlier_of_50_sigma_leaves_the_probabilities_finite_and_ranked():
    """exp(-1250) underflows; the turn whose prediction is nearest must gain, not the weights of before."""
    measurements = record(np.random.default_rng(18), 30)
    measurements.z[20] += [5000.0, 5000.0]
    result = track(InteractingMultipleModel(POSITION, published_set(0.3)), measurements, PRIOR)
    assert np.isfinite(result.mean).all()
    np.testing.assert_allclose(result.model_probabilities.sum(axis=1), 1.0, rtol=1e-12)
    assert result.log_likelihood[20] < -200.0


def test_a_model_with_probability_zero_stays_finite():
    switching = ((0.9, 0.1, 0.0), (0.2, 0.8, 0.0), (0.5, 0.5, 0.0))
    tracker = InteractingMultipleModel(POSITION, ModelSet(MODELS, switching, (0.5, 0.5, 0.0)))
    result = track(tracker, record(np.random.default_rng(19)), PRIOR)
    assert np.isfinite(result.mean).all()
    np.testing.assert_array_equal(result.model_probabilities[:, 2], 0.0)


def test_no_time_no_switching():
    tracker = InteractingMultipleModel(POSITION, published_set())
    state = tracker.begin(PRIOR)
    still, innovation = tracker.step(state, 0.0, None, None)
    assert innovation is None
    np.testing.assert_array_equal(still.weights, state.weights)


def test_the_published_start_sums_to_one_and_truncates_to_the_printed_digits():
    start = published_set().probabilities
    assert sum(start) == pytest.approx(1.0, abs=1e-15)
    assert [math.floor(100 * value) for value in start] == [53, 33, 13]


def test_bad_sets_are_refused_with_a_sentence():
    good = published_set()
    with pytest.raises(ValueError, match=r"row 1 of the switching matrix sums to 1\.01"):
        InteractingMultipleModel(
            POSITION, good._replace(switching=((1.0, 0.0, 0.0), (0.02, 0.98, 0.01), (0.0, 0.0, 1.0)))
        )
    with pytest.raises(ValueError, match="initial probabilities sum to"):
        InteractingMultipleModel(POSITION, good._replace(probabilities=(0.53, 0.33, 0.13)))
    with pytest.raises(ValueError, match="must not be negative"):
        InteractingMultipleModel(POSITION, good._replace(probabilities=(1.1, -0.1, 0.0)))
    with pytest.raises(ValueError, match="3 rows of 3"):
        InteractingMultipleModel(POSITION, good._replace(switching=((0.5, 0.5), (0.5, 0.5))))
    with pytest.raises(ValueError, match="3 initial probabilities"):
        InteractingMultipleModel(POSITION, good._replace(probabilities=(1.0,)))
    with pytest.raises(ValueError, match="at least one model"):
        InteractingMultipleModel(POSITION, ModelSet((), (), ()))


def test_switching_holds_over_its_period_and_over_any_other_time():
    """Two half periods are one, three periods are the cube, and rows stay probabilities.

    Two half periods reach from one turn to the other by way of straight flight, which the matrix itself excludes.
    """
    model_set = improved_set()
    once = np.array(model_set.switching)
    half = switching_over(model_set, 0.35)
    np.testing.assert_allclose(half @ half, once, atol=2e-5)
    np.testing.assert_allclose(switching_over(model_set, 2.1), once @ once @ once, rtol=1e-14)
    for dt in (0.01, 0.35, 0.7, 4.0, 60.0):
        matrix = switching_over(model_set, dt)
        assert (matrix >= 0.0).all()
        np.testing.assert_allclose(matrix.sum(axis=1), 1.0, rtol=1e-12)
    with pytest.raises(ValueError, match="period of the switching matrix"):
        InteractingMultipleModel(POSITION, model_set._replace(period=0.0))


def test_the_published_kind_is_the_published_set():
    measurements = record(np.random.default_rng(21), 20)
    kind = track(PublishedModels(POSITION, acceleration_density=0.3), measurements, PRIOR)
    judge = track(InteractingMultipleModel(POSITION, published_set(0.3)), measurements, PRIOR)
    np.testing.assert_array_equal(kind.mean, judge.mean)
    with pytest.raises(ValueError, match="acceleration_density must not be negative"):
        PublishedModels(POSITION, acceleration_density=-0.1)
