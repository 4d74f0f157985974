"""Autonomous models against exact Bayes of a constant mode, against the IMM that never switches, and their floor."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.stats import multivariate_normal

from tracking.gaussian import Gaussian, merge
from tracking.measurement import LinearMeasurement
from tracking.motion import ConstantVelocity, CoordinatedTurn
from tracking.track import Measurements, follow, track
from tracking.trackers.autonomous_models import AutonomousModels
from tracking.trackers.imm import InteractingMultipleModel, ModelSet
from tracking.trackers.kalman import Kalman

POSITION = LinearMeasurement(((1.0, 0.0, 0.0, 0.0), (0.0, 0.0, 1.0, 0.0)))
PRIOR = Gaussian(np.array([9000.0, -60.0, 500.0, 30.0]), np.diag([1e4, 25.0, 1e4, 25.0]))
MODELS = (CoordinatedTurn(-0.045, 0.1), CoordinatedTurn(0.02, 0.3), ConstantVelocity(0.01))
IDENTITY = ((1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0))
SET = ModelSet(MODELS, IDENTITY, (0.5, 0.2, 0.3))
H, NOISE, SCAN = np.array(POSITION.H), np.diag([400.0, 900.0]), 0.7


def record(k, runs, model=MODELS[0]):
    """Positions of targets that move by one model."""
    rng = np.random.default_rng(7)
    F, Q, _ = model.transition(SCAN, None)
    x = rng.multivariate_normal(PRIOR.mean, PRIOR.cov, runs).T
    z = []
    for _ in range(k):
        x = F @ x + rng.multivariate_normal(np.zeros(4), Q, runs).T
        z.append(H @ x + rng.multivariate_normal(np.zeros(2), NOISE, runs).T)
    time = SCAN * np.arange(1, k + 1)
    return Measurements(("radar.north", "radar.east"), time, time, np.array(z), np.broadcast_to(NOISE, (k, 2, 2)))


def whole_record(model, z):
    """Log-density of a record (k, 2) under one model, and the mean of its last state: one big normal, no recursion."""
    k = len(z)
    F, Q, _ = model.transition(SCAN, None)
    mean, cov = [], np.zeros((4 * k, 4 * k))
    x, P = PRIOR.mean, PRIOR.cov
    for i in range(k):
        x, P = F @ x, F @ P @ F.T + Q
        mean.append(x)
        block = P
        for j in range(i, k):
            cov[4 * j : 4 * j + 4, 4 * i : 4 * i + 4] = block
            cov[4 * i : 4 * i + 4, 4 * j : 4 * j + 4] = block.T
            block = F @ block
    picks = np.kron(np.eye(k), H)
    S = picks @ cov @ picks.T + np.kron(np.eye(k), NOISE)
    centre = picks @ np.concatenate(mean)
    last = mean[-1] + cov[-4:] @ picks.T @ np.linalg.solve(S, z.ravel() - centre)
    return multivariate_normal(centre, S).logpdf(z.ravel()), last


def test_a_constant_mode_has_the_exact_posterior():
    measurements = record(8, 3)
    *_, epoch = follow(AutonomousModels(POSITION, SET, least_weight=0.0), measurements, PRIOR, 0.0)
    for run in range(3):
        logs, means = zip(*(whole_record(model, measurements.z[..., run]) for model in MODELS), strict=True)
        weights = np.array(SET.probabilities) * np.exp(np.array(logs) - max(logs))
        weights /= weights.sum()
        assert weights.min() > 1e-6  # else there would be nothing to compare
        np.testing.assert_allclose(epoch.estimate.weights[:, run], weights, rtol=1e-8)
        np.testing.assert_allclose(merge(epoch.estimate).mean[:, run], weights @ np.array(means), rtol=1e-9)


def test_without_a_floor_they_are_the_interacting_models_that_never_switch():
    measurements = record(40, 5)
    ours = track(AutonomousModels(POSITION, SET, least_weight=0.0), measurements, PRIOR, 0.0)
    judge = track(InteractingMultipleModel(POSITION, SET), measurements, PRIOR, 0.0)
    for own, his in zip(ours[2:8], judge[2:8], strict=True):
        np.testing.assert_allclose(own, his, rtol=1e-9, atol=1e-12)


def test_one_model_is_the_kalman_filter():
    measurements = record(40, 2)
    one = AutonomousModels(POSITION, ModelSet(MODELS[:1], ((1.0,),), (1.0,)))
    ours, judge = track(one, measurements, PRIOR, 0.0), track(Kalman(POSITION, MODELS[0]), measurements, PRIOR, 0.0)
    for own, his in zip(ours[2:7], judge[2:7], strict=True):
        np.testing.assert_allclose(own, np.broadcast_to(his, own.shape), rtol=1e-12, atol=1e-12)


def test_the_floor_holds_and_lets_a_model_come_back():
    """A straight flight after a turn: without a floor its model has nothing left to grow from.

    The densities are such that a filter which was wrong finds the aircraft again.
    """
    turn, line = CoordinatedTurn(-0.1, 1.0), ConstantVelocity(1.0)
    turning, straight = record(300, 4, turn), record(60, 4, line)
    z = np.concatenate([turning.z, straight.z[1:] + turning.z[-1] - straight.z[0]])
    time = SCAN * np.arange(1, len(z) + 1)
    measurements = Measurements(turning.channels, time, time, z, np.broadcast_to(NOISE, (len(z), 2, 2)))
    pair = ModelSet((turn, line), ((1.0, 0.0), (0.0, 1.0)), (0.5, 0.5))
    found = {}
    for floor in (0.0, 0.01):
        tracker = AutonomousModels(POSITION, pair, least_weight=floor)
        found[floor] = track(tracker, measurements, PRIOR, 0.0).model_probabilities
        np.testing.assert_allclose(found[floor].sum(axis=1), 1.0, atol=1e-12)
    assert found[0.01].min() == 0.01
    assert found[0.0][299, 1].max() < 1e-12
    assert found[0.0][-1, 1].max() < 0.5
    assert found[0.01][-1, 1].min() > 0.5


@pytest.mark.parametrize("floor", [-0.1, 1.0 / 3.0, np.nan])
def test_the_floor_is_checked(floor):
    with pytest.raises(ValueError, match="least_weight must not be negative and be below 1/3"):
        AutonomousModels(POSITION, SET, least_weight=floor)
