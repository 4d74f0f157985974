"""Smoothers judged by the joint Gaussian of the whole record, by filterpy, by truncated records and by enumeration."""

from __future__ import annotations

import itertools

import numpy as np
import pytest

from tracking.consistency import normalised_error
from tracking.gaussian import Gaussian
from tracking.intervals import gain
from tracking.measurement import LinearMeasurement
from tracking.motion import AlongTrackAcceleration, ConstantVelocity, CoordinatedTurn
from tracking.smoothing import smooth, smooth_fixed_lag, smooth_models
from tracking.track import Measurements, track
from tracking.trackers.imm import InteractingMultipleModel, ModelSet, improved_set
from tracking.trackers.kalman import Kalman

POSITION = LinearMeasurement(((1.0, 0.0, 0.0, 0.0), (0.0, 0.0, 1.0, 0.0)))
H = np.array(POSITION.H)
PRIOR = Gaussian(np.array([0.0, 70.0, 0.0, 0.0]), np.diag([400.0, 25.0, 400.0, 25.0]))
STRAIGHT = ConstantVelocity(0.5)
TURNING = ModelSet(
    (STRAIGHT, CoordinatedTurn(0.06, 0.5), CoordinatedTurn(-0.06, 0.5)),
    ((0.9, 0.06, 0.04), (0.1, 0.85, 0.05), (0.12, 0.03, 0.85)),
    (0.6, 0.2, 0.2),
)


def drawn(model_set: ModelSet, runs: int, epochs: int, seed: int) -> tuple[np.ndarray, Measurements]:
    """Truth (k, 4, N) drawn from a chain of models, and measurements of 30 m at uneven epochs."""
    generator = np.random.default_rng(seed)
    switching, start = np.array(model_set.switching), np.array(model_set.probabilities)
    mode = generator.choice(len(start), size=runs, p=start)
    x = PRIOR.mean[:, None] + np.sqrt(np.diag(PRIOR.cov))[:, None] * generator.standard_normal((4, runs))
    time = np.cumsum(np.where(np.arange(epochs) % 3 == 1, 0.7, 1.4))
    truth = []
    for dt in np.diff(time, prepend=0.0):
        mode = (generator.random(runs)[:, None] > switching[mode].cumsum(axis=1)).sum(axis=1)
        pairs = [model.transition(dt, None) for model in model_set.models]
        F, root = np.stack([p.F for p in pairs])[mode], np.stack([np.linalg.cholesky(p.Q) for p in pairs])[mode]
        x = np.einsum("Nij,jN->iN", F, x) + np.einsum("Nij,jN->iN", root, generator.standard_normal((4, runs)))
        truth.append(x)
    truth = np.stack(truth)
    z = truth[:, [0, 2]] + 30.0 * generator.standard_normal((epochs, 2, runs))
    R = np.broadcast_to(900.0 * np.eye(2), (epochs, 2, 2))
    return truth, Measurements(("a", "b"), time, time, z, R)


ONE = ModelSet((STRAIGHT,), ((1.0,),), (1.0,))


def joint_posterior(measurements: Measurements, run: int, transitions) -> tuple[np.ndarray, np.ndarray, float]:
    """Mean (k, 4), covariance (k, 4, 4) and log-likelihood of all states at once, from their joint Gaussian."""
    steps = len(transitions)
    mean, cov = np.zeros((steps, 4)), np.zeros((steps, 4, steps, 4))
    x, P = PRIOR.mean, PRIOR.cov
    for k, (F, Q) in enumerate(transitions):
        cov[k, :, :k] = np.einsum("ij,jlm->ilm", F, cov[k - 1][:, :k]) if k else 0.0
        cov[:k, :, k] = np.moveaxis(cov[k, :, :k], 0, -1)
        x, P = F @ x, F @ P @ F.T + Q
        mean[k], cov[k, :, k] = x, P
    cov = cov.reshape(4 * steps, 4 * steps)
    observe = np.kron(np.eye(steps), H)
    seen = np.isfinite(measurements.z[:, :, run]).ravel()
    observe, v = observe[seen], (measurements.z[:, :, run].ravel() - observe @ mean.ravel())[seen]
    S = observe @ cov @ observe.T + 900.0 * np.eye(seen.sum())
    K = cov @ observe.T @ np.linalg.inv(S)
    posterior = cov - K @ S @ K.T
    log = -0.5 * (v @ np.linalg.solve(S, v) + np.linalg.slogdet(2 * np.pi * S)[1])
    blocks = posterior.reshape(steps, 4, steps, 4)
    return mean + (K @ v).reshape(steps, 4), np.stack([blocks[k, :, k] for k in range(steps)]), log


def matrices(measurements: Measurements, model=STRAIGHT):
    return [model.transition(dt, None)[:2] for dt in np.diff(measurements.time, prepend=0.0)]


