"""Bounds judged by the Kalman covariance, by enumeration, by finite differences and by the integrals they claim."""

from __future__ import annotations

import numpy as np
import pytest

from tracking.bounds import (
    efficiency,
    information,
    known_modes_bound,
    oracle_riccati,
    polar_jacobian,
    posterior_bound,
    relative_fisher_information,
    riccati,
    trajectory_averaged_riccati,
)
from tracking.consistency import Consistency
from tracking.gaussian import Gaussian
from tracking.intervals import Interval
from tracking.measurement import DebiasedPolar, LinearMeasurement
from tracking.motion import CARTESIAN, ConstantVelocity, planar_constant_velocity
from tracking.track import Measurements, follow, track
from tracking.trackers.kalman import Kalman

H = np.array([[1.0, 0.0, 0.0, 0.0], [0.0, 0.0, 1.0, 0.0]])
PRIOR = np.diag([1000.0, 25.0, 1000.0, 25.0])


def test_bound_of_a_linear_system_is_the_kalman_covariance():
    """Both solve one Riccati equation, in two different forms; 1e-10 relative is rounding over 50 steps."""
    R = np.array([[400.0, 100.0], [100.0, 900.0]])
    times = np.arange(1.0, 51.0)
    record = Measurements(("a", "b"), times, times, np.zeros((50, 2)), np.broadcast_to(R, (50, 2, 2)))
    kalman = Kalman(LinearMeasurement(tuple(map(tuple, H))), ConstantVelocity(0.3))
    covs = track(kalman, record, Gaussian(np.zeros(4), PRIOR), start=0.0).cov
    F, Q = planar_constant_velocity(1.0, 0.3, 0.3)
    bound = posterior_bound(PRIOR, F, Q, np.broadcast_to(information(H, R), (50, 4, 4)))
    np.testing.assert_allclose(bound, covs, rtol=1e-10, atol=1e-9)


def test_singular_noise_and_no_information_pass():
    """Q = 0 and J = 0: the covariance is F C F', which an information form could not reach from a singular C."""
    F, _ = planar_constant_velocity(1.0, 0.0, 0.0)
    C = np.zeros((4, 4))
    C[0, 0] = 9.0
    np.testing.assert_allclose(riccati(C, F, np.zeros((4, 4)), np.zeros((4, 4))), F @ C @ F.T, atol=1e-12)
    moved = riccati(C, F, np.zeros((4, 4)), information(H, 9.0 * np.eye(2)))
    assert moved[0, 0] == pytest.approx(4.5)


def test_polar_jacobian_against_finite_differences():
    step, point = 1e-3, np.array([8000.0, -3000.0])

    def polar(north, east):
        return np.array([np.hypot(north, east), np.arctan2(east, north)])

    numeric = np.stack([(polar(*(point + d)) - polar(*(point - d))) / (2 * step) for d in step * np.eye(2)], axis=1)
    np.testing.assert_allclose(polar_jacobian(*point, CARTESIAN)[:, [0, 2]], numeric, rtol=1e-6, atol=1e-12)
    assert not polar_jacobian(*point, CARTESIAN)[:, [1, 3]].any()


def test_information_does_not_depend_on_the_conversion():
    """Polar measurement with constant R, or its cartesian image with J R J': the same information."""
    R = np.diag([30.0**2, np.radians(1.0) ** 2])
    jacobian = polar_jacobian(8000.0, -3000.0, CARTESIAN)
    to_cartesian = np.linalg.inv(jacobian[:, [0, 2]])
    np.testing.assert_allclose(information(jacobian, R), information(H, to_cartesian @ R @ to_cartesian.T), rtol=1e-9)


def test_missed_detections_never_beat_the_mean_information():
    """Mean covariance over all 2^6 detection histories against the recursion with Pd J."""
    F, Q = planar_constant_velocity(1.0, 0.5, 0.5)
    J = information(H, 400.0 * np.eye(2))
    exact = np.zeros((4, 4))
    for history in range(64):
        seen = np.array([history >> i & 1 for i in range(6)], dtype=float)
        probability = 0.7 ** seen.sum() * 0.3 ** (6 - seen.sum())
        exact += probability * posterior_bound(PRIOR, F, Q, seen[:, None, None] * J)[-1]
    bound = posterior_bound(PRIOR, F, Q, np.broadcast_to(information(H, 400.0 * np.eye(2), 0.7), (6, 4, 4)))[-1]
    assert np.linalg.eigvalsh(exact - bound).min() >= 0.0
    assert np.trace(bound) > 0.8 * np.trace(exact)
    with pytest.raises(ValueError, match="between 0 and 1"):
        information(H, np.eye(2), 1.2)


