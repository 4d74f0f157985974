"""Trackers that are set against each other: the sentence, the reason, where they part, the figure and the replay."""

from __future__ import annotations

import dataclasses
import json
import math
import re
import runpy
from pathlib import Path

import numpy as np
import pytest

from autopilot.modes.lateral_navigation import LateralNavigation
from autopilot.route import Leg, Route
from sim.cli.run_summary import summary
from sim.reporting.replay import LEAD, replay
from sim.reporting.text.contrast_sentence import ERRORS, INTERVALS, contrast_sentences, first_contrast
from sim.reporting.text.reasons import Flown, apart, cause, loss
from sim.reporting.tracker_figures.charts import contrast_chart
from sim.reporting.tracker_figures.contrast_map import contrast_map
from sim.reporting.tracker_figures.error_curves import shown_trackers
from sim.reporting.tracker_figures.parting import parting
from sim.scenario.reading import read
from tracking.consistency import LOST_EPOCHS

_trackers = runpy.run_path(str(Path(__file__).with_name("test_report_trackers.py")))  # tests are modules in no package
followed_by, scenario, summaries, written = (
    _trackers[name] for name in ("followed_by", "scenario", "summaries", "written")
)
LAW = LateralNavigation(0.0025, 0.029, np.radians(15.0), 412.0, 50.0)
TIME = np.arange(0.0, 60.0, 1 / 30)
NORTH = -12000.0 + 70.0 * TIME
ONE = Route((Leg((-50000.0, 0.0), (300.0, 0.0), 70.0, 400.0),))


# ------------------------------------------------------------------------------------------------------ the sentence


def ratio(value, of, against, low=None, high=None):
    return {"ratio": value, "low": low, "high": high, "n": 130, "of": of, "against": against}


def contrast(of, against, overall, ahead=None, name=None, channel="position_m"):
    ahead = {} if ahead is None else {"20_s": {channel: ratio(9.0, 9.0, 1.0)}, "60_s": {channel: ahead}}
    overall = {} if overall is None else {channel: overall}
    return {"of": of, "against": against, "name": name, "overall": overall, "by_phase": {}, "look_ahead": ahead}


FEEDBACK, CONTROL, RIVAL = "linear_feedback", "saturated_control", "imm"
KIND = {"published": FEEDBACK, "control_published": CONTROL, FEEDBACK: FEEDBACK, CONTROL: CONTROL, RIVAL: RIVAL}
AHEAD, WHOLE = ratio(22.35, 2314.0, 103.54, 20.1, 24.6), ratio(3.312, 122.6, 37.02, 3.104, 3.523)


def metrics(*contrasts, lost=None, flights=1, draws=130, seen=KIND):
    """As in metrics.json; ``lost`` are shares of the draws."""
    trackers = {
        name: {"kind": kind, "overall": {"position_m": {}} if name in seen else {},
               "lost_fraction": (lost or {}).get(name, 0.0), "lost_time_s": None}
        for name, kind in KIND.items()
    }  # fmt: skip
    return {"contrasts": list(contrasts), "trackers": trackers, "flights": flights, "draws": draws}


@pytest.fixture
def nothing(make_flight):
    """A flight that nobody tracked, so that nothing is known of why."""
    return Flown(scenario(), LAW, make_flight(TIME, ["final"] * len(TIME), north=NORTH), {})


def test_the_look_ahead_leads_and_both_errors_stand_beside_their_ratio(nothing):
    ahead, whole, lost = contrast_sentences(metrics(contrast(FEEDBACK, CONTROL, WHOLE, AHEAD)), nothing)
    assert ahead == (
        "60 s ahead saturated control is off by 104 m and linear feedback by 2314 m, 22 times as much (20 to 25)."
    )
    assert whole == (
        "Over the whole flight saturated control is off by 37.0 m and linear feedback by 123 m, "
        "3.3 times as much (3.1 to 3.5)."
    )
    assert lost == f"Neither is ever lost. {ERRORS}{INTERVALS}."


def test_two_ways_to_set_up_a_pair_are_told_together(nothing):
    told = contrast_sentences(
        metrics(
            contrast("published", "control_published", ratio(29.0, 1050.0, 36.2, 27.0, 31.0), AHEAD, "as published"),
            contrast(FEEDBACK, CONTROL, WHOLE, AHEAD, "each at its best"),
        ),
        nothing,
    )
    assert told[1] == (
        "Over the whole flight, as published, saturated control is off by 36.2 m and linear feedback by 1050 m, "
        "29 times as much (27 to 31); each at its best, by 37.0 m and 123 m, 3.3 times as much (3.1 to 3.5)."
    )
    assert told[2] == f"None of them is ever lost. {ERRORS}{INTERVALS}."


