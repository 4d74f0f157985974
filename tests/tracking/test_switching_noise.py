"""The switching-noise filter against exact Bayes, its scalar closed form, the Kalman filter and the bound."""

import itertools

import numpy as np
import pytest

from tracking.gaussian import Gaussian, merge
from tracking.track import Measurements, track
from tracking.trackers.elevation import PERIOD, Elevation, increments
from tracking.trackers.switching_noise import BeamNoise, SwitchingNoise, stationary

DEGREE = np.pi / 180
R = np.array([[0.0036]]) * DEGREE**2
PRIOR = Gaussian(np.array([2.2906, 0.0]) * DEGREE, np.diag([0.005, 0.0122**2]) * DEGREE**2)
MEASURED = ("mls.elevation",)


def bursts(length: float, share: float = 0.2) -> tuple[tuple[float, float], ...]:
    """Chain of anomalies that last ``length`` steps on average and fill a share of the time."""
    leave = 1.0 / length
    enter = leave * share / (1.0 - share)
    return (1.0 - enter, enter), (leave, 1.0 - leave)


def glide(rng, runs, steps, chain=((0.8, 0.2), (0.8, 0.2)), factors=(1.0, 30.0)):
    """Model truth (steps, 2, runs), measurements (steps, 1, runs) in rad, and which accuracy held (steps, runs)."""
    chain, factors = np.array(chain), np.array(factors)
    cumulative = chain.cumsum(axis=1)
    state = (rng.random(runs)[:, None] > stationary(chain).cumsum()).sum(axis=1)
    x = PRIOR.mean[:, None] + np.sqrt(np.diag(PRIOR.cov))[:, None] * rng.standard_normal((2, runs))
    A, _ = increments(2, PERIOD, PERIOD, 1.0)
    truth, z, which = np.empty((steps, 2, runs)), np.empty((steps, 1, runs)), np.empty((steps, runs), dtype=int)
    for k in range(steps):
        state = (rng.random(runs)[:, None] > cumulative[state]).sum(axis=1)
        x = A @ x
        x[1] += 0.01 * DEGREE * rng.standard_normal(runs)
        truth[k], which[k] = x, state
        z[k] = x[0] + 0.06 * DEGREE * factors[state] * rng.standard_normal(runs)
    return truth, z, which


def tracked(tracker, z, channels=MEASURED):
    time = PERIOD * np.arange(1, len(z) + 1)
    variances = np.broadcast_to(R[0, 0] * np.eye(len(channels)), (len(z), len(channels), len(channels)))
    return track(tracker, Measurements(channels, time, time, z, variances), PRIOR, start=0.0)


def closed_form(x, P, z, factors, weights):
    """(12)-(14) for scalar z and one prior in closed form: no hypothesis' posterior is ever formed."""
    p, v = P[:, 0], z - x[0]
    k = 1.0 / (P[0, 0] + np.square(factors) * R[0, 0])
    w = weights * np.sqrt(k) * np.exp(-0.5 * v**2 * k)
    w = w / w.sum()
    m = (w * k).sum()
    spread = (w * k**2).sum() - m**2
    return x + p * m * v, P - np.outer(p, p) * (m - v**2 * spread), w


def test_golden_steps():
    tracker = SwitchingNoise(MEASURED)
    state, seen = tracker.begin(PRIOR), []
    for _ in range(2):
        state, _ = tracker.step(state, PERIOD, np.array([2.4906 * DEGREE]), R)
        mean, cov = merge(state)
        seen.append((mean[0] / DEGREE, cov[0, 0] / DEGREE**2, state.weights[1]))
    expected = [(2.39345791, 0.00380502, 0.1157354), (2.44227795, 0.00194644, 0.02205798)]
    np.testing.assert_allclose(seen, expected, rtol=2e-6)  # the printed digits