def test_smoothing_is_the_conditional_of_the_joint_gaussian():
    """Also with absent values and uneven epochs; 1e-8 of a 60-dimensional inverse."""
    _, measurements = drawn(ONE, 2, 15, seed=1)
    measurements.z[4] = np.nan
    measurements.z[7, 0, 1] = np.nan
    smoothed = smooth(track(Kalman(POSITION, STRAIGHT), measurements, PRIOR, start=0.0), STRAIGHT)
    for run in range(2):
        mean, cov, _ = joint_posterior(measurements, run, matrices(measurements))
        np.testing.assert_allclose(smoothed.mean[..., run], mean, rtol=1e-8, atol=1e-8)
        np.testing.assert_allclose(np.broadcast_to(smoothed.cov, (15, 4, 4, 2))[..., run], cov, rtol=1e-7, atol=1e-7)


def test_smoothing_against_filterpy():
    filterpy = pytest.importorskip("filterpy.kalman")
    _, measurements = drawn(ONE, 1, 20, seed=2)
    filtered = track(Kalman(POSITION, STRAIGHT), measurements, PRIOR, start=0.0)
    judge = filterpy.KalmanFilter(dim_x=4, dim_z=2)
    pairs = matrices(measurements)
    means, covs, _, _ = judge.rts_smoother(
        filtered.mean[..., 0],
        np.broadcast_to(filtered.cov, (20, 4, 4, 1))[..., 0],
        Fs=[F for F, _ in pairs[1:]] + [pairs[-1][0]],
        Qs=[Q for _, Q in pairs[1:]] + [pairs[-1][1]],
    )
    smoothed = smooth(filtered, STRAIGHT)
    if np.abs(means - smoothed.mean[..., 0]).max() > 1e-3:  # older releases take F and Q of the later epoch
        means, covs, _, _ = judge.rts_smoother(
            filtered.mean[..., 0],
            np.broadcast_to(filtered.cov, (20, 4, 4, 1))[..., 0],
            Fs=[F for F, _ in pairs],
            Qs=[Q for _, Q in pairs],
        )
    np.testing.assert_allclose(smoothed.mean[..., 0], means, rtol=1e-9, atol=1e-8)
    np.testing.assert_allclose(np.broadcast_to(smoothed.cov, (20, 4, 4, 1))[..., 0], covs, rtol=1e-8, atol=1e-8)


@pytest.mark.parametrize("lag", [0, 1, 4, 30])
def test_fixed_lag_is_smoothing_of_the_record_so_far(lag):
    _, measurements = drawn(ONE, 2, 12, seed=3)
    filtered = track(Kalman(POSITION, STRAIGHT), measurements, PRIOR, start=0.0)
    lagged = smooth_fixed_lag(filtered, STRAIGHT, lag)
    for k in range(12):
        until = slice(0, min(k + lag, 11) + 1)
        so_far = filtered._replace(time=filtered.time[until], mean=filtered.mean[until], cov=filtered.cov[until])
        expected = smooth(so_far, STRAIGHT)
        np.testing.assert_allclose(lagged.mean[k], expected.mean[k], rtol=1e-12, atol=1e-12)
        np.testing.assert_allclose(lagged.cov[k], expected.cov[k], rtol=1e-12, atol=1e-12)
    with pytest.raises(ValueError, match="negative"):
        smooth_fixed_lag(filtered, STRAIGHT, -1)


@pytest.mark.parametrize("motion", [STRAIGHT, AlongTrackAcceleration(-0.5, 0.5)], ids=["straight", "slowing"])
@pytest.mark.parametrize("lag", [None, 0, 3])
def test_one_model_is_the_plain_smoother(motion, lag):
    """1e-5 relative: the diffuse start of the backward pass is 1e6 times the filtered covariance."""
    _, measurements = drawn(ONE, 3, 25, seed=4)
    measurements.z[6] = np.nan
    filtered = track(Kalman(POSITION, motion), measurements, PRIOR, start=0.0)
    plain = smooth(filtered, motion) if lag is None else smooth_fixed_lag(filtered, motion, lag)
    tracker = InteractingMultipleModel(POSITION, ModelSet((motion,), ((1.0,),), (1.0,)))
    several = smooth_models(tracker, measurements, PRIOR, start=0.0, lag=lag)
    sigma = np.sqrt(np.einsum("kii...->ki...", plain.cov))
    # where the motion depends on the state, the plain smoother linearises at the same filtered mean
    assert (np.abs(several.mean - plain.mean) < 1e-5 * sigma).all()
    np.testing.assert_allclose(several.cov, np.broadcast_to(plain.cov, several.cov.shape), rtol=1e-5, atol=1e-5)


