"""What all law-aware trackers promise, on a line and on a route through a turn."""

from __future__ import annotations

import math
from dataclasses import replace
from functools import partial

import numpy as np
import pytest

from autopilot.modes.radio_beacon import RadioBeacon
from tests.tracking.law_truth import (
    BASE_START,
    BASE_TO_FINAL,
    CROSS_TRACK,
    NOMINAL,
    PATTERN_LAW,
    PATTERN_SPEED,
    PLANE,
    flown_by,
    line_truth,
    prior,
    record,
    route_truth,
)
from tracking.gaussian import Gaussian, Mixture, merge
from tracking.reference_path import Legs, Line
from tracking.track import track
from tracking.trackers.intent_imm import IntentImm
from tracking.trackers.linear_feedback import LinearFeedback
from tracking.trackers.saturated_control import SaturatedControl

RUNS = 3
APPROACH = Line(100.0, 20e3)
BEACON = RadioBeacon(6.0, 1.2, math.radians(15.0), math.radians(5.0))
KINDS = {
    "LinearFeedback": LinearFeedback,
    "SaturatedControl": SaturatedControl,
    "SaturatedControl, jacobian": partial(SaturatedControl, covariance="jacobian"),
    "IntentImm": IntentImm,
}


def on_line(law):
    return {f"{name} on a line": kind(law, APPROACH, CROSS_TRACK, sub_step=0.5) for name, kind in KINDS.items()}


def on_route(law):
    return {f"{name} on a route": kind(law, BASE_TO_FINAL, PLANE, sub_step=0.5) for name, kind in KINDS.items()}


TRACKERS = {
    **{f"{name}, route law": tracker for name, tracker in (on_line(NOMINAL) | on_route(PATTERN_LAW)).items()},
    **{f"{name}, beacon law": tracker for name, tracker in (on_line(BEACON) | on_route(BEACON)).items()},
}
each = pytest.mark.parametrize("tracker", TRACKERS.values(), ids=TRACKERS.keys())


@pytest.fixture(scope="module")
def truths():
    rng = np.random.default_rng(5)
    line = line_truth(flown_by(NOMINAL), (3000.0, 0.0), 24.0, rng, RUNS, dt=0.2)
    turn = route_truth(PATTERN_LAW, BASE_TO_FINAL, (-13500.0, 0.0, -2000.0, PATTERN_SPEED), 24.0, rng, RUNS, dt=0.2).x
    return {2: line, 4: turn}


def observed(tracker, truths):
    truth = truths[len(tracker.channels)]
    rng = np.random.default_rng(6)
    return prior(truth, rng), record(truth, rng)


@each
def test_an_ensemble_equals_its_single_runs(tracker, truths):
    """1e-12 of the scale of the states (1e4 m): only the order of sums differs."""
    start, measured = observed(tracker, truths)
    together = track(tracker, measured, start, start=0.0)
    for run in (0, RUNS - 1):
        z, mean = measured.z[..., run], start.mean[:, run]
        alone = track(tracker, replace(measured, z=z), Gaussian(mean, start.cov), start=0.0)
        np.testing.assert_allclose(together.mean[..., run], alone.mean, rtol=1e-12, atol=1e-8)
        cov = np.broadcast_to(together.cov, (*together.cov.shape[:3], RUNS))[..., run]
        np.testing.assert_allclose(cov, alone.cov, rtol=1e-9, atol=1e-9)


@each
def test_an_absent_measurement_is_a_prediction(tracker, truths):
    """NaN in one run, none at all, and two steps in place of one lead to the same estimate there."""
    start, measured = observed(tracker, truths)
    state, _ = tracker.step(tracker.begin(start), 0.0, measured.z[0], measured.R[0])
    z = measured.z[1].copy()
    z[:, 2] = np.nan
    partly, innovation = tracker.step(state, 4.0, z, measured.R[1])
    ahead, nothing = tracker.step(state, 4.0, None, None)
    assert nothing is None
    assert innovation.nis[2] == 0.0
    assert innovation.log_likelihood[2] == pytest.approx(0.0, abs=1e-12)
    one, other = (merged(tracker.estimate(s)) for s in (partly, ahead))
    np.testing.assert_allclose(one.mean[:, 2], other.mean[:, 2], rtol=1e-12, atol=1e-8)
    assert np.isfinite(one.mean).all()


@each
def test_the_covariance_stays_one(tracker, truths):
    start, measured = observed(tracker, truths)
    cov = np.moveaxis(track(tracker, measured, start, start=0.0).cov, -1, 1)
    assert np.array_equal(cov, cov.swapaxes(-1, -2))
    assert np.linalg.eigvalsh(cov).min() > 0.0


