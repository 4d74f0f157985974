"""The loop over time: order of arrival, absence, age, streaming, and bad records."""

from __future__ import annotations

import dataclasses

import numpy as np
import pytest

from tracking.gaussian import Gaussian, Mixture, merge
from tracking.measurement import LinearMeasurement
from tracking.motion import ConstantVelocity
from tracking.track import Measurements, chunks, follow, track
from tracking.trackers.imm import InteractingMultipleModel, published_set
from tracking.trackers.kalman import Kalman

POSITION = LinearMeasurement(((1.0, 0.0, 0.0, 0.0), (0.0, 0.0, 1.0, 0.0)))
PRIOR = Gaussian(np.array([0.0, 60.0, 0.0, 30.0]), np.diag([1e4, 25.0, 1e4, 25.0]))
KALMAN = Kalman(POSITION, ConstantVelocity(0.3))


def record(k=10, runs=3, seed=51, delay=0.0):
    rng = np.random.default_rng(seed)
    time = np.arange(k) * 1.0
    truth = np.stack([60.0 * time, 30.0 * time], axis=1)
    z = truth[:, :, None] + 100.0 * rng.standard_normal((k, 2, runs))
    R = np.broadcast_to(1e4 * np.eye(2)[None, :, :, None], (k, 2, 2, 1))
    return Measurements(("radar.north", "radar.east"), time, time + delay, z, R)


def test_the_first_measurement_meets_the_prior_itself():
    measurements = record()
    result = track(KALMAN, measurements, PRIOR)
    direct, _ = KALMAN.step(
        Gaussian(PRIOR.mean[:, None], PRIOR.cov[:, :, None]), 0.0, measurements.z[0], measurements.R[0]
    )
    np.testing.assert_array_equal(result.mean[0], direct.mean)


def test_values_are_used_in_order_of_arrival():
    """The record's rows may come in any order; equal arrivals keep the order of the rows."""
    measurements = record()
    order = np.array([3, 0, 9, 1, 2, 8, 4, 7, 6, 5])
    shuffled = dataclasses.replace(
        measurements,
        time=measurements.time[order],
        arrival=measurements.arrival[order],
        z=measurements.z[order],
        R=measurements.R[order],
    )
    np.testing.assert_array_equal(track(KALMAN, shuffled, PRIOR).mean, track(KALMAN, measurements, PRIOR).mean)
    rows = [epoch.row for epoch in follow(KALMAN, shuffled, PRIOR)]
    assert rows == np.argsort(order).tolist()


def test_time_never_runs_backwards_when_an_old_value_arrives_late():
    measurements = record()
    arrival = measurements.time.copy()
    arrival[4] = 6.5  # overtaken by 5 and 6
    seen = []

    @dataclasses.dataclass(frozen=True)
    class Watched:
        inner: Kalman
        channels = KALMAN.channels

        def begin(self, prior):
            return self.inner.begin(prior)

        def step(self, state, dt, z, R):
            seen.append(dt)
            return self.inner.step(state, dt, z, R)

        def estimate(self, state):
            return self.inner.estimate(state)

    result = track(Watched(KALMAN), dataclasses.replace(measurements, arrival=arrival), PRIOR)
    assert min(seen) >= 0.0
    np.testing.assert_array_equal(result.time, np.sort(arrival))


def test_a_time_stamped_tracker_steers_an_old_value_to_now():
    """Noise-free measurements 2 s old: taken as new they drag the estimate 134 m back, steered they do not."""

    @dataclasses.dataclass(frozen=True)
    class Stamped:
        inner: Kalman
        channels = KALMAN.channels

        def begin(self, prior):
            return self.inner.begin(prior)

        def step(self, state, dt, z, R):
            return self.inner.step(state, dt, z, R)

        def estimate(self, state):
            return self.inner.estimate(state)

        def steer(self, state, z, age):
            return z + age * state.mean[[1, 3]]

    time = np.arange(60) * 1.0
    truth = np.stack([60.0 * time, 30.0 * time], axis=1)[:, :, None]
    R = np.broadcast_to(np.eye(2)[None, :, :, None], (60, 2, 2, 1))
    late = Measurements(("r.n", "r.e"), time, time + 2.0, truth, R)
    prior = Gaussian(np.array([120.0, 60.0, 60.0, 30.0]), PRIOR.cov)
    now = np.array([60.0, 30.0]) * (time[-1] + 2.0)
    steered, naive = (track(tracker, late, prior).mean[-1, [0, 2], 0] for tracker in (Stamped(KALMAN), KALMAN))
    np.testing.assert_allclose(steered, now, atol=1e-6)
    assert np.linalg.norm(naive - now) > 100.0


def test_an_epoch_without_measurements_is_pure_prediction():
    measurements = record()
    measurements.z[4] = np.nan
    result = track(KALMAN, measurements, PRIOR)
    F, Q, _ = KALMAN.motion.transition(1.0, None)
    np.testing.assert_allclose(result.mean[4], F @ result.mean[3], rtol=1e-13)
    np.testing.assert_allclose(result.cov[4, ..., 0], F @ result.cov[3, ..., 0] @ F.T + Q, rtol=1e-12)
    assert np.isnan(result.white[4]).all()
    np.testing.assert_array_equal(result.nis[4], 0.0)
    np.testing.assert_array_equal(result.log_likelihood[4], 0.0)


