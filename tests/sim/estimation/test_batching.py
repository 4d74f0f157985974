"""Trackers that run as one: each has the estimates that it has alone."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from sim.estimation.batching import can_batch, repeat_runs, split_track, stack_trackers
from tests.tracking.law_truth import BASE_TO_FINAL, CROSS_TRACK, LINE, NOMINAL, PATTERN_LAW, PLANE
from tracking.gaussian import Gaussian
from tracking.track import Measurements, track
from tracking.trackers.imm import InteractingMultipleModel
from tracking.trackers.intent_imm import IntentImm
from tracking.trackers.kalman import Kalman
from tracking.trackers.linear_feedback import LinearFeedback
from tracking.trackers.saturated_control import SaturatedControl

RUNS, LOOKS = 3, 40
WIDER = replace(PATTERN_LAW, cross_track_limit=1.3 * PATTERN_LAW.cross_track_limit)
ON_ROUTE = SaturatedControl(PATTERN_LAW, BASE_TO_FINAL, PLANE)
ALIKE = {
    "linear feedback": (LinearFeedback(PATTERN_LAW, BASE_TO_FINAL, PLANE), {"acceleration_density": 20.0}),
    "linear feedback on a line": (LinearFeedback(NOMINAL, LINE, CROSS_TRACK), {"acceleration_density": 20.0}),
    "saturated control": (ON_ROUTE, {"acceleration_density": 2.0}),
    "law and noise": (ON_ROUTE, {"acceleration_density": 2.0, "law": WIDER}),
    "with slope": (replace(ON_ROUTE, covariance="jacobian"), {"acceleration_density": 2.0}),
    "engaged": (replace(ON_ROUTE, begins="engaged"), {"acceleration_density": 2.0}),
    "intents": (IntentImm(PATTERN_LAW, BASE_TO_FINAL, PLANE), {"law_density": 2.0, "straight_density": 0.5}),
    "models": (InteractingMultipleModel(PLANE), {"straight_density": 2.0, "manoeuvre_density": 4.0}),
}


def seen(line: bool) -> tuple[Measurements, Gaussian]:
    """Plots of an aircraft near the path, its draws' own noise, every fifth look silent in one draw."""
    rng, now = np.random.default_rng(5), 4.0 * np.arange(LOOKS)
    leg = BASE_TO_FINAL.legs[0]
    speed = np.array(leg.direction) * leg.speed
    truth = np.zeros((LOOKS, 1)) if line else np.array(leg.start) + now[:, None] * speed
    z = truth[:, :, None] + 50.0 * rng.standard_normal((*truth.shape, RUNS))
    z[::5, :, 1] = np.nan
    R = np.broadcast_to(2500.0 * np.eye(z.shape[1])[None, :, :, None], (LOOKS, *(z.shape[1],) * 2, 1))
    mean = np.zeros(2) if line else np.array([truth[0, 0], speed[0], truth[0, 1], speed[1]])
    prior = Gaussian(np.repeat(mean[:, None], RUNS, axis=1), np.diag(np.tile([1e4, 100.0], len(mean) // 2)))
    return Measurements(tuple(f"radar.{row}" for row in range(z.shape[1])), now, now, z, R), prior


@pytest.mark.parametrize("name", ALIKE)
def test_trackers_that_differ_in_noise_are_as_one_what_they_are_alone(name):
    one, change = ALIKE[name]
    pair = [one, replace(one, **change)]
    record, prior = seen("line" in name.split())
    assert can_batch(*pair)
    made = split_track(track(stack_trackers(pair, RUNS), *repeat_runs(record, prior, 2), 0.0), 2)
    alone = [track(tracker, record, prior, 0.0) for tracker in pair]
    sigma = np.sqrt(np.einsum("kii...->ki...", alone[0].cov))
    assert np.max(np.abs(alone[1].mean - alone[0].mean) / sigma) > 1e-3  # the noise matters here
    for own, expected in zip(made, alone, strict=True):  # other kernels multiply larger stacks: rounding
        np.testing.assert_allclose(own.mean / sigma, expected.mean / sigma, rtol=0.0, atol=1e-9)
        np.testing.assert_allclose(own.cov, np.broadcast_to(expected.cov, own.cov.shape), rtol=1e-9, atol=1e-9)


def test_what_takes_no_value_per_run_keeps_trackers_apart():
    assert not can_batch(ON_ROUTE, replace(ON_ROUTE, sub_step=0.25))
    assert not can_batch(ON_ROUTE, replace(ON_ROUTE, covariance="jacobian"))
    assert not can_batch(ON_ROUTE, replace(ON_ROUTE, law=replace(PATTERN_LAW, bank_limit=0.2)))
    assert not can_batch(Kalman(PLANE), Kalman(PLANE, acceleration_density=1.0))
    assert not can_batch(InteractingMultipleModel(PLANE), Kalman(PLANE))
    models = InteractingMultipleModel(PLANE)
    assert not can_batch(models, replace(models, acceleration=-1.0))