def test_a_way_in_which_the_other_is_better_names_both_again(nothing):
    told = contrast_sentences(
        metrics(
            contrast("published", "control_published", ratio(4.0, 40.0, 10.0, 3.0, 5.0), name="as published"),
            contrast(FEEDBACK, CONTROL, ratio(0.5, 10.0, 20.0, 0.4, 0.625), name="each at its best"),
        ),
        nothing,
    )
    assert "each at its best, linear feedback is off by 10.0 m and saturated control by 20.0 m, 2.0 times" in told[0]
    assert "(1.6 to 2.5)" in told[0]  # the reciprocals of .625 and .4


@pytest.mark.parametrize(
    ("entry", "said"),
    [
        (ratio(1.03, 103.0, 100.0, 0.97, 1.09), "no difference within the noise (1.03 times, 0.97 to 1.09)"),
        (ratio(1.0, 50.0, 50.0, 1.0, 1.0), "exactly the same"),
        (ratio(3.0, 30.0, 10.0), "3.0 times as much, which a single sample does not tell from chance"),
        (ratio(1.02, 30.6, 30.0, 1.015, 1.025), "1.020 times as much (1.015 to 1.025)"),
    ],
)
def test_a_ratio_says_what_it_is_worth(nothing, entry, said):
    assert f", {said}." in contrast_sentences(metrics(contrast(FEEDBACK, CONTROL, entry)), nothing)[0]


def test_what_has_no_ratio_is_left_to_the_warnings(nothing):
    empty, gone = contrast(FEEDBACK, CONTROL, None), contrast(FEEDBACK, CONTROL, ratio(None, None, 30.0))
    for one in (empty, gone):
        assert contrast_sentences(metrics(one), nothing) == []
        assert first_contrast(metrics(one)) is None
    (told, _) = contrast_sentences(metrics(empty, contrast("published", CONTROL, WHOLE)), nothing)
    assert told.startswith("Over the whole flight saturated control is off by 37.0 m and published by 123 m")
    assert contrast_sentences({"trackers": {}}, nothing) == []


def test_an_angle_is_no_distance(nothing):
    told = contrast_sentences(
        metrics(contrast(FEEDBACK, CONTROL, ratio(2.0, 0.08, 0.04, 1.5, 2.5), channel="radar.azimuth_deg")), nothing
    )
    assert "saturated control is off in radar: azimuth by 0.040 deg and linear feedback by 0.080 deg" in told[0]


def test_several_flights_say_so_and_who_is_lost_on_which(nothing):
    pair = contrast(FEEDBACK, CONTROL, WHOLE, AHEAD)
    told = contrast_sentences(metrics(pair, lost={FEEDBACK: 0.034}, flights=6), nothing)
    assert told[0].startswith("60 s ahead, over 6 flights, saturated control")
    assert told[1].startswith("Over 6 flights saturated control")
    assert "Linear feedback is lost in 3.4 % of the draws of all 6 flights, not on this flight." in told[2]
    assert "Saturated control is never lost." in told[2]


def test_the_first_figure_is_of_the_way_in_which_they_differ_least():
    best = contrast(FEEDBACK, CONTROL, ratio(0.5, 1.0, 2.0, 0.4, 0.6))
    other = contrast(RIVAL, CONTROL, ratio(1.0, 1.0, 1.0, 1.0, 1.0))
    published = contrast("published", "control_published", ratio(29.0, 1.0, 1.0, 28.0, 30.0))
    assert first_contrast(metrics(published, best, other)) is best  # of the first pair; by the logarithm


def test_the_text_of_a_run_has_it_before_the_table_of_trackers():
    figures = {"rmse": 1.0, "raw": 2.0, "gain": 2.0}
    run = {
        "scenario": "s", "seed": 1, "flights": 1, "flight": {"reason": "landed", "duration_s": 1.0}, "checks": [],
        "warnings": [], "trackers": {"one": {"overall": {"position_m": figures}}},
    }  # fmt: skip
    lines = summary(run, "", contrasted=["A is off.", "B is lost."]).splitlines()
    assert lines.index("A is off.") + 1 == lines.index("B is lost.")
    assert lines.index("B is lost.") < next(i for i, line in enumerate(lines) if line.startswith("tracker "))


