"""Kychak, Volovyk, Volovyk, Shutylo 2011 at full size: what two hypotheses gain, and where they do not suffice."""

import itertools
from dataclasses import dataclass

import numpy as np
import pytest
from scipy.linalg import solve_discrete_lyapunov

from tracking.bounds import relative_fisher_information
from tracking.gaussian import Gaussian, Mixture, merge
from tracking.measurement import LinearMeasurement
from tracking.motion import Transition
from tracking.track import Measurements, follow
from tracking.trackers.elevation import PERIOD, Elevation, Model, gain_schedule, increments
from tracking.trackers.gated import Gated
from tracking.trackers.huber import Huber
from tracking.trackers.switching_noise import BeamNoise, SwitchingNoise, stationary

pytestmark = pytest.mark.acceptance

DEGREE = np.pi / 180
VARIANCE = 0.0036  # deg^2
R = np.array([[VARIANCE]]) * DEGREE**2
PRIOR = Gaussian(np.array([2.2906, 0.0]) * DEGREE, np.diag([0.005, 0.0122**2]) * DEGREE**2)
MEASURED = ("mls.elevation",)
IID = ((0.8, 0.2), (0.8, 0.2))
A, Q = increments(2, PERIOD, PERIOD, 0.01)  # deg
SETTLED = 200


def independent(*shares: float) -> tuple[tuple[float, ...], ...]:
    return (shares,) * len(shares)


def bursts(length: float, share: float = 0.2) -> tuple[tuple[float, float], ...]:
    leave = 1.0 / length
    enter = leave * share / (1.0 - share)
    return (1.0 - enter, enter), (leave, 1.0 - leave)


@dataclass
class Experiment:
    """Truth (steps, 2, runs) and measurements (steps, 1, runs) in rad, and which accuracy held (steps, runs)."""

    truth: np.ndarray
    z: np.ndarray
    which: np.ndarray
    factors: np.ndarray


def glide(seed, runs=2000, steps=600, chain=IID, factors=(1.0, 30.0), prior=PRIOR) -> Experiment:
    """The glide leg drawn from the model, with a Markov chain of accuracies."""
    rng, chain, factors = np.random.default_rng(seed), np.array(chain), np.array(factors)
    cumulative = chain.cumsum(axis=1)
    cumulative[:, -1] = 1.0
    first = np.append(stationary(chain).cumsum()[:-1], 1.0)
    state = (rng.random(runs)[:, None] > first).sum(axis=1)
    x = prior.mean[:, None] + np.sqrt(np.diag(prior.cov))[:, None] * rng.standard_normal((2, runs))
    truth, z, which = np.empty((steps, 2, runs)), np.empty((steps, 1, runs)), np.empty((steps, runs), dtype=int)
    for k in range(steps):
        state = (rng.random(runs)[:, None] > cumulative[state]).sum(axis=1)
        x = A @ x
        x[1] += 0.01 * DEGREE * rng.standard_normal(runs)
        truth[k], which[k] = x, state
        z[k] = x[0] + 0.06 * DEGREE * factors[state] * rng.standard_normal(runs)
    return Experiment(truth, z, which, factors)


def followed(tracker, experiment, variances=None, prior=PRIOR):
    steps = len(experiment.z)
    time = PERIOD * np.arange(1, steps + 1)
    spread = np.broadcast_to(R, (steps, 1, 1)) if variances is None else variances
    yield from follow(tracker, Measurements(MEASURED, time, time, experiment.z, spread), prior, start=0.0)


@dataclass
class Result:
    """After the transient: mean square error of the angle (deg^2) as a whole and per run, ANEES, weights."""

    mse: float
    by_run: np.ndarray
    nees: float
    weights: np.ndarray | None


def judge(tracker, experiment, variances=None) -> Result:
    squares, nees, weights = [], [], []
    for epoch in followed(tracker, experiment, variances):
        if epoch.row < SETTLED:
            continue
        estimate = epoch.estimate
        if isinstance(estimate, Mixture):
            weights.append(estimate.weights)
            estimate = merge(estimate)
        e = estimate.mean - experiment.truth[epoch.row]
        P = np.broadcast_to(estimate.cov, (2, 2, e.shape[1]))
        squares.append(e[0] ** 2)
        nees.append(
            np.mean((P[1, 1] * e[0] ** 2 - 2 * P[0, 1] * e[0] * e[1] + P[0, 0] * e[1] ** 2)
                    / (P[0, 0] * P[1, 1] - P[0, 1] ** 2)) / 2
        )  # fmt: skip
    by_run = np.mean(squares, axis=0) / DEGREE**2
    return Result(float(by_run.mean()), by_run, float(np.mean(nees)), np.array(weights) if weights else None)


