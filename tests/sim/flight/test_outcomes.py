"""How flights end: the touchdown box, by states made by hand and by a flight that comes down beside its runway."""

from __future__ import annotations

import dataclasses
import math

import pytest

import sim
from aircraft.state import FUSELAGE, MAIN_WHEEL, NOSE_WHEEL, TAIL, TAIL_WHEEL, WING_TIP, AircraftState
from autopilot.route import Leg, Route
from sim.errors import ScenarioError
from sim.flight.outcomes import Limits, OutcomeMonitor
from sim.flight.preparation import prepare
from sim.scenario.reading import read
from sim.scenario.tables import Runway

RUNWAY = Runway(heading=math.radians(80.0))
ROUTE = Route((Leg(RUNWAY.to_local(-20_000.0, 0.0), RUNWAY.to_local(300.0, 0.0), 60.0, 400.0),))
TWO_LEGS = Route((Leg((0.0, 0.0), (9000.0, 0.0), 60.0, 200.0), Leg((9000.0, 0.0), (9000.0, 9000.0), 60.0, 200.0)))
FLYING = AircraftState(*(0.0 for _ in AircraftState._fields))._replace(airspeed=60.0)

HIGH = FLYING._replace(height=200.0)


def touchdown(past, across, sink=0.6, first=MAIN_WHEEL, touched=MAIN_WHEEL, runway=RUNWAY):
    """The verdict on a straight flight along the runway that touches it at a place, with some part first."""
    monitor = OutcomeMonitor(Limits(None, runway), ROUTE)
    ahead = math.cos(RUNWAY.heading), math.sin(RUNWAY.heading)
    for down in (0.0, 1.0):
        north, east = RUNWAY.to_local(past, across)
        state = FLYING._replace(
            north=north, east=east, height=1.0, velocity_north=60.0 * ahead[0], velocity_east=60.0 * ahead[1],
            velocity_up=-sink, main_wheels=down, first_contact=down * first, touched=down * touched,
        )  # fmt: skip
        verdict = monitor(state, 0, "")
    return verdict


@pytest.mark.parametrize(
    ("past", "across", "sink", "outcome"),
    [
        (430.0, 0.0, 0.6, "landed"),
        (430.0, 20.9, 0.6, "landed"),
        (430.0, -20.9, 0.6, "landed"),
        (430.0, 21.1, 0.6, "ground"),
        (430.0, -2030.0, 0.6, "ground"),
        (61.0, 0.0, 0.6, "landed"),
        (59.0, 0.0, 0.6, "ground"),
        (824.0, 0.0, 0.6, "ground"),
        (430.0, 0.0, 3.1, "ground"),
    ],
)
def test_landed_is_a_soft_touchdown_in_the_box(past, across, sink, outcome):
    assert touchdown(past, across, sink)[0] == outcome


def test_the_box_belongs_to_the_runway_of_the_scenario():
    narrow = dataclasses.replace(RUNWAY, touchdown_from=100.0, touchdown_to=400.0, touchdown_aside=10.0)
    assert touchdown(399.0, 9.9, runway=narrow)[0] == "landed"
    assert "430 m past the threshold, beyond the box of 400 m" in touchdown(430.0, 0.0, runway=narrow)[1]
    assert "90 m past the threshold, short of the box, 100 m past it" in touchdown(90.0, 0.0, runway=narrow)[1]
    assert "beside the box of 10 m" in touchdown(300.0, 11.0, runway=narrow)[1]
    with pytest.raises(ValueError, match="touchdown_from must lie before touchdown_to"):
        Runway(touchdown_from=900.0)


