"""Association judged by the textbook's own formulas, by its limits and by the tracks it keeps."""

from __future__ import annotations

import math

import numpy as np
import pytest

from tracking.association import ProbabilisticDataAssociation, blend, clutter_density
from tracking.gaussian import Gaussian, Mixture, merge
from tracking.measurement import LinearMeasurement
from tracking.motion import ConstantVelocity, planar_constant_velocity
from tracking.trackers.gated import Gated
from tracking.trackers.huber import Huber
from tracking.trackers.imm import InteractingMultipleModel, published_set
from tracking.trackers.kalman import Kalman

POSITION = LinearMeasurement(((1.0, 0.0, 0.0, 0.0), (0.0, 0.0, 1.0, 0.0)))
H = np.array(POSITION.H)
R = 400.0 * np.eye(2)[..., None]
KALMAN = Kalman(POSITION, ConstantVelocity(0.3))
IMM = InteractingMultipleModel(POSITION, published_set(0.3))
PRIOR = Gaussian(np.array([0.0, 70.0, 0.0, 0.0])[:, None], np.diag([400.0, 25.0, 900.0, 25.0])[..., None])
CLUTTER = 1e-4  # per m2


def candidates(runs: int, count: int, seed: int) -> np.ndarray:
    """(c, 2, N) around the prediction after 1 s."""
    generator = np.random.default_rng(seed)
    return np.array([70.0, 0.0])[:, None] + 60.0 * generator.standard_normal((count, 2, runs))


def textbook(mean, cov, z, detection, gate, density):
    """Bar-Shalom's update of one run of a Kalman filter with plots z (c, 2)."""
    F, Q = planar_constant_velocity(1.0, 0.3, 0.3)
    x, P = F @ mean, F @ cov @ F.T + Q
    S = H @ P @ H.T + R[..., 0]
    K = P @ H.T @ np.linalg.inv(S)
    v = z - H @ x
    square = np.einsum("ci,ij,cj->c", v, np.linalg.inv(S), v)
    v = v[square <= -2.0 * math.log(1.0 - gate)]  # chi-square of two channels
    square = square[square <= -2.0 * math.log(1.0 - gate)]
    e = np.exp(-0.5 * square)
    b = density * math.sqrt(np.linalg.det(2 * np.pi * S)) * (1.0 - detection * gate) / detection
    beta, none = e / (b + e.sum()), b / (b + e.sum())
    combined = beta @ v
    spread = K @ (np.einsum("c,ci,cj->ij", beta, v, v) - np.outer(combined, combined)) @ K.T
    return x + K @ combined, none * P + (1.0 - none) * (P - K @ S @ K.T) + spread


def test_kalman_filter_against_the_textbook():
    """Two ways to one posterior; 1e-9 relative is rounding."""
    z = candidates(50, 5, seed=1)
    tracker = ProbabilisticDataAssociation(KALMAN, CLUTTER, 0.9, 0.99)
    state, _ = tracker.step(tracker.begin(PRIOR), 1.0, z, R)
    for run in range(50):
        mean, cov = textbook(PRIOR.mean[:, 0], PRIOR.cov[..., 0], z[..., run], 0.9, 0.99, CLUTTER)
        np.testing.assert_allclose(state.mean[:, run], mean, rtol=1e-9, atol=1e-9)
        np.testing.assert_allclose(state.cov[..., run], cov, rtol=1e-9, atol=1e-7)


def test_imm_against_the_joint_posterior_of_model_and_plot():
    """Every model conditioned on every plot, in plain loops; moments within each model."""
    z = candidates(3, 3, seed=2)
    tracker = ProbabilisticDataAssociation(IMM, CLUTTER, 0.8, 1.0 - 1e-12)
    start, _ = IMM.step(IMM.begin(PRIOR), 1.0, np.array([[60.0, 70.0, 80.0], [0.0, 5.0, -5.0]]), R)
    state, _ = tracker.step(start, 1.0, z + np.array([70.0, 0.0])[:, None], R)
    predicted, _ = IMM.step(start, 1.0, None, None)
    for run in range(3):
        weights, means, covs = [], [], []
        for plot in [None, *(z[..., run] + np.array([70.0, 0.0]))]:
            for model in range(3):
                x, P = predicted.mean[:, model, run], predicted.cov[:, :, model, run]
                weight = predicted.weights[model, run]
                if plot is None:
                    weight *= 0.2 * CLUTTER
                else:
                    S, v = H @ P @ H.T + R[..., 0], plot - H @ x
                    K = P @ H.T @ np.linalg.inv(S)
                    weight *= 0.8 * math.exp(-0.5 * v @ np.linalg.solve(S, v)) / math.sqrt(np.linalg.det(2 * np.pi * S))
                    x, P = x + K @ v, P - K @ S @ K.T
                weights.append(weight)
                means.append(x)
                covs.append(P)
        joint = np.array(weights).reshape(4, 3) / np.sum(weights)
        np.testing.assert_allclose(state.weights[:, run], joint.sum(axis=0), rtol=1e-9)
        expected = merge(Mixture(joint.ravel(), np.array(means).T, np.moveaxis(np.array(covs), 0, -1)))
        measured = merge(tracker.estimate(state))
        np.testing.assert_allclose(measured.mean[:, run], expected.mean, rtol=1e-9, atol=1e-9)
        np.testing.assert_allclose(measured.cov[..., run], expected.cov, rtol=1e-9, atol=1e-7)


