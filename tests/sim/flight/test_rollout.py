"""The roll-out: it goes on where the flight ends, stops on the runway, and changes nothing of what ended before it."""

from __future__ import annotations

import dataclasses
import json
import math
from functools import cache

import numpy as np
import pytest

from aircraft.airframe import InitialCondition
from aircraft.state import STANDARD_GRAVITY, AircraftState, Controls
from aircraft.wind import SteadyWind
from autopilot.inner_loops import InnerLoops
from autopilot.rollout import Rollout
from sim.experiment import evaluate, fly
from sim.flight.loop import roll_out
from sim.flight.outcomes import ROLLOUT, STOPPED
from sim.flight.preparation import prepare
from sim.flight.record import RECORD_STEP
from sim.flight.vehicles import JsbsimBody
from sim.metrics.checks import evaluate_checks
from sim.metrics.flight import flight_metrics
from sim.reporting.text.outcome_sentence import what_happened
from sim.reporting.text.warnings import warnings
from sim.scenario.reading import read
from sim.scenario.tables import Check
from sim.studies.kept import flight_cache

AUTOMATIC = 8.2  # m, 27 ft: how far an automatic roll-out may stray to either side [FAA AC 20-57A, from memory]
SHORT = {"start.phase": "final", "start.distance_m": 2000.0, "draws": 2}


@cache
def landed(name="an26_pattern"):
    prepared = prepare(read(name, SHORT))
    return prepared, fly(prepared)


def figures(prepared, flight):
    return flight_metrics(flight, prepared.scenario.runway, prepared.law.bank_limit, prepared.stall_speed)


def test_it_goes_on_one_record_after_the_landing_and_stops():
    _, flight = landed()
    rollout, whole = flight.rollout, flight.whole
    assert flight.outcome == "landed"
    assert rollout.outcome == STOPPED
    assert [event.name for event in rollout.events] == [ROLLOUT, STOPPED]
    assert np.diff(whole.time) == pytest.approx(RECORD_STEP)
    moved = np.hypot(np.diff(whole.state.north), np.diff(whole.state.east))
    assert moved == pytest.approx(whole.state.ground_speed[1:] * RECORD_STEP, abs=0.05)  # no jump
    assert set(np.array(whole.phases)[rollout.phase]) == {ROLLOUT}
    assert whole.during(ROLLOUT).sum() == len(rollout.time)
    assert not flight.during(ROLLOUT).any()
    assert whole.outcome == "landed"
    assert whole.rollout is None


def test_the_forward_force_does_the_work_of_the_kinetic_energy():
    prepared, flight = landed()
    down = flight_metrics(flight, prepared.scenario.runway, 1.0)["touchdown"]
    s = flight.whole.state
    first = int(np.searchsorted(s.time, down["time_s"] - 1e-9))
    speed, force = s.ground_speed[first:], STANDARD_GRAVITY * s.load_factor[0][first:]
    work = -np.trapezoid(force * speed, s.time[first:])
    assert work == pytest.approx(0.5 * (speed[0] ** 2 - speed[-1] ** 2), rel=0.02)  # of each kilogram


def test_figures_are_those_of_the_record():
    prepared, flight = landed()
    found = figures(prepared, flight)
    rollout, down = found["rollout"], found["touchdown"]
    s = flight.rollout.state
    past, _ = prepared.scenario.runway.from_local(s.north[-1], s.east[-1])
    assert rollout["distance_m"] == pytest.approx(past - down["past_threshold_m"])
    assert rollout["time_s"] == pytest.approx(s.time[-1] - down["time_s"])
    # the brakes come on late, so the mean speed is above half the first; all the time at it would make twice that
    speed = s.ground_speed[0]
    assert 1.0 < 2.0 * rollout["distance_m"] / (speed * rollout["time_s"]) < 1.3
    assert rollout["deceleration_mean_mps2"] == pytest.approx(speed / rollout["time_s"], rel=0.02)
    assert found["duration_s"] == flight.time[-1]
    assert f"came to a stop {rollout['distance_m']:.0f} m later" in what_happened(flight, found, [])


def test_a_flight_without_a_landing_has_no_figures_of_a_rollout():
    prepared, flight = landed()
    without = dataclasses.replace(flight, rollout=None)
    assert figures(prepared, without)["rollout"] is None
    assert figures(prepared, without) | {"rollout": 0} == figures(prepared, flight) | {"rollout": 0}
    assert "stop" not in what_happened(without, figures(prepared, without), [])


def test_checks_see_the_rollout_only_where_they_name_it():
    prepared, flight = landed()
    runway = prepared.scenario.runway
    slow = float(flight.state.airspeed.min())

    def judged(during):
        check = Check(metric="airspeed_mps", min=0.99 * slow, during=during)
        return evaluate_checks((check,), flight, runway, {})[0]

    assert judged("all")["passed"]
    assert not judged(ROLLOUT)["passed"]
    assert judged(ROLLOUT)["value"] == pytest.approx(0.0, abs=1.0)
    assert not judged(("flare", ROLLOUT))["passed"]
    go_around = dataclasses.replace(flight, rollout=None)
    check = Check(metric="airspeed_mps", min=1.0, during=ROLLOUT)
    assert evaluate_checks((check,), go_around, runway, {})[0]["passed"] is None


