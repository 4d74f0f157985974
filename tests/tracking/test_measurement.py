"""Polar conversions against sampled errors, numerical Jacobians and the bound of their validity."""

from __future__ import annotations

import math

import numpy as np
import pytest

from tracking.gaussian import Gaussian, update
from tracking.measurement import (
    ConvertedPolar,
    DebiasedPolar,
    ExtendedPolar,
    LinearMeasurement,
    Stacked,
    longest_range,
    to_ground,
    wrap,
)

RANGE_SIGMA, AZIMUTH_SIGMA, ELEVATION_SIGMA = 30.0, math.radians(1.0), math.radians(0.5)
POLAR = np.diag([RANGE_SIGMA**2, AZIMUTH_SIGMA**2])
FORMS = [ConvertedPolar, DebiasedPolar, ExtendedPolar]


def state(north, east):
    return np.array([north, -60.0, east, 10.0])


def plot(north, east, height, sensor):
    """Noise-free slant range and azimuth."""
    x, y = north - sensor.position[0], east - sensor.position[1]
    return np.array([math.sqrt(x**2 + y**2 + height**2), wrap(math.atan2(y, x) - sensor.course)])


def test_wrap_covers_the_circle_once():
    np.testing.assert_allclose(
        wrap(np.radians([-540.0, -180.0, 0.0, 179.0, 181.0, 370.0])),
        np.radians([-180.0, -180.0, 0.0, 179.0, -179.0, 10.0]),
    )


def test_longest_range_of_the_radar():
    """39 394 m for 30 m and 1 deg; with degrees in the formula it would be 12 m."""
    assert longest_range(RANGE_SIGMA, AZIMUTH_SIGMA) == pytest.approx(39_394.0, abs=1.0)
    assert longest_range(RANGE_SIGMA, 0.5) == 0.0
    assert longest_range(RANGE_SIGMA, 0.0) == math.inf


@pytest.mark.parametrize("form", FORMS)
@pytest.mark.parametrize("height", [380.0, None])
def test_a_plot_without_noise_is_the_position(form, height):
    """From 15 km to touchdown; slant range taken as ground range would be 45 m off at 4 km and 600 m height."""
    sensor = form(position=(-900.0, 150.0), course=math.radians(180.0), height=height)
    for north, east in [(-15_000.0, 40.0), (-4_000.0, -30.0), (-1_500.0, 700.0), (3_000.0, 2_000.0)]:
        z = plot(north, east, 380.0, sensor)
        R = np.diag([1e-6, 1e-12])
        if height is None:
            z, R = np.append(z, math.asin(380.0 / z[0])), np.diag([1e-6, 1e-12, 1e-12])
        linear = sensor.linearise(z, R, state(north, east))
        posterior, _ = update(Gaussian(state(north + 50.0, east - 80.0), np.diag([1e4, 1.0, 1e4, 1.0])), *linear)
        np.testing.assert_allclose(posterior.mean[[0, 2]], [north, east], atol=1e-3)


def test_azimuth_is_positive_right_of_the_sensors_course():
    """A radar that looks up the approach (course 180 deg) sees what is right of the landing centreline on its left."""
    radar = ExtendedPolar(course=math.pi, height=0.0)
    mean = state(-5000.0, 200.0)  # south of the antenna, east: right of a landing course of 0 deg
    H = radar.linearise(np.array([5000.0, 0.0]), POLAR, mean).H
    assert H[1, 2] < 0.0
    assert plot(-5000.0, 200.0, 0.0, radar)[1] < 0.0


@pytest.mark.parametrize("form", FORMS)
def test_azimuth_residual_is_wrapped(form):
    """Target at 179.9 deg, plot at -179.9 deg of the same sensor: a difference of 0.2 deg, not of 359.8."""
    sensor = form(height=0.0)
    target = 8000.0 * np.array([math.cos(math.radians(179.9)), math.sin(math.radians(179.9))])
    mean = np.array([target[0], 0.0, target[1], 0.0])
    linear = sensor.linearise(np.array([8000.0, math.radians(-179.9)]), POLAR, mean)
    _, innovation = update(Gaussian(mean, np.eye(4)), *linear)
    assert innovation.nis < 0.1


