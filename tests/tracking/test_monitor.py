"""The monitor judged by its stated false-alarm rate, by what it must notice and by what a restart must repair."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.stats import binom

from tracking.gaussian import Gaussian, Innovation, Mixture, merge
from tracking.intervals import mean_interval
from tracking.measurement import LinearMeasurement
from tracking.monitor import Monitored, NisMonitor
from tracking.motion import ConstantVelocity, planar_constant_velocity
from tracking.track import Measurements, Track, follow, track
from tracking.trackers.gated import Gated
from tracking.trackers.imm import InteractingMultipleModel, improved_set
from tracking.trackers.kalman import Kalman
from tracking.tree import choose

POSITION = LinearMeasurement(((1.0, 0.0, 0.0, 0.0), (0.0, 0.0, 1.0, 0.0)))
PRIOR = Gaussian(np.array([0.0, 70.0, 0.0, 0.0]), np.diag([400.0, 25.0, 400.0, 25.0]))
WIDE = np.diag([1e6, 900.0, 1e6, 900.0])


def record(epochs: int, runs: int, seed: int, turn_after: int | None = None) -> tuple[np.ndarray, Measurements]:
    """Truth from constant velocity of density 0.3, noise of 20 m; optionally a jump of 300 m and a new course."""
    generator = np.random.default_rng(seed)
    F, Q = planar_constant_velocity(1.0, 0.3, 0.3)
    x = PRIOR.mean[:, None] + np.sqrt(np.diag(PRIOR.cov))[:, None] * generator.standard_normal((4, runs))
    truth = []
    for epoch in range(epochs):
        x = F @ x + np.linalg.cholesky(Q) @ generator.standard_normal((4, runs))
        if epoch == turn_after:
            x = x + np.array([300.0, -70.0, 0.0, 70.0])[:, None]
        truth.append(x)
    truth = np.stack(truth)
    z = truth[:, [0, 2]] + 20.0 * generator.standard_normal((epochs, 2, runs))
    time = np.arange(1.0, epochs + 1.0)
    return truth, Measurements(("a", "b"), time, time, z, np.broadcast_to(400.0 * np.eye(2), (epochs, 2, 2)))


def alarms(monitor: NisMonitor, tracker, measurements: Measurements) -> np.ndarray:
    """Whether there was an alarm (k, N)."""
    window, found = monitor.begin(), []
    for epoch in follow(tracker, measurements, PRIOR, start=0.0):
        window, verdict = monitor.step(window, epoch.innovation)
        found.append(verdict.alarm)
    return np.stack(found)


@pytest.mark.parametrize("window", [1, 8])
def test_false_alarms_come_at_the_stated_rate(window):
    """Exact for a linear Gaussian filter, from the first epoch on; the interval is over independent runs."""
    _, measurements = record(40, 2000, seed=1)
    found = alarms(NisMonitor(window, 0.01), Kalman(POSITION, ConstantVelocity(0.3)), measurements)
    assert mean_interval(found.mean(axis=0), level=0.999).contains(0.01)


def test_absent_channels_change_neither_the_rate_nor_the_window():
    """A third of the values is absent, some epochs wholly: the rate holds per epoch with a measurement."""
    _, measurements = record(40, 2000, seed=2)
    z = np.where(np.random.default_rng(3).random(measurements.z.shape) < 1 / 3, np.nan, measurements.z)
    z[5] = np.nan
    holes = Measurements(measurements.channels, measurements.time, measurements.arrival, z, measurements.R)
    window, monitor, rates = NisMonitor(8, 0.01).begin(), NisMonitor(8, 0.01), []
    for epoch in follow(Kalman(POSITION, ConstantVelocity(0.3)), holes, PRIOR, start=0.0):
        window, verdict = monitor.step(window, epoch.innovation)
        assert (verdict is None) == (epoch.row == 5)
        if verdict is not None:
            rates.append(verdict.alarm)
    assert mean_interval(np.stack(rates).mean(axis=0), level=0.999).contains(0.01)


def test_an_imm_keeps_the_rate_to_a_factor_of_two():
    """Its innovation is only moment-matched: asked 1 %, on straight flight it must stay between 0.3 and 2 %."""
    _, measurements = record(40, 1000, seed=4)
    tracker = InteractingMultipleModel(POSITION, improved_set(0.3, 0.3))
    found = alarms(NisMonitor(8, 0.01), tracker, measurements)
    assert 0.003 < found.mean() < 0.02


def test_a_manoeuvre_is_noticed_and_a_wrong_noise_too():
    _, measurements = record(40, 200, seed=5, turn_after=20)
    found = alarms(NisMonitor(8, 1e-4), Kalman(POSITION, ConstantVelocity(0.3)), measurements)
    assert found[:20].mean() < 1e-3
    assert found[20:23].any(axis=0).mean() > 0.99
    doubled = Measurements(
        measurements.channels, measurements.time, measurements.arrival, measurements.z, measurements.R / 4
    )
    noticed = alarms(NisMonitor(8, 1e-4), Kalman(POSITION, ConstantVelocity(0.3)), doubled)
    assert noticed[:20].any(axis=0).mean() > 0.9


def test_a_restart_finds_the_target_that_a_gate_has_lost():
    """A gated filter never sees the target again after a jump; restarted, it is consistent ten epochs later."""
    truth, measurements = record(60, 100, seed=6, turn_after=20)
    gated = Gated(POSITION, ConstantVelocity(0.3))
    lost = track(gated, measurements, PRIOR, start=0.0)
    assert np.median(np.abs(lost.mean[-1, 2] - truth[-1, 2])) > 1000.0
    found = track(Monitored(gated, WIDE, NisMonitor(5, 1e-5)), measurements, PRIOR, start=0.0)
    error = found.mean[40:] - truth[40:]
    assert np.sqrt((error[:, [0, 2]] ** 2).sum(axis=1).mean()) < 25.0  # raw plots: 28 m
    assert (np.abs(error) < 6.0 * np.sqrt(np.einsum("kii...->ki...", found.cov[40:]))).all()


def test_runs_restart_one_by_one():
    """Batched equals single, also where only some runs alarm."""
    _, measurements = record(30, 4, seed=7)
    z = measurements.z.copy()
    z[10:, 0, 1] += 500.0
    z[20:, 1, 3] -= 900.0
    broken = Measurements(measurements.channels, measurements.time, measurements.arrival, z, measurements.R)
    for tracker in (
        Kalman(POSITION, ConstantVelocity(0.3)),
        InteractingMultipleModel(POSITION, improved_set(0.3, 0.3)),
    ):
        monitored = Monitored(tracker, WIDE, NisMonitor(4, 1e-4))
        together = track(monitored, broken, PRIOR, start=0.0)
        for run in range(4):
            alone = track(monitored, broken.runs(slice(run, run + 1)), PRIOR, start=0.0)
            np.testing.assert_allclose(alone.mean[..., 0], together.mean[..., run], rtol=1e-12, atol=1e-9)


def test_without_alarm_nothing_changes():
    _, measurements = record(20, 3, seed=8)
    tracker = Kalman(POSITION, ConstantVelocity(0.3))
    plain, monitored = (
        track(t, measurements, PRIOR, start=0.0) for t in (tracker, Monitored(tracker, WIDE, NisMonitor(5, 1e-12)))
    )
    np.testing.assert_array_equal(plain.mean, monitored.mean)
    np.testing.assert_array_equal(plain.cov, monitored.cov)


def test_a_single_run_restarts_too():
    _, measurements = record(30, 1, seed=9, turn_after=15)
    single = Measurements(
        measurements.channels, measurements.time, measurements.arrival, measurements.z[..., 0], measurements.R
    )
    monitored = Monitored(Kalman(POSITION, ConstantVelocity(0.3)), WIDE, NisMonitor(4, 1e-4))
    states = track(monitored, single, PRIOR, start=0.0)
    batch = track(monitored, measurements, PRIOR, start=0.0)
    np.testing.assert_allclose(states.mean, batch.mean[..., 0], rtol=1e-12, atol=1e-9)


def test_a_tracker_that_is_no_longer_finite_is_an_alarm():
    _, verdict = NisMonitor().step(
        NisMonitor().begin(), Innovation(np.array([[0.0, 1.0]]), np.array([np.nan, 1.0]), np.zeros(2))
    )
    assert verdict.alarm.tolist() == [True, False]


def test_choose_walks_any_state():
    mask = np.array([True, False])
    old = Mixture(np.full((2, 1), 0.5), np.zeros((3, 2, 2)), np.zeros((3, 3, 2, 1)))
    new = Mixture(np.array([[1.0, 1.0], [0.0, 0.0]]), np.ones((3, 2, 2)), np.ones((3, 3, 2, 1)))
    mixed, leg, epoch = choose(mask, (new, np.array([2, 2]), 7), (old, np.array([0, 1]), 3))
    assert isinstance(mixed, Mixture)
    np.testing.assert_array_equal(mixed.weights, [[1.0, 0.5], [0.0, 0.5]])
    np.testing.assert_array_equal(merge(mixed).mean, np.tile([1.0, 0.0], (3, 1)))
    assert leg.tolist() == [2, 1]
    assert epoch == 3


def test_parameters_in_range():
    with pytest.raises(ValueError, match="at least 1"):
        NisMonitor(window=0)
    with pytest.raises(ValueError, match="between 0 and 1"):
        NisMonitor(false_alarm_rate=0.0)


# ---- along a record, all at once ----------------------------------------------------------------------------------


def stepped(monitor: NisMonitor, followed: Track, measured: np.ndarray) -> np.ndarray:
    """The alarms of ``step`` on the innovations of a record, at the epochs (k,) at which anything was measured."""
    window, found = monitor.begin(), []
    for row in np.flatnonzero(measured):
        innovation = Innovation(followed.white[row], followed.nis[row], followed.log_likelihood[row])
        window, verdict = monitor.step(window, innovation)
        found.append(verdict.alarm)
    return np.stack(found)


@pytest.mark.parametrize("window", [1, 7, 100])
def test_along_a_record_the_verdicts_are_those_of_the_steps(window):
    """Channels, epochs and runs with holes, a jump, a lost run, and a window longer than the record."""
    _, measurements = record(40, 50, seed=12, turn_after=20)
    z = np.where(np.random.default_rng(3).random(measurements.z.shape) < 1 / 3, np.nan, measurements.z)
    z[[5, 6, 30]] = np.nan
    holes = Measurements(measurements.channels, measurements.time, measurements.arrival, z, measurements.R)
    followed = track(Kalman(POSITION, ConstantVelocity(0.3)), holes, PRIOR, start=0.0)
    measured = np.isfinite(followed.white).any(axis=(1, 2))
    lost = followed.nis.copy()
    lost[25:, 3] = np.where(measured[25:], np.nan, 0.0)
    followed = followed._replace(nis=lost)
    monitor = NisMonitor(window, 0.01)
    found = monitor.watch(followed)
    assert found.time.tolist() == followed.time[measured].tolist()
    assert len(found.time) == 37
    np.testing.assert_array_equal(found.alarm, stepped(monitor, followed, measured))
    assert 0.02 < found.alarm.mean() < 0.98
    assert found.alarm[-1, 3]
    assert found.looked[:, 0].sum() == np.isfinite(followed.white[:, :, 0]).any(axis=1).sum()


def test_a_lost_run_is_an_alarm_although_nothing_of_it_is_white():
    """A filter whose state is NaN gives no residuals: that is not the same as having measured nothing."""
    tracker = Kalman(POSITION, ConstantVelocity(0.3))
    mean = np.where(np.arange(2) == 1, np.nan, PRIOR.mean[:, None])
    state = tracker.begin(Gaussian(mean, PRIOR.cov[..., None]))
    _, innovation = tracker.step(state, 1.0, np.zeros((2, 2)), 400.0 * np.eye(2)[..., None])
    monitor = NisMonitor(4, 1e-9)
    window, verdict = monitor.step(monitor.begin(), innovation)
    assert np.isnan(innovation.white[:, 1]).all()
    assert verdict.alarm.tolist() == [False, True]
    assert monitor.step(window, Innovation(np.full((2, 2), np.nan), np.zeros(2), np.zeros(2)))[1].alarm[1]


@pytest.mark.parametrize("window", [1, 10])
def test_a_matched_filter_is_alarmed_as_often_as_stated(window):
    """Windows that do not overlap are independent, so that their alarms are binomial: 99.9 % of it, and not more."""
    _, measurements = record(200, 1000, seed=13)
    found = NisMonitor(window, 0.01).watch(track(Kalman(POSITION, ConstantVelocity(0.3)), measurements, PRIOR, 0.0))
    alone = found.alarm[window - 1 :: window]
    low, high = binom.ppf([5e-4, 1 - 5e-4], alone.size, 0.01)
    assert low <= alone.sum() <= high