def oracle(experiment) -> float:
    """Mean square error (deg^2) of the Kalman filter that is told which accuracy holds."""
    told = (experiment.factors[experiment.which] ** 2 * R[0, 0])[:, None, None]
    return judge(Elevation(MEASURED), experiment, told).mse


@dataclass(frozen=True)
class AngleMotion:
    """The process of the paper for the baselines."""

    channels = ("elevation", "elevation_rate")
    depends_on_state = False

    def transition(self, dt, mean):
        return Transition(A, Q * DEGREE**2)


ANGLE = LinearMeasurement(((1.0, 0.0),))


def student(experiment, freedom: float) -> float:
    """Mean square error (deg^2) of a variational Bayes Student-t filter, three iterations a step."""
    x, P = np.repeat(PRIOR.mean[:, None], experiment.z.shape[2], axis=1), PRIOR.cov[..., None]
    squares = []
    for k, z in enumerate(experiment.z[:, 0]):
        x = A @ x
        P = np.einsum("ij,jkn,lk->iln", A, P, A) + (Q * DEGREE**2)[..., None]
        scale = np.ones_like(z)
        for _ in range(3):
            S = P[0, 0] + R[0, 0] / scale
            K = P[:, 0] / S
            post, cov = x + K * (z - x[0]), P - K[:, None] * P[0]
            scale = (freedom + 1.0) / (freedom + ((z - post[0]) ** 2 + cov[0, 0]) / R[0, 0])
        x, P = post, cov
        if k >= SETTLED:
            squares.append((x[0] - experiment.truth[k, 0]) ** 2)
    return float(np.mean(squares)) / DEGREE**2


@pytest.fixture(scope="module")
def paper() -> Experiment:
    return glide(20111)


@pytest.fixture(scope="module")
def two_hypotheses(paper) -> Result:
    return judge(SwitchingNoise(MEASURED), paper)


@pytest.fixture(scope="module")
def kalman(paper) -> Result:
    return judge(Elevation(MEASURED), paper)


def test_steady_state_and_the_gain(paper, two_hypotheses, kalman, row):
    """B4: 107 in variance, 10.3 in RMS. The print's 25-30 follows from neither definition."""
    steady = gain_schedule(np.eye(2), Model(A, Q, np.array([[1.0, 0.0]]), np.array([[VARIANCE]])), 1000)[0][-1]
    closed = (np.eye(2) - steady @ [[1.0, 0.0]]) @ A
    driven = (np.eye(2) - steady @ [[1.0, 0.0]]) @ Q @ (np.eye(2) - steady @ [[1.0, 0.0]]).T
    effective = (0.8 + 0.2 * 900) * VARIANCE
    analytic = solve_discrete_lyapunov(closed, driven + effective * steady @ steady.T)[0, 0]
    knowing = oracle(paper)
    ratio = kalman.mse / two_hypotheses.mse
    row("Kychak, two hypotheses, P11 deg^2", "3.99e-4 +- 4 %", f"{two_hypotheses.mse:.3e}",
        abs(two_hypotheses.mse / 3.99e-4 - 1) < 0.04)  # fmt: skip
    row("Kychak, two hypotheses, ANEES", "1.00 +- 0.06", f"{two_hypotheses.nees:.3f}",
        abs(two_hypotheses.nees - 1) < 0.06)  # fmt: skip
    row("Kychak, gain in variance", "107 +- 8 (printed 25-30)", f"{ratio:.1f}", abs(ratio - 107) < 8)
    row("Kychak, gain in RMS", "10.35 +- 0.4", f"{np.sqrt(ratio):.2f}", abs(np.sqrt(ratio) - 10.35) < 0.4)
    # 2000 runs of 400 steps, errors correlated over ten: 0.5 %, and heavy tails.
    assert analytic == pytest.approx(4.305e-2, rel=1e-3)
    assert kalman.mse == pytest.approx(analytic, rel=0.04)
    assert two_hypotheses.mse == pytest.approx(3.99e-4, rel=0.04)
    assert knowing == pytest.approx(3.77e-4, rel=0.04)
    assert two_hypotheses.nees == pytest.approx(1.0, abs=0.06)
    assert ratio == pytest.approx(107, abs=8)
    small = [kalman.by_run[i : i + 50].mean() / two_hypotheses.by_run[i : i + 50].mean() for i in range(0, 2000, 50)]
    assert np.median(small) == pytest.approx(107, abs=8)
    assert np.percentile(small, 5) > 95
    assert np.percentile(small, 95) < 125