@pytest.mark.parametrize("tracker", [KALMAN, IMM], ids=["kalman", "imm"])
def test_one_sure_plot_is_a_plain_update(tracker):
    """Pd = 1 and next to no false alarms: the rest of the probability is 1e-13."""
    z = candidates(4, 1, seed=3)
    associated = ProbabilisticDataAssociation(tracker, 1e-20, 1.0, 1.0 - 1e-12)
    state, _ = associated.step(associated.begin(PRIOR), 1.0, z, R)
    plain, _ = tracker.step(tracker.begin(PRIOR), 1.0, z[0], R)
    for mine, theirs in zip(merge_of(tracker, state), merge_of(tracker, plain), strict=True):
        np.testing.assert_allclose(mine, np.broadcast_to(theirs, mine.shape), rtol=1e-9, atol=1e-7)


@pytest.mark.parametrize("tracker", [KALMAN, IMM], ids=["kalman", "imm"])
def test_nothing_in_the_gate_is_a_prediction(tracker):
    far = np.full((2, 2, 3), 5000.0)
    far[:, :, 1] = np.nan  # a run without any candidate
    associated = ProbabilisticDataAssociation(tracker, CLUTTER)
    state, innovation = associated.step(associated.begin(PRIOR), 1.0, far, R)
    plain, _ = tracker.step(tracker.begin(PRIOR), 1.0, None, None)
    estimate, expected = (merge_of(tracker, s) for s in (state, plain))
    np.testing.assert_allclose(estimate.mean, np.broadcast_to(expected.mean, (4, 3)), rtol=1e-12)
    np.testing.assert_allclose(estimate.cov, np.broadcast_to(expected.cov, (4, 4, 3)), rtol=1e-9)
    assert np.isnan(innovation.white).all()
    np.testing.assert_allclose(innovation.log_likelihood, math.log(1.0 - 0.9 * 0.9997))
    for nothing in (None, np.full((2, 2, 3), np.nan)):
        state, innovation = associated.step(associated.begin(PRIOR), 1.0, nothing, R)
        assert innovation is None


@pytest.mark.parametrize("tracker", [KALMAN, IMM], ids=["kalman", "imm"])
def test_order_and_padding_do_not_matter_and_runs_are_independent(tracker):
    z = candidates(4, 5, seed=4)
    z[3:, :, 2] = np.nan
    associated = ProbabilisticDataAssociation(tracker, CLUTTER)
    begun = associated.begin(PRIOR)
    reference = merge_of(associated, associated.step(begun, 1.0, z, R)[0])
    shuffled = merge_of(associated, associated.step(begun, 1.0, z[[4, 2, 0, 1, 3]], R)[0])
    padded = merge_of(associated, associated.step(begun, 1.0, np.concatenate([z, np.full_like(z, np.nan)]), R)[0])
    for other in (shuffled, padded):
        np.testing.assert_allclose(other.mean, reference.mean, rtol=1e-12)
        np.testing.assert_allclose(other.cov, reference.cov, rtol=1e-9)
    for run in range(4):
        alone = merge_of(associated, associated.step(begun, 1.0, z[..., run : run + 1], R)[0])
        np.testing.assert_allclose(alone.mean[:, 0], reference.mean[:, run], rtol=1e-12)


TRACKERS = {
    "kalman": KALMAN,
    "imm": IMM,
    "gated": Gated(POSITION, ConstantVelocity(0.3)),
    "huber": Huber(POSITION, ConstantVelocity(0.3)),
}


