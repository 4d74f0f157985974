"""Statistics judged by the laws they must follow: chi-square, Student, binomial, and a filter on its own model."""

from __future__ import annotations

import numpy as np
import pytest
from scipy import stats

from tracking.consistency import Consistency, autocorrelation, lost, normalised_error
from tracking.gaussian import Gaussian, Mixture
from tracking.intervals import (
    bootstrap,
    correlation_band,
    gain,
    mean_interval,
    mean_square_band,
    paired_difference,
    proportion,
    rmse,
    rmse_band,
)
from tracking.measurement import LinearMeasurement
from tracking.motion import ConstantVelocity, planar_constant_velocity
from tracking.track import Measurements, follow
from tracking.trackers.kalman import Kalman

MEASURE_POSITION = LinearMeasurement(((1.0, 0.0, 0.0, 0.0), (0.0, 0.0, 1.0, 0.0)))
PRIOR = np.diag([400.0, 25.0, 400.0, 25.0])
POSITION = (0, 2)


def own_model(runs: int, epochs: int, density: float, seed: int):
    """Truths (k, n, N) drawn from constant velocity and position measurements of 20 m, period 1 s."""
    generator = np.random.default_rng(seed)
    F, Q = planar_constant_velocity(1.0, density, density)
    root = np.linalg.cholesky(Q)
    x = np.linalg.cholesky(PRIOR) @ generator.standard_normal((4, runs))
    truths = []
    for _ in range(epochs):
        x = F @ x + root @ generator.standard_normal((4, runs))
        truths.append(x)
    truth = np.stack(truths)
    z = truth[:, [0, 2]] + 20.0 * generator.standard_normal((epochs, 2, runs))
    time = np.arange(1.0, epochs + 1.0)
    R = np.broadcast_to(400.0 * np.eye(2), (epochs, 2, 2))
    return truth, Measurements(("radar.north", "radar.east"), time, time, z, R)


def judged(tracker, truth, measurements):
    statistics = Consistency(POSITION)
    sums = statistics.begin()
    for epoch in follow(tracker, measurements, Gaussian(np.zeros(4), PRIOR), start=0.0):
        sums = statistics.add(sums, epoch.estimate, truth[epoch.row], epoch.innovation)
    return sums


def tracker(density: float) -> Kalman:
    return Kalman(MEASURE_POSITION, ConstantVelocity(density))


@pytest.fixture(scope="module")
def consistent():
    truth, measurements = own_model(400, 60, 0.5, seed=1)
    return Consistency(POSITION).summary(judged(tracker(0.5), truth, measurements))


@pytest.fixture(scope="module")
def overconfident():
    truth, measurements = own_model(400, 60, 0.5, seed=1)
    return Consistency(POSITION).summary(judged(tracker(0.02), truth, measurements))


def test_bands_are_the_textbooks():
    """The bands of the literature for the numbers of runs in use, to the printed digits."""
    assert np.round(mean_square_band(4, 130), 3).tolist() == [0.882, 1.125]
    assert np.round(mean_square_band(2, 130), 3).tolist() == [0.835, 1.179]
    assert np.round(rmse_band(50), 3).tolist() == [0.804, 1.195]
    assert np.round(rmse_band(130), 3).tolist() == [0.879, 1.121]
    assert correlation_band(400) == pytest.approx(0.098, abs=1e-4)


def test_a_filter_on_its_own_model_is_consistent(consistent):
    """95 % intervals hold the right value; the tolerances below leave four standard errors of the shares."""
    assert consistent.anees.value == pytest.approx(1.0, abs=0.04)  # 400 runs, correlated in time: s.e. about 0.01
    assert consistent.anees_position.value == pytest.approx(1.0, abs=0.06)
    assert consistent.anis.value == pytest.approx(1.0, abs=4 * np.sqrt(2 / (2 * 400 * 60)))
    for measured, asked in zip(consistent.coverage, (0.5, 0.9, 0.95), strict=True):
        assert measured.value == pytest.approx(asked, abs=0.03)
    for measured, asked in zip(consistent.coverage_position, (0.5, 0.9, 0.95), strict=True):
        assert measured.value == pytest.approx(asked, abs=0.03)
    assert consistent.white_epochs.value > 0.95 - 4 * np.sqrt(0.95 * 0.05 / 118)
    assert abs(consistent.correlation.value) < 4 / np.sqrt(2 * 400 * 60)
    assert consistent.unbiased_epochs.value > 0.8  # correlated in time: a wide margin
    assert consistent.lost.value == 0.0
    assert consistent.lost.high == pytest.approx(0.0095, abs=5e-4)  # Wilson at none of 400
    assert abs(consistent.inclination.value) < 0.3