@pytest.mark.parametrize("tracker", [KALMAN, InteractingMultipleModel(POSITION, published_set())])
def test_a_first_measurement_that_is_absent_and_a_record_that_is_empty_work(tracker):
    measurements = record()
    measurements.z[0] = np.nan
    assert np.isfinite(track(tracker, measurements, PRIOR).mean).all()
    measurements.z[...] = np.nan
    nothing = track(tracker, measurements, PRIOR)
    assert np.isfinite(nothing.mean).all()
    assert np.isnan(nothing.white).all()
    spread = nothing.cov[:, 0, 0, 0]
    assert (np.diff(spread) > 0.0).all()  # less and less is known


def test_two_measurements_of_one_instant_are_two_updates():
    """Period zero: no time passes, nothing moves, the information adds up."""
    measurements = record(k=2)
    together = dataclasses.replace(measurements, time=np.zeros(2), arrival=np.zeros(2))
    result = track(KALMAN, together, PRIOR)
    information = np.linalg.inv(PRIOR.cov)
    information[[0, 2], [0, 2]] += 2.0 / 1e4
    np.testing.assert_allclose(result.cov[1, ..., 0], np.linalg.inv(information), rtol=1e-12)


def test_streaming_over_chunks_is_the_whole_ensemble():
    measurements = record(runs=11)
    tracker = InteractingMultipleModel(POSITION, published_set())
    whole = track(tracker, measurements, PRIOR)
    for runs in chunks(11, 4):
        for epoch in follow(tracker, measurements.runs(runs), PRIOR):
            assert isinstance(epoch.estimate, Mixture)
            merged = merge(epoch.estimate)
            np.testing.assert_allclose(merged.mean, whole.mean[epoch.row][:, runs], rtol=1e-12, atol=1e-9)
    assert [part.stop - part.start for part in chunks(11, 4)] == [4, 4, 3]


def test_a_prior_per_run_serves_each_run_its_own():
    measurements = record(runs=2)
    means = PRIOR.mean[:, None] + np.array([[0.0, 500.0], [0.0, 0.0], [0.0, 0.0], [0.0, 0.0]])
    both = track(KALMAN, measurements, Gaussian(means, PRIOR.cov))
    for run in range(2):
        alone = track(KALMAN, measurements.runs(slice(run, run + 1)), Gaussian(means[:, run], PRIOR.cov))
        np.testing.assert_allclose(both.mean[..., run], alone.mean[..., 0], rtol=1e-12)


BAD = [
    ({"arrival": np.arange(10) - 1.0}, "cannot arrive before it was taken"),
    ({"time": np.arange(9.0)}, "vectors of one length"),
    ({"time": np.full(10, np.nan)}, "times must be finite"),
    ({"z": np.zeros((10, 3, 3))}, r"z must have the shape \(10, 2, runs\)"),
    ({"R": np.zeros((10, 2, 3, 1))}, r"R must have the shape \(10, 2, 2, runs\)"),
    ({"R": -np.ones((10, 2, 2, 1))}, "the variance of 'radar.north' is negative"),
    ({"R": np.tile(np.array([[1.0, 0.5], [0.0, 1.0]])[None, :, :, None], (10, 1, 1, 1))}, "R is not symmetric"),
    ({"R": np.tile(np.array([[1.0, 2.0], [2.0, 1.0]])[None, :, :, None], (10, 1, 1, 1))}, "a correlation exceeds 1"),
    ({"z": np.full((10, 2, 3), np.inf)}, "a measurement is infinite"),
]


@pytest.mark.parametrize(("change", "sentence"), BAD, ids=[sentence for _, sentence in BAD])
def test_bad_records_are_refused_with_a_sentence(change, sentence):
    with pytest.raises(ValueError, match=sentence):
        dataclasses.replace(record(), **change)


BAD_PRIORS = [
    (Gaussian(PRIOR.mean, np.eye(3)), "needs a covariance"),
    (Gaussian(PRIOR.mean, np.triu(np.ones((4, 4)))), "not symmetric"),
    (Gaussian(PRIOR.mean, -np.eye(4)), "negative variance"),
    (Gaussian(np.full(4, np.nan), np.eye(4)), "must be finite"),
    (Gaussian(np.zeros((4, 3, 2)), np.eye(4)), "more batch axes"),
]


@pytest.mark.parametrize(("prior", "sentence"), BAD_PRIORS, ids=[sentence for _, sentence in BAD_PRIORS])
def test_bad_priors_are_refused_with_a_sentence(prior, sentence):
    with pytest.raises(ValueError, match=sentence):
        track(KALMAN, record(), prior)


def test_a_prior_of_the_future_is_refused():
    with pytest.raises(ValueError, match="after the first arrival"):
        track(KALMAN, record(), PRIOR, start=5.0)
