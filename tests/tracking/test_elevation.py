"""The elevation filter against its printed model, textbook algebra, filterpy, the matrix exponential and chi-square."""

import numpy as np
import pytest
from filterpy.kalman import KalmanFilter
from scipy.linalg import solve_discrete_are

from tracking.gaussian import Gaussian
from tracking.motion import singer, singer_short, van_loan
from tracking.track import Measurements, track
from tracking.trackers.elevation import (
    PERIOD,
    Elevation,
    Model,
    arbitrary_gain,
    band_coverage,
    elevation_of,
    full,
    gain_schedule,
    increments,
    information,
    interval_half_width,
    joseph,
    manoeuvre_variance,
    short_form,
    stored_gain,
)

DEGREE = np.pi / 180
R = np.array([[0.0036]])  # deg^2; the realisations are linear, so the tests of the algebra stay in degrees
START = Gaussian(np.array([0.7, 0.0122]), np.diag([50e-4, 0.0122**2]))


def published() -> Model:
    A, Q = increments(2, PERIOD, PERIOD, 0.01)
    return Model(A, Q, np.array([[1.0, 0.0]]), R)


def drive(rng: np.random.Generator, model: Model, steps: int, runs: int) -> tuple[np.ndarray, np.ndarray]:
    """Truth (steps, 2, runs) drawn from the model with B = [0, 1]', and its measurements (steps, 1, runs)."""
    x = START.mean[:, None] + np.sqrt(np.diag(START.cov))[:, None] * rng.standard_normal((2, runs))
    truth, z = np.empty((steps, 2, runs)), np.empty((steps, 1, runs))
    for k in range(steps):
        x = model.A @ x
        x[1] += 0.01 * rng.standard_normal(runs)
        truth[k], z[k] = x, x[:1] + 0.06 * rng.standard_normal(runs)
    return truth, z


@pytest.mark.parametrize(
    ("distance", "speed", "expected"),
    [
        (15e3, 150.0, (0.7639, 0.007638, 1.2091e-4)),
        (10e3, 127.4755, (1.1458, 0.01460, 3.0053e-4)),
        (5e3, 100.0, (2.2906, 0.04576, 1.5416e-3)),
    ],
)
def test_level_leg_has_the_angles_of_the_geometry(distance, speed, expected):
    motion = elevation_of(distance, 200.0, -speed, 0.0, 0.625, 0.0)
    np.testing.assert_allclose(np.degrees(motion), expected, rtol=2e-4)  # four digits and more


@pytest.mark.parametrize("vertical", [0.0, 0.9])
def test_elevation_derivatives_are_central_differences(vertical):
    def at(t: float) -> tuple[float, ...]:
        return 7e3 - 110 * t + 0.3125 * t**2, 200 - 4 * t + 0.5 * vertical * t**2

    def motion(t: float):
        d, h = at(t)
        return elevation_of(d, h, -110 + 0.625 * t, -4 + vertical * t, 0.625, vertical)

    step = 1e-3  # s: truncation 1e-9, rounding 1e-12 of the angle
    before, here, after = motion(10 - step), motion(10.0), motion(10 + step)
    assert here.rate == pytest.approx((after.angle - before.angle) / (2 * step), rel=1e-5)
    assert here.acceleration == pytest.approx((after.rate - before.rate) / (2 * step), rel=1e-5)


def test_straight_glide_has_no_angular_rate():
    distance = np.linspace(5000.0, 750.0, 50)
    motion = elevation_of(distance, 0.04 * distance, -90.0, -3.6, 0.2, 0.008)
    np.testing.assert_allclose(np.degrees(motion.angle), 2.2906, atol=5e-5)
    assert np.abs(motion.rate).max() < 1e-12
    assert np.abs(motion.acceleration).max() < 1e-12


def test_manoeuvre_variance_is_the_moment_of_its_distribution():
    largest, often, none = 0.2 * 9.81, 0.1, 0.5
    rest = 1.0 - none - 2.0 * often
    by_parts = 2.0 * often * largest**2 + rest * largest**2 / 3.0
    assert manoeuvre_variance(largest, often, none) == pytest.approx(by_parts, rel=1e-14)
    assert manoeuvre_variance(largest, often, none) == pytest.approx(1.1548, abs=5e-5)


