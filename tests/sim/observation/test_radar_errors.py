"""Errors that radars do not state: biases, north, steps, missed plots, where the beam is and what lies outside it."""

from __future__ import annotations

import math
from itertools import pairwise

import numpy as np
import pytest

from aircraft.state import AircraftState
from sim.errors import ScenarioError
from sim.observation.record import observe
from sim.observation.sensors.precision_radar import PrecisionRadar
from sim.observation.sensors.surveillance_radar import SurveillanceRadar
from sim.randomness import Streams
from sim.scenario.reading import read

SITE = {"position": (0.0, 0.0, 10.0)}  # of a runway to the north, at the origin


@pytest.fixture
def circle(make_flight):
    """Clockwise round the antenna at 9 km and 90 m/s, 400 m up: .01 rad/s, from north on."""

    def fly(radius=9000.0, rate=0.01, until=200.0, height=400.0, step=1 / 30):
        time = np.arange(0.0, until, step)
        north, east = radius * np.cos(rate * time), radius * np.sin(rate * time)
        speed = radius * rate
        velocity = {"velocity_north": -speed * np.sin(rate * time), "velocity_east": speed * np.cos(rate * time)}
        columns = {"north": north, "east": east, "height": np.full(len(time), height)}
        return make_flight(time, ["final"] * len(time), **columns, **velocity)

    return fly


def seen(radar, flight, draws=1):
    return observe(flight, {"radar": radar}, seed=4, draws=draws)["radar"]


def test_biases_are_added_and_the_zero_mark_taken_off_and_the_noise_is_the_same(circle):
    flight = circle(until=60.0)
    plain = seen(SurveillanceRadar(**SITE), flight, 3)
    wrong = seen(SurveillanceRadar(**SITE, range_bias=80.0, azimuth_bias=0.004, north_error=0.001), flight, 3)
    np.testing.assert_allclose(wrong.z - plain.z, np.broadcast_to([[80.0], [0.003]], plain.z.shape), atol=1e-9)
    np.testing.assert_array_equal(wrong.R, plain.R)  # it does not know


def test_the_precision_radar_s_biases_and_latency(circle):
    flight = circle(until=30.0)
    site = {**SITE, "sector": 2 * math.pi, "course": 0.0, "accuracy": "constant"}
    plain = seen(PrecisionRadar(**site), flight, 2)
    biases = {"range_bias": -15.0, "azimuth_bias": 0.002, "elevation_bias": 0.001}
    wrong = seen(PrecisionRadar(**site, **biases, latency=0.25), flight, 2)
    np.testing.assert_allclose(wrong.z - plain.z, np.broadcast_to([[-15.0], [0.002], [0.001]], plain.z.shape))
    np.testing.assert_allclose(wrong.arrival - wrong.time, 0.25)


def test_counters_give_multiples_of_their_step_and_r_counts_them(circle):
    step, turn = 1852.0 / 8, 2 * math.pi / 4096
    radar = SurveillanceRadar(
        **SITE, period=1.0, range_sigma=5.0, azimuth_sigma=1e-5, range_step=step, azimuth_step=turn
    )
    found = seen(radar, circle(rate=0.0101), 20)
    counts = found.z / np.array([[step], [turn]])
    np.testing.assert_allclose(counts, np.round(counts), atol=1e-9)
    # with next to no noise the error in azimuth is all step: uniform, of the variance step^2 / 12
    error = found.z[:, 1] - 0.0101 * found.time[:, None]
    assert found.R[0, 1, 1] == pytest.approx(turn**2 / 12 + 1e-10)
    assert np.mean(error**2) == pytest.approx(found.R[0, 1, 1], rel=0.1)  # 199 looks sample 8 steps of the counter


def test_a_share_of_the_plots_is_missed_and_the_others_are_the_same(circle):
    flight = circle()
    plain, missing = (seen(SurveillanceRadar(**SITE, detection=p), flight, 50) for p in (1.0, 0.7))
    missed = np.isnan(missing.z)
    assert (missed.all(axis=1) == missed.any(axis=1)).all()  # range and azimuth together
    assert 1 - missed.mean() == pytest.approx(0.7, abs=4 * math.sqrt(0.21 / (49 * 50)))
    np.testing.assert_array_equal(missing.z[~missed], plain.z[~missed])