def test_the_reason_says_where_and_behind_each_figure_what_it_is_beyond():
    assert touchdown(934.0, 0.0) == (
        "ground",
        "touched down 934 m past the threshold, beyond the box of 823 m, 0.0 m off the centreline, sink 0.60 m/s, "
        "main wheel first",
    )
    assert "411 m before the threshold, short of the box, 60 m past it" in touchdown(-411.0, 0.0)[1]
    assert "430 m past the threshold, 2030.0 m off the centreline, beside the box of 21 m" in touchdown(430, -2030)[1]
    assert "sink 3.40 m/s, harder than 3.05 m/s" in touchdown(430.0, 0.0, 3.4)[1]
    assert touchdown(430.0, 0.0)[1].startswith("landed 430 m past the threshold, 0.0 m off the centreline, sink 0.60")


@pytest.mark.parametrize(
    ("first", "touched", "outcome", "words"),
    [
        (MAIN_WHEEL, MAIN_WHEEL + NOSE_WHEEL, "landed", "main wheel first"),
        (MAIN_WHEEL + TAIL_WHEEL, MAIN_WHEEL + TAIL_WHEEL, "landed", "main wheel and tail wheel first"),
        (NOSE_WHEEL, NOSE_WHEEL + MAIN_WHEEL, "ground", "nose wheel first"),
        (MAIN_WHEEL + NOSE_WHEEL, MAIN_WHEEL + NOSE_WHEEL, "ground", "main wheel and nose wheel first"),
        (TAIL_WHEEL, TAIL_WHEEL + MAIN_WHEEL, "ground", "tail wheel first"),
        (TAIL, TAIL + MAIN_WHEEL, "ground", "tail first"),
        (FUSELAGE, FUSELAGE, "ground", "fuselage first"),
        (MAIN_WHEEL, MAIN_WHEEL + TAIL, "ground", "main wheel first, then the tail"),
        (MAIN_WHEEL, MAIN_WHEEL + WING_TIP, "ground", "main wheel first, then the wing tip"),
    ],
)
def test_a_landing_needs_a_main_wheel_first_and_no_strike(first, touched, outcome, words):
    found, reason = touchdown(430.0, 0.0, 0.6, first, touched)
    assert found == outcome
    assert reason.endswith(words)


@pytest.mark.parametrize(("second", "outcome"), [(0.6, "landed"), (3.4, "ground")])
def test_where_it_first_touches_counts_and_its_hardest_bounce(second, outcome):
    """On one wheel inside the box, up again, and on both wheels 30 m beyond its end."""
    monitor = OutcomeMonitor(Limits(None, RUNWAY), ROUTE)
    told = []
    for past, sink, down in ((800.0, 0.6, 0.0), (810.0, 0.6, 0.5), (840.0, second, 0.0), (853.0, 0.0, 1.0)):
        north, east = RUNWAY.to_local(past, 0.0)
        touched = MAIN_WHEEL * (past > 800.0)
        state = FLYING._replace(
            north=north, east=east, height=1.0, velocity_up=-sink, main_wheels=down, first_contact=touched,
            touched=touched,
        )  # fmt: skip
        told.append(monitor(state, 0, ""))
    assert told[:3] == [None, None, None]
    assert told[3][0] == outcome
    assert "810 m past the threshold, 0.0 m off the centreline" in told[3][1]
    assert ("sink 3.40 m/s, harder than 3.05" in told[3][1]) is (outcome == "ground")


def test_an_aircraft_that_comes_down_beside_its_runway_has_not_landed():
    """The law flies a line 40 m beside it: within half scale of the localiser, and not on the runway."""
    low = {"route.height_m": 150.0, "route.downwind_speed_mps": 60.0, "route.turn_speed_mps": 60.0, "checks": []}
    place = {"start.phase": "final", "start.distance_m": 3000.0, "trackers": {}, "sensors": {}}
    beside = [{"at_s": 10.0, "flies": "offset", "offset_m": 40.0}]
    result = sim.run("an26_pattern", overrides={**low, **place, "departures": beside})
    figures = result.metrics["flight"]
    assert figures["touchdown"]["cross_track_m"] == pytest.approx(40.0, abs=10.0)
    assert figures["outcome"] == "ground"
    assert figures["landed"] == 0.0


