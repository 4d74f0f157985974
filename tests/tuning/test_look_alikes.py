"""The look-alikes obey mechanics and their seeds, and the scenes made of them say what their radar says."""

from __future__ import annotations

import math

import numpy as np
import pytest

from aircraft.state import STANDARD_GRAVITY
from sim.observation.record import observe
from tests.tuning.arrival_trackers import RADARS, raw, watched, wrong_routes
from tests.tuning.look_alikes import PHASES, last_turn, look_alikes

FEW = 8


@pytest.fixture(scope="module", params=["law", "heading"])
def kind(request):
    return request.param


@pytest.fixture(scope="module")
def flights(kind):
    return look_alikes(kind, 5, FEW)


def test_positions_are_the_sum_of_velocities(flights):
    for flight in flights:
        s = flight.state
        for place, rate in ((s.north, s.velocity_north), (s.east, s.velocity_east)):
            way = np.concatenate(([0.0], np.cumsum(0.5 * (rate[1:] + rate[:-1]))))
            # a speed is held for a step of 0.25 s: half of that times the 70 m/s that it falls by
            assert np.abs(place - place[0] - way).max() < 9.0


def test_headings_turn_by_the_bank(flights):
    for flight in flights:
        s = flight.state
        turned = np.unwrap(s.heading)
        rate = STANDARD_GRAVITY * np.tan(s.bank) / s.airspeed
        by_bank = np.concatenate(([0.0], np.cumsum(0.5 * (rate[1:] + rate[:-1]))))
        assert np.abs(turned - turned[0] - by_bank).max() < math.radians(3.0)  # of the rolls between two seconds


def test_they_arrive_on_the_line_and_do_what_recorded_ones_do(flights):
    for flight in flights:
        assert abs(flight.deviation.cross_track[-1]) < 100.0
        assert abs(math.degrees(flight.deviation.track_error[-1])) < 5.0
        order = [PHASES[i] for i in dict.fromkeys(flight.phase.tolist())]
        assert order[:2] == ["vectors", "capture"]
        assert set(order[2:]) <= {"established", "glide"}
        assert flight.state.ground_speed[-1] < flight.state.ground_speed[0]
        assert np.isnan(flight.state.pitch).all()  # nobody records it


def test_a_seed_is_a_seed():
    again, other = (look_alikes("heading", seed, 2) for seed in (5, 6))
    assert np.array_equal(again[0].state.north, look_alikes("heading", 5, 2)[0].state.north)
    assert not np.array_equal(again[0].state.north[:50], other[0].state.north[:50])


def test_an_offset_is_flown_beside_the_line():
    for flight in look_alikes("heading", 5, 3, "offset"):
        (left,) = (event.time for event in flight.events if event.name == "departed")
        before = flight.time < left
        assert np.abs(flight.deviation.cross_track[before][-20:]).max() < 60.0
        assert np.abs(flight.deviation.cross_track[-1]) == pytest.approx(300.0, abs=60.0)


def test_the_turn_onto_final_is_found_by_its_course():
    time = np.arange(200.0)
    off = np.radians(np.interp(time, (0, 50, 60, 100, 110), (90, 90, 40, 40, 0)))
    began, ended = last_turn(time, off)
    assert (began, ended) == (pytest.approx(100.0, abs=3.0), pytest.approx(110.0, abs=3.0))
    with pytest.raises(ValueError, match="no turn onto final"):
        last_turn(time, np.zeros(200))


def test_a_scene_says_what_the_sensor_says(kind, flights):
    """Mean and spread of its errors are those of the radar's own looks at the same flight."""
    radar = RADARS[kind]
    seen = watched(flights[:1], radar, 5, 60, lambda flight: (float(flight.time[0]), float(flight.time[-1])))
    looks = observe(flights[0], {"radar": radar}, 5, 0, 60)["radar"]
    common = min(len(looks.time), len(seen.plots.time) - 1)
    ours, theirs = seen.plots.z[1 : 1 + common], looks.z[:common]  # a sensor begins one period later
    np.testing.assert_allclose(seen.plots.time[1 : 1 + common], looks.time[:common])
    sigma = np.sqrt(np.diag(radar.covariance()))
    apart = (ours.mean(axis=2) - theirs.mean(axis=2)) / sigma
    assert np.abs(apart[:, :2]).max() < 5.0 * math.sqrt(2.0 / 60.0)
    assert np.abs(apart[:, 2]).max() < 5.0 * math.sqrt(2.0 / 60.0)  # one error of the altimetry in each draw
    spread = (ours[:, :2] - theirs[:, :2].mean(axis=2, keepdims=True)).std(axis=(0, 2)) / sigma[:2]
    assert spread == pytest.approx(1.0, abs=0.05)


def test_raw_errors_follow_from_the_distance(kind, flights):
    radar = RADARS[kind]
    seen = watched(flights, radar, 5, 4)
    north, east, _ = radar.antenna
    far = np.hypot(seen.truth[:, 0] - north, seen.truth[:, 2] - east)
    expected = radar.range_sigma**2 + (far * radar.azimuth_sigma) ** 2
    found = raw(seen).squares
    for part in range(3):
        wanted = np.nanmean(np.where(seen.part == part, expected, np.nan))
        assert np.nanmean(found[part]) == pytest.approx(wanted, rel=0.15)  # 1000 plots, heights off by 20 m


def test_a_route_told_wrong_is_another_line():
    for course in (0.0, math.radians(73.0)):
        routes = wrong_routes(course)
        point = -10e3 * math.cos(course), -10e3 * math.sin(course)
        off = {name: float(one.deviation(0, point, (80.0, 0.0)).cross_track) for name, one in routes.items()}
        assert off["384 m beside"] == pytest.approx(-384.0)
        assert off["20 km beside"] == pytest.approx(-20e3)
        assert abs(off["0.5 deg off"]) == pytest.approx(10e3 * math.sin(math.radians(0.5)), rel=1e-6)