def test_several_models_against_enumeration():
    """Five epochs, 243 mode histories, each from its joint Gaussian: within 0.3 exact standard deviations on average.

    The filter at the same epochs is judged by the same yardstick, and must be farther off: it lacks the future.
    """
    runs = 4
    _, measurements = drawn(TURNING, runs, 5, seed=5)
    tracker = InteractingMultipleModel(POSITION, TURNING)
    smoothed = smooth_models(tracker, measurements, PRIOR, start=0.0)
    filtered = track(tracker, measurements, PRIOR, start=0.0)
    each = [matrices(measurements, model) for model in TURNING.models]
    off, filtered_off, mode_off = [], [], []
    for run in range(runs):
        logs, means, covs, modes = [], [], [], []
        for history in itertools.product(range(3), repeat=5):
            chance = np.array(TURNING.probabilities) @ np.array(TURNING.switching)[:, history[0]]
            chance *= np.prod([TURNING.switching[a][b] for a, b in itertools.pairwise(history)])
            mean, cov, log = joint_posterior(measurements, run, [each[m][k] for k, m in enumerate(history)])
            logs.append(np.log(chance) + log)
            means.append(mean)
            covs.append(np.einsum("kii->ki", cov))
            modes.append(np.eye(3)[list(history)])
        weights = np.exp(np.array(logs) - max(logs))
        weights /= weights.sum()
        exact = np.einsum("h,hki->ki", weights, means)
        variance = np.einsum("h,hki->ki", weights, np.array(covs) + (np.array(means) - exact) ** 2)
        off.append(np.abs(smoothed.mean[..., run] - exact) / np.sqrt(variance))
        filtered_off.append(np.abs(filtered.mean[..., run] - exact) / np.sqrt(variance))
        mode_off.append(np.abs(smoothed.model_probabilities[..., run] - np.einsum("h,hkm->km", weights, modes)))
    assert np.mean(off) < 0.3
    assert np.mean(off) < 0.5 * np.mean(filtered_off)
    assert np.max(mode_off) < 0.3


@pytest.fixture(scope="module")
def turning():
    truth, measurements = drawn(TURNING, 150, 80, seed=6)
    return truth, measurements, track(InteractingMultipleModel(POSITION, TURNING), measurements, PRIOR, start=0.0)


def test_smoothing_pays_and_stays_consistent(turning):
    """On its own model; the gain's interval is paired, the ANEES of merged mixtures is allowed 0.8 to 1.15."""
    truth, measurements, filtered = turning
    smoothed = smooth_models(InteractingMultipleModel(POSITION, TURNING), measurements, PRIOR, start=0.0)

    def squares(record):
        return ((record.mean - truth)[:, [0, 2]] ** 2).sum(axis=1).mean(axis=0)

    assert gain(squares(filtered), squares(smoothed)).low > 1.3
    nees = [normalised_error(Gaussian(*pair), x) for *pair, x in zip(smoothed.mean, smoothed.cov, truth, strict=True)]
    assert 0.8 < np.mean(nees) / 4 < 1.15
    assert np.linalg.eigvalsh(np.moveaxis(smoothed.cov, (1, 2), (-2, -1))).min() > 0.0
    np.testing.assert_allclose(smoothed.model_probabilities.sum(axis=1), 1.0, rtol=1e-12)


def test_more_lag_is_better(turning):
    truth, measurements, filtered = turning
    tracker, few = InteractingMultipleModel(POSITION, TURNING), slice(0, 50)
    lagged = [smooth_models(tracker, measurements.runs(few), PRIOR, start=0.0, lag=lag) for lag in (0, 2, 6)]
    np.testing.assert_allclose(lagged[0].mean, filtered.mean[..., few], rtol=1e-12)
    errors = [((record.mean - truth[..., few])[:, [0, 2]] ** 2).mean() for record in lagged]
    assert errors[0] > 1.2 * errors[1] > 1.44 * errors[2]


def test_runs_are_independent_and_a_state_dependent_set_passes():
    _, measurements = drawn(ONE, 3, 15, seed=7)
    tracker = InteractingMultipleModel(POSITION, improved_set())
    together = smooth_models(tracker, measurements, PRIOR, start=0.0)
    for run in range(3):
        alone = smooth_models(tracker, measurements.runs(slice(run, run + 1)), PRIOR, start=0.0)
        np.testing.assert_allclose(alone.mean[..., 0], together.mean[..., run], rtol=1e-10, atol=1e-9)


def test_two_plots_at_one_time():
    """A second plot at the same epoch is one more measurement, not one more motion."""
    _, measurements = drawn(ONE, 1, 6, seed=8)
    time = np.repeat(measurements.time, 2)
    double = Measurements(
        ("a", "b"), time, time, np.repeat(measurements.z, 2, axis=0), np.repeat(measurements.R, 2, axis=0)
    )
    halved = Measurements(("a", "b"), measurements.time, measurements.time, measurements.z, measurements.R / 2)
    tracker = InteractingMultipleModel(POSITION, ONE)
    twice = smooth_models(tracker, double, PRIOR, start=0.0)
    once = smooth_models(tracker, halved, PRIOR, start=0.0)
    np.testing.assert_allclose(twice.mean[1::2], once.mean, rtol=1e-6, atol=1e-4)
    kalman = smooth(track(Kalman(POSITION, STRAIGHT), double, PRIOR, start=0.0), STRAIGHT)
    np.testing.assert_allclose(kalman.mean[::2], once.mean, rtol=1e-6, atol=1e-4)