SWING = "15 deg of bank at 5 deg/s of roll sustain an oscillation"


def reason_after(banks, legs=None):
    """The reason of a flight that ends after a sequence of banks, deg, under a law that swings by theory."""
    monitor = OutcomeMonitor(Limits(None, RUNWAY, swing=SWING, swing_bank=math.radians(7.5)), TWO_LEGS)
    *flown, last = zip(banks, legs or [0] * len(banks), strict=True)
    for bank, leg in flown:
        assert monitor(HIGH._replace(bank=math.radians(bank)), leg, "") is None
    return monitor(HIGH._replace(bank=math.radians(last[0])), last[1], "go_around")[1]


def test_an_airliner_leaves_its_wheels_some_of_the_crab_and_keeps_its_wing_tips_off_the_ground():
    """A320 of JSBSim in 12 m/s of crosswind: 7.2 deg of crab would ask for 13 deg of bank, its tips touch at 11.3."""
    prepared = prepare(read("a320", {"start.phase": "final", "wind.crosswind_mps": 12.0}))
    flight = sim.fly(prepared)
    assert (flight.outcome, flight.reason[-16:]) == ("landed", "main wheel first")
    low = flight.state.height < prepared.autopilot.landing.align_height
    assert math.degrees(abs(flight.state.bank[low]).max()) < 0.6 * 11.3  # half of it, and what the roll overshoots
    assert 3.0 < math.degrees(abs(flight.state.heading[-1] - prepared.scenario.runway.heading)) < 5.0


def test_an_aircraft_that_swings_says_why():
    assert (
        reason_after([0, 14, 0, -14, 0, 14])
        == f"went around and regained its height, 200 m; it swung: by theory {SWING}"
    )


@pytest.mark.parametrize(
    ("banks", "legs"),
    [
        ([0, 14, 0, -14, 0], None),  # a turn to a line and the capture
        ([0, 14, 3, -4, 3, -14, 0], None),  # small banks are no swing
        ([14, -14, 14, -14], [0, 0, 1, 1]),  # each leg has its own turn
    ],
)
def test_a_turn_onto_a_leg_is_no_swing(banks, legs):
    assert "swung" not in reason_after(banks, legs)


PATTERN = {
    "name": "bank30",
    "runway": {"heading_deg": 80, "glide_path_deg": 2.6666666, "aiming_point_m": 300},
    "aircraft": {"model": "an26", "mass_kg": 20000},
    "start": {"phase": "base", "distance_m": 4000},
    "route": {
        **{"kind": "pattern", "side": "left", "height_m": 400, "downwind_abeam_m": 7000, "base_distance_m": 13800},
        **{"downwind_speed_mps": 72, "turn_speed_mps": 69, "approach_speed_mps": 58},
    },
    "autopilot": {"bank_limit_deg": 30},
}


def test_a_bank_limit_of_30_deg_lands():
    """As quick as 30 deg of bank alone allow, the law weaved 320 m to both sides and went around."""
    flight = sim.run(PATTERN).metrics["flight"]
    assert flight["outcome"] == "landed"
    assert flight["overshoot_m"] < 5.0


def test_a_law_of_the_users_own_that_swings_is_told_before_and_named_after():
    result = sim.run({**PATTERN, "autopilot": {"bank_limit_deg": 30, "frequency_share": 0.15}})
    assert any("the law swings by theory: 30 deg of bank at 5 deg/s" in text for text in result.metrics["warnings"])
    assert result.metrics["flight"]["outcome"] == "go_around"
    assert "it swung: by theory" in result.metrics["flight"]["reason"]


def test_a_law_that_is_too_slow_for_its_turns_is_refused_with_the_crossing():
    with pytest.raises(ScenarioError, match=r"because from 0\.\d+ rad/s on 45 deg of bank at 2 deg/s of roll sustain"):
        prepare(read({**PATTERN, "autopilot": {"bank_limit_deg": 45, "roll_rate_limit_degps": 2}}))