@pytest.mark.parametrize("tracker", TRACKERS.values(), ids=TRACKERS)
def test_a_step_of_no_time_is_a_mere_update(tracker):
    """What the association relies on: predict and update in one step, or in two."""
    z = candidates(4, 1, seed=7)[0]
    begun = tracker.begin(PRIOR)
    at_once, one = tracker.step(begun, 1.0, z, R)
    predicted, _ = tracker.step(begun, 1.0, None, None)
    in_two, two = tracker.step(predicted, 0.0, z, R)
    for mine, theirs in zip(at_once, in_two, strict=True):
        np.testing.assert_allclose(mine, theirs, rtol=1e-12, atol=1e-12)
    np.testing.assert_allclose(one.log_likelihood, two.log_likelihood, rtol=1e-12)


def merge_of(tracker, state) -> Gaussian:
    estimate = tracker.estimate(state)
    return merge(estimate) if isinstance(estimate, Mixture) else estimate


def test_density_counts_false_alarms_in_the_ellipse():
    """Uniform plots of that density, counted inside three sigma: 3 +- 4 standard errors over 400 scans."""
    generator = np.random.default_rng(5)
    cov = np.array([[400.0, 150.0], [150.0, 900.0]])
    density = clutter_density(3.0, cov)
    number = generator.poisson(density * 400.0**2, 400)
    plots = generator.uniform(-200.0, 200.0, (2, number.sum()))
    inside = np.einsum("iN,ij,jN->N", plots, np.linalg.inv(cov), plots) <= 9.0
    assert inside.sum() / 400 == pytest.approx(3.0, abs=4 * math.sqrt(3.0 / 400))
    assert clutter_density(3.0, np.array([[4.0]])) == pytest.approx(3.0 / 12.0)  # one channel: plus and minus 3 sigma


def test_it_keeps_tracks_that_the_nearest_plot_loses():
    """Pd 0.9 and 3 false alarms inside 3 sigma, straight flight, 40 scans: who is within 8 sigma."""
    generator = np.random.default_rng(6)
    runs, density = 200, clutter_density(3.0, R[..., 0])
    F, Q = planar_constant_velocity(4.0, 0.3, 0.3)
    x = PRIOR.mean + np.sqrt(np.diag(PRIOR.cov[..., 0]))[:, None] * generator.standard_normal((4, runs))
    associated = ProbabilisticDataAssociation(KALMAN, density)
    state, nearest = associated.begin(PRIOR), KALMAN.begin(PRIOR)
    for _ in range(40):
        x = F @ x + np.linalg.cholesky(Q) @ generator.standard_normal((4, runs))
        own = x[[0, 2]] + 20.0 * generator.standard_normal((2, runs))
        own[:, generator.random(runs) > 0.9] = np.nan
        z = x[[0, 2]] + generator.uniform(-160.0, 160.0, (60, 2, runs))
        z = np.where((np.arange(60)[:, None] < generator.poisson(density * 320.0**2, runs))[:, None], z, np.nan)
        z = np.concatenate([own[None], z])
        state, _ = associated.step(state, 4.0, z, R)
        predicted, _ = KALMAN.step(nearest, 4.0, None, None)
        distance = np.nan_to_num(((z - predicted.mean[[0, 2]]) ** 2).sum(axis=1), nan=np.inf)
        best = np.take_along_axis(z, distance.argmin(axis=0)[None, None], axis=0)[0]
        nearest, _ = KALMAN.step(nearest, 4.0, best, R)
    kept = [(np.hypot(*(s.mean - x)[[0, 2]]) < 160.0).mean() for s in (state, nearest)]
    assert kept[0] > kept[1] + 0.1
    assert kept[0] > 0.5


def test_blend_takes_the_rest_from_the_likeliest():
    weights = np.array([[0.6, 0.1], [0.4, 0.9]])
    one = (Gaussian(np.zeros((1, 2)), np.ones((1, 1, 1))), np.array([0, 0]), "name")
    other = (Gaussian(np.ones((1, 2)), np.ones((1, 1, 1))), np.array([1, 1]), "name")
    gaussian, leg, name = blend(weights, [one, other])
    np.testing.assert_allclose(gaussian.mean, [[0.4, 0.9]])
    np.testing.assert_allclose(gaussian.cov[0, 0], 1.0 + np.array([0.24, 0.09]))
    assert leg.tolist() == [0, 1]
    assert name == "name"


def test_parameters_in_range():
    with pytest.raises(ValueError, match="detection_probability"):
        ProbabilisticDataAssociation(KALMAN, CLUTTER, 0.0)
    with pytest.raises(ValueError, match="gate_probability"):
        ProbabilisticDataAssociation(KALMAN, CLUTTER, 0.9, 1.0)
    with pytest.raises(ValueError, match="without false alarms"):
        ProbabilisticDataAssociation(KALMAN, 0.0)
