"""The autopilot's own navigation: bends with their stated spread and length, a filter that knows what it should."""

from __future__ import annotations

import itertools
import math

import numpy as np
import pytest

import sim
from sim.errors import ScenarioError
from sim.estimation.navigation_errors import Beam, ErringNavigator
from sim.randomness import Streams
from sim.scenario.arrivals.navigation import NavigationErrors
from sim.scenario.tables import Runway
from tests.capture import CAPTURE

LINE = {**CAPTURE, "until_s": 60.0, "draws": 1}


def beam(at=1e6):
    noise = Streams(1, 0, 1, "navigation").normal("localiser", 1)
    first = float(noise.row()[0, 0])
    return Beam(noise, first, first, at)


def test_a_bend_is_a_gauss_markov_process_over_the_distance():
    """Over 10,000 lengths: variances scatter by 2 %, five of which are allowed; correlation is e after one length."""
    bent, values, length = beam(), [], 100.0
    for distance in np.arange(1e6, 0.0, -25.0):
        bent, value = bent.seen_at(float(distance), length)
        values.append(value)
    values = np.array(values)
    assert values.std() == pytest.approx(1.0, abs=0.05)
    assert np.corrcoef(values[:-4], values[4:])[0, 1] == pytest.approx(math.exp(-1.0), abs=0.05)


def test_a_bend_stays_where_it_is():
    """It does not depend on how often it is looked at, and whoever turns away sees what it saw last."""
    often, rarely = beam(), beam()
    for distance in np.arange(1e6, 999_000.0, -3.0):
        often, _ = often.seen_at(float(distance), 100.0)
    one, other = often.seen_at(998_990.0, 100.0)[1], rarely.seen_at(998_990.0, 100.0)[1]
    assert one == pytest.approx(other)


def test_without_errors_the_autopilot_knows_its_motion():
    """But for a filter that integrates once a record: a tenth of a metre in a minute."""
    right, erring = (sim.fly(sim.prepare(sim.read(LINE, more))) for more in ({}, {"navigation_errors": {}}))
    assert np.abs(right.deviation.cross_track - erring.deviation.cross_track).max() < 0.5


def test_a_course_line_that_is_turned_is_flown():
    errors = {"localiser_bias_deg": 0.2, "localiser_past_m": 20000.0}
    flight = sim.fly(sim.prepare(sim.read(LINE, {"navigation_errors": errors, "until_s": 150.0})))
    to_antenna = 20000.0 - flight.state.north[-1]
    assert flight.deviation.cross_track[-1] == pytest.approx(to_antenna * math.radians(0.2), rel=0.1)


@pytest.mark.parametrize("motion", ["air", "inertial"])
def test_a_wrong_wind_is_worked_out_in_a_few_time_constants(motion):
    errors = NavigationErrors(wind=5.0, smoothing=10.0, motion=motion)
    navigator = ErringNavigator(errors, Runway(), Streams(3, 0, 1, "navigation"))
    flight = sim.fly(sim.prepare(sim.read(LINE)))
    states = [type(flight.state)(*(float(column[k]) for column in flight.state)) for k in range(len(flight.time))]
    sight, seen = navigator.begin(states[0])
    wrong = [sight.wind]
    for before, after in itertools.pairwise(states):
        sight, seen = navigator.step(sight, before, after)
        wrong.append(sight.wind)
    assert abs(wrong[0]) > 1.0
    assert abs(wrong[-1]) < 0.05 * abs(wrong[0])  # (1 + t/T) exp(-t/T) after six of them is 0.02
    assert seen.velocity_east == pytest.approx(states[-1].velocity_east, abs=0.1)


@pytest.mark.parametrize(("motion", "fooled"), [("air", 10.0), ("inertial", 0.0)])
def test_a_gust_fools_who_knows_the_velocity_through_the_air_alone(motion, fooled):
    """The wind across changes by 10 m/s from one record to the next: the velocity over the ground is the same."""
    navigator = ErringNavigator(NavigationErrors(motion=motion), Runway(), Streams(3, 0, 1, "navigation"))
    flight = sim.fly(sim.prepare(sim.read(LINE)))
    before, after = (type(flight.state)(*(float(column[k]) for column in flight.state)) for k in (0, 1))
    sight, _ = navigator.begin(before)
    gusty = after._replace(sideslip=after.sideslip + 10.0 / after.airspeed)
    still, gust = (navigator.step(sight, before, one)[1].velocity_east for one in (after, gusty))
    assert abs(gust - still) == pytest.approx(fooled, abs=1.0)


def test_each_flight_has_its_own_errors_and_the_same_again():
    prepared = sim.prepare(sim.read(LINE, {"navigation_errors": {"localiser_bend_deg": 0.1}, "until_s": 20.0}))
    first, second, again = (sim.fly(prepared, number).state.east[-1] for number in (0, 1, 0))
    assert first == again != second


def test_a_tracker_that_navigates_has_its_own_errors():
    tables = {"sensors": {"radar": {"kind": "surveillance_radar"}}, "trackers": {"t": {"kind": "kalman"}}}
    with pytest.raises(ScenarioError, match="a tracker that navigates has its own errors"):
        sim.read({**LINE, **tables, "autopilot": {"navigation": "t"}, "navigation_errors": {}})
