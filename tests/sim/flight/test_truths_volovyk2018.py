"""The landing profile against what the published elevation filter does on the real level leg, measured elsewhere."""

from __future__ import annotations

import math

import numpy as np
import pytest

from sim.flight.truths.mls_profile import MlsProfile
from tracking.gaussian import Gaussian
from tracking.measurement import wrap
from tracking.track import Measurements, track
from tracking.trackers.elevation import PERIOD, Elevation, elevation_of

SIGMA, RUNS = math.radians(0.06), 50


@pytest.fixture(scope="module")
def level_leg():
    """True elevation of every sample of the level leg and of its end."""
    flight = MlsProfile().fly(step=PERIOD)
    state = flight.state
    level = flight.during("level")
    north, height = state.north[level], state.height[level]
    truth = elevation_of(-north, height, -state.velocity_north[level], state.velocity_up[level])
    return flight.time[level], truth


def test_rates_are_those_of_the_elevation_formula(level_leg):
    """Two derivations of the same rate: the record's angle differenced, and the formula on the record's motion."""
    time, truth = level_leg
    assert np.gradient(truth.angle, time)[1:-1] == pytest.approx(truth.rate[1:-1], rel=1e-5)


def test_published_filter_looks_good_on_the_real_leg_and_is_not(level_leg):
    """Mean square error over its own variance .76 +- .04: below one, because the truth has no process noise at all."""
    time, truth = level_leg
    generator = np.random.default_rng(20180612)
    z = truth.angle[:, None] + SIGMA * generator.standard_normal((len(time), RUNS))
    measurements = Measurements(("mls.elevation",), time, time, z[:, None], np.full((len(time), 1, 1), SIGMA**2))
    prior = Gaussian(np.array([truth.angle[0], truth.rate[0]]), np.diag([SIGMA**2, math.radians(0.0122) ** 2]))
    followed = track(Elevation(("mls.elevation",)), measurements, prior, start=time[0])
    settled = slice(200, None)
    error = wrap(followed.mean[settled, 0] - truth.angle[settled, None])
    ratio = (error**2).mean() / followed.cov[settled, 0, 0].mean()
    assert ratio == pytest.approx(0.76, abs=0.04)
    assert math.degrees(error.mean()) == pytest.approx(0.0, abs=1e-3)  # the bias: -8e-5 deg
