"""The air over a runway against printed tables of the standard atmosphere, against JSBSim, and against a barometer."""

import math

import numpy as np
import pytest

from aircraft.air import STANDARD_DENSITY, Air
from aircraft.airframe import InitialCondition, load
from aircraft.point_mass import PointMass
from aircraft.runway import Runway
from aircraft.state import Controls
from aircraft.trim import trim

SLUG_PER_CUBIC_FOOT = 515.3788184  # kg/m3


@pytest.mark.parametrize(
    ("altitude", "temperature", "pressure", "density"),
    [  # ICAO Doc 7488, geometric altitude
        (0.0, 288.150, 101325.0, 1.2250),
        (1000.0, 281.651, 89876.2, 1.1117),
        (5000.0, 255.676, 54048.3, 0.73643),
        (10000.0, 223.252, 26499.9, 0.41351),
        (15000.0, 216.650, 12111.8, 0.19476),
    ],
)
def test_the_standard_atmosphere_is_that_of_its_table(altitude, temperature, pressure, density):
    air = Air()
    assert air.is_standard
    assert air.temperature_at(altitude) == pytest.approx(temperature, abs=2e-3)  # the digits that are printed
    assert air.pressure(altitude) == pytest.approx(pressure, rel=2e-5)
    assert air.density(altitude) == pytest.approx(density, rel=5e-5)
    assert air.density(np.array([altitude]))[0] == pytest.approx(air.density(altitude), rel=1e-12)


@pytest.mark.parametrize("elevation", [0.0, 4061.0])
@pytest.mark.parametrize(("celsius", "qnh"), [(None, 101325.0), (40.0, 98000.0), (-60.0, 104000.0)])
def test_jsbsim_flies_in_this_air(elevation, celsius, qnh):
    air = Air(elevation, None if celsius is None else celsius + 273.15, qnh)
    airframe = load("an26", runway=Runway(elevation=elevation), air=air)
    for height in (0.0, 400.0):
        still = InitialCondition(
            0.0, 0.0, height, 0.0, 0.0, 0.0, 70.0, 0.0, 0.0, Controls(0.0, 0.0, 0.0, 0.3, 0.0, 0.0)
        )
        state = airframe.begin(still)
        density = airframe._executive["atmosphere/rho-slugs_ft3"] * SLUG_PER_CUBIC_FOOT
        assert density == pytest.approx(air.density(height), rel=1e-4)  # JSBSim's own constants have five digits
        assert state.airspeed == pytest.approx(70.0, abs=1e-3)
        assert state.equivalent_airspeed == pytest.approx(70.0 * math.sqrt(density / 1.225), rel=1e-4)
    body = PointMass(air=air)
    read = body.read(body.begin(0.0, 0.0, 400.0, 0.0, 70.0))
    assert read.equivalent_airspeed == pytest.approx(state.equivalent_airspeed, rel=1e-4)


def test_an_altimeter_on_the_qnh_shows_the_elevation_and_in_cold_air_too_much_above_it():
    for qnh in (98000.0, 101325.0, 104000.0):
        field = Air(1500.0, 253.15, qnh)
        assert field.altimeter(0.0) == pytest.approx(1500.0, abs=0.5)  # geopotential: 0.35 m less
        # above the field it counts the thin, warm air of the standard: more by the ratio of temperatures
        standard = 288.15 - 0.0065 * field.pressure_altitude(150.0)
        shown = field.altimeter(300.0) - field.altimeter(0.0)
        assert shown == pytest.approx(300.0 * standard / field.temperature_at(150.0), rel=2e-3)
    # a transponder knows no QNH: 27 ft for each hPa near sea level
    low, high = Air(0.0, None, 100325.0), Air(0.0, None, 101325.0)
    assert low.pressure_altitude(300.0) - high.pressure_altitude(300.0) == pytest.approx(10 * 8.32, rel=0.01)


def test_what_indicated_leaves_out_is_small_where_it_is_used():
    assert abs(Air().compressibility(100.0, 0.0)) < 1e-12  # nothing at sea level, at any speed
    high = Air(4061.0)
    mach = 0.25
    true = mach * math.sqrt(1.4 * 287.05287 * high.temperature_at(0.0))
    series = mach * mach / 8.0 * (1.0 - high.pressure(0.0) / 101325.0)
    assert high.compressibility(true, 0.0) == pytest.approx(series, rel=0.03)  # the next term is of the order of M^2
    assert series < 0.005


def test_hot_air_takes_the_power_that_thin_air_takes():
    """A lever gives the propellers less in hot air of one density as it does in thin standard air of the same."""
    hot = Air(0.0, 288.15 + 45.0)
    height = next(h for h in np.arange(0.0, 3000.0, 1.0) if Air().density(float(h)) < hot.density(0.0))
    levers = []
    for air, place in ((hot, 0.0), (Air(), float(height))):
        # clear of the ground effect both; the same equivalent airspeed through the same density
        airframe = load("an26", 20000.0, air=air)
        levers.append(trim(airframe, 75.0, 0.0, place + 300.0, math.radians(15.0)).controls.throttle)
    assert levers[0] == pytest.approx(levers[1], rel=5e-3)  # 300 m of another lapse of density between them


def test_air_that_nobody_measured_is_refused():
    with pytest.raises(ValueError, match="must be at least -90"):
        Air(0.0, 180.0)
    with pytest.raises(ValueError, match="must be at least 85000"):
        Air(0.0, None, 70000.0)
    assert Air().density(0.0) == pytest.approx(STANDARD_DENSITY, rel=1e-12)


def test_a_trim_names_the_power_that_lacks():
    """What it says is checked by a descent: the weight then gives the thrust that lacks."""
    from aircraft.errors import TrimError

    airframe = load("an26", 20000.0, runway=Runway(elevation=5000.0))
    with pytest.raises(TrimError, match=r"needs more than full power: [0-9]+ kW lack") as told:
        trim(airframe, 88.0, 0.0, 1000.0, math.radians(38.0), 1.0)
    words = str(told.value).split()
    force = 1e3 * float(words[words.index("kN") - 1]) + 20.0  # it is told to 10 N
    sine = force / (20000.0 * 9.80665)
    steady = trim(airframe, 88.0, -math.asin(sine), 1000.0, math.radians(38.0), 1.0)
    assert steady.controls.throttle == pytest.approx(1.0, abs=0.005)