# -------------------------------------------------------------------------------------------------------- the reason


def flown(make_flight, law_from="autopilot", errors=((0.0,), (0.0,)), given=None, route=ONE, command=None, **signals):
    """A flight under the law from given signals, watched by one tracker."""
    flight = make_flight(TIME, ["final"] * len(TIME), route, **{"north": NORTH, **signals})
    bank = LAW(flight.deviation) if command is None else np.full(len(TIME), command)
    flight = dataclasses.replace(flight, command=flight.command._replace(bank=bank))
    return Flown(given or scenario(), LAW, flight, {"one": followed_by(flight, errors, law_from)})


def ahead_by(metres):
    return ((metres,), (0.0,))


def test_limits_act_where_the_aircraft_is_far_from_its_leg(make_flight):
    far = np.full(len(TIME), 5000.0)
    at_both = flown(make_flight, east=far)
    assert cause(at_both, "one", 10.0, 20.0) == "the law is at its bank and cross-track limits there"
    on_its_way = flown(make_flight, east=far, velocity_east=np.full(len(TIME), -30.0))  # asks for 9 deg
    assert cause(on_its_way, "one", 10.0, 20.0) == "the law is at its cross-track limit there"
    assert "within its limits" in cause(flown(make_flight), "one", 10.0, 20.0)


def test_a_limit_that_hardly_acts_explains_nothing(make_flight):
    for lasting, said in ((0.5, "within its limits"), (2.0, "cross-track limit")):
        east = np.where((TIME > 12.0) & (TIME - lasting < 12.0), 413.0, 10.0)
        speed = np.where(east > 400.0, -35.0, 0.0)  # keeps the bank below its limit
        assert said in cause(flown(make_flight, east=east, velocity_east=speed), "one", 10.0, 20.0)


def test_the_law_is_not_engaged_where_another_bank_is_commanded(make_flight):
    by_hand = flown(make_flight, command=np.radians(3.0))
    assert cause(by_hand, "one", 10.0, 20.0).startswith("the law is not engaged there")
    on_estimate = scenario(autopilot={"navigation": "best"}, sensors={"radar": {"kind": "surveillance_radar"}})
    flies_its_own = flown(make_flight, command=np.radians(3.0), given=on_estimate)
    assert "not engaged" not in cause(flies_its_own, "one", 10.0, 20.0)


def test_another_law_is_flown_than_the_tracker_assumes(make_flight):
    left = scenario(departures=[{"at_s": 30.0, "flies": "bank", "bank_deg": 10.0}])
    one = flown(make_flight, given=left)
    assert "within its limits" in cause(one, "one", 10.0, 20.0)  # not yet
    assert cause(one, "one", 25.0, 40.0) == (
        "another law is flown than it assumes (flown by hand, 10 deg to the right)"
    )
    assert cause(flown(make_flight, "told wrong"), "one", 10.0, 20.0) == (
        "it assumes another law than the one that flies"
    )


def test_an_estimate_may_turn_before_the_aircraft(make_flight):
    """The leg ends in 6 km; a turn of 90 deg at 70 m/s and 15 deg of bank begins 1.9 km before, so 4.5 km ahead."""
    corner = Route(
        (Leg((-50000.0, 0.0), (-5400.0, 0.0), 70.0, 400.0), Leg((-5400.0, 0.0), (-5400.0, 9e3), 70.0, 400.0))
    )
    for metres, early in ((0.0, False), (4500.0, True)):
        one = flown(make_flight, errors=ahead_by(metres), route=corner)
        one.tracked["one"].track.mean[:, 1] = 70.0  # m/s northwards
        said = cause(one, "one", 5.0, 10.0)
        assert (said == "its estimate turns onto the next leg before the aircraft does") is early


