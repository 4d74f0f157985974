"""Vectored approaches against geometry and the theory of the law: where headings lead, when it captures."""

from __future__ import annotations

import math

import numpy as np
import pytest

import sim
from autopilot.vectored import Vector, heading_of, turn_time, way
from sim.cli.explain import explain
from sim.errors import ScenarioError
from sim.flight.arrivals import vectoring

VECTORED = {
    "name": "vectored",
    "route": {"kind": "vectored", "height_m": 600, "intercept_angle_deg": 30, "last_vector_s": 60, "level_m": 9000},
    "autopilot": {"bank_limit_deg": 25, "damping": 0.5, "intercept_speed_mps": 60, "law": {"k1_deg_per_m": 0.055}},
    "until_s": 150.0,
}


def flown(**changes):
    """(scenario, preparation, flight) of a point mass."""
    scenario = sim.read(VECTORED, changes)
    prepared = sim.prepare(scenario)
    return scenario, prepared, sim.fly(prepared)


def begun(flight, phase):
    return next(event.time for event in flight.events if event.name == phase)


@pytest.mark.parametrize(("side", "wind"), [("left", {}), ("right", {"headwind_mps": 6.0, "crosswind_mps": 8.0})])
def test_the_last_heading_meets_the_extended_centreline_where_it_was_planned(side, wind):
    """On two vectors, with a law that comes too late."""
    vectors = [{"angle_deg": 90, "for_s": 50}]
    changes = {"route.vectors": vectors, "route.arm_late_s": 100, "route.side": side, "wind": wind, "until_s": 120.0}
    scenario, _, flight = flown(**changes)
    z = flight.deviation.cross_track
    crossed = int(np.flatnonzero(np.sign(z) != np.sign(z[0]))[0])
    assert np.sign(z[0]) == (-1.0 if side == "left" else 1.0)
    lag = 72.0 / math.tan(math.radians(30.0))  # m: a second of the bank's own, on base, seen along the line
    assert flight.deviation.distance_to_go[crossed] == pytest.approx(vectoring.met(scenario, scenario.route), abs=lag)
    assert math.degrees(abs(flight.deviation.track_error[crossed])) == pytest.approx(30.0, abs=0.5)


@pytest.mark.parametrize("late", [0.0, 4.0])
def test_the_law_captures_when_it_would_turn_in_and_takes_over_late(late):
    """A heading that is shallower than the law's own intercept: the line is k2/k1 seconds away."""
    _, prepared, flight = flown(**{"route.arm_late_s": late})
    at = int(np.searchsorted(flight.time, begun(flight, "capture") - 1e-9))
    d, law = flight.deviation, prepared.law
    assert -d.cross_track[at] / d.cross_track_rate[at] == pytest.approx(law.k2 / law.k1 - late, abs=0.1)
    before = flight.state.bank[(flight.time > 5.0) & (flight.time <= flight.time[at])]
    assert np.degrees(np.abs(before)).max() < 0.1


def test_a_law_whose_own_intercept_is_shallower_flies_it_from_where_a_localiser_shows_the_line():
    """Deviations grow with the angle up to 180 microampere, of which there are 150 to 105 m at the threshold, 2800 m
    before the antenna; the aiming point is 300 m behind it."""
    _, prepared, flight = flown(**{"autopilot.intercept_speed_mps": 15.0, "until_s": 70.0})
    at = int(np.searchsorted(flight.time, begun(flight, "capture") - 1e-9))
    d = flight.deviation
    assert prepared.law.k2 / prepared.law.k1 * d.cross_track_rate[at] < -d.cross_track[at]  # it would not turn in yet
    to_antenna = d.distance_to_go[at] + 2800.0 - prepared.scenario.runway.aiming_point
    assert -d.cross_track[at] == pytest.approx(1.2 * 105.0 / 2800.0 * to_antenna, abs=2.0)
    assert d.cross_track_rate[-1] == pytest.approx(15.0, rel=0.1)


