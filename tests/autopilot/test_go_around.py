"""A go-around climbs no faster than its airspeed allows: what a microburst takes is regained by height."""

from __future__ import annotations

import math

import numpy as np
import pytest

import sim
from autopilot.landing import Landing

LANDING = Landing()  # 1.3 and 1.15 of the stall speed are 53.7 and 47.5 m/s


def test_the_climb_is_free_above_the_threshold_speed_and_none_at_the_touchdown_speed():
    assert LANDING.climb_away(LANDING.threshold_speed, 200.0) == math.inf
    just_below = LANDING.climb_away(LANDING.threshold_speed - 1e-6, 200.0)
    assert just_below == pytest.approx(LANDING.threshold_speed * LANDING.climb_angle, rel=1e-5)
    assert LANDING.climb_away(LANDING.touchdown_speed, 200.0) == pytest.approx(0.0, abs=1e-9)


def test_below_it_height_buys_speed_as_steeply_as_it_climbs_at_most():
    slow = np.linspace(30.0, LANDING.touchdown_speed, 50)
    sinks = [LANDING.climb_away(speed, 200.0) for speed in slow]
    assert max(sinks) <= 1e-9
    assert min(sinks) == pytest.approx(-LANDING.threshold_speed * LANDING.climb_angle)
    assert (np.diff(sinks) >= 0.0).all()


def test_near_the_runway_the_sink_is_that_of_a_flare():
    assert LANDING.climb_away(40.0, 0.0) == -LANDING.touchdown_sink
    assert LANDING.climb_away(40.0, 200.0) < -LANDING.touchdown_sink


def test_an_aircraft_whose_two_speeds_are_one_still_has_an_answer():
    assert Landing(approach_speed=30.0).climb_away(29.0, 200.0) == pytest.approx(-30.0 * LANDING.climb_angle)


def test_a_microburst_that_stalled_the_go_around_is_flown_out_of():
    """26 m/s at 2.5 km: the stall is at 20 deg; held to its climb, the aircraft went to 32 deg and 39 m/s."""
    flight = sim.fly(sim.read("an26_windshear", {"wind.events.burst.peak_mps": 26}))
    assert flight.outcome == "go_around"
    away = np.array(flight.phase) == flight.phases.index("go_around")
    assert np.degrees(flight.state.angle_of_attack[away]).max() < 15.0
    assert flight.state.airspeed[away].min() > 1.15 * 41.3
    assert flight.state.height[away].min() > 60.0