@pytest.mark.parametrize(
    ("increment", "held", "variance", "gain"),
    [
        (0.01, False, 3.1233e-4, (0.086757, 0.159273)),
        (0.01 * PERIOD, True, 5.0974e-5, (0.01416, 0.004087)),
    ],
)
def test_steady_state_is_the_riccati_solution_of_either_reading(increment, held, variance, gain):
    A, Q = increments(2, PERIOD, PERIOD, increment, held)
    H = np.array([[1.0, 0.0]])
    predicted = solve_discrete_are(A.T, H.T, Q, R)
    K = predicted @ H.T / (predicted[0, 0] + R)
    assert predicted[0, 0] * (1 - K[0, 0]) == pytest.approx(variance, rel=1e-4)
    np.testing.assert_allclose(K[:, 0], gain, rtol=5e-4)  # four printed digits
    steps = 4000 if held else 800
    gains, covariances = gain_schedule(START.cov, Model(A, Q, H, R), steps)
    np.testing.assert_allclose(gains[-1], K, rtol=1e-9)
    if not held:  # the recursion has settled to rel 3.5e-8 after 200 steps
        assert covariances[199, 0, 0] == pytest.approx(covariances[-1, 0, 0], rel=1e-6)


def test_golden_steps():
    x, P = START
    seen = []
    for y in (0.8, 0.75, 0.72):
        x, P, _ = full(x, P, np.array([y]), published())
        seen.append((x[0], P[0, 0]))
    expected = [
        (0.758266117869578, 0.0020930391675322477),
        (0.7554180908759511, 0.001323626875247225),
        (0.7461150750502906, 0.0009680361313777608),
    ]
    np.testing.assert_allclose(seen, expected, rtol=1e-12)


def test_realisations_agree_with_filterpy_and_each_other():
    model, steps = published(), 1000
    _, z = drive(np.random.default_rng(1), model, steps, 1)
    z = z[:, :, 0]
    gains, _ = gain_schedule(START.cov, model, steps)
    judge = KalmanFilter(dim_x=2, dim_z=1)
    judge.F, judge.Q, judge.H, judge.R = model.A, model.Q, model.C, model.R
    judge.x, judge.P = START.mean[:, None], START.cov
    (x1, P1), (x2, P2), (x3, P3), x4 = START, START, START, START.mean
    for k in range(steps):
        judge.predict()
        judge.update(z[k])
        x1, P1, K = full(x1, P1, z[k], model)
        x2, P2 = arbitrary_gain(x2, P2, z[k], gains[k], model)
        x3, P3 = information(x3, P3, z[k], model)
        x4 = stored_gain(x4, z[k], gains[k], model.A, model.C)
        np.testing.assert_array_equal(K, gains[k])  # the gain does not look at the data
        np.testing.assert_array_equal(x4, x1)  # so nothing can differ, not even in the last bit
        for x, P in ((x2, P2), (x3, P3)):
            np.testing.assert_allclose(x, x1, rtol=0, atol=1e-12)
            np.testing.assert_allclose(P, P1, rtol=1e-10, atol=0)
        np.testing.assert_allclose(x1, judge.x[:, 0], rtol=0, atol=1e-12)
        np.testing.assert_allclose(P1, judge.P, rtol=1e-10, atol=0)


def test_a_stored_schedule_loses_nothing_under_mismatch_but_is_not_told_of_noise():
    """The print's loss of convergence needs information that the schedule does not get."""
    model, steps = published(), 400
    rng = np.random.default_rng(2)
    truth, z = drive(rng, model, steps, 200)
    wild = truth[:, :1] + 0.3 * np.sin(0.1 * np.arange(steps))[:, None, None]  # nothing like the model
    gains, _ = gain_schedule(START.cov, model, steps)
    x1, x4, P = np.tile(START.mean[:, None], 200), np.tile(START.mean[:, None], 200), START.cov
    for k in range(steps):
        x1, P, _ = full(x1, P, wild[k], model)
        x4 = stored_gain(x4, wild[k], gains[k], model.A, model.C)
    np.testing.assert_array_equal(x1, x4)

    louder = truth[:, :1] + 10.0 * (z - truth[:, :1])  # R grows a hundredfold and only realisation 1 is told
    told, x1, x4, P = model._replace(R=100.0 * R), START.mean[:, None], START.mean[:, None], START.cov
    full_error, stored_error = [], []
    for k in range(steps):
        x1, P, _ = full(x1, P, louder[k], told)
        x4 = stored_gain(x4, louder[k], gains[k], model.A, model.C)
        full_error.append(x1[0] - truth[k, 0])
        stored_error.append(x4[0] - truth[k, 0])
    ratio = np.mean(np.square(stored_error[200:])) / np.mean(np.square(full_error[200:]))
    assert ratio > 1.8  # 2.37 on the page; 200 runs of 200 correlated steps know it to about 10 %


