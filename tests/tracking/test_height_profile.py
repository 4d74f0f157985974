"""Heights of a chart and ranges brought to the ground with them: sampled, against geometry, alone and in a batch."""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
import pytest

from tracking.height_profile import (
    DISPLACED,
    LEVEL_SIGMA,
    ChartedHeight,
    ChartHeight,
    HeightProfile,
    MeasuredHeight,
    with_elevation,
)
from tracking.measurement import ConvertedPolar, DebiasedPolar, ExtendedPolar, to_ground

MEAN = np.array([[9000.0, 3000.0], [60.0, 0.0], [250.0, -4000.0], [-3.0, -70.0]])  # of two runs
R = np.array([[3600.0, 0.02], [0.02, 7e-6]])
DESCENT = HeightProfile(
    ((0.0, 0.0, 20_000.0, 0.0), (20_000.0, 0.0, 50_000.0, 0.0)),
    (0.0, 15_000.0, 35_000.0, 50_000.0),
    (1500.0, 1500.0, 600.0, 600.0),
)


class Level(NamedTuple):
    """A chart of one height."""

    height: float
    variance: float = 0.0

    def at(self, *anywhere):
        return ChartHeight(self.height, self.variance)


@pytest.mark.parametrize("form", [ConvertedPolar, DebiasedPolar, ExtendedPolar])
def test_a_height_without_doubt_is_a_known_height(form):
    z = np.array([[9100.0, 5300.0], [0.02, -0.9]])
    known = form((100.0, 50.0), 0.1, 590.0).linearise(z, R[..., None], MEAN)
    model = form((100.0, 50.0), 0.1)
    charted = ChartedHeight(model, Level(600.0), 10.0).linearise(z, R[..., None], MEAN)
    told = np.concatenate((z, np.full((1, 2), 600.0)))
    precise = np.zeros((3, 3, 1))
    precise[:2, :2, 0] = R
    measured = MeasuredHeight(model, 10.0).linearise(told, precise, MEAN)
    for one in (charted, measured):
        np.testing.assert_allclose(one.z, known.z, rtol=0, atol=1e-6)
        np.testing.assert_allclose(one.R, np.broadcast_to(known.R, one.R.shape), rtol=1e-9, atol=1e-9)


def test_the_doubt_of_a_height_is_one_of_the_distance():
    rng, height, sigma = np.random.default_rng(3), 1500.0, 120.0
    noise = np.linalg.cholesky(R) @ rng.standard_normal((2, 40_000))
    heights = height + sigma * rng.standard_normal(40_000)
    sampled = to_ground(*with_elevation(np.array([[3000.0], [0.4]]) + noise, R[..., None], heights, sigma**2), None)
    foretold = to_ground(*with_elevation(np.array([3000.0, 0.4]), R, height, sigma**2), None)
    assert np.var(sampled.distance) == pytest.approx(float(foretold.distance_variance), rel=0.03)  # 4 standard errors
    cross = np.cov(sampled.distance, sampled.azimuth)[0, 1]
    standard_error = math.sqrt(foretold.distance_variance * R[1, 1] / 4e4)
    assert cross == pytest.approx(float(foretold.covariance), abs=4 * standard_error)
    plain = (3000.0**2 * 3600.0 + height**2 * sigma**2) / (3000.0**2 - height**2)
    assert float(foretold.distance_variance) == pytest.approx(plain)


def test_a_range_shorter_than_the_height_is_not_used():
    linear = ChartedHeight(DebiasedPolar(), Level(600.0, 900.0)).linearise(np.array([590.0, 0.1]), R, MEAN[:, 0])
    assert np.isnan(linear.z).all()
    assert np.isfinite(linear.R).all()


def test_a_missed_plot_stays_missed():
    z = np.array([[9100.0, math.nan], [0.02, math.nan]])
    linear = ChartedHeight(DebiasedPolar(), DESCENT).linearise(z, R[..., None], MEAN)
    assert np.isnan(linear.z[:, 1]).all()
    assert np.isfinite(linear.z[:, 0]).all()
    assert np.isfinite(linear.R[..., 0]).all()