@pytest.mark.parametrize(
    ("factors", "switching"),
    [((1.0, 30.0), ((0.8, 0.2), (0.8, 0.2))), ((1.0, 5.0, 30.0), ((0.7, 0.2, 0.1),) * 3)],
)
def test_equal_rows_are_independent_accuracies_in_closed_form(factors, switching):
    _, z, _ = glide(np.random.default_rng(1), 1, 200)
    result = tracked(SwitchingNoise(MEASURED, factors, switching), z[:, :, 0])
    A, Q = increments(2, PERIOD, PERIOD, 0.01 * DEGREE)
    x, P = PRIOR
    for k in range(200):
        x, P, w = closed_form(A @ x, A @ P @ A.T + Q, z[k, 0, 0], factors, np.array(switching[0]))
        np.testing.assert_allclose(result.mean[k], x, rtol=1e-11, atol=1e-14)
        np.testing.assert_allclose(result.cov[k], P, rtol=1e-9, atol=1e-18)  # the closed form cancels P - ...
        np.testing.assert_allclose(result.model_probabilities[k], w, rtol=0, atol=1e-11)


def test_markov_chain_is_the_recursion_written_out():
    """(10)-(11) with a chain of three accuracies that is not symmetric, by plain loops."""
    factors, chain = (1.0, 5.0, 30.0), ((0.9, 0.07, 0.03), (0.3, 0.6, 0.1), (0.05, 0.15, 0.8))
    _, z, _ = glide(np.random.default_rng(2), 1, 60, chain, factors)
    result = tracked(SwitchingNoise(MEASURED, factors, chain), z[:, :, 0])
    A, Q = increments(2, PERIOD, PERIOD, 0.01 * DEGREE)
    (x, P), w = PRIOR, stationary(np.array(chain))
    for k in range(60):
        predicted = np.array([sum(w[j] * chain[j][i] for j in range(3)) for i in range(3)])
        x, P, w = closed_form(A @ x, A @ P @ A.T + Q, z[k, 0, 0], factors, predicted)
        np.testing.assert_allclose(result.model_probabilities[k], w, rtol=0, atol=1e-11)
        np.testing.assert_allclose(result.mean[k], x, rtol=1e-11, atol=1e-14)


@pytest.mark.parametrize("factors", [(1.0,), (1.0, 1.0)])
def test_one_accuracy_is_the_kalman_filter(factors):
    _, z, _ = glide(np.random.default_rng(3), 5, 100)
    z[30:40, :, 2] = np.nan
    chain = ((1.0,),) if len(factors) == 1 else ((0.8, 0.2), (0.3, 0.7))
    switching, kalman = tracked(SwitchingNoise(MEASURED, factors, chain), z), tracked(Elevation(MEASURED), z)
    np.testing.assert_allclose(switching.mean, kalman.mean, rtol=1e-12, atol=1e-15)
    # Residuals in sigmas magnify the rounding of an angle by 1e3, anomalous ones by 30 more.
    np.testing.assert_allclose(switching.log_likelihood, kalman.log_likelihood, rtol=1e-11, atol=1e-11)
    np.testing.assert_allclose(switching.cov, np.broadcast_to(kalman.cov, switching.cov.shape), rtol=1e-10)


def test_no_accuracy_at_all_is_a_missing_measurement():
    _, z, _ = glide(np.random.default_rng(4), 3, 50)
    worthless = tracked(SwitchingNoise(MEASURED, (1e12,), ((1.0,),)), z)
    missing = tracked(SwitchingNoise(MEASURED), np.full_like(z, np.nan))
    np.testing.assert_allclose(worthless.mean, np.broadcast_to(missing.mean, worthless.mean.shape), rtol=0, atol=1e-12)
    np.testing.assert_allclose(worthless.cov, np.broadcast_to(missing.cov, worthless.cov.shape), rtol=1e-12)


def test_a_missed_measurement_says_nothing_about_the_accuracy():
    chain = ((0.98, 0.02), (0.1, 0.9))
    tracker = SwitchingNoise(MEASURED, switching=chain)
    state, _ = tracker.step(tracker.begin(PRIOR), PERIOD, PRIOR.mean[:1] + 0.5 * DEGREE, R)
    missed, innovation = tracker.step(state, PERIOD, np.array([np.nan]), R)
    predicted, _ = tracker.step(state, PERIOD, None, None)
    np.testing.assert_allclose(missed.weights, state.weights @ np.array(chain), rtol=1e-14)
    np.testing.assert_array_equal(missed.weights, predicted.weights)
    np.testing.assert_array_equal(missed.mean, predicted.mean)
    assert innovation.log_likelihood == pytest.approx(0.0, abs=1e-15)