@pytest.mark.parametrize("form", [ConvertedPolar, DebiasedPolar])
def test_converted_covariance_is_that_of_sampled_plots(form):
    """1e5 plots at 15 km: eigenvalues of a sampled covariance scatter by 0.5 %, bias of 5 m by 0.8 m."""
    rng = np.random.default_rng(1)
    sensor = form(height=0.0, course=0.3)
    north, east, runs = 12_000.0, -9_000.0, 100_000
    z = plot(north, east, 0.0, sensor)[:, None] + rng.standard_normal((2, runs)) * np.sqrt(np.diag(POLAR))[:, None]
    mean = np.repeat(state(north, east)[:, None], runs, axis=1)
    linear = sensor.linearise(z, POLAR[:, :, None], mean)
    error = linear.z - np.array([[north], [east]])
    at_truth = sensor.linearise(plot(north, east, 0.0, sensor)[:, None], POLAR[:, :, None], mean[:, :1]).R[..., 0]
    whitened = np.linalg.solve(np.linalg.cholesky(at_truth), error)
    assert np.linalg.eigvalsh(np.cov(whitened)) == pytest.approx([1.0, 1.0], abs=0.03)
    bias = np.linalg.norm(error.mean(axis=1))
    assert bias < (0.1 if form is ConvertedPolar else 0.05) * RANGE_SIGMA


def test_beyond_the_bound_a_conversion_is_biased_and_flagged():
    """At three times the longest range the bend of the arc is 18 m = 0.6 sigma of the range."""
    rng = np.random.default_rng(2)
    distance, runs = 3.0 * longest_range(RANGE_SIGMA, AZIMUTH_SIGMA), 200_000
    azimuths = AZIMUTH_SIGMA * rng.standard_normal(runs)
    bias = distance * (1.0 - np.cos(azimuths).mean())
    assert bias > 0.5 * RANGE_SIGMA
    inside = ConvertedPolar(height=0.0).linearise(np.array([0.99 * distance / 3.0, 0.1]), POLAR, state(distance, 0.0))
    outside = ConvertedPolar(height=0.0).linearise(np.array([1.01 * distance / 3.0, 0.1]), POLAR, state(distance, 0.0))
    assert np.isfinite(inside.z).all()
    assert np.isnan(outside.z).all()
    debiased = DebiasedPolar(height=0.0)
    z = np.stack([np.full(runs, distance), azimuths])
    mean = np.repeat(state(distance, 0.0)[:, None], runs, axis=1)
    converted = debiased.linearise(z, POLAR[:, :, None], mean).z
    scatter = distance * AZIMUTH_SIGMA**2 / math.sqrt(2.0 * runs)  # of the mean of r (1 - cos)
    assert converted[0].mean() - distance == pytest.approx(0.0, abs=5.0 * scatter)


def test_extended_jacobian_is_the_numerical_one():
    sensor = ExtendedPolar(position=(-900.0, 150.0), course=2.0, height=300.0)
    mean = state(4000.0, -2500.0)
    z = plot(4000.0, -2500.0, 300.0, sensor)
    H = sensor.linearise(z, POLAR, mean).H

    def ground(x):
        north, east = x[0] + 900.0, x[2] - 150.0
        return np.array([math.hypot(north, east), math.atan2(east, north)])

    numerical = np.array([(ground(mean + e) - ground(mean - e)) / 2.0 for e in np.eye(4)]).T
    np.testing.assert_allclose(H, numerical, atol=1e-7)  # third derivative over 24 at 5 km


@pytest.mark.parametrize("height", [500.0, None])
def test_ground_covariance_is_that_of_sampled_slant_measurements(height):
    rng = np.random.default_rng(3)
    slant, azimuth, elevation = 3000.0, 0.4, math.asin(500.0 / 3000.0)
    z = np.array([slant, azimuth, elevation])[: 2 if height else 3]
    R = np.diag([RANGE_SIGMA**2, AZIMUTH_SIGMA**2, ELEVATION_SIGMA**2])[: len(z), : len(z)]
    samples = z[:, None] + rng.standard_normal((len(z), 200_000)) * np.sqrt(np.diag(R))[:, None]
    ground = to_ground(samples, R[:, :, None], height)
    nominal = to_ground(z, R, height)
    assert ground.distance.var() == pytest.approx(
        nominal.distance_variance, rel=0.02
    )  # 200 000 samples scatter by 0.3 %
    assert nominal.distance == pytest.approx(math.sqrt(3000.0**2 - 500.0**2), rel=1e-12)