@pytest.mark.parametrize("rate", [0.01, -0.01])
def test_a_turning_beam_meets_the_aircraft_where_it_is(circle, rate):
    """Beam 2 pi t / T and aircraft w t meet at t = k T / (1 - w T / 2 pi): later if it flies with the beam."""
    found = seen(SurveillanceRadar(**SITE, rotating=True), circle(rate=rate))
    spacing = 4.0 / (1.0 - rate * 4.0 / (2 * math.pi))
    expected = spacing * np.arange(1, len(found.time) + 1)
    # the antenna is 10 m up and at the centre; the motion between records is a cubic: 1e-6 rad of beam are .6 us
    np.testing.assert_allclose(found.time, expected, atol=1e-6)
    assert expected[-1] + spacing > 199.9


def test_a_beam_that_turns_faster_than_records_come_is_not_missed(circle):
    found = seen(SurveillanceRadar(**SITE, rotating=True, period=0.02), circle(rate=0.0, until=2.0, step=0.1))
    np.testing.assert_allclose(found.time, 0.02 * np.arange(1, len(found.time) + 1), atol=1e-6)
    assert len(found.time) == 95


def test_a_turning_beam_sees_the_same_in_the_loop_and_over_a_record(circle):
    flight, radar = circle(), SurveillanceRadar(**SITE, rotating=True, detection=0.9)
    state, z = radar.begin(0.0, Streams(4, 0, 2, "radar")), []
    for before, after in pairwise(AircraftState(*row) for row in np.column_stack(flight.state).tolist()):
        state, looks = radar.step(state, before, after)
        z += [look.z for look in looks]
    np.testing.assert_array_equal(np.array(z), seen(radar, flight, 2).z)


def test_it_sees_neither_beyond_its_coverage_nor_above_its_antenna(circle, make_flight):
    assert len(seen(SurveillanceRadar(**SITE, coverage=8000.0), circle()).time) == 0
    time = np.arange(0.0, 120.0, 0.1)
    over = make_flight(
        time,
        ["final"] * len(time),
        north=-6000.0 + 100.0 * time,
        east=np.full(len(time), 1.0),
        height=np.full(len(time), 1010.0),
        velocity_north=np.full(len(time), 100.0),
    )
    found = seen(SurveillanceRadar(**SITE, period=0.5, cone_of_silence=math.radians(45.0)), over)
    distance = np.abs(-6000.0 + 100.0 * found.time)
    assert distance.min() >= 999.0  # 1000 m above the antenna, seen below 45 deg
    assert np.diff(found.time).max() == pytest.approx(20.5, abs=0.51)  # 20 s of silence


@pytest.mark.parametrize(
    ("table", "said"),
    [
        ({"detection": 1.5}, "detection must be at most 1"),
        ({"cone_of_silence": 1.6}, "cone_of_silence must be below 1.5708: beyond, it would see nothing"),
        ({"range_step": -1.0}, "range_step must be at least 0"),
        ({"latency": -0.1}, "latency must be at least 0"),
        ({"coverage": 0.0}, "coverage must be above 0"),
        ({"position_sigma": 50.0, "north_error": 0.01}, "north_error is an error of range or azimuth"),
    ],
)
def test_what_no_radar_has_is_told(table, said):
    with pytest.raises(ValueError, match=said):
        SurveillanceRadar(**table)


def test_scenarios_write_them_with_units_and_other_sensors_point_here(tmp_path):
    text = '[aircraft]\nmodel = "an26"\n[sensors.a]\nkind = "{kind}"\n{keys}\n'
    keys = "north_error_deg = 0.3\nrange_bias_m = 60\nlatency_s = 0.5\nrotating = true\ncone_of_silence_deg = 45"
    path = tmp_path / "radar.toml"
    path.write_text(text.format(kind="surveillance_radar", keys=keys))
    radar = read(path).sensors["a"]
    assert (radar.north_error, radar.range_bias, radar.rotating) == (pytest.approx(math.radians(0.3)), 60.0, True)
    path.write_text(text.format(kind="mls", keys="range_bias_m = 60"))
    with pytest.raises(ScenarioError, match="a mls has none, it is one of precision_radar, surveillance_radar"):
        read(path)
