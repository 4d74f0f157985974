"""What the mutants need and no other test looks at."""

from __future__ import annotations

import math

import numpy as np
import pytest
from scipy.integrate import quad

from autopilot.modes.lateral_navigation import LateralNavigation
from autopilot.route import PathDeviation
from tracking.measurement import ConvertedPolar
from tracking.motion import constant_velocity

LAW = LateralNavigation(math.radians(0.02), math.radians(0.5), math.radians(20.0), 1250.0, 60.0)


def bank(cross_track: float, rate: float) -> float:
    """Degrees that the route law commands."""
    return math.degrees(LAW(PathDeviation(cross_track, rate, math.inf, 0.0, 0.0, 0.0)))


def test_each_limit_of_the_route_law_acts():
    """By hand with .02 deg/m, .5 deg/(m/s), 20 deg, 1250 m, 60 m/s: 25 deg and 30 deg are what the limits leave."""
    assert bank(500.0, 10.0) == pytest.approx(-15.0)
    assert bank(5000.0, -20.0) == pytest.approx(-25.0 + 10.0)
    assert bank(1000.0, -80.0) == pytest.approx(-20.0 + 30.0)
    assert bank(5000.0, 0.0) == pytest.approx(-20.0)
    assert bank(-5000.0, 0.0) == pytest.approx(20.0)


def test_a_law_that_orbits_in_its_wind_is_refused():
    """z_max 2500 m asks for 50 deg; zdot_max 120 m/s would take back 60 deg, but 72 m/s of ground speed only 36 deg."""
    law = LateralNavigation(LAW.k1, LAW.k2, LAW.bank_limit, 2500.0, 120.0)
    law.check_convergence(101.0)
    with pytest.raises(ValueError, match="orbit"):
        law.check_convergence(72.0)
    law.check_convergence(72.0, offset=1500.0)  # never that far out: 30 deg


def test_constant_velocity_noise_is_the_integral_of_white_acceleration():
    """Q = density * integral of [T - t, 1]' [T - t, 1] dt, entry by entry."""
    dt, density = 0.7, 0.3
    _, Q = constant_velocity(dt, density)
    responses = (lambda t: dt - t, lambda t: 1.0)
    for i, first in enumerate(responses):
        for j, second in enumerate(responses):
            integral, _ = quad(lambda t, a=first, b=second: a(t) * b(t), 0.0, dt)
            assert Q[i, j] == pytest.approx(density * integral, rel=1e-12)


def test_the_cross_range_error_is_that_of_the_azimuth():
    """Straight ahead the error to the right is range times azimuth sigma, whatever the elevation's is."""
    R = np.diag([30.0**2, math.radians(1.0) ** 2, math.radians(0.1) ** 2])
    plot = ConvertedPolar().linearise(np.array([10000.0, 0.0, 0.05]), R, np.zeros(4))
    distance = 10000.0 * math.cos(0.05)
    assert plot.R[1, 1] == pytest.approx((distance * math.radians(1.0)) ** 2, rel=1e-12)
    assert plot.R[0, 0] == pytest.approx(
        (30.0 * math.cos(0.05)) ** 2 + (10000.0 * 0.05 * math.radians(0.1)) ** 2, rel=0.01
    )
