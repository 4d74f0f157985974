"""The load-factor tracker against plain Kalman filters, dead reckoning, single runs and itself without its aid."""

from __future__ import annotations

import numpy as np
import pytest

from tests.tracking.radar_flights import (
    DEGREE,
    FINE,
    MEASURED,
    azimuth_errors,
    base_turn,
    deaf,
    observed,
    prior_of,
    rms,
    s_turn,
)
from tracking.gaussian import Gaussian, predict, update
from tracking.motion import singer
from tracking.track import Measurements, track
from tracking.trackers.load_factor import DOWNLINK, LoadFactor

MODES = ("published", "intended", "corrected", "corrected_residual")


def test_blocks_are_plain_kalman_filters_and_gains_do_not_look_at_the_data():
    flight, rng = base_turn(), np.random.default_rng(2)
    _, measurements = observed(flight, 0.7, 0.15 * DEGREE, 3, rng)
    prior = prior_of(flight, 0.15 * DEGREE, 3, rng)
    tracker = LoadFactor(MEASURED, 0.0)
    state, judge = tracker.begin(Gaussian(prior.mean, prior.cov[..., None])), None
    F, Q = singer(0.7, 20.0, 1e4 / 40.0)
    mean = np.vstack([prior.mean[:2], np.zeros((1, 3))])
    judge = Gaussian(mean, np.diag([*np.diag(prior.cov)[:2], 1e4 / 40.0]))
    for z, R in zip(measurements.z[:40], measurements.R, strict=False):
        state, _ = tracker.step(state, 0.7, z, R[..., None])
        judge, _ = update(predict(judge, F, Q), z[:1], np.eye(1, 3), R[:1, :1])
    np.testing.assert_allclose(state.blocks.range.mean, judge.mean, rtol=1e-10, atol=1e-9)
    np.testing.assert_allclose(state.blocks.range.cov[..., 0], judge.cov, rtol=1e-9)
    assert all(block.cov.shape[-1] == 1 for block in state.blocks)  # one Riccati recursion for all runs


@pytest.mark.parametrize("mode", ["published", "intended", "corrected"])
def test_printed_azimuth_block_never_corrects_its_acceleration(mode):
    tracker = LoadFactor(MEASURED, 0.0, mode)
    flight, rng = base_turn(), np.random.default_rng(3)
    _, measurements = observed(flight, 0.7, DEGREE, 1, rng)
    state = tracker.begin(prior_of(flight, DEGREE, 1, rng)._replace(cov=np.eye(6)[..., None] * 1e-4))
    for z, R in zip(measurements.z[:5], measurements.R, strict=False):
        state, _ = tracker.step(state, 0.7, z, R[..., None])
        moved, aid, _ = tracker._azimuth_now(state._replace(blocks=aged(state.blocks, 0.7)))
        assert (moved.cov[2, 0] == 0.0).all()  # so K31 = P31 / S is zero, whatever the data
        np.testing.assert_array_equal(moved.mean[2], aid)


def aged(blocks, by):
    return type(blocks)(*(block._replace(clock=block.clock + by) for block in blocks))


def test_the_tracker_flags_where_the_print_is_clamped():
    """Half of a base turn, and never where the formula is signed."""
    flight, rng = base_turn(), np.random.default_rng(14)
    rows, measurements = observed(flight, 0.7, DEGREE, 4, rng, scale=0.1)
    prior = prior_of(flight, DEGREE, 4, rng, scale=0.1)
    flags = {}
    for mode in ("published", "corrected"):
        tracker = LoadFactor(MEASURED, 0.0, mode)
        state, flags[mode] = tracker.begin(Gaussian(prior.mean, prior.cov[..., None])), []
        for z, R in zip(measurements.z, measurements.R, strict=True):
            state, _ = tracker.step(state, 0.7, z, R[..., None])
            assert np.isfinite(tracker.estimate(state).mean).all()
            flags[mode].append(state.clamped)
    turning = flight["turning"][rows]
    assert 0.3 < np.mean(np.array(flags["published"])[turning]) < 0.7  # 0.48 on the flight itself
    assert not np.any(flags["corrected"])