def test_the_line_is_tracked_by_the_designed_law_with_less_bank_once_it_is_captured():
    """After 25 s of capture, on the line with less than 5 deg of bank; 2 s later it has rolled to whatever that asks.

    The lag of the capture is left too.
    """
    _, prepared, flight = flown(**{"autopilot.bank_lag_s": 1.0, "autopilot.damping": 0.4, "until_s": 130.0})
    law = prepared.controller.tracking.law
    assert (law.k1, law.k2) == pytest.approx((prepared.designed.k1, prepared.designed.k2))
    assert math.degrees(law.bank_limit) == pytest.approx(10.0)
    since = flight.time - begun(flight, "capture")
    is_tracked = np.abs(law(flight.deviation) - flight.command.bank) < 1e-9
    d, level = flight.deviation, np.degrees(np.abs(flight.command.bank)) < 5.0
    due = (since > 25.0) & level & (np.degrees(np.abs(d.track_error)) < 5.0) & (np.abs(d.cross_track) < 100.0)
    begins = int(np.flatnonzero(~is_tracked)[-1]) + 1
    assert 0.0 <= since[begins] - since[np.flatnonzero(due)[0]] < 2.0
    assert not is_tracked[(since > 2.0) & (since < 24.0)].any()


def test_a_glide_path_is_followed_within_half_scale_of_a_localiser_while_the_law_still_captures():
    """Half scale, 52.5 m at the threshold, is an angle; the turn onto the line is not over there."""
    _, prepared, flight = flown(**{"route.level_m": 1200, "until_s": 110.0})
    glide = int(np.searchsorted(flight.time, begun(flight, "glide") - 1e-9))
    half_scale = 52.5 / 2800.0 * (flight.deviation.distance_to_go[glide] + 2500.0)
    assert 100.0 < abs(flight.deviation.cross_track[glide]) < half_scale  # of 100 m the line would be established
    landing = prepared.autopilot.landing
    assert landing.may_descend(half_scale - 1.0, flight.deviation.distance_to_go[glide], is_established=False)
    assert not landing.may_descend(half_scale + 1.0, flight.deviation.distance_to_go[glide], is_established=True)


@pytest.mark.parametrize("angle", [10.0, 60.0])
def test_straight_flight_begins_where_the_turn_to_the_last_heading_is_over(angle):
    """But for 5 deg."""
    limit, rolling = math.radians(25.0), math.radians(5.0)
    time = turn_time(math.radians(angle), 80.0, limit, rolling)
    along, across = way([Vector(math.radians(angle), 0.5), Vector(0.0, time)], 80.0, limit, rolling, (0.0, 0.0))
    assert math.degrees(math.atan2(across[-1] - across[-2], along[-1] - along[-2])) == pytest.approx(5.0, abs=0.3)
    vectors = [{"angle_deg": 30.0 + angle, "for_s": 30}]
    scenario = sim.read(VECTORED, {"route.vectors": vectors, "route.straight_s": 20.0})
    wanted = 20.0 + turn_time(math.radians(angle), scenario.route.speed, limit, rolling)
    assert vectoring.vectors(scenario, scenario.route)[-1].time == pytest.approx(wanted)


@pytest.mark.parametrize("damping", [0.4, 0.7])
def test_the_overshoot_is_that_of_the_linear_law(damping):
    """From the balance k1 z + k2 z' = 0 on, z'' is the impulse response of z', so the overshoot has a closed form.

    The point mass rolls with a lag, which adds to it by the order of frequency times lag.
    """
    _, prepared, flight = flown(**{"autopilot.damping": damping, "autopilot.roll_rate_limit_degps": 30.0})
    law, z = prepared.law, flight.deviation.cross_track
    at = int(np.searchsorted(flight.time, begun(flight, "capture") - 1e-9))
    root = math.sqrt(1.0 - damping * damping)
    share = math.exp(-damping * (math.pi - math.acos(damping)) / root)
    assert z.max() == pytest.approx(share * flight.deviation.cross_track_rate[at] / law.frequency, rel=0.3)


def test_the_other_side_is_the_mirror_image():
    left, right = (flown(**{"route.intercept_angle_deg": angle, "until_s": 70.0})[2] for angle in (30.0, -30.0))
    np.testing.assert_allclose(left.deviation.cross_track, -right.deviation.cross_track, atol=1e-6)