def test_what_a_tracker_without_a_law_does_not_hold(make_flight):
    def said(**signals):
        return cause(flown(make_flight, None, **signals), "one", 10.0, 20.0)

    assert said(bank=np.full(len(TIME), np.radians(-14.6))) == "the aircraft turns there, banked up to 15 deg"
    assert said(velocity_north=70.0 - 0.5 * TIME) == "the aircraft slows down there at 0.5 m/s²"
    assert said(velocity_north=70.0 + 0.4 * TIME) == "the aircraft speeds up there at 0.4 m/s²"
    held = flown(make_flight, velocity_north=70.0 - 0.5 * TIME)
    assert cause(held, "one", 10.0, 20.0).endswith("within its limits, but the aircraft slows down there at 0.5 m/s²")
    assert said() == "the aircraft flies straight there at a steady speed"


def test_a_loss_is_told_with_the_first_look_that_counts_for_it(make_flight):
    east = np.where(TIME < 30.0, 0.0, 5000.0)
    one = flown(make_flight, east=east)
    epochs = one.tracked["one"].track.time
    first = int(np.searchsorted(epochs, 32.0))
    found = loss(one, "one", float(epochs[first + LOST_EPOCHS - 1]))
    assert found.astray == epochs[first]
    assert "cross-track" in found.cause
    assert loss(one, "one", None) is None
    assert loss(one, "another", 20.0) is None
    pair = metrics(contrast(FEEDBACK, CONTROL, WHOLE), lost={FEEDBACK: 1.0})
    named = one._replace(tracked={FEEDBACK: one.tracked["one"]})
    told = contrast_sentences(pair, named, {FEEDBACK: {"lost_time_s": found.time}})[-1]
    assert told.startswith(
        f"Linear feedback is lost in every draw, first at {found.time:.0f} s, astray since {found.astray:.0f} s "
        "(final): the law is at its bank and cross-track limits there. Saturated control is never lost."
    )
    alone = contrast_sentences({**pair, "draws": 1}, named, {FEEDBACK: {"lost_time_s": found.time}})[-1]
    assert alone.startswith(f"Linear feedback is lost at {found.time:.0f} s, astray since")
    several = contrast_sentences({**pair, "flights": 4}, named, {FEEDBACK: {"lost_time_s": found.time}})[-1]
    assert f"lost in every draw of all 4 flights, on this flight first at {found.time:.0f} s, astray" in several


# ------------------------------------------------------------------------------------------------- where they part


def apart_from(flight, sizes, law_from="autopilot"):
    """A tracker that is off to the north by sizes (40,) in each of two draws."""
    errors = np.zeros((40, 2, 2))
    errors[:, 0] = np.asarray(sizes)[:, None]
    return followed_by(flight, errors, law_from)


@pytest.fixture
def straight(make_flight):
    return make_flight(TIME, np.where(TIME < 30, "final", "glide"), north=NORTH)


EPOCHS = np.linspace(1.0, 59.0, 40)


@pytest.mark.parametrize(
    ("sizes", "start", "factor"),
    [
        (np.where(EPOCHS < 30.0, 10.0, 40.0), 30.0, 3.0),
        (np.where((EPOCHS > 10.0) & (EPOCHS < 14.0), 90.0, np.where(EPOCHS < 30.0, 10.0, 40.0)), 30.0, 3.0),  # a spike
        (np.where(EPOCHS < 20.0, 10.0, np.where(EPOCHS < 40.0, 2.0, 10.0)), 20.0, 3.0),  # the other is worse
        (np.where(EPOCHS < 40.0, 10.0, 18.0), 40.0, 1.5),
    ],
)
def test_two_part_where_the_error_of_one_is_a_multiple_and_stays_so(straight, sizes, start, factor):
    one, other = apart_from(straight, sizes).curves, apart_from(straight, np.full(40, 10.0)).curves
    found = parting(one, other, "position_m")
    step = EPOCHS[1] - EPOCHS[0]
    assert abs(found.start - start) <= step
    assert found.factor == factor


def test_two_that_err_alike_do_not_part(straight):
    one, other = apart_from(straight, np.full(40, 14.0)).curves, apart_from(straight, np.full(40, 10.0)).curves
    assert parting(one, other, "position_m") is None


@pytest.fixture
def pair(straight):
    """The law that flies has limits that act from 30 s on, from when linear feedback is off."""
    given = scenario({FEEDBACK: FEEDBACK, CONTROL: CONTROL})
    tracked = {
        FEEDBACK: apart_from(straight, np.where(EPOCHS < 30.0, 10.0, 400.0)),
        CONTROL: apart_from(straight, np.full(40, 10.0)),
    }
    return Flown(given, LAW, straight, tracked)