def test_a_sample_between_scans_touches_its_own_block_alone():
    tracker, rng = LoadFactor(MEASURED, 0.0), np.random.default_rng(4)
    flight = base_turn()
    _, measurements = observed(flight, 0.7, DEGREE, 1, rng)
    prior = prior_of(flight, DEGREE, 1, rng)
    state = tracker.begin(Gaussian(prior.mean[:, 0], prior.cov))
    for z, R in zip(measurements.z[:10, :, 0], measurements.R, strict=False):
        state, _ = tracker.step(state, 0.7, z, R)
    alone = np.full(9, np.nan)
    alone[MEASURED.index("link.aerodynamic_bank")] = -0.2
    after, innovation = tracker.step(state, 0.1, alone, measurements.R[0])
    assert np.isfinite(innovation.white).sum() == 1
    own = DOWNLINK.index("aerodynamic_bank")
    for name, block in after.blocks._asdict().items():
        old, others = getattr(state.blocks, name), slice(None)
        if name == "downlink":
            assert block.clock[own] == 0.0
            assert block.mean[0, own] != old.mean[0, own]
            others = np.arange(6) != own
        np.testing.assert_allclose(np.atleast_1d(block.clock)[others], np.atleast_1d(old.clock + 0.1)[others])
        if name == "downlink":
            np.testing.assert_array_equal(block.mean[:, others], old.mean[:, others])
            np.testing.assert_array_equal(block.cov[:, :, others], old.cov[:, :, others])
        else:
            np.testing.assert_array_equal(block.mean, old.mean)
            np.testing.assert_array_equal(block.cov, old.cov)


@pytest.mark.parametrize("mode", MODES)
def test_a_batch_is_its_runs_with_measurements_missing(mode):
    """Every run misses other channels, one loses the downlink for 5 s, all lose the radar for 3 s."""
    flight, rng = base_turn(), np.random.default_rng(5)
    _, measurements = observed(flight, 0.5, 0.15 * DEGREE, 3, rng)
    z = np.array(measurements.z[60:110])
    z[rng.random(z.shape) < 0.2] = np.nan
    z[10:20, 3:, 1] = np.nan
    z[25:31, :3] = np.nan
    z[40] = np.nan
    time, R = measurements.time[60:110], measurements.R[60:110]
    prior = Gaussian(np.array([9000.0, -20.0, 0.2, -0.008, 0.04, 0.0]), np.diag([100, 5, 0.01, 0.002, 0.01, 5e-4]) ** 2)
    tracker = LoadFactor(MEASURED, 0.0, mode)
    batch = track(tracker, Measurements(MEASURED, time, time, z, R), prior)
    assert np.isfinite(batch.mean).all()
    scale = np.sqrt(np.einsum("kiin->kin", batch.cov))
    for run in range(3):
        alone = track(tracker, Measurements(MEASURED, time, time, z[..., run], R), prior)
        difference = np.abs(batch.mean[..., run] - alone.mean) / scale[..., run]
        assert difference.max() < 1e-10  # sigmas; angles are wrapped, which costs 4e-16 rad
        np.testing.assert_allclose(batch.cov[..., run], alone.cov, rtol=1e-9, atol=1e-24)
        np.testing.assert_allclose(batch.log_likelihood[:, run], alone.log_likelihood, rtol=1e-9, atol=1e-9)


def test_absent_measurements_are_pure_prediction():
    tracker, rng = LoadFactor(MEASURED, 0.0), np.random.default_rng(6)
    flight = base_turn()
    _, measurements = observed(flight, 0.7, DEGREE, 1, rng)
    prior = prior_of(flight, DEGREE, 1, rng)
    state = tracker.begin(Gaussian(prior.mean[:, 0], prior.cov))
    for z, R in zip(measurements.z[:70, :, 0], measurements.R, strict=False):
        state, _ = tracker.step(state, 0.7, z, R)
    nothing = state
    for _ in range(8):
        state, innovation = tracker.step(state, 0.5, np.full(9, np.nan), measurements.R[0])
        nothing, _ = tracker.step(nothing, 0.5, None, None)
    at_once, _ = tracker.step(state._replace(blocks=aged(state.blocks, -4.0)), 4.0, None, None)
    assert innovation.nis == 0.0
    for other in (nothing, at_once):
        np.testing.assert_allclose(tracker.estimate(other).mean, tracker.estimate(state).mean, rtol=1e-12)
        np.testing.assert_allclose(tracker.estimate(other).cov, tracker.estimate(state).cov, rtol=1e-12)


