"""One azimuth or one slant range as rows of a filter: against finite differences, a least squares fit, a polar plot."""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
import pytest

from tracking.gaussian import Gaussian
from tracking.height_profile import ChartHeight
from tracking.measurement import DebiasedPolar, ExtendedPolar, Stacked
from tracking.partial_place import Azimuth, Chosen, SlantRange
from tracking.trackers.kalman import Kalman
from tracking.trackers.line_of_approach import LineOfApproach


class Level(NamedTuple):
    """A chart of one height."""

    height: float
    sigma: float = 0.0

    def at(self, *anywhere):
        return ChartHeight(self.height, self.sigma**2)


AZIMUTH = Azimuth((2800.0, 50.0), math.pi)
RANGE = SlantRange((300.0, 120.0, 3.0), Level(600.0))
MEAN = np.array([[-9000.0, -4000.0], [60.0, 55.0], [250.0, -30.0], [-3.0, 1.0]])  # of two runs


def exact(model, mean):
    """What the sensor would measure at a state."""
    if model is AZIMUTH:
        north, east = mean[0] - 2800.0, mean[2] - 50.0
        return (np.arctan2(east, north) - math.pi + math.pi) % (2 * math.pi) - math.pi
    return np.sqrt((mean[0] - 300.0) ** 2 + (mean[2] - 120.0) ** 2 + 597.0**2)


@pytest.mark.parametrize("model", [AZIMUTH, RANGE])
def test_a_row_is_the_derivative_and_vanishes_at_the_truth(model):
    z, R = exact(model, MEAN)[None], np.ones((1, 1, 1))
    linear = model.linearise(z, R, MEAN)
    np.testing.assert_allclose(linear.z, np.einsum("ij...,j...->i...", linear.H, MEAN), rtol=1e-12, atol=1e-9)
    for component in range(4):
        step = np.zeros_like(MEAN)
        step[component] = 0.5
        slope = exact(model, MEAN + step) - exact(model, MEAN - step)
        np.testing.assert_allclose(linear.H[0, component], slope, rtol=1e-6, atol=1e-12)


def test_an_azimuth_is_taken_the_shorter_way_round():
    behind = np.array([12_000.0, 0.0, 50.0, 0.0])[:, None]  # seen at pi from the antenna's zero, which points south
    linear = AZIMUTH.linearise(np.full((1, 1), math.pi - 0.01), np.ones((1, 1, 1)), behind)
    residual = linear.z - np.einsum("ij...,j...->i...", linear.H, behind)
    assert residual == pytest.approx(-0.01, abs=1e-9)


def test_nothing_is_read_over_an_antenna():
    over = np.array([2790.0, 60.0, 60.0, 0.0])[:, None]
    assert np.isnan(AZIMUTH.linearise(np.zeros((1, 1)), np.ones((1, 1, 1)), over).z).all()
    over = np.array([310.0, 60.0, 100.0, 0.0])[:, None]
    assert np.isnan(RANGE.linearise(np.full((1, 1), 600.0), np.ones((1, 1, 1)), over).z).all()


def test_a_height_that_is_not_known_is_an_error_of_the_range():
    """Sampled: the spread of the slant range over heights, beside its own noise."""
    rng = np.random.default_rng(1)
    mean = np.array([-2000.0, 60.0, 250.0, 0.0])[:, None]
    uncertain = SlantRange(RANGE.position, Level(600.0, 90.0))
    R = uncertain.linearise(np.full((1, 1), 2500.0), np.full((1, 1, 1), 15.0**2), mean).R
    heights = 597.0 + 90.0 * rng.standard_normal(20_000)
    sampled = np.sqrt(2300.0**2 + 130.0**2 + heights**2) + 15.0 * rng.standard_normal(20_000)
    assert R[0, 0] == pytest.approx(sampled.var(), rel=0.05)  # 3 standard errors are 3 %, and the square bends


def test_a_range_and_an_azimuth_of_one_antenna_are_a_plot():
    """Read at one moment, the two rows are what the polar filter of the same plot makes of it."""
    here, sigma = (100.0, 50.0, 3.0), np.diag((20.0**2, 0.002**2))
    z = np.array([[9105.0], [3.13]])
    prior = Gaussian(MEAN[:, :1], np.diag((200.0, 5.0, 150.0, 5.0))[..., None] ** 2)
    rows = Stacked((SlantRange(here, Level(600.0)), Azimuth(here[:2], 0.0)))
    apart, _ = Kalman(rows).step(prior, 0.0, z, sigma[..., None])
    plot, _ = Kalman(ExtendedPolar(here[:2], 0.0, 597.0)).step(prior, 0.0, z, sigma[..., None])
    np.testing.assert_allclose(apart.mean, plot.mean, rtol=0, atol=0.1)  # slant and ground differ by second order
    np.testing.assert_allclose(apart.cov, plot.cov, rtol=5e-3, atol=0.5)


def test_what_else_a_sensor_measures_is_left_out():
    z = np.array([[math.nan], [9100.0], [3.1]])
    R = np.diag((9.0, 400.0, 1e-6))[..., None]
    mean = MEAN[:, :1]
    chosen = Chosen(DebiasedPolar(height=500.0), (1, 2), 3).linearise(z, R, mean)
    plain = DebiasedPolar(height=500.0).linearise(z[1:], R[1:, 1:], mean)
    for one, other in zip(chosen, plain, strict=True):
        np.testing.assert_array_equal(one, other)


def test_a_silent_sensor_has_as_many_rows_as_one_that_speaks():
    models = (Chosen(AZIMUTH, (0,), 1), RANGE, DebiasedPolar(height=500.0))
    stacked, R = Stacked(models), np.eye(4)[..., None]
    assert (stacked.rows, stacked.equations) == (4, 4)
    for spoken in range(4):
        z = np.full((4, 1), np.nan)
        z[spoken] = 1.0
        assert stacked.linearise(z, R, MEAN[:, :1]).H.shape[:2] == (4, 4)


def test_the_line_of_approach_spends_its_noise_along_and_across_the_line():
    zero = math.radians(260.0)  # the line comes in on 080
    tracker = LineOfApproach(RANGE, zero, along_density=0.2, across_density=2.0)
    F, Q, _ = tracker.transition(1.0, None)
    along = np.array((math.cos(zero), math.sin(zero)))
    across = np.array((-along[1], along[0]))
    rates = Q[np.ix_((1, 3), (1, 3))]
    assert (along @ rates @ along, across @ rates @ across) == pytest.approx((0.2, 2.0))
    assert along @ rates @ across == pytest.approx(0.0, abs=1e-12)
    np.testing.assert_array_equal(F, np.kron(np.eye(2), ((1.0, 1.0), (0.0, 1.0))))
    with pytest.raises(ValueError, match="across_density must be above 0"):
        LineOfApproach(RANGE, zero, across_density=0.0)