def test_fisher_information_of_mixture_noise():
    """0.7450 of Kychak's noise is four printed digits; the genie who sees the switch has 0.8 + 0.2/900."""
    assert relative_fisher_information([1.0], [7.0]) == pytest.approx(1.0, abs=1e-9)
    kychak = relative_fisher_information([0.8, 0.2], [1.0, 30.0])
    assert kychak == pytest.approx(0.7450, abs=5e-5)
    assert kychak < 0.8 + 0.2 / 900
    grid = np.linspace(-300.0, 300.0, 600_001)  # the same by the trapezoidal rule on log-density differences
    density = sum(w * np.exp(-0.5 * (grid / s) ** 2) / s for w, s in ((0.8, 1.0), (0.2, 30.0))) / np.sqrt(2 * np.pi)
    slope = np.gradient(density, grid)
    assert kychak == pytest.approx(np.trapezoid(slope**2 / np.maximum(density, 1e-300), grid), rel=1e-5)
    with pytest.raises(ValueError, match="sum to one"):
        relative_fisher_information([0.5, 0.4], [1.0, 2.0])
    with pytest.raises(ValueError, match="positive"):
        relative_fisher_information([0.5, 0.5], [1.0, 0.0])


def test_bound_of_kychaks_channel():
    """Steady state for q = 1e-4 deg2 per step at 40.5 Hz: 0.01977 deg, four printed digits."""
    period = 1 / 40.5
    J = information(np.array([[1.0, 0.0]]), np.array([[0.0036 / relative_fisher_information([0.8, 0.2], [1, 30])]]))
    F, Q = np.array([[1.0, period], [0.0, 1.0]]), np.diag([0.0, 1e-4])
    bound = posterior_bound(np.eye(2), F, Q, np.broadcast_to(J, (2000, 2, 2)))
    assert np.sqrt(bound[-1, 0, 0]) == pytest.approx(0.01977, abs=5e-6)


def polar_flight(runs: int, epochs: int, density: float, seed: int):
    """Truths from constant velocity, 12 km out and inbound, seen by a radar of 30 m and 1 deg every 0.7 s."""
    generator = np.random.default_rng(seed)
    F, Q = planar_constant_velocity(0.7, density, density)
    start = np.array([12000.0, -50.0, 2000.0, 0.0])
    x = start[:, None] + np.sqrt(np.diag(PRIOR))[:, None] * generator.standard_normal((4, runs))
    truths = []
    for _ in range(epochs):
        x = F @ x + np.linalg.cholesky(Q) @ generator.standard_normal((4, runs))
        truths.append(x)
    truth = np.stack(truths)
    R = np.diag([30.0**2, np.radians(1.0) ** 2])
    z = np.stack([np.hypot(truth[:, 0], truth[:, 2]), np.arctan2(truth[:, 2], truth[:, 0])], axis=1)
    z = z + np.sqrt(np.diag(R))[:, None] * generator.standard_normal(z.shape)
    time = 0.7 * np.arange(1, epochs + 1)
    record = Measurements(("par.range", "par.azimuth"), time, time, z, np.broadcast_to(R, (epochs, 2, 2)))
    return truth, record, Gaussian(start, PRIOR), (F, Q)


def test_polar_constant_velocity_reaches_the_bound():
    """Efficiency >= 0.99 at q = 0.01; 400 runs leave +-1.2 %, so the interval must reach it (full size: acceptance)."""
    truth, record, prior, (F, Q) = polar_flight(400, 80, 0.01, seed=1)
    statistics = Consistency((0, 2))
    sums = statistics.begin()
    for epoch in follow(Kalman(DebiasedPolar(height=0.0), ConstantVelocity(0.01)), record, prior, start=0.0):
        sums = statistics.add(sums, epoch.estimate, truth[epoch.row], epoch.innovation)
    J = np.stack([information(polar_jacobian(x[0], x[2], CARTESIAN), record.R[0]) for x in truth])
    reached = efficiency(posterior_bound(PRIOR, F, Q, J), statistics.summary(sums).rmse_position, components=(0, 2))
    assert reached.high >= 0.99
    assert reached.low <= 1.0


def test_averages_are_ordered():
    """The covariance is convex in the information (Jensen): the bound lies below the average over trajectories."""
    truth, record, _, (F, Q) = polar_flight(50, 60, 5.0, seed=2)
    J = np.stack([information(polar_jacobian(x[0], x[2], CARTESIAN), record.R[0]) for x in truth])
    bound, averaged = posterior_bound(PRIOR, F, Q, J), trajectory_averaged_riccati(PRIOR, F, Q, J)
    assert np.linalg.eigvalsh(averaged - bound).min() > -1e-6
    alone = np.stack([oracle_riccati(PRIOR, F, Q, J[..., i]) for i in range(50)], axis=-1)
    np.testing.assert_allclose(alone.mean(axis=-1), averaged, rtol=1e-9)


def test_one_mode_is_a_plain_bound():
    F, Q = planar_constant_velocity(1.0, 0.3, 0.3)
    J = information(H, 400.0 * np.eye(2))

    def straight(modes):
        shape = (4, 4, len(modes))
        return np.broadcast_to(F[..., None], shape), np.broadcast_to(Q[..., None], shape)

    known = known_modes_bound(PRIOR, straight, np.zeros((20, 3), dtype=int), J)
    np.testing.assert_allclose(known, posterior_bound(PRIOR, F, Q, np.broadcast_to(J, (20, 4, 4))), rtol=1e-10)


def test_efficiency_is_a_ratio_of_lengths():
    bound = np.diag([9.0, 1.0, 16.0, 1.0])
    assert efficiency(bound, Interval(10.0, 8.0, 12.5, 50), (0, 2)) == pytest.approx((0.5, 0.4, 0.625, 50))