def exact_bayes(z, steps):
    """Mean and variance of the angle given z under all 2^steps histories of the accuracy, runs in the last axis."""
    A, Q = increments(2, PERIOD, PERIOD, 0.01 * DEGREE)
    branches = []
    for history in itertools.product((1.0, 30.0), repeat=steps):
        x, P, log_weight = np.repeat(PRIOR.mean[:, None], z.shape[2], axis=1), PRIOR.cov, 0.0
        for k, factor in enumerate(history):
            x, P = A @ x, A @ P @ A.T + Q
            S, v = P[0, 0] + factor**2 * R[0, 0], z[k, 0] - x[0]
            x, P = x + (P[:, :1] / S) * v, P - P[:, :1] @ P[:1] / S
            log_weight = log_weight + np.log(0.8 if factor == 1.0 else 0.2) - 0.5 * (v**2 / S + np.log(S))
        branches.append((log_weight, x[0], P[0, 0]))
    log_weights, means, variances = (np.array(column) for column in zip(*branches, strict=True))
    w = np.exp(log_weights - log_weights.max(axis=0))
    w /= w.sum(axis=0)
    mean = (w * means).sum(axis=0)
    return mean, (w * (variances[:, None] + (means - mean) ** 2)).sum(axis=0)


def test_exact_bayes_after_one_step_and_nearly_so_after_seven():
    truth, z, _ = glide(np.random.default_rng(5), 400, 7)
    result = tracked(SwitchingNoise(MEASURED), z)
    mean, variance = exact_bayes(z, 1)
    np.testing.assert_allclose(result.mean[0, 0], mean, rtol=0, atol=1e-14)
    np.testing.assert_allclose(result.cov[0, 0, 0], variance, rtol=1e-10)
    mean, _ = exact_bayes(z, 7)
    difference = (result.mean[6, 0] - mean) / DEGREE
    assert 1e-5 < np.sqrt(np.mean(difference**2)) < 0.004  # deg: collapsing costs something, a tenth of the error
    loss = np.mean((result.mean[6, 0] - truth[6, 0]) ** 2) / np.mean((mean - truth[6, 0]) ** 2)
    assert loss < 1.04


def errors(tracker, truth, z, settled):
    """Mean square error (deg^2) of the angle and normalised error squared, after the transient."""
    result = tracked(tracker, z)
    e = (result.mean - truth)[settled:]
    cov = np.broadcast_to(result.cov, (*result.cov.shape[:3], z.shape[2]))[settled:]
    P11, P12, P22 = cov[:, 0, 0], cov[:, 0, 1], cov[:, 1, 1]
    nees = (P22 * e[:, 0] ** 2 - 2.0 * P12 * e[:, 0] * e[:, 1] + P11 * e[:, 1] ** 2) / (P11 * P22 - P12**2)
    return np.mean(e[:, 0] ** 2) / DEGREE**2, np.mean(nees) / 2.0, result


def test_anomalies_cost_little_and_are_found():
    """Steady state of the paper's experiment at a small sample: about 6000 independent errors, so 5 % tolerances."""
    truth, z, which = glide(np.random.default_rng(6), 300, 500)
    mse, nees, result = errors(SwitchingNoise(MEASURED), truth, z, 150)
    plain, overconfident, _ = errors(Elevation(MEASURED), truth, z, 150)
    assert mse == pytest.approx(3.99e-4, rel=0.08)
    assert nees == pytest.approx(1.0, abs=0.06)
    assert 95 < plain / mse < 125  # in variance; 10.3 in RMS. The print's 25-30 follows from neither
    assert overconfident > 50  # the Kalman filter believes its own 3.12e-4
    found = result.model_probabilities[150:, 1] > 0.5
    anomalous = which[150:] == 1
    assert found[anomalous].mean() == pytest.approx(0.914, abs=0.015)
    assert found[~anomalous].mean() == pytest.approx(0.0021, abs=0.001)