@each
def test_steps_between_scans_change_little(tracker, truths):
    """Asked eight times per scan, in the same sub-steps; only an IMM then mixes its models more often: 2 m at most."""
    start, measured = observed(tracker, truths)
    state, _ = tracker.step(tracker.begin(start), 0.0, measured.z[0], measured.R[0])
    at_once, _ = tracker.step(state, 4.0, None, None)
    for _ in range(8):
        state, _ = tracker.step(state, 0.5, None, None)
    fine, coarse = (merged(tracker.estimate(s)).mean for s in (state, at_once))
    tolerance = 2.0 if isinstance(tracker, IntentImm) else 0.5  # m; the gains of a beacon law hold for one step
    np.testing.assert_allclose(fine[0::2], coarse[0::2], rtol=0, atol=tolerance)


def moved_by(matrix, shift):
    """State, route and covariance under a map (north, east) -> matrix (north, east) + shift."""
    big = np.kron(matrix, np.eye(2))

    def of_state(x):
        moved = np.einsum("ij,j...->i...", big, x)
        moved[0::2] += np.reshape(shift, (2, *(1,) * (x.ndim - 1)))
        return moved

    def of_route(route):
        legs = tuple(
            replace(leg, start=tuple(matrix @ leg.start + shift), end=tuple(matrix @ leg.end + shift))
            for leg in route.legs
        )
        return replace(route, legs=legs)

    return of_state, of_route, big


@pytest.mark.parametrize("name", KINDS)
@pytest.mark.parametrize("mirror", [False, True], ids=["turned", "mirrored"])
def test_the_map_does_not_matter(name, mirror, truths):
    """Turned by 37 deg and moved, or mirrored, data and route give the turned or mirrored estimate.

    1e-6 m on coordinates of 1e4 m: the numerical slope of the law carries 1e-9 of rounding.
    """
    angle = math.radians(37.0)
    turn = np.array([[math.cos(angle), -math.sin(angle)], [math.sin(angle), math.cos(angle)]])
    matrix, shift = (np.diag([1.0, -1.0]), np.zeros(2)) if mirror else (turn, np.array([3000.0, -8000.0]))
    of_state, of_route, big = moved_by(matrix, shift)
    tracker = on_route(PATTERN_LAW)[f"{name} on a route"]
    start, measured = observed(tracker, truths)
    here = track(tracker, measured, start, start=0.0)
    z = np.einsum("ij,kj...->ki...", matrix, measured.z) + shift[:, None]
    there = track(
        replace(tracker, route=of_route(BASE_TO_FINAL)),
        replace(measured, z=z),
        Gaussian(of_state(start.mean), start.cov),  # the same along both axes
        start=0.0,
    )
    expected = np.stack([of_state(mean) for mean in here.mean])
    np.testing.assert_allclose(there.mean, expected, rtol=0, atol=1e-6)
    np.testing.assert_allclose(there.cov, np.einsum("ij,kjl...,ml->kim...", big, here.cov, big), rtol=0, atol=1e-4)


def merged(estimate):
    return merge(estimate) if isinstance(estimate, Mixture) else estimate


def test_the_first_leg_is_the_one_that_the_prior_flies():
    legs = Legs(BASE_TO_FINAL, PATTERN_LAW.bank_limit)
    on_base = np.array(BASE_START)
    on_final = np.array([-8000.0, 69.0, 150.0, -2.0])
    assert legs.begin(on_base) == 0
    assert legs.begin(on_final) == 1
    np.testing.assert_array_equal(legs.begin(np.stack([on_base, on_final], axis=-1)), [0, 1])


def test_every_run_takes_the_turn_by_its_own_estimate():
    """Two runs 400 m apart along the base leg change to the final 400 m / 69 m/s apart."""
    tracker = SaturatedControl(PATTERN_LAW, BASE_TO_FINAL, PLANE)
    mean = np.array([[-13500.0, -13500.0], [0.0, 0.0], [-3000.0, -3400.0], [69.0, 69.0]])
    state = tracker.begin(Gaussian(mean, np.diag([1e4, 25.0, 1e4, 25.0])))
    switched = [None, None]
    for k in range(160):
        state, _ = tracker.step(state, 0.5, None, None)
        for run in (0, 1):
            if switched[run] is None and state.place[run] == 1:
                switched[run] = 0.5 * (k + 1)
    assert switched[1] - switched[0] == pytest.approx(400.0 / 69.0, abs=0.51)


@pytest.mark.parametrize("speed", [0.0, -70.0, math.nan])
def test_a_line_needs_a_speed(speed):
    with pytest.raises(ValueError, match="ground speed"):
        Line(speed)
