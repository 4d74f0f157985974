"""The last turn of a flight that is a formula: straight, an arc at a known bank, straight."""

from __future__ import annotations

import math

import numpy as np
import pytest

from aircraft.state import STANDARD_GRAVITY
from autopilot.route import Leg, Route
from sim.metrics.arrivals.last_turn import last_turn
from sim.metrics.arrivals.look_alike import FIGURES, distance, rank_correlation, values

SPEED, RATE = 100.0, 30.0


def arc(make_flight, angle=40.0, bank=20.0, over=15.0, before=60.0, after=120.0, weave=0.0):
    """A flight northwards onto the line east = 0, which it passes by ``over`` m and comes back to where asked."""
    turn_rate = STANDARD_GRAVITY * math.tan(math.radians(bank)) / SPEED
    lasts = math.radians(angle) / turn_rate
    time = np.arange(0.0, before + lasts + after, 1.0 / RATE)
    course = np.radians(angle) - turn_rate * np.clip(time - before, 0.0, lasts)
    late = np.clip(time - before - lasts, 0.0, None)
    course = course + weave * np.sin(0.3 * late)
    north_rate, east_rate = SPEED * np.cos(course), SPEED * np.sin(course)
    north, east = np.cumsum(north_rate) / RATE, np.cumsum(east_rate) / RATE
    east += over - east.max()
    route = Route((Leg((0.0, 0.0), (north[-1] + 5000.0, 0.0), SPEED, 900.0),))
    nan = np.full(len(time), math.nan)
    return make_flight(
        time, ["final"] * len(time), route, north=north, east=east, height=np.full(len(time), 900.0), bank=nan,
        heading=nan, airspeed=nan, velocity_north=north_rate, velocity_east=east_rate,
    )  # fmt: skip


def test_an_arc_is_measured_from_position_and_velocity_alone(make_flight):
    """Nothing else of the state is known, as of a recorded flight."""
    turn = last_turn(arc(make_flight))
    assert math.degrees(turn.angle) == pytest.approx(40.0, abs=1.0)
    assert math.degrees(turn.bank) == pytest.approx(20.0, abs=0.3)
    turning = math.radians(40.0) / (STANDARD_GRAVITY * math.tan(math.radians(20.0)) / SPEED)
    assert turn.duration == pytest.approx(turning + 3.0, abs=1.0)  # whole seconds of which 5 are averaged
    assert turn.overshoot == pytest.approx(15.0, abs=2.0)
    assert turn.settling < 0.0  # 3 deg are left when there is still a rate to see
    assert (turn.speed, turn.height) == pytest.approx((SPEED, 900.0))
    assert turn.slowed == pytest.approx(0.0, abs=0.1)


def test_the_roll_rate_of_a_step_is_the_slope_of_the_line_through_it(make_flight):
    """Through a step of 20 deg in the middle of 11 s: 20 (1 + 2 + 3 + 4 + 5) / 110 and half a second in between."""
    turn = last_turn(arc(make_flight, angle=60.0))
    assert math.degrees(turn.roll_rate) == pytest.approx(20.0 * 15.0 / 110.0, rel=0.05)


def test_final_is_judged_by_its_spread_and_its_bank(make_flight):
    """A weave of A sin(w t) in course is V A / w across and V w A / g of bank, both over the square root of two."""
    amplitude, w = 0.004, 0.3
    turn = last_turn(arc(make_flight, weave=amplitude, after=400.0))
    assert turn.cross_track_sd == pytest.approx(SPEED * amplitude / w / math.sqrt(2.0), rel=0.1)
    smoothed = math.sin(w) / w  # the slope of the course over 2 s
    assert turn.bank_rms == pytest.approx(SPEED * w * amplitude / STANDARD_GRAVITY / math.sqrt(2.0) * smoothed, rel=0.1)


@pytest.mark.parametrize("flown", [{"angle": 130.0}, {"angle": 10.0}])
def test_no_turn_below_115_deg_is_none(make_flight, flown):
    assert last_turn(arc(make_flight, **flown)) is None


def test_a_short_final_says_nothing_about_it(make_flight):
    turn = last_turn(arc(make_flight, after=30.0))
    assert turn.cross_track_sd is None
    assert turn.bank_rms is None
    assert len(values([turn], FIGURES[-1])) == 0


def test_the_distance_is_the_largest_difference_of_shares():
    uniform = np.arange(1, 101) / 100.0
    assert distance(uniform, (0.05, 0.5, 0.9, 0.95)) == pytest.approx(0.0)
    assert distance(uniform + 0.3, (0.05, 0.5, 0.9, 0.95)) == pytest.approx(0.3)


def test_a_rank_correlation_does_not_ask_for_a_line():
    x = np.arange(1.0, 20.0)
    assert rank_correlation(x, np.exp(x)) == pytest.approx(1.0)
    assert rank_correlation(x, -(x**3)) == pytest.approx(-1.0)
