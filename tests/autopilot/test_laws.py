"""The bank laws against their equations, their limits and each other."""

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from autopilot.modes.lateral_navigation import LateralNavigation
from autopilot.modes.radio_beacon import RadioBeacon
from autopilot.route import Leg, PathDeviation, Route
from autopilot.saturation import rate_limit, saturate

LAW = LateralNavigation(3.4907e-4, 8.7266e-3, math.radians(20.0), 1250.0, 60.0)
finite = st.floats(-1e5, 1e5)


def at(cross_track, rate):
    return PathDeviation(cross_track, rate, 1e4, 0.0, 0.0, 0.0)


@given(value=finite, limit=st.floats(0.0, 1e4))
def test_saturation_is_the_nearest_point_of_its_interval(value, limit):
    limited = saturate(value, limit)
    assert -limit <= limited <= limit
    assert limited == float(np.clip(value, -limit, limit))
    assert saturate(np.array([value]), limit)[0] == limited


def test_rate_limit_arrives_in_the_time_of_the_rate():
    value = 0.0
    for _ in range(30):
        value = rate_limit(value, 1.0, 0.5, 1.0 / 30.0)
    assert value == pytest.approx(0.5)
    for _ in range(31):
        value = rate_limit(value, 1.0, 0.5, 1.0 / 30.0)
    assert value == 1.0


@given(cross_track=finite, rate=st.floats(-200.0, 200.0))
def test_route_law_is_odd_and_limited(cross_track, rate):
    bank = LAW(at(cross_track, rate))
    assert abs(bank) <= LAW.bank_limit
    assert LAW(at(-cross_track, -rate)) == -bank


@pytest.mark.parametrize(
    ("cross_track", "rate", "degrees"),
    [
        (100.0, 0.0, -2.0),  # 0.02 deg/m
        (0.0, 10.0, -5.0),  # 0.5 deg/(m/s)
        (100.0, -4.0, 0.0),
        (5000.0, -50.0, 0.0),  # beyond 1250 m the position asks for 25 deg, which 50 m/s take back
        (5000.0, -80.0, 5.0),  # the rate counts no more than 60 m/s
        (5000.0, 0.0, -20.0),
    ],
)
def test_route_law_by_hand(cross_track, rate, degrees):
    assert math.degrees(LAW(at(cross_track, rate))) == pytest.approx(degrees, abs=1e-3)  # k are given to 5 digits


def test_bank_of_laws_in_one_call_equals_single_laws():
    limits = np.array([400.0, 1250.0, np.inf])
    rng = np.random.default_rng(3)
    z, rate = rng.normal(0.0, 2000.0, (1, 50)), rng.normal(0.0, 40.0, (1, 50))
    bank = LateralNavigation(LAW.k1, LAW.k2, LAW.bank_limit, limits[:, None], 60.0)(at(z, rate))
    for i, limit in enumerate(limits):
        single = LateralNavigation(LAW.k1, LAW.k2, LAW.bank_limit, float(limit), 60.0)
        np.testing.assert_array_equal(
            bank[i], [single(at(float(a), float(b))) for a, b in zip(z[0], rate[0], strict=True)]
        )


@pytest.mark.parametrize("field", ["k1", "k2", "bank_limit", "cross_track_limit", "cross_track_rate_limit"])
def test_route_law_refuses_what_cannot_steer(field):
    values = {"k1": 1e-3, "k2": 1e-2, "bank_limit": 0.3, "cross_track_limit": 500.0, "cross_track_rate_limit": 40.0}
    for wrong in (0.0, -1.0, math.nan):
        with pytest.raises(ValueError, match=field):
            LateralNavigation(**(values | {field: wrong}))


LINE = Route((Leg((0.0, 0.0), (40e3, 0.0), 100.0, 400.0),))


@pytest.mark.parametrize("side", [1.0, -1.0])
def test_beacon_law_turns_back_to_its_line_from_either_side(side):
    law = RadioBeacon(6.0, 1.2, math.radians(20.0), math.radians(5.0))
    assert side * law(LINE.deviation(0, (0.0, side * 500.0), (100.0, 0.0))) < 0.0
    assert side * law(LINE.deviation(0, (0.0, 0.0), (100.0, side * 10.0))) < 0.0


def test_beacon_law_near_its_line_is_the_route_law_with_k3_over_distance_and_k4_over_speed():
    beacon = RadioBeacon(6.0, 1.2, math.radians(20.0), math.radians(5.0))
    distance, speed = 30e3, 100.0
    route = LateralNavigation(6.0 / distance, 1.2 / speed, math.radians(20.0), 1e9, 1e9)
    deviation = LINE.deviation(0, (40e3 - distance, 40.0), (speed, 0.5))
    # angles of 1e-3 and 5e-3 rad differ from their tangents and sines by 1e-5 of themselves
    assert beacon(deviation) == pytest.approx(route(deviation), rel=1e-4)


def test_beacon_law_on_heading_rests_off_its_line_in_a_crosswind():
    """The equilibrium k3 eps = k4 drift: 1.6 deg of bearing for 8 deg of drift."""
    law = RadioBeacon(6.0, 1.2, math.radians(20.0), math.radians(5.0), course="heading")
    drift, bearing = math.radians(8.0), math.radians(1.6)
    resting = PathDeviation(-30e3 * math.tan(bearing), 0.0, 30e3, bearing, 0.0, drift)
    assert law(resting) == pytest.approx(0.0, abs=1e-12)
    on_track = RadioBeacon(6.0, 1.2, math.radians(20.0), math.radians(5.0), course="track")
    assert math.degrees(on_track(resting)) == pytest.approx(9.6)


def test_beacon_law_holds_the_course_over_the_station():
    law = RadioBeacon(6.0, 1.2, math.radians(20.0), math.radians(5.0), cone_radius=500.0)
    for distance in (499.0, 0.0, -300.0):
        deviation = LINE.deviation(0, (40e3 - distance, 30.0), (100.0, 2.0))
        assert law(deviation) == pytest.approx(-1.2 * deviation.track_error)
    outside = LINE.deviation(0, (40e3 - 501.0, 30.0), (100.0, 2.0))
    assert law(outside) < -1.2 * outside.track_error - 0.1


def test_beacon_law_takes_arrays():
    law = RadioBeacon(6.0, 1.2, math.radians(20.0), math.radians(5.0))
    north, east = np.array([0.0, 39.8e3, 20e3]), np.array([500.0, 10.0, -3e3])
    bank = law(LINE.deviation(np.zeros(3, int), (north, east), (np.full(3, 100.0), np.zeros(3))))
    singles = [law(LINE.deviation(0, (a, b), (100.0, 0.0))) for a, b in zip(north.tolist(), east.tolist(), strict=True)]
    np.testing.assert_allclose(bank, singles, rtol=1e-12)