def test_trackers_end_with_the_flight_and_have_the_rollout_as_a_phase():
    prepared, flight = landed("two_radars")
    with_it, without = (evaluate(prepared, one) for one in (flight, dataclasses.replace(flight, rollout=None)))
    seen = 0
    for name, tracker in with_it.trackers.items():
        rolling = tracker["by_phase"].pop(ROLLOUT, None)
        assert tracker == without.trackers[name]
        rest, track = with_it.tracks[name].rollout, with_it.tracks[name].track
        assert np.array_equal(track.mean, without.tracks[name].track.mean)
        assert track.time[-1] <= flight.time[-1]
        if rolling is not None:
            seen += 1
            assert rest.time[0] > flight.time[-1]
            assert all(figure["rmse"] > 0.0 for figure in rolling.values())
    assert seen > 0
    assert any(record.time[-1] > flight.time[-1] for record in with_it.records.values())
    for name, record in with_it.records.items():
        until = record.until(float(flight.time[-1]))
        assert np.array_equal(until.z, without.records[name].z, equal_nan=True)


def test_a_kept_flight_has_its_rollout(tmp_path):
    prepared, flight = landed()
    flight_cache.store(tmp_path, "one", flight)
    kept = flight_cache.load(tmp_path, "one", prepared)
    assert kept.rollout.events == flight.rollout.events
    assert np.array_equal(kept.whole.state.north, flight.whole.state.north)
    assert json.dumps(figures(prepared, kept)) == json.dumps(figures(prepared, flight))


def test_the_same_seed_gives_the_same_rollout():
    prepared, flight = landed()
    again = fly(prepared)
    assert np.array_equal(np.array(again.whole.state), np.array(flight.whole.state))


def test_a_point_mass_does_not_roll():
    prepared = prepare(read("an26_pattern", SHORT | {"aircraft.model": "point_mass"}))
    assert fly(prepared).rollout is None


class Sledge:
    """A vehicle that no law steers: straight on at its course, slowed by ``brakes`` (m/s2)."""

    def __init__(self, course, brakes):
        self.course, self.brakes = course, brakes
        self.state = AircraftState(*(0.0 for _ in AircraftState._fields))._replace(velocity_north=40.0)

    def rollout(self, body):
        return Rollout(5.0, 2.0, 0.2, 0.0, 0.0)

    def read(self, body):
        return self.state

    def roll(self, body, controls, wheels, dt):
        s = self.state
        speed = s.ground_speed - self.brakes * dt
        north, east = speed * math.cos(self.course), speed * math.sin(self.course)
        self.state = s._replace(
            time=s.time + dt, north=s.north + north * dt, east=s.east + east * dt, velocity_north=north,
            velocity_east=east, airspeed=speed,
        )  # fmt: skip
        return body


@pytest.mark.parametrize(
    ("course", "brakes", "outcome", "words"),
    [(5.0, 1.0, "excursion", "left the runway"), (0.0, 0.0, "time_limit", "still rolling"), (0.0, 2.0, STOPPED, "")],
)
def test_what_does_not_stop_on_the_runway_is_told(course, brakes, outcome, words):
    _, flight = landed()
    runway = dataclasses.replace(landed()[0].scenario.runway, heading=0.0)
    rolled = roll_out(Sledge(math.radians(course), brakes), None, flight.route, 0, runway, None)
    assert rolled.outcome == outcome
    other = dataclasses.replace(flight, rollout=rolled)
    assert any(words in sentence for sentence in warnings(other, {}, {}, {}, {})) is bool(words)
    rollout = flight_metrics(other, runway, 1.0)["rollout"]
    assert (rollout["distance_m"] is None) is (outcome != STOPPED)
    assert words in what_happened(other, figures(landed()[0], flight) | {"rollout": rollout}, [])


@pytest.mark.parametrize("name", ["an26_pattern", "a320"])
def test_it_stops_on_the_runway_from_60_mps_in_a_crosswind_of_10(name):
    prepared = prepare(read(name))
    # without flaps: with all of them the An-26 is not on its wheels at 60 m/s
    vehicle, airframe, runway = prepared.vehicle, prepared.airframe.load(), prepared.scenario.runway
    north, east = runway.to_local(500.0, 3.0)
    along, across = (math.cos(runway.heading), math.sin(runway.heading)), 10.0
    wind = SteadyWind(across * along[1], -across * along[0], 0.0)  # from the right
    begun = InitialCondition(
        north, east, airframe.data.height_of_wheels, runway.heading, 0.0, 0.0, math.hypot(60.0, across), 0.0,
        math.atan2(across, 60.0), Controls(0.0, 0.0, 0.0, 0.0, 0.0, 1.0),
    )  # fmt: skip
    state = airframe.begin(begun, tuple(wind))
    body = JsbsimBody(airframe, InnerLoops(prepared.designed), None, state, wind)
    rolled = roll_out(vehicle, body, prepared.route, 0, runway, None)
    assert rolled.state.ground_speed[0] == pytest.approx(60.0, abs=0.1)
    _, off = runway.from_local(rolled.state.north, rolled.state.east)
    assert rolled.outcome == STOPPED
    assert np.abs(off).max() < AUTOMATIC
    assert abs(off[-1]) < 2.0  # a quarter of it: it has come back
