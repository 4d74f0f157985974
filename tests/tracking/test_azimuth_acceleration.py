"""The printed, the intended and the exact second derivative of the azimuth against the kinematics of a point."""

from __future__ import annotations

import math

import numpy as np
import pytest

from tests.tracking.radar_flights import base_turn, glide_turn, rms, s_turn
from tracking.azimuth_acceleration import (
    corrected_azimuth_acceleration,
    horizontal_acceleration,
    intended_azimuth_acceleration,
    published_azimuth_acceleration,
)
from tracking.motion import GRAVITY
from tracking.trackers.load_factor import DOWNLINK


def computed(flight, turned=0.0):
    """All three forms along a flight whose earth axes are turned by an angle."""
    a_X, a_Z = horizontal_acceleration(*(flight[name] for name in DOWNLINK[:5]), turned - flight["air_course"])
    line_of_sight = np.gradient(flight["range_rate"], flight["time"], edge_order=2)
    here = (flight["range"], flight["elevation"])
    corrected = corrected_azimuth_acceleration(
        a_X, a_Z, flight["azimuth"] - turned, flight["azimuth_rate"], flight["range"], flight["range_rate"],
        flight["elevation"], flight["elevation_rate"],
    )  # fmt: skip
    return (
        corrected,
        published_azimuth_acceleration(a_X, a_Z, line_of_sight, *here),
        intended_azimuth_acceleration(a_X, a_Z, line_of_sight, *here),
    )


@pytest.mark.parametrize("flight", [base_turn(), s_turn(), glide_turn()], ids=["base", "S", "glide"])
def test_corrected_acceleration_is_the_second_derivative_of_the_azimuth(flight):
    exact = flight["azimuth_acceleration"]
    corrected, _, _ = computed(flight)
    np.testing.assert_allclose(corrected, exact, rtol=0, atol=1e-9 * np.abs(exact).max())
    numeric = np.gradient(np.gradient(flight["azimuth"], flight["time"]), flight["time"])
    np.testing.assert_allclose(exact[5:-5], numeric[5:-5], rtol=0, atol=3e-5 * np.abs(exact).max())  # grid of 10 ms


def test_golden_values():
    angles = np.radians([-15.0, -3.0, 120.0])
    a_X, a_Z = horizontal_acceleration(0.02, 1.05, 0.01, *angles)
    assert a_X == pytest.approx(-2.5848374311848406, rel=1e-12)
    assert a_Z == pytest.approx(0.6635906659692135, rel=1e-12)
    elevation = math.radians(2.0)
    corrected = corrected_azimuth_acceleration(a_X, a_Z, math.radians(10.0), 0.004, 8000.0, -60.0, elevation, 0.0002)
    assert corrected == pytest.approx(1.9793505825578667e-4, rel=1e-12)
    published, clamped = published_azimuth_acceleration(a_X, a_Z, 0.5, 8000.0, elevation)
    assert published == pytest.approx(2.3203213231146763e-4, rel=1e-12)
    assert not clamped


def test_printed_bracket_is_the_sum_of_the_components():
    rng = np.random.default_rng(1)
    n_x, n_y, n_z = rng.uniform(-1, 1, 50), rng.uniform(0.5, 1.5, 50), rng.uniform(-0.3, 0.3, 50)
    gamma, theta, phi = rng.uniform(-0.5, 0.5, 50), rng.uniform(-0.2, 0.2, 50), rng.uniform(-3, 3, 50)
    bracket = GRAVITY * (
        (np.sin(phi) * np.sin(theta) - np.cos(phi) * np.sin(theta)) * (n_y * np.cos(gamma) - n_z * np.sin(gamma))
        + n_x * np.cos(theta) * (np.cos(phi) - np.sin(phi))
        + (np.sin(phi) + np.cos(phi)) * (n_y * np.sin(gamma) + n_z * np.cos(gamma))
    )
    np.testing.assert_allclose(sum(horizontal_acceleration(n_x, n_y, n_z, gamma, theta, phi)), bracket, atol=1e-12)


def test_only_the_print_depends_on_where_its_axes_point():
    """In the middle of a base turn: the printed value grows tenfold with the axes, the others stay."""
    flight = {name: values[6225:6226] for name, values in base_turn().items()} | {"turning": None}
    forms = []
    for turned in np.radians([0.0, 30.0, 45.0, 90.0]):
        a_X, a_Z = horizontal_acceleration(*(flight[name] for name in DOWNLINK[:5]), turned - flight["air_course"])
        forms.append(
            [
                corrected_azimuth_acceleration(a_X, a_Z, flight["azimuth"] - turned, flight["azimuth_rate"],
                                               flight["range"], flight["range_rate"], flight["elevation"], 0.0)[0],
                intended_azimuth_acceleration(a_X, a_Z, 0.0, flight["range"], flight["elevation"])[0][0],
                published_azimuth_acceleration(a_X, a_Z, 0.0, flight["range"], flight["elevation"])[0][0],
            ]
        )  # fmt: skip
    corrected, intended, published = np.transpose(forms)
    np.testing.assert_allclose(corrected, corrected[0], rtol=1e-12)
    np.testing.assert_allclose(intended, intended[0], rtol=1e-12)
    assert published.max() > 10 * published.min()


def test_a_mirrored_flight_flips_the_sign_that_the_print_has_lost():
    left, right = computed(base_turn(-1.0)), computed(base_turn(1.0))
    np.testing.assert_allclose(left[0], -right[0], rtol=0, atol=1e-15)
    assert (left[1][0] >= 0).all()
    assert (right[1][0] >= 0).all()
    np.testing.assert_allclose(left[2][0], right[2][0], rtol=1e-9, atol=1e-12)  # nor can the intended form


def test_clamped_radicand_is_flagged_and_no_nan():
    flight = base_turn()
    corrected, (published, clamped), _ = computed(flight)
    turning = flight["turning"]
    assert np.isfinite(published).all()
    assert 0.4 < clamped[turning].mean() < 0.6  # half of a base turn
    assert clamped[~turning].mean() > 0.9  # and nearly all straight flight, where it knows nothing
    error = rms((published - corrected)[turning])
    assert error > 0.5 * rms(corrected[turning])


def test_straight_level_flight_has_no_horizontal_acceleration():
    """Gravity has no horizontal component, so no g cos(theta) belongs into (1); what is left is Coriolis."""
    course = np.linspace(-3, 3, 7)
    a_X, a_Z = horizontal_acceleration(0.0, 1.0, 0.0, 0.0, 0.0, course)
    np.testing.assert_allclose([a_X, a_Z], 0.0, atol=1e-14)
    crossing = corrected_azimuth_acceleration(0.0, 0.0, 0.3, 0.004, 8000.0, -60.0, 0.0, 0.0)
    assert crossing == pytest.approx(2 * 60.0 * 0.004 / 8000.0, rel=1e-12)
