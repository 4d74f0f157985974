"""Judge: the wind shear model of MIL-F-8785C by hand, and the classical one-seventh power."""

import math

import pytest

from aircraft.wind import SteadyWind, Together
from aircraft.wind_shear import LogarithmicProfile, PowerProfile, ShearedWind

TWENTY_FEET = 20.0 * 0.3048


def test_logarithmic_profile_by_hand():
    profile = LogarithmicProfile()
    # ln(1000 / 0.15) / ln(20 / 0.15) = 8.8049 / 4.8929
    assert profile.share(1000.0 * 0.3048, TWENTY_FEET) == pytest.approx(1.7995, abs=1e-4)
    # ln(3 / 0.15) / ln(20 / 0.15) = 2.9957 / 4.8929, the lowest of the specification
    assert profile.share(3.0 * 0.3048, TWENTY_FEET) == pytest.approx(0.6123, abs=1e-4)


def test_power_profile_by_hand():
    assert PowerProfile().share(80.0, 10.0) == pytest.approx(8.0 ** (1.0 / 7.0))
    assert PowerProfile(0.5).share(40.0, 10.0) == pytest.approx(2.0)


@pytest.mark.parametrize("profile", [LogarithmicProfile(), LogarithmicProfile(0.3), PowerProfile(), PowerProfile(1.0)])
def test_every_profile_is_one_where_it_is_measured_and_ends_where_the_specification_ends(profile):
    assert profile.share(10.0, 10.0) == pytest.approx(1.0)
    assert profile.share(-5.0, 10.0) == profile.share(0.0, 10.0) == profile.share(0.9, 10.0) > 0.0
    assert profile.share(5000.0, 10.0) == profile.share(304.8, 10.0)
    shares = [profile.share(float(height), 10.0) for height in range(1, 300, 10)]
    assert shares == sorted(shares)


def test_a_rougher_ground_shears_more():
    assert LogarithmicProfile(0.3).share(100.0, 10.0) > LogarithmicProfile(0.03).share(100.0, 10.0)


def test_sheared_wind_keeps_its_direction():
    wind = ShearedWind(SteadyWind(-3.0, 4.0), 10.0, PowerProfile(0.5))
    north, east, up = wind.velocity(7.0, (100.0, 200.0, 40.0), 70.0)
    assert (north, east, up) == pytest.approx((-6.0, 8.0, 0.0))


def test_movements_add():
    both = Together((SteadyWind(1.0, 2.0, 0.5), ShearedWind(SteadyWind(0.0, 1.0), 10.0, PowerProfile(0.5))))
    assert both.velocity(0.0, (0.0, 0.0, 40.0), 70.0) == pytest.approx((1.0, 4.0, 0.5))
    assert Together(()).velocity(0.0, (0.0, 0.0, 0.0), 70.0) == (0.0, 0.0, 0.0)


@pytest.mark.parametrize("wrong", [0.0, -1.0, 1.0, math.nan])
def test_impossible_roughness_is_refused(wrong):
    with pytest.raises(ValueError, match=r"roughness must be (above 0|at most 0.4572)"):
        LogarithmicProfile(wrong)


@pytest.mark.parametrize("wrong", [0.0, -0.2, 1.5, math.nan])
def test_impossible_exponent_is_refused(wrong):
    with pytest.raises(ValueError, match=r"exponent must be (above 0|at most 1)"):
        PowerProfile(wrong)