def test_efficiency_against_the_bound_of_the_mixture_noise():
    """Riccati recursion with the mixture's Fisher information, 0.745 / R; the reference is 99.2 % in RMS."""
    truth, z, _ = glide(np.random.default_rng(7), 600, 500)
    mse, _, _ = errors(SwitchingNoise(MEASURED), truth, z, 150)
    A, Q = increments(2, PERIOD, PERIOD, 0.01)
    P = np.eye(2)
    for _ in range(2000):
        P = A @ P @ A.T + Q
        P = P - P[:, :1] @ P[:1] / (P[0, 0] + 0.0036 / 0.7450)
    efficiency = np.sqrt(P[0, 0] / mse)
    assert efficiency > 0.96  # the requirement is 0.98; RMS known to 1.5 % here, at full size in the acceptance test
    assert efficiency < 1.03


def test_without_anomalies_it_is_almost_the_kalman_filter():
    truth, z, _ = glide(np.random.default_rng(8), 300, 400, ((1.0, 0.0), (1.0, 0.0)))
    mse, _, result = errors(SwitchingNoise(MEASURED), truth, z, 150)
    plain, _, _ = errors(Elevation(MEASURED), truth, z, 150)
    assert 1.0 <= mse / plain < 1.04  # paired, so the common noise cancels
    assert result.model_probabilities[150:, 1].mean() == pytest.approx(0.021, abs=0.004)  # the print says 0


def test_bursts_need_the_markov_chain():
    length = 40
    truth, z, _ = glide(np.random.default_rng(9), 150, 1000, bursts(length))
    markov, _, _ = errors(SwitchingNoise(MEASURED, switching=bursts(length)), truth, z, 200)
    independent, inconsistent, _ = errors(SwitchingNoise(MEASURED), truth, z, 200)
    plain, _, _ = errors(Elevation(MEASURED), truth, z, 200)
    assert markov < plain / 8
    assert independent > 8 * markov
    assert inconsistent > 3


def test_an_outlier_far_beyond_underflow_still_ranks_the_hypotheses():
    tracker = SwitchingNoise(MEASURED, factors=(1.0, 5.0))
    state, innovation = tracker.step(tracker.begin(PRIOR), PERIOD, PRIOR.mean[:1] + 90.0 * DEGREE, R)
    assert np.isfinite(merge(state).mean).all()
    assert np.isfinite(innovation.log_likelihood)
    np.testing.assert_allclose(state.weights, [0.0, 1.0], atol=1e-300)


def test_the_spread_of_the_hypotheses_counts():
    """A doubtful measurement can leave more doubt than there was: P11 depends on the data and may grow."""
    tracker = SwitchingNoise(MEASURED)
    _, predicted = (
        (tracker.step(tracker.begin(PRIOR), PERIOD, None, None)[0]).mean,
        merge(tracker.step(tracker.begin(PRIOR), PERIOD, None, None)[0]),
    )
    grown = []
    for offset in np.linspace(0.0, 1.0, 41):
        z = predicted.mean[:1] + offset * DEGREE
        cov = merge(tracker.step(tracker.begin(PRIOR), PERIOD, z, R)[0]).cov
        np.testing.assert_allclose(cov, cov.T, rtol=1e-13)
        assert (np.linalg.eigvalsh(cov) > 0).all()
        grown.append(cov[0, 0] > predicted.cov[0, 0])
    assert any(grown)
    assert not all(grown)