def test_efficiency_against_the_bound(two_hypotheses, row):
    information = relative_fisher_information((0.8, 0.2), (1.0, 30.0))  # over that of the nominal noise
    P = np.eye(2)
    for _ in range(2000):
        P = A @ P @ A.T + Q
        P = P - P[:, :1] @ P[:1] / (P[0, 0] + VARIANCE / information)
    efficiency = np.sqrt(P[0, 0] / two_hypotheses.mse)
    row("two hypotheses, RMS against the bound", ">= 0.98", f"{efficiency:.4f}", efficiency >= 0.98)
    assert information == pytest.approx(0.7450, abs=2e-4)
    assert 0.98 <= efficiency < 1.01


def test_detection(paper, two_hypotheses, row):
    found, anomalous = two_hypotheses.weights[:, 1] > 0.5, paper.which[SETTLED:] == 1
    detected, false = found[anomalous].mean(), found[~anomalous].mean()
    row(
        "Kychak, anomalies found / false",
        "0.914 / 0.0021",
        f"{detected:.4f} / {false:.4f}",
        abs(detected - 0.914) < 0.01,
    )
    assert detected == pytest.approx(0.914, abs=0.01)
    assert false == pytest.approx(0.0021, abs=0.001)


def test_no_anomalies(row):
    """B5: 1.5 % worse than the Kalman filter, and the probability of an anomaly is 2 %, not 0 as printed."""
    clean = glide(20112, chain=independent(1.0, 0.0))
    two, one = judge(SwitchingNoise(MEASURED), clean), judge(Elevation(MEASURED), clean)
    doubt = two.weights[:, 1].mean()
    row("Kychak, no anomalies: MSE over Kalman, mean probability", "1.00..1.04, 0.021 (printed 0)",
        f"{two.mse / one.mse:.4f}, {doubt:.4f}", 1.0 <= two.mse / one.mse <= 1.04)  # fmt: skip
    assert 1.0 <= two.mse / one.mse <= 1.04
    assert doubt == pytest.approx(0.021, abs=0.004)


@pytest.mark.parametrize(("share", "factor", "gain", "within"), [(0.05, 30.0, 33.7, 4), (0.2, 15.0, 26.6, 3)])
def test_what_would_give_the_printed_gain(share, factor, gain, within):
    """B8: half of the factor or a quarter of the anomalies; neither is printed."""
    chain = independent(1.0 - share, share)
    experiment = glide(20113, chain=chain, factors=(1.0, factor))
    two = judge(SwitchingNoise(MEASURED, (1.0, factor), chain), experiment)
    ratio = judge(Elevation(MEASURED), experiment).mse / two.mse
    print(f"share {share}, factor {factor}: gain {ratio:.1f}")
    assert ratio == pytest.approx(gain, abs=within)


@pytest.mark.parametrize(
    ("length", "plain", "knowing", "independent_filter", "markov"),
    [
        (1.25, 4.3e-2, 3.7e-4, 3.96e-4, 3.96e-4),
        (5, 4.3e-2, 4.1e-4, 5.0e-4, 4.4e-4),
        (10, 4.4e-2, 4.8e-4, 1.7e-3, 5.6e-4),
        (40, 4.3e-2, 1.8e-3, 5.8e-2, 2.9e-3),
    ],
)
def test_bursts(length, plain, knowing, independent_filter, markov, row):
    """B7: what counts is the Markov chain (10)-(11), which the print gives and does not evaluate."""
    chain = bursts(length)
    experiment = glide(20114, runs=2000, steps=1000, chain=chain)
    iid, two = judge(SwitchingNoise(MEASURED), experiment), judge(SwitchingNoise(MEASURED, switching=chain), experiment)
    one, told = judge(Elevation(MEASURED), experiment), oracle(experiment)
    row(f"bursts of {length:g}: P11 of Kalman, told, independent, Markov", "reported",
        f"{one.mse:.2e} {told:.2e} {iid.mse:.2e} {two.mse:.2e}, medians of the last two "
        f"{np.median(iid.by_run):.2e} {np.median(two.by_run):.2e}", True)  # fmt: skip
    assert one.mse == pytest.approx(plain, rel=0.08)  # the page's own samples, two digits
    assert told == pytest.approx(knowing, rel=0.10)
    # A mean that a few runs rule, which lost the truth for a while, is known to a factor of two by 2000 runs.
    assert independent_filter / 2.0 < iid.mse < independent_filter * 2.0
    assert markov / 1.6 < two.mse < markov * 1.6
    assert np.median(two.by_run) < 1.01 * np.median(iid.by_run)
    if length == 40:
        assert two.mse < one.mse / 8
        assert iid.mse > 8 * two.mse


