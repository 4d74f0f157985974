"""Flights as recordings: places on the globe by another way of computing, true courses, altitudes, rows of a sensor."""

from __future__ import annotations

import math

import numpy as np
import pytest

from aircraft.air import Air
from aircraft.state import AircraftState
from sim.observation.as_recorded import as_seen, exact, records_traffic
from sim.observation.record import SensorRecord
from sim.observation.sensors.adsb import Adsb
from sim.observation.sensors.surveillance_radar import SurveillanceRadar
from sim.scenario.tables import Runway

RUNWAY = Runway(math.radians(52.0), math.radians(8.0), elevation=100.0)
AIR = Air(100.0, qnh=103_000.0)


def straight(north, east, rate_north, rate_east, rows=91):
    """A flight at 1000 m that is straight in the frame of the runway, at 30 Hz."""
    time = np.arange(rows) / 30.0
    nothing = np.full(rows, np.nan)
    columns = dict.fromkeys(AircraftState._fields, nothing)
    columns |= {"time": time, "north": north + rate_north * time, "east": east + rate_east * time}
    columns |= {"height": np.full(rows, 1000.0), "velocity_up": np.zeros(rows)}
    columns |= {"velocity_north": np.full(rows, rate_north), "velocity_east": np.full(rows, rate_east)}
    return AircraftState(**columns)


def test_there_is_a_row_each_second_with_the_altitude_of_that_air():
    track = exact("one", straight(-20e3, 0.0, 80.0, 0.0), RUNWAY, AIR, 1e9)
    np.testing.assert_allclose(track.time, 1e9 + np.arange(4.0))
    np.testing.assert_allclose(track.height, 1100.0)
    np.testing.assert_allclose(track.pressure_altitude, AIR.pressure_altitude(1000.0))
    np.testing.assert_allclose(track.ground_speed, 80.0)
    assert track.longitude == pytest.approx(RUNWAY.longitude, abs=1e-12)
    # down the meridian by the length of a degree of latitude at 52 deg, 111.2 km less 0.5 at half the way, at 1.1 km
    degree = 111.1329 - 0.5598 * math.cos(2 * math.radians(51.91))  # km, the series of the ellipsoid
    way = (1.0 + 1.1 / 6380.0) * degree * np.degrees(RUNWAY.latitude - track.latitude[0])
    assert way == pytest.approx(20.0, abs=0.002)


def test_courses_are_counted_from_true_north_where_the_aircraft_is():
    """40 km east the meridians lean to the left by the difference in longitude times the sine of the latitude."""
    track = exact("one", straight(0.0, 40e3, 80.0, 0.0), RUNWAY, AIR, 0.0)
    turned = (track.longitude[0] - RUNWAY.longitude) * math.sin(RUNWAY.latitude)
    assert math.degrees(turned) == pytest.approx(0.459, abs=0.002)
    assert np.angle(np.exp(1j * track.course[0])) == pytest.approx(turned, rel=0.01)


def test_rows_of_a_sensor_are_those_that_it_received():
    z = np.full((3, 6, 2), np.nan)
    z[:, :, 1] = np.array((-20e3, 0.0, float(AIR.pressure_altitude(1000.0)), 80.0, 0.0, -3.0))
    z[1, :, 1] = np.nan
    seen = SensorRecord(Adsb.channels, np.arange(3.0), np.arange(3.0), z, np.empty(0))
    track = as_seen("one", seen, RUNWAY, AIR, 100.0, draw=1)
    assert track.time.tolist() == [100.0, 102.0]
    assert track.height is None
    assert track.vertical_rate.tolist() == [-3.0, -3.0]
    exactly = exact("one", straight(-20e3, 0.0, 80.0, 0.0), RUNWAY, AIR, 100.0)
    assert track.latitude[0] == pytest.approx(exactly.latitude[0], abs=1e-10)
    assert not len(as_seen("one", seen, RUNWAY, AIR, 100.0, draw=0).time)


def test_only_what_says_place_and_pressure_altitude_records_traffic():
    assert records_traffic(Adsb())
    assert not records_traffic(SurveillanceRadar(height="mode_c"))