def test_runs_in_a_batch_are_the_runs_alone():
    profile = HeightProfile(((0, 0, 9000, 0), (9000, 0, 9000, 9000)), (0.0, 9000.0, 14_000.0), (900.0, 900.0, 400.0))
    z = np.array([[9100.0, 5300.0], [0.02, -0.9]])
    model = ChartedHeight(DebiasedPolar((100.0, 50.0), 0.1), profile, 10.0)
    together = model.linearise(z, R[..., None], MEAN)
    for run in range(2):
        alone = model.linearise(z[:, run], R, MEAN[:, run])
        np.testing.assert_allclose(together.z[:, run], alone.z, rtol=1e-12)
        np.testing.assert_allclose(together.R[..., run], alone.R, rtol=1e-9)


@pytest.mark.parametrize("north", [5000.0, 14_500.0, 15_200.0, 25_000.0, 35_300.0, 45_000.0])
def test_the_doubt_is_that_of_a_plan_that_is_flown_early_or_late(north):
    """The error of the chart over many flights of the plan, each displaced as a whole, in its stated variance."""
    one = HeightProfile(((0.0, 0.0, 50_000.0, 0.0),), DESCENT.along, DESCENT.height)
    rng = np.random.default_rng(4)
    flown = np.interp(north + rng.uniform(-DISPLACED, DISPLACED, 20_000), one.along, one.height)
    flown = flown + LEVEL_SIGMA * rng.standard_normal(20_000)
    height, variance = one.at(np.array(north), np.array(0.0))
    share = np.mean((flown - height) ** 2) / variance
    assert share == pytest.approx(1.0, abs=0.1)  # 10 standard errors: nine places stand for all of them


def test_on_the_glide_path_the_place_says_the_height():
    along, height = (0.0, 10_000.0, 20_000.0), (500.0, 500.0, 0.0)
    glide = HeightProfile(((0.0, 0.0, 20_000.0, 0.0),), along, height, glide_path_from=10_000.0)
    assert glide.at(np.array([12_000.0, 25_000.0]), np.zeros(2)).height == pytest.approx([400.0, 0.0])
    assert glide.at(12_000.0, 0.0).variance == pytest.approx(LEVEL_SIGMA**2)


def test_of_two_legs_that_cross_it_is_the_one_of_the_course():
    cross = HeightProfile(
        ((0, 0, 20_000, 0), (20_000, 0, 10_000, 10_000), (10_000, 10_000, 10_000, -10_000)),
        (0.0, 20_000.0, 34_142.0, 54_142.0),
        (2000.0, 2000.0, 800.0, 800.0),
    )
    north, east = np.full(2, 10_000.0), np.zeros(2)
    height = cross.at(north, east, np.array([80.0, 0.0]), np.array([0.0, -80.0])).height
    # chord^2 / 2 DISPLACED^2 at a right angle and a radius of 2 km is 4: the other leg keeps exp(-4) = 1.8 %
    assert height == pytest.approx([2000.0, 800.0], abs=0.02 * 1200.0)


def test_what_legs_on_each_other_differ_by_is_doubt():
    out_and_out_again = HeightProfile(
        ((0, 0, 20_000, 0), (20_000, 0, 10_000, 9000), (10_000, 9000, 0, 0), (0, 0, 20_000, 0)),
        (0.0, 20_000.0, 46_907.0, 66_907.0),
        (2000.0, 2000.0, 500.0, 500.0),
    )
    height, variance = out_and_out_again.at(10_000.0, 0.0, 80.0, 0.0)
    assert height == pytest.approx(1250.0, abs=5.0)
    assert variance == pytest.approx(750.0**2, rel=0.02)


def test_profiles_are_values():
    assert HeightProfile(DESCENT.legs, DESCENT.along, DESCENT.height) == DESCENT
    assert len({DESCENT, HeightProfile(DESCENT.legs, DESCENT.along, DESCENT.height)}) == 1