def test_three_accuracies(row):
    """A chain over (1, 5, 30): three Markov hypotheses, three independent, two independent, and the told filter."""
    chain = ((0.95, 0.025, 0.025), (0.1, 0.85, 0.05), (0.1, 0.05, 0.85))
    share = tuple(stationary(np.array(chain)).tolist())
    experiment = glide(20115, chain=chain, factors=(1.0, 5.0, 30.0))
    factors = (1.0, 5.0, 30.0)
    markov = judge(SwitchingNoise(MEASURED, factors, chain), experiment).mse
    three = judge(SwitchingNoise(MEASURED, factors, independent(*share)), experiment).mse
    two = judge(SwitchingNoise(MEASURED, (1.0, 30.0), independent(share[0], share[1] + share[2])), experiment).mse
    told = oracle(experiment)
    row("three accuracies: P11 told, Markov 3, independent 3, independent 2", "in this order",
        f"{told:.2e} {markov:.2e} {three:.2e} {two:.2e}", told < markov < three < two)  # fmt: skip
    assert told < markov < three < two


def test_exact_bayes_over_twelve_steps(row):
    """B3: one Gaussian per step against the 4096 of the exact posterior."""
    runs, steps = 2000, 12
    experiment = glide(20116, runs, steps)
    branches = []
    for history in itertools.product((1.0, 30.0), repeat=steps):
        x, P, log_weight = np.repeat(PRIOR.mean[:, None], runs, axis=1), PRIOR.cov, 0.0
        for k, factor in enumerate(history):
            x, P = A @ x, A @ P @ A.T + Q * DEGREE**2
            S, v = P[0, 0] + factor**2 * R[0, 0], experiment.z[k, 0] - x[0]
            x, P = x + (P[:, :1] / S) * v, P - P[:, :1] @ P[:1] / S
            log_weight = log_weight + np.log(0.8 if factor == 1.0 else 0.2) - 0.5 * (v**2 / S + np.log(S))
        branches.append((log_weight, x[0]))
    log_weights, means = (np.array(column) for column in zip(*branches, strict=True))
    w = np.exp(log_weights - log_weights.max(axis=0))
    exact = (w * means).sum(axis=0) / w.sum(axis=0)
    *_, last = followed(SwitchingNoise(MEASURED), experiment)
    mean = merge(last.estimate).mean[0]
    difference = np.sqrt(np.mean((mean - exact) ** 2)) / DEGREE
    truth = experiment.truth[-1, 0]
    loss = np.mean((mean - truth) ** 2) / np.mean((exact - truth) ** 2)
    row("two hypotheses against exact Bayes, 12 steps: rms deg, MSE loss", "< 0.004, < 1.04",
        f"{difference:.4f}, {loss:.4f}", difference < 0.004 and loss < 1.04)  # fmt: skip
    assert difference < 0.004
    assert loss < 1.04


def test_alternatives(paper, two_hypotheses, kalman, row):
    """B12: two hypotheses, gates, Student-t, Huber, in this order on the same data."""
    gain = {"two hypotheses": kalman.mse / two_hypotheses.mse}
    nees = {"two hypotheses": two_hypotheses.nees}
    for name, tracker in {
        "gate 3": Gated(ANGLE, AngleMotion()),
        "Huber 1.345": Huber(ANGLE, AngleMotion()),
        "Huber 2": Huber(ANGLE, AngleMotion(), tuning=2.0),
    }.items():
        result = judge(tracker, paper)
        gain[name], nees[name] = kalman.mse / result.mse, result.nees
    gain["Student-t 4"] = kalman.mse / student(paper, 4.0)
    gain["Student-t 1"] = kalman.mse / student(paper, 1.0)
    for name, value in gain.items():
        row(
            f"alternatives, {name}: gain in variance, ANEES",
            "reported",
            f"{value:.1f}, {nees.get(name, np.nan):.2f}",
            True,
        )
    assert gain["two hypotheses"] > gain["gate 3"] > gain["Student-t 4"] > gain["Huber 1.345"]
    assert nees["gate 3"] > nees["two hypotheses"]


@pytest.mark.parametrize(("share", "factor"), [(0.05, 30.0), (0.4, 30.0), (0.2, 5.0), (0.2, 10.0), (0.2, 100.0)])
def test_wrong_priors_hardly_matter(share, factor, row):
    """For independent anomalies the filter told (0.2, 30) loses a few per cent to the one told right."""
    chain = independent(1.0 - share, share)
    experiment = glide(20117, chain=chain, factors=(1.0, factor))
    wrong = judge(SwitchingNoise(MEASURED), experiment).mse
    right = judge(SwitchingNoise(MEASURED, (1.0, factor), chain), experiment).mse
    row(
        f"told (0.2, 30) where ({share}, {factor:g}) holds: loss in MSE",
        "<= 6 %",
        f"{wrong / right - 1:.1%}",
        wrong / right < 1.06,
    )
    assert 0.99 < wrong / right < 1.06