def test_only_differences_of_courses_count():
    """The whole scene turned with the radar's zero azimuth: the same estimates, whatever way GOST's X points."""
    flight, rng = s_turn(), np.random.default_rng(7)
    _, measurements = observed(flight, 0.5, 0.15 * DEGREE, 1, rng)
    prior = prior_of(flight, 0.15 * DEGREE, 1, rng)
    z = np.array(measurements.z)
    z[:, MEASURED.index("link.air_course")] += 2.5
    turned = Measurements(MEASURED, measurements.time, measurements.arrival, z, measurements.R)
    one = azimuth_errors(LoadFactor(MEASURED, 0.0), flight, np.arange(len(z)), measurements, prior)
    other = azimuth_errors(LoadFactor(MEASURED, 2.5), flight, np.arange(len(z)), turned, prior)
    np.testing.assert_allclose(one, other, rtol=0, atol=1e-9)


# What it is worth: small samples, the figures at full size in tests/acceptance


def test_dead_reckoning_without_azimuth_measurements():
    """Exact start, noise-free inputs, trapezoid rule: at most 0.2 deg after two minutes."""
    flight, rng = base_turn(), np.random.default_rng(8)
    _, measurements = observed(flight, 0.5, DEGREE, 1, rng, scale=0.0)
    z = np.array(measurements.z)
    z[:, 1] = np.nan
    blind = Measurements(MEASURED, measurements.time, measurements.arrival, z, 1e-6 * measurements.R)
    prior = prior_of(flight, DEGREE, 1, rng, scale=0.0)
    rows = np.searchsorted(flight["time"], measurements.time - FINE / 2)
    errors = azimuth_errors(LoadFactor(MEASURED, 0.0), flight, rows, blind, prior)
    assert np.abs(errors).max() < 0.2 * DEGREE


def test_the_corrected_aid_pays_in_a_turn_and_the_printed_one_does_not():
    """Gains over a constant-acceleration filter in the base turn, .5 s and .15 deg, all tuned on other seeds."""
    flight, rng, angle, runs = base_turn(), np.random.default_rng(9), 0.15 * DEGREE, 25
    rows, measurements = observed(flight, 0.5, angle, runs, rng)
    prior = prior_of(flight, angle, runs, rng)
    turning = flight["turning"][rows]
    plain = azimuth_errors(LoadFactor(MEASURED, 0.0), flight, rows, deaf(measurements), prior)[turning]
    aided = azimuth_errors(LoadFactor(MEASURED, 0.0), flight, rows, measurements, prior)[turning]
    printed = azimuth_errors(
        LoadFactor(MEASURED, 0.0, "published", azimuth_density=1e-7), flight, rows, measurements, prior
    )[turning]
    assert 1.3 < rms(plain) / rms(aided) < 2.2
    assert 0.8 < rms(plain) / rms(printed) < 1.25
    trusted = azimuth_errors(
        LoadFactor(MEASURED, 0.0, "published", azimuth_density=1e-10), flight, rows, measurements, prior
    )[turning]
    assert rms(trusted) > 2 * rms(plain)  # believing it is far worse than doing without


def test_a_silent_downlink_leaves_the_kinematic_filter():
    """30 s without downlink in the turn: with the switch to kinematic noise at most a little worse than without aid."""
    flight, rng, angle, runs = base_turn(), np.random.default_rng(10), 0.15 * DEGREE, 25
    rows, measurements = observed(flight, 0.5, angle, runs, rng)
    prior = prior_of(flight, angle, runs, rng)
    gap = (measurements.time >= 45.0) & (measurements.time < 75.0)
    plain = azimuth_errors(LoadFactor(MEASURED, 0.0), flight, rows, deaf(measurements), prior)[gap]
    lost = azimuth_errors(LoadFactor(MEASURED, 0.0), flight, rows, deaf(measurements, gap), prior)[gap]
    stubborn = LoadFactor(MEASURED, 0.0, dropout=1e3)  # never admits the silence
    kept = azimuth_errors(stubborn, flight, rows, deaf(measurements, gap), prior)[gap]
    assert rms(lost) < 1.10 * rms(plain)  # 25 runs know the ratio to 3 %; 1.05 is asked at full size
    assert rms(kept) > 1.5 * rms(plain)


@pytest.mark.parametrize(
    ("measured", "fields", "sentence"),
    [
        (MEASURED[:8], {}, "air_course"),
        (("other.range", *MEASURED[1:]), {}, "one radar"),
        (MEASURED, {"dropout": 0.0}, "dropout"),
        (MEASURED, {"azimuth_density": -1.0}, "azimuth_density"),
    ],
)
def test_parameters_out_of_range_are_refused(measured, fields, sentence):
    with pytest.raises(ValueError, match=sentence):
        LoadFactor(measured, 0.0, **fields)