def test_joseph_form_is_what_a_wrong_gain_earns():
    """Errors of the constant gain [.05, .05], by Monte Carlo, beside the Joseph and the short form."""
    model, K = published(), np.array([[0.05], [0.05]])
    runs, steps = 4000, 400
    truth, z = drive(np.random.default_rng(3), model, steps, runs)
    x, P = np.tile(START.mean[:, None], runs), START.cov
    errors = []
    for k in range(steps):
        x, P = arbitrary_gain(x, P, z[k], K, model)
        if k >= 300:
            errors.append(x[0] - truth[k, 0])
    assert P[0, 0] == pytest.approx(5.805e-4, rel=1e-3)
    # 4000 runs, two or three independent times each in 100 steps: 1.6 % of sigma.
    assert np.mean(np.square(errors)) == pytest.approx(P[0, 0], rel=0.04)
    short = START.cov
    for _ in range(steps):
        predicted = model.A @ short @ model.A.T + model.Q
        short = (np.eye(2) - K @ model.C) @ predicted
    assert short[0, 0] == pytest.approx(1.900e-3, rel=1e-3)  # what the refused form would have claimed
    with pytest.raises(ValueError, match="Joseph"):
        short_form(predicted, K, model.C, model.R)


def test_short_form_is_the_joseph_form_for_the_optimal_gain():
    model = published()
    _, P, K = full(*START, np.array([0.8]), model)
    predicted = model.A @ START.cov @ model.A.T + model.Q
    np.testing.assert_allclose(short_form(predicted, K, model.C, model.R), P, rtol=1e-14)
    np.testing.assert_allclose(joseph(predicted, K, model.C, model.R), P, rtol=1e-13)


def test_realisations_are_batched():
    model, rng = published(), np.random.default_rng(4)
    z = 0.8 + 0.06 * rng.standard_normal((1, 5))
    together = full(np.tile(START.mean[:, None], 5), START.cov, z, model)[0]
    alone = np.stack([full(*START, z[:, i], model)[0] for i in range(5)], axis=1)
    np.testing.assert_allclose(together, alone, rtol=0, atol=1e-15)


@pytest.mark.parametrize("held", [False, True])
@pytest.mark.parametrize("order", [1, 2])
def test_a_long_step_is_the_recursion_itself(order, held):
    F, Q = increments(order, PERIOD, PERIOD, 0.01, held)
    P = np.zeros((order, order))
    for _ in range(28):
        P = F @ P @ F.T + Q
    F28, Q28 = increments(order, 28 * PERIOD, PERIOD, 0.01, held)
    np.testing.assert_allclose(Q28, P, rtol=1e-12)
    np.testing.assert_allclose(F28, np.linalg.matrix_power(F, 28), rtol=1e-14)


@pytest.mark.parametrize(("ratio", "low", "high"), [(0.0247, 0.0, 0.026), (1.0, 0.6, 2.0)])
def test_short_singer_noise_needs_a_short_step(ratio, low, high):
    F, Q = singer(PERIOD, PERIOD / ratio, 1.0)
    A = np.array([[0, 1, 0], [0, 0, 1], [0, 0, -ratio / PERIOD]])
    exact = van_loan(A, np.diag([0, 0, 2.0 * ratio / PERIOD]), PERIOD)
    np.testing.assert_allclose(F, exact[0], rtol=1e-10)
    np.testing.assert_allclose(Q, exact[1], rtol=1e-10)
    error = singer_short(PERIOD, PERIOD / ratio, 1.0)[1] / Q - 1.0
    assert (error > low).all()
    assert (error < high).all()


def tracked(tracker: Elevation, z: np.ndarray, prior: Gaussian, channels=("mls.elevation",)):
    m, k = len(channels), len(z)
    time = PERIOD * np.arange(1, k + 1)
    variances = np.broadcast_to((0.06 * DEGREE) ** 2 * np.eye(m), (k, m, m))
    return track(tracker, Measurements(channels, time, time, z, variances), prior, start=0.0)


def in_radians(gaussian: Gaussian) -> Gaussian:
    return Gaussian(gaussian.mean * DEGREE, gaussian.cov * DEGREE**2)


def test_tracker_is_the_full_realisation():
    model, steps = published(), 300
    _, z = drive(np.random.default_rng(5), model, steps, 1)
    result = tracked(Elevation(("mls.elevation",)), z[:, :, 0] * DEGREE, in_radians(START))
    x, P = START
    for k in range(steps):
        x, P, _ = full(x, P, z[k, :, 0], model)
        np.testing.assert_allclose(result.mean[k] / DEGREE, x, rtol=0, atol=1e-12)
    np.testing.assert_allclose(result.cov[-1] / DEGREE**2, P, rtol=1e-10)