def test_a_filter_with_too_small_process_noise_is_told_so(overconfident, consistent):
    assert overconfident.anees.low > 1.5
    assert overconfident.anis.low > 1.05
    assert overconfident.correlation.low > 0.05
    assert overconfident.white_epochs.high < 0.9
    assert overconfident.coverage[2].high < 0.9
    assert overconfident.inclination.low > 1.0
    assert overconfident.noncredibility.low > consistent.noncredibility.high
    assert overconfident.rmse_position.low > consistent.rmse_position.high


def test_a_bias_is_found():
    truth, measurements = own_model(200, 30, 0.5, seed=2)
    statistics = Consistency(POSITION)
    shifted = truth + np.array([5.0, 0.0, 0.0, 0.0])[:, None]  # a quarter of the measurement error
    summary = statistics.summary(judged(tracker(0.5), shifted, measurements))
    assert summary.unbiased_epochs.high < 0.3


def test_the_log_score_prefers_the_true_model():
    truth, measurements = own_model(200, 40, 0.5, seed=3)
    right = judged(tracker(0.5), truth, measurements)
    for wrong in (0.02, 20.0):
        other = judged(tracker(wrong), truth, measurements)
        assert paired_difference(right.runs.log_likelihood, other.runs.log_likelihood).low > 0.0


def test_chunks_join_to_the_whole():
    """Sums are exact; only the credibility indices look at the runs of one chunk together."""
    truth, measurements = own_model(60, 10, 0.5, seed=4)
    statistics = Consistency(POSITION)
    whole = judged(tracker(0.5), truth, measurements)
    parts = [
        judged(tracker(0.5), truth[..., chosen], measurements.runs(chosen)) for chosen in (slice(0, 25), slice(25, 60))
    ]
    joined = statistics.join(*parts)
    for name, value in joined.runs._asdict().items():
        if "log_ratio" not in name:
            np.testing.assert_allclose(value, getattr(whole.runs, name), rtol=1e-12, atol=1e-9)
    for mine, theirs in zip(joined.epochs, whole.epochs, strict=True):
        np.testing.assert_allclose(mine.product, theirs.product, rtol=1e-12)
        np.testing.assert_allclose(mine.lagged, theirs.lagged, rtol=1e-9, atol=1e-9)
        assert mine.runs == 60
    with pytest.raises(ValueError, match="same epochs"):
        statistics.join(parts[0], judged(tracker(0.5), truth[:5, :, :25], own_model(25, 5, 0.5, 1)[1]))


def test_lost_means_ten_epochs_outside_in_a_row_or_not_finite():
    statistics = Consistency((0, 1))
    sums, squares = statistics.begin(), []
    limit = stats.chi2.isf(1e-6, 2)
    far, near = np.sqrt(limit) * 1.001, np.sqrt(limit) * 0.999
    for epoch in range(25):
        error = np.zeros((2, 4))
        error[0, 0] = far if epoch < 10 else 0.0  # lost, then found again: it was lost
        error[0, 1] = far if epoch % 10 < 9 else near  # nine in a row at most
        error[0, 2] = np.nan if epoch == 20 else 0.0
        sums = statistics.add(sums, Gaussian(error, np.eye(2)), np.zeros(2), None)
        squares.append((error**2).sum(axis=0))
    assert sums.runs.lost.tolist() == [True, False, True, False]
    assert lost(np.array(squares), 2).tolist() == [True, False, True, False]
    summary = statistics.summary(sums)
    assert summary.lost.value == 0.5
    assert np.isfinite(summary.rmse_position.value)  # the run that ended as NaN is counted as lost, not averaged