def test_they_part_with_a_reason_where_none_is_lost(pair):
    found = apart(pair, FEEDBACK, CONTROL)
    told = contrast_sentences(metrics(contrast(FEEDBACK, CONTROL, WHOLE)), pair)[-1]
    assert told.startswith(
        f"Neither is ever lost. They part at {found.stretch.start:.0f} s ({found.phase}): the law is flown there within"
    )
    assert apart(pair, FEEDBACK, "another") is None


def test_the_figure_shows_both_where_they_part(pair):
    shown = shown_trackers(pair.scenario, pair.tracked)
    stretch = apart(pair, FEEDBACK, CONTROL).stretch
    found = contrast_map(pair.flight, (shown[0], shown[1]), stretch)
    assert [one.name for one in found.believed] == ["linear feedback", "saturated control"]
    wanted = (-12000.0 + 70.0 * stretch.start) * 1e-3  # km, on a course due north
    np.testing.assert_allclose(found.parted, (wanted, 0.0), atol=2e-3)
    wrong = found.believed[0].ties
    np.testing.assert_allclose((wrong[:, 1] - wrong[:, 0])[-1], (0.4, 0.0), atol=2e-3)  # 400 m too far
    chart = contrast_chart(pair.flight, contrast(FEEDBACK, CONTROL, WHOLE, name="at its best"), shown, stretch)
    assert chart.title == "Linear feedback against saturated control (at its best)"
    assert [name for name, *_ in chart.keys] == ["flown", "linear feedback", "saturated control"]
    assert f"They part at {stretch.start:.0f} s" in chart.caption
    assert contrast_chart(pair.flight, contrast(FEEDBACK, "unseen", None), shown, None) is None
    whole = contrast_map(pair.flight, (shown[0], shown[1]), None)
    assert whole.parted is None
    assert whole.time == (TIME[0], TIME[-1])


def test_the_replay_opens_shortly_before_they_part(pair):
    assert replay(pair.flight, pair.scenario, [], {}, parted=42.0)["opens"] == 42.0 - LEAD
    assert replay(pair.flight, pair.scenario, [], {}, parted=3.0)["opens"] == 0.0
    assert replay(pair.flight, pair.scenario, [], {})["opens"] == 0.0


def test_the_first_screen_has_sentence_figure_and_replay(pair, tmp_path):
    given, flight, tracked = pair.scenario, pair.flight, pair.tracked
    trackers = summaries(given, {FEEDBACK: 30.0, CONTROL: 10.0})
    contrasts = [contrast(FEEDBACK, CONTROL, WHOLE, AHEAD)]
    page = written(tmp_path, flight, given, tracked, trackers, contrasts=contrasts)
    text = re.sub(r"\s+", " ", page.text)
    first, _, rest = text.partition("flight time")
    assert first.index("60 s ahead saturated control is off by 104 m") < first.index("Over the whole flight saturated")
    assert first.index("Over the whole flight saturated") < first.index("saturated control was best")
    assert "Linear feedback against saturated control" in first
    assert "It opens shortly before linear feedback and saturated control part." in rest
    opens = json.loads(page.scripts[0])["opens"]
    assert math.isclose(opens, apart(pair, FEEDBACK, CONTROL).stretch.start - LEAD, abs_tol=0.05)  # rounded to 0.1 s
    assert page.faults == []


def test_a_result_says_it_itself():
    import sim

    legs = [{"from_m": [0, 0], "to_m": [40000, 0], "speed_mps": 72, "height_m": 600}]
    tables = {
        "name": "capture", "draws": 8, "until_s": 90, "aircraft": {"model": "point_mass"},
        "start": {"leg": 0, "cross_track_m": 5000}, "route": {"kind": "legs", "legs": legs},
        "sensors": {"radar": {"kind": "surveillance_radar", "period_s": 4}},
        "trackers": {name: {"kind": name, "acceleration_density_m2ps3": 0.1} for name in (FEEDBACK, CONTROL)},
        "contrasts": [{"of": FEEDBACK, "against": CONTROL}],
    }  # fmt: skip
    ahead, whole, lost = sim.run(read(tables)).contrasted
    assert re.match(r"60 s ahead saturated control is off by .* and linear feedback by .* times as much \(", ahead)
    assert whole.startswith("Over the whole flight saturated control is off by ")
    assert lost.startswith("Linear feedback is lost in ")
    assert "cross-track" in lost  # 5 km off, the limit of the position acts