def test_tracker_with_a_gain_is_the_arbitrary_realisation_and_needs_no_data_that_are_absent():
    model, steps = published(), 300
    _, z = drive(np.random.default_rng(6), model, steps, 3)
    z[40:60, :, 1] = np.nan
    gain = (0.086757, 0.159273)
    result = tracked(Elevation(("mls.elevation",), gain=gain), z * DEGREE, in_radians(START))
    for run in range(3):
        x, P = START
        for k in range(steps):
            K = np.array(gain)[:, None] if np.isfinite(z[k, 0, run]) else np.zeros((2, 1))
            x, P = arbitrary_gain(x, P, np.nan_to_num(z[k, :, run]), K, model)
            np.testing.assert_allclose(result.mean[k, :, run] / DEGREE, x, rtol=0, atol=1e-12)
        np.testing.assert_allclose(result.cov[-1, :, :, run] / DEGREE**2, P, rtol=1e-10)


@pytest.mark.parametrize("order", [1, 2, 3])
@pytest.mark.parametrize("constant", [False, True])
def test_a_batch_is_its_runs_with_measurements_missing(order, constant):
    rng = np.random.default_rng(7)
    channels = ("mls.azimuth", "mls.elevation", "mls.range")
    z = 0.04 + 1e-3 * rng.standard_normal((60, 3, 4))
    z[rng.random((60, 3, 4)) < 0.3] = np.nan
    z[20:30] = np.nan
    gain = (0.1, 0.2, 0.1)[:order] if constant else None
    tracker = Elevation(channels, order=order, gain=gain)
    assert tracker.channels[0] == "mls.elevation"
    prior = Gaussian(np.zeros(order), 1e-4 * np.eye(order))
    batch = tracked(tracker, z, prior, channels)
    for run in range(4):
        alone = tracked(tracker, z[:, :, run], prior, channels)
        for name in ("mean", "cov", "white", "nis", "log_likelihood"):
            together, single = getattr(batch, name), getattr(alone, name)
            together = np.broadcast_to(together, (*together.shape[:-1], 4))[..., run]
            # White residuals magnify the rounding of an angle (4e-16 rad after wrapping) by 1 / sigma, about 1e3.
            floor = 1e-15 if name in ("mean", "cov") else 1e-11
            np.testing.assert_allclose(together, single, rtol=1e-12, atol=floor)
    assert np.isfinite(batch.mean).all()


def test_absent_measurement_is_pure_prediction():
    tracker = Elevation(("mls.elevation",))
    state = tracker.begin(in_radians(START))
    nothing, _ = tracker.step(state, PERIOD, None, None)
    absent, innovation = tracker.step(state, PERIOD, np.array([np.nan]), R)
    np.testing.assert_array_equal(absent.mean, nothing.mean)
    np.testing.assert_array_equal(absent.cov, nothing.cov)
    assert innovation.log_likelihood == 0.0


@pytest.mark.parametrize(("wide", "q"), [(50, 0.2086), (60, 0.1883), (100, 0.1428)])
def test_interval_half_width_is_the_table_value(wide, q):
    assert interval_half_width(0.95, wide) == pytest.approx(q, abs=5e-5)


@pytest.mark.parametrize(
    ("confidence", "interval", "band"), [(0.9, 38, 35), (0.95, 54, 49), (0.99, 98, 84), (0.999, 167, 136)]
)
def test_smallest_number_of_runs(confidence, interval, band):
    """The print's 50 runs are right for a band about the theory and slightly few for the printed inequality."""
    assert next(n for n in range(20, 300) if interval_half_width(confidence, n) <= 0.2) == interval
    assert next(n for n in range(20, 300) if band_coverage(0.2, n) >= confidence) == band


@pytest.mark.parametrize(
    ("fields", "sentence"),
    [
        ({"order": 4}, "order"),
        ({"period": 0.0}, "period"),
        ({"rate_increment": -1.0}, "rate_increment"),
        ({"gain": (0.1,)}, "gain needs 2"),
        ({"measured": ("radar.range",)}, "elevation"),
        ({"measured": ("a.elevation", "b.elevation")}, "one sensor"),
    ],
)
def test_parameters_out_of_range_are_refused(fields, sentence):
    with pytest.raises(ValueError, match=sentence):
        Elevation(**({"measured": ("mls.elevation",)} | fields))


def test_a_prior_of_another_order_is_refused():
    with pytest.raises(ValueError, match="2 states"):
        Elevation(("mls.elevation",)).begin(Gaussian(np.zeros(3), np.eye(3)))