@pytest.mark.parametrize("form", FORMS)
@pytest.mark.parametrize("slant", [399.0, 400.0, 404.0])
def test_a_target_over_the_antenna_is_not_used(form, slant):
    """The direction of a target overhead is noise: the plot is dropped and the filter predicts on."""
    sensor = form(height=400.0)
    prior = Gaussian(state(30.0, 0.0), np.diag([100.0, 1.0, 100.0, 1.0]))
    linear = sensor.linearise(np.array([slant, 2.0]), POLAR, prior.mean)
    assert np.isnan(linear.z).all()
    posterior, innovation = update(prior, *linear)
    np.testing.assert_allclose(posterior.mean, prior.mean)
    np.testing.assert_allclose(posterior.cov, prior.cov)
    assert np.isnan(innovation.white).all()


@pytest.mark.parametrize("form", FORMS)
def test_batch_is_the_single_plot(form):
    rng = np.random.default_rng(4)
    sensor = form(position=(100.0, 200.0), course=0.5, height=200.0)
    mean = state(5000.0, 3000.0)[:, None] + 50.0 * rng.standard_normal((4, 6))
    z = plot(5000.0, 3000.0, 200.0, sensor)[:, None] + rng.standard_normal((2, 6)) * np.sqrt(np.diag(POLAR))[:, None]
    z[:, 2] = np.nan
    many = sensor.linearise(z, POLAR[:, :, None], mean)
    for run in range(6):
        one = sensor.linearise(z[:, run], POLAR, mean[:, run])
        np.testing.assert_allclose(many.z[:, run], one.z, rtol=1e-12)
        np.testing.assert_allclose(many.R[:, :, run] if many.R.shape[-1] > 1 else many.R[..., 0], one.R, rtol=1e-12)


def test_an_absent_elevation_leaves_no_position():
    linear = DebiasedPolar().linearise(np.array([5000.0, 0.1, np.nan]), np.eye(3), state(5000.0, 500.0))
    assert np.isnan(linear.z).all()


def test_stacked_sensors_are_one_update_after_the_other():
    """Two independent sensors in one stacked update, against the same two in turn."""
    one = LinearMeasurement(((1.0, 0.0, 0.0, 0.0),))
    two = DebiasedPolar(position=(3000.0, -8000.0), height=100.0)
    both = Stacked((one, two))
    assert both.rows == 3
    mean = state(6000.0, 1000.0)
    prior = Gaussian(mean, np.diag([1e4, 9.0, 1e4, 9.0]))
    z = np.concatenate([[6040.0], plot(5950.0, 1100.0, 100.0, two)])
    R = np.zeros((3, 3))
    R[0, 0], R[1:, 1:] = 400.0, POLAR
    together, _ = update(prior, *both.linearise(z, R, mean))
    first, _ = update(prior, *one.linearise(z[:1], R[:1, :1], mean))
    second, _ = update(first, *two.linearise(z[1:], R[1:, 1:], mean))  # both linearised at the same mean
    np.testing.assert_allclose(together.mean, second.mean, rtol=1e-10)
    np.testing.assert_allclose(together.cov, second.cov, rtol=1e-8)


def test_stacked_sensors_may_have_different_batches():
    mean = state(6000.0, 1000.0)[:, None] + np.zeros((4, 3))
    both = Stacked((LinearMeasurement(((1.0, 0.0, 0.0, 0.0),)), ConvertedPolar(height=0.0)))
    z = np.array([[6000.0] * 3, [6100.0, 6050.0, np.nan], [0.1, 0.2, 0.3]])
    R = np.zeros((3, 3, 1))
    R[0, 0], R[1:, 1:] = 400.0, POLAR[:, :, None]
    linear = both.linearise(z, R, mean)
    assert linear.R.shape == (3, 3, 3)
    np.testing.assert_allclose(linear.R[0, 0], 400.0)
    assert not linear.R[0, 1:, :2].any()
    posterior, _ = update(Gaussian(mean, np.eye(4)[:, :, None] * 1e4), *linear)
    assert np.isfinite(posterior.mean).all()


def test_ragged_rows_are_refused():
    with pytest.raises(ValueError, match="rows of H"):
        LinearMeasurement(((1.0, 0.0), (1.0,)))


@pytest.mark.parametrize("form", FORMS)
def test_an_azimuth_without_a_direction_is_not_used(form):
    """An accuracy of 60 in degrees where radians are meant is no accuracy at all."""
    linear = form(height=0.0).linearise(np.array([5000.0, 0.1]), np.diag([900.0, 60.0**2]), state(5000.0, 500.0))
    assert np.isnan(linear.z).all()
