"""Height by transponder: steps, altimetry, QNH and cold air, against the rules of charts."""

from __future__ import annotations

import math

import numpy as np
import pytest

from aircraft.air import FREEZING, Air
from aircraft.state import AircraftState
from sim.errors import ScenarioError
from sim.observation.sensor import broken_promises
from sim.observation.sensors.surveillance_radar import ALTIMETRY_SIGMA, FOOT, STEPS, SurveillanceRadar
from sim.randomness import Streams
from sim.scenario.reading import read

STILL = AircraftState(*(0.0,) * len(AircraftState._fields))


def told(radar, height, draws=1500):
    """What one look says of an aircraft that stands still in the air, (channels, draws)."""
    here = STILL._replace(north=4000.0, height=height)
    state = radar.begin(0.0, Streams(3, 0, draws, "radar"))
    return radar.step(state, here, here._replace(time=5.0))[1][0]


@pytest.mark.parametrize("step", STEPS)
def test_a_radar_with_mode_c_keeps_the_contract(step):
    assert broken_promises(SurveillanceRadar, lambda: SurveillanceRadar(height="mode_c", height_step=step)) == []


@pytest.mark.parametrize("step", STEPS)
def test_the_error_is_as_stated_and_comes_in_steps(step):
    radar = SurveillanceRadar(height="mode_c", height_step=step)
    errors = np.concatenate([told(radar, height).z[2] - height for height in (803.0, 811.0, 822.0)])
    # a geopotential height of 800 m is 0.1 m less than a geometric one
    assert np.mean(errors) == pytest.approx(0.0, abs=4 * ALTIMETRY_SIGMA / math.sqrt(1500))
    assert np.mean(errors**2) == pytest.approx(told(radar, 803.0).R[2, 2], rel=0.15)  # 4 standard errors of 1500
    steps = told(radar, 803.0).z[2] / step
    np.testing.assert_allclose(steps, np.round(steps), atol=1e-6)


def test_the_altimetry_of_an_aircraft_does_not_change_from_look_to_look():
    radar = SurveillanceRadar(height="mode_c")
    state = radar.begin(0.0, Streams(3, 0, 50, "radar"))
    here = STILL._replace(north=4000.0, height=803.0)
    looks = radar.step(state, here, here._replace(time=60.0))[1]
    assert len(looks) == 15
    assert all(np.array_equal(look.z[2], looks[0].z[2]) for look in looks)
    assert np.ptp(looks[0].z[2]) > ALTIMETRY_SIGMA


@pytest.mark.parametrize("qnh", [97_000.0, 104_000.0])
def test_the_qnh_is_taken_off(qnh):
    plain, other = (SurveillanceRadar(height="mode_c", air=Air(250.0, qnh=p)) for p in (101_325.0, qnh))
    heights = np.arange(0.0, 60.0, 0.7)  # 4 % for 10 K: the standard temperature is that of 350 m higher or lower
    off = np.mean(other.reported_height(heights) - plain.reported_height(heights))
    assert abs(other.air.pressure_altitude(0.0) - plain.air.pressure_altitude(0.0)) > 200.0
    assert off == pytest.approx(0.0, abs=1.0)


@pytest.mark.parametrize("celsius", [-30.0, -10.0, 35.0])
def test_a_cold_day_puts_the_aircraft_below_what_it_says(celsius):
    """The correction to a true height H above sea level, H (15 - t) / (273 + t - 0.0065 H / 2) [Doc 8168]."""
    radar = SurveillanceRadar(height="mode_c", air=Air(0.0, FREEZING + celsius))
    shown = float(np.mean(told(radar, 1000.0).z[2]))
    correction = 1000.0 * (15.0 - celsius) / (273.0 + celsius - 0.5 * 0.0065 * 1000.0)
    assert shown - 1000.0 == pytest.approx(correction, rel=0.05, abs=2.0)
    assert (shown > 1000.0) == (celsius < 15.0)


def test_range_and_azimuth_do_not_hear_of_the_height():
    with_height, without = told(SurveillanceRadar(height="mode_c"), 800.0), told(SurveillanceRadar(), 800.0)
    np.testing.assert_array_equal(with_height.z[:2], without.z)
    plane = SurveillanceRadar(position_sigma=100.0, height="mode_c")
    assert plane.channels == ("north", "east", "height")
    assert told(plane, 800.0).z.shape == (3, 1500)


def test_a_step_in_a_file_is_one_of_the_two():
    with pytest.raises(ValueError, match="height_step must be 25 ft or 100 ft, not 50 ft"):
        SurveillanceRadar(height_step=50.0 * FOOT)


def test_a_sensor_without_mode_c_says_who_has_it():
    sensors = {"link": {"kind": "downlink", "height": "mode_c"}}
    told_so = r"\[sensors.link\] height: no such key; a downlink has none, it is one of surveillance_radar$"
    with pytest.raises(ScenarioError, match=told_so):
        read({"name": "x", "sensors": sensors})