def test_normalised_error_of_parts_and_of_mixtures():
    """Against the plain inverse."""
    generator = np.random.default_rng(5)
    root = generator.standard_normal((4, 4))
    P = root @ root.T + np.eye(4)
    error = generator.standard_normal((4, 7))
    expected = np.einsum("iN,ij,jN->N", error, np.linalg.inv(P), error)
    np.testing.assert_allclose(normalised_error(Gaussian(error, P[..., None]), np.zeros((4, 1))), expected, rtol=1e-10)
    part = np.ix_(POSITION, POSITION)
    expected = np.einsum("iN,ij,jN->N", error[[0, 2]], np.linalg.inv(P[part]), error[[0, 2]])
    measured = normalised_error(Gaussian(error, P[..., None]), np.zeros((4, 1)), POSITION)
    np.testing.assert_allclose(measured, expected, rtol=1e-10)
    twins = Mixture(np.full((2, 7), 0.5), np.stack([error, error], axis=1), np.stack([P, P], axis=2)[..., None])
    np.testing.assert_allclose(normalised_error(twins, np.zeros((4, 1)), POSITION), measured, rtol=1e-10)


@pytest.mark.parametrize(
    ("measure", "truth"),
    [
        (lambda e, g: rmse(np.mean(e**2, axis=0)), np.sqrt(2.0)),
        (lambda e, g: gain(np.mean(4.0 * e**2 + 4.0, axis=0), np.mean(e**2, axis=0)), np.sqrt(6.0)),
        (lambda e, g: mean_interval(e[0] ** 2), 2.0),
        (lambda e, g: bootstrap(lambda s: s.mean(axis=-1), (e[0] ** 2,), g, resamples=200), 2.0),
    ],
    ids=["rmse", "gain", "mean", "bootstrap"],
)
def test_intervals_hold_the_truth_as_often_as_they_say(measure, truth):
    """200 repetitions of 80 correlated runs of variance 2: 95 % - 4 standard errors (1.5 %) - 2 % for skewness."""
    generator = np.random.default_rng(6)
    hits = 0
    for _ in range(200):
        common = generator.standard_normal((1, 80))
        error = common + generator.standard_normal((12, 80))
        hits += measure(error, generator).contains(truth)
    assert 0.95 - 0.082 < hits / 200 < 1.0


def test_pairing_narrows_a_gain():
    generator = np.random.default_rng(7)
    shared = generator.chisquare(2, 300)
    paired = gain(shared * 1.44, shared * generator.uniform(0.95, 1.05, 300))
    unpaired = gain(shared * 1.44, generator.permutation(shared))
    assert paired.high - paired.low < 0.1 * (unpaired.high - unpaired.low)
    assert paired.contains(1.2)


def test_wilson_at_the_edges():
    """Against scipy's own Wilson interval."""
    for count, trials in ((0, 10), (3, 10), (10, 10), (1, 1000)):
        expected = stats.binomtest(count, trials).proportion_ci(method="wilson")
        measured = proportion(count, trials)
        assert (measured.low, measured.high) == pytest.approx((expected.low, expected.high), abs=1e-12)


def test_one_run_says_nothing_about_its_interval():
    for interval in (rmse([4.0]), mean_interval([4.0]), gain([4.0], [1.0])):
        assert interval.runs == 1
        assert np.isnan(interval.low)
        assert np.isnan(interval.high)
    assert rmse([4.0]).value == gain([4.0], [1.0]).value == 2.0
    assert np.isnan(rmse([]).value)


def test_autocorrelation_of_white_and_of_coloured_innovations():
    generator = np.random.default_rng(8)
    white = generator.standard_normal((2000, 2))
    band = correlation_band(4000, 0.9999)
    assert np.abs(autocorrelation(white, 5)[1:]).max() < band
    coloured = white[1:] + 0.3 * white[:-1]
    assert autocorrelation(coloured, 2)[1] == pytest.approx(0.3 / 1.09, abs=band)
    white[10] = np.nan  # absent
    assert np.isfinite(autocorrelation(white, 1)).all()