def test_speed_follows_the_schedule_on_the_last_heading_only():
    vectors, speeds = [{"angle_deg": 150, "for_s": 60}], [{"distance_m": 23500, "speed_mps": 64}]
    _, _, flight = flown(**{"route.vectors": vectors, "route.speeds": speeds, "until_s": 150.0})
    to_go, time = flight.deviation.distance_to_go, flight.time
    assert to_go[time < 60.0].min() < 23500.0  # it was nearer once, away from the final
    assert np.ptp(flight.state.airspeed[time < 60.0]) < 0.2
    assert flight.state.airspeed[-1] == pytest.approx(64.0, abs=0.2)


def test_nothing_descends_before_the_law_has_taken_over():
    """A vector that leads past where the glide path begins ends neither in a go-around nor in a descent."""
    _, _, flight = flown(**{"route.intercept_distance_m": 9000, "route.arm_late_s": 100, "until_s": 100.0})
    assert {flight.phases[i] for i in np.unique(flight.phase)} == {"vectors"}
    assert np.ptp(flight.state.height) < 1.0


def test_the_way_of_a_turn_is_an_arc_that_runs_out():
    """At the limit until the error is so small that it fades in 8 s: across R cos(e), then V T Si(e) with e = w T."""
    speed, limit, fading = 80.0, math.radians(25.0), 8.0
    _, across = way([Vector(math.pi / 2, 10.0), Vector(0.0, 100.0)], speed, limit, math.inf, (0.0, 0.0))
    rate = 9.80665 * math.tan(limit) / speed
    left = rate * fading
    tail = speed * fading * (left - left**3 / 18.0)
    assert across[-1] == pytest.approx(10.0 * speed + speed / rate * math.cos(left) + tail, abs=40.0)  # a step
    assert heading_of(0.0, 80.0, (0.0, 8.0)) == pytest.approx(-math.asin(0.1))


def test_a_start_has_a_course_of_its_own():
    _, prepared, _ = flown(**{"start.course_deg": 25.0, "until_s": 1.0})
    assert prepared.initial.course == pytest.approx(math.radians(25.0))


def test_a_law_by_damping_and_intercept_speed():
    law = sim.prepare(sim.read(VECTORED)).law
    assert (law.damping, law.intercept_speed) == pytest.approx((0.5, 60.0))


def test_explain_tells_the_vectors_and_what_errs():
    text = explain(sim.read(VECTORED, {"wind.crosswind_mps": 5.0, "navigation_errors": {"localiser_bend_deg": 0.05}}))
    assert "vector from s on" in text
    assert "localiser 0.050 deg" in text


@pytest.mark.parametrize(
    ("changes", "told"),
    [
        ({"route.intercept_angle_deg": 0}, "intercept_angle must not be 0"),
        ({"route.speeds": [{"distance_m": 20000, "speed_mps": 90}]}, "must not rise towards the runway"),
        (
            {"route.speeds": [{"distance_m": d, "speed_mps": 65} for d in (9000, 20000)]},
            "the distances of the schedule must fall",
        ),
        ({"route.speeds": [{"distance_m": 20000, "speed_mps": 40}]}, "raise 'speed' and its schedule"),
        ({"route.vectors": [{"angle_deg": 200, "for_s": 5}]}, "angle_deg: must be at most 180"),
        ({"route.vectors": [{"angle_deg": 90, "for_s": 5}] * 21}, "vectors: 21 are more than the 20"),
        ({"autopilot.law": {"k1_deg_per_m": 0.05, "k2_deg_per_mps": 0.9}}, "'damping' sets k2"),
        ({"start.phase": "final"}, "'phase' belongs to a pattern"),
        ({"navigation_errors": {"smoothing_s": 0}}, r"\[navigation_errors\] smoothing_s: must be at least 0.5"),
    ],
)
def test_what_cannot_be_vectored_is_said(changes, told):
    with pytest.raises(ScenarioError, match=told):
        sim.prepare(sim.read(VECTORED, changes))
