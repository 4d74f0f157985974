"""The radio-beacon law flown by the point mass: on the track it holds the line, on the heading it homes."""

import math

import numpy as np
import pytest

from aircraft.wind import steady_wind
from autopilot.approach import Approach
from autopilot.modes.radio_beacon import RadioBeacon
from autopilot.route import Leg, Route
from sim.flight.vehicles import Initial, PointMassVehicle

SPEED = 100.0
LINE = Leg((0.0, 0.0), (40e3, 0.0), SPEED, 600.0)
K3, K4 = 6.0, 1.2


def home(course, wind_speed, cross_track=0.0):
    """(time, distance to go, cross-track, bearing error, bank) of a flight to the station in wind from the right."""
    wind = steady_wind(math.radians(90.0), wind_speed)
    law = RadioBeacon(K3, K4, math.radians(20.0), math.radians(5.0), course)
    approach = Approach(Route((LINE,), wind[:2]), law)
    vehicle = PointMassVehicle()
    body = vehicle.begin(Initial(0.0, cross_track, 600.0, 0.0, SPEED), wind)
    s = approach.begin(vehicle.read(body))
    rows = []
    while not s.finished:
        state = vehicle.read(body)
        s, command = approach.step(s, state, 1 / 30)
        deviation = approach.deviation(0, state)
        rows.append((state.time, deviation.distance_to_go, deviation.cross_track, deviation.bearing_error, state.bank))
        body = vehicle.step(body, command, 1 / 30)
    return np.array(rows).T


def test_on_the_track_a_crosswind_does_not_move_it_off_the_line():
    _, _, z, _, _ = home("track", 8.0)
    assert abs(z).max() < 5.0


def test_on_the_heading_it_flies_the_homing_curve():
    """Heading for the station its course error is bearing plus drift: k3 eps = k4 (eps + drift) holds the bearing."""
    _, distance, z, bearing, _ = home("heading", 8.0)
    drift = math.asin(8.0 / SPEED)
    assert z.min() < -150.0  # the wind from the right carries it to the left of the line
    settled = (distance > 2e3) & (distance < 12e3)
    # settling leaves a thousandth of the bearing, and sines are taken for angles of 5 deg
    np.testing.assert_allclose(bearing[settled], K4 / (K3 - K4) * drift, rtol=0.01)
    assert abs(z[distance < 600.0]).max() < 120.0  # it still comes to the station


def test_capture_from_six_kilometres_keeps_the_bank_limit_and_ends_at_the_station():
    _, distance, z, _, bank = home("track", 0.0, 6000.0)
    assert math.degrees(abs(bank).max()) <= 20.0 + 1e-9
    assert abs(z[distance < 2000.0]).max() < 20.0
    assert z.min() > -100.0


def test_stiffness_grows_towards_the_station():
    """Small deviations decay with k3/D: the damping (k4/2) sqrt(g D/k3)/V falls as the station comes near."""
    damping = [K4 / 2 * math.sqrt(9.80665 * distance / K3) / SPEED for distance in (40e3, 10e3)]
    assert damping == pytest.approx([1.534, 0.767], abs=2e-3)
    law = RadioBeacon(K3, K4, math.radians(20.0), math.radians(5.0))
    route = Route((LINE,))
    bank = [law(route.deviation(0, (40e3 - distance, 50.0), (SPEED, 0.0))) for distance in (40e3, 10e3)]
    assert bank[1] / bank[0] == pytest.approx(4.0, rel=1e-4)