def test_live_accuracy_down_the_glide(row):
    """Free-space noise from 5 km to 750 m: the filter told R live, and the one that believes a fixed R."""
    beam = BeamNoise(snr=20.0, at_distance=750.0, floor=0.01 * DEGREE)
    steps, runs = 1900, 500
    distance = np.linspace(5000.0, 750.0, steps)
    variance = beam.variance(distance)
    experiment = glide(20118, runs, steps, ((1.0,),), (1.0,))
    noise = experiment.z - experiment.truth[:, :1]
    experiment.z = experiment.truth[:, :1] + noise * np.sqrt(variance / R[0, 0])[:, None, None]
    live = judge(Elevation(MEASURED), experiment, variance[:, None, None])
    fixed = judge(Elevation(MEASURED), experiment)
    row("live R down the glide: MSE fixed over live, ANEES live, fixed", "> 1, 1.00, not 1",
        f"{fixed.mse / live.mse:.2f}, {live.nees:.3f}, {fixed.nees:.2f}", fixed.mse > live.mse)  # fmt: skip
    assert live.nees == pytest.approx(1.0, abs=0.02)
    assert fixed.mse > 1.1 * live.mse
    assert abs(fixed.nees - 1.0) > 0.1


def test_a_wide_prior_loses_some_runs(row):
    """The mean is then ruled by the few that lock on a wrong angle; the median is not, so both are told."""
    prior = Gaussian(PRIOR.mean, np.diag([1.0, 0.0122**2]) * DEGREE**2)
    experiment = glide(20119, runs=4000, steps=240, prior=prior)
    found = {}
    for name, tracker in {"Kalman": Elevation(MEASURED), "two": SwitchingNoise(MEASURED)}.items():
        squares, lost = [], None
        for epoch in followed(tracker, experiment, prior=prior):
            mean = epoch.estimate.mean if name == "Kalman" else merge(epoch.estimate).mean
            error = (mean[0] - experiment.truth[epoch.row, 0]) / DEGREE
            if epoch.row == 40:
                lost = np.mean(np.abs(error) > 0.5)
            if epoch.row >= 80:
                squares.append(error**2)
        found[name] = np.mean(squares, axis=0), lost
    mean_gain = found["Kalman"][0].mean() / found["two"][0].mean()
    median_gain = np.median(found["Kalman"][0]) / np.median(found["two"][0])
    lost = found["two"][1]
    row("Kychak, prior of 1 deg: gain of means, of medians, lost after 1 s", "medians near 107, lost 0.3-1 %",
        f"{mean_gain:.0f}, {median_gain:.0f}, {lost:.2%}",
        abs(median_gain - 107) < 8 and 0.003 <= lost <= 0.01)  # fmt: skip
    assert mean_gain < 0.7 * median_gain
    assert median_gain > 80
    assert 0.001 < lost < 0.02


def test_bias_bursts_deceive_the_independent_filter(row):
    """Multipath of +0.3 deg for half a second: three Markov hypotheses ride it out, two independent ones do not."""
    runs, steps, length = 500, 1200, 20
    rng = np.random.default_rng(20120)
    experiment = glide(20120, runs, steps, ((1.0,),), (1.0,))
    start = rng.random((steps, runs)) < 0.2 / length
    on = np.array([start[max(0, k - length + 1) : k + 1].any(axis=0) for k in range(steps)])
    experiment.z = experiment.z + 0.3 * DEGREE * on[:, None]
    stay, enter = 1.0 - 1.0 / length, 0.1 / length
    chain = ((1.0 - 2 * enter, enter, enter), (1.0 - stay, stay, 0.0), (1.0 - stay, 0.0, stay))
    one = judge(Elevation(MEASURED), experiment).mse
    two = judge(SwitchingNoise(MEASURED), experiment).mse
    three = judge(SwitchingNoise(MEASURED, (1.0, 5.0, 30.0), chain), experiment).mse
    row("bias bursts .3 deg .5 s: RMSE deg of Kalman, independent 2, Markov 3", "Markov best",
        f"{one**0.5:.4f}, {two**0.5:.4f}, {three**0.5:.4f}", three < min(one, two))  # fmt: skip
    assert three < one
    assert three < two