def test_a_batch_is_its_runs_with_measurements_missing():
    channels = ("mls.azimuth", "mls.elevation")
    rng = np.random.default_rng(10)
    _, z, _ = glide(rng, 4, 80)
    z = np.concatenate([np.zeros_like(z), z], axis=1)
    z[rng.random(z.shape) < 0.3] = np.nan
    z[20:30] = np.nan
    tracker = SwitchingNoise(channels, switching=bursts(5.0))
    batch = tracked(tracker, z, channels)
    for run in range(4):
        alone = tracked(tracker, z[:, :, run], channels)
        np.testing.assert_allclose(batch.mean[..., run], alone.mean, rtol=1e-12, atol=1e-15)
        cov = np.broadcast_to(batch.cov, (*batch.cov.shape[:3], 4))[..., run]
        np.testing.assert_allclose(cov, alone.cov, rtol=1e-11, atol=1e-20)
        np.testing.assert_allclose(batch.model_probabilities[..., run], alone.model_probabilities, atol=1e-12)


def test_variance_is_read_live():
    """A receiver that tells its own accuracy is believed, run by run."""
    tracker = SwitchingNoise(MEASURED)
    prior = Gaussian(PRIOR.mean[:, None], PRIOR.cov[..., None])
    z = PRIOR.mean[:1, None] + np.array([[0.1, 0.1]]) * DEGREE
    live = np.array([[[1.0, 25.0]]]) * R[0, 0]
    state = merge(tracker.step(tracker.begin(prior), PERIOD, z, live)[0])
    for run in range(2):
        alone = merge(tracker.step(tracker.begin(PRIOR), PERIOD, z[:, run], live[..., run])[0])
        np.testing.assert_allclose(state.mean[:, run], alone.mean, rtol=1e-13)
        np.testing.assert_allclose(state.cov[..., run], alone.cov, rtol=1e-12)


def test_beam_noise_is_the_printed_formula():
    beam = BeamNoise(snr=10.0, at_distance=5000.0, floor=0.0)
    for decibels, variance in ((10.0, 1.06e-3), (14.0, 4.0e-4), (20.0, 9.7e-5)):
        assert beam.of_ratio(10 ** (0.1 * decibels)) / DEGREE**2 == pytest.approx(variance, rel=5e-3)
    # The printed R of 0.0036 deg^2 asks for 5.38 dB, which is not printed.
    assert beam.of_ratio(3.4505) / DEGREE**2 == pytest.approx(0.0036, rel=2e-4)
    assert beam.of_ratio(2.652) / DEGREE**2 == pytest.approx(50e-4, rel=1e-3)


def test_free_space_costs_six_decibels_per_doubling():
    beam = BeamNoise(snr=10 * np.log10(3.4505), at_distance=750.0, floor=0.0)
    far = beam.variance(np.array([750.0, 5000.0, 15000.0])) / DEGREE**2
    np.testing.assert_allclose(far, [0.0036, 1.72, 130.0], rtol=6e-3)  # so 0.0036 at 750 m is no anchor
    assert BeamNoise(40.0, 5000.0, 0.01 * DEGREE).variance(100.0) == pytest.approx((0.01 * DEGREE) ** 2, rel=1e-3)


def test_stationary_probabilities_are_kept_by_the_chain():
    chain = np.array(bursts(10.0, 0.2))
    np.testing.assert_allclose(stationary(chain), [0.8, 0.2], rtol=1e-12)
    np.testing.assert_allclose(stationary(chain) @ chain, stationary(chain), rtol=1e-12)


@pytest.mark.parametrize(
    ("fields", "sentence"),
    [
        ({"factors": ()}, "factors"),
        ({"factors": (1.0, np.inf)}, "NaN"),
        ({"switching": ((0.8, 0.2),)}, "2 rows"),
        ({"switching": ((0.8, 0.3), (0.8, 0.2))}, "sum to one"),
        ({"switching": ((1.2, -0.2), (0.8, 0.2))}, "negative"),
        ({"period": 0.0}, "period"),
    ],
)
def test_parameters_out_of_range_are_refused(fields, sentence):
    with pytest.raises(ValueError, match=sentence):
        SwitchingNoise(MEASURED, **fields)


@pytest.mark.parametrize("fields", [{"at_distance": 0.0}, {"snr": np.nan}, {"floor": -1.0}])
def test_beam_noise_out_of_range_is_refused(fields):
    with pytest.raises(ValueError, match=next(iter(fields))):
        BeamNoise(**({"snr": 10.0, "at_distance": 5000.0, "floor": 0.0} | fields))
