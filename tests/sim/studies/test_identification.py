"""Laws identified from captures whose law is known, and what is told of them, judged by hand and by the smoother."""

from __future__ import annotations

import math
import tomllib

import numpy as np
import pytest

from autopilot.capture import smoother_of
from autopilot.identification import Parameter
from autopilot.last_turn import last_turn
from autopilot.law_search import Search
from sim.errors import OutputError, ScenarioError
from sim.experiment import read
from sim.studies.identification.captures import identify
from sim.studies.identification.command import identify_to_folder, summary
from sim.studies.identification.law_file import law_text
from sim.studies.identification.page import page
from sim.studies.identification.spread import spread_of, spreads
from sim.studies.identification.survey import Survey, as_json, survey
from tests import captures
from tests.capture import CAPTURE
from tracking.smoothing import smooth
from tracking.track import Measurements, track
from tracking.trackers.kalman import Kalman

EXACT = 0.01  # of a number, found from a path without errors: what steps of .25 s and a turn read over 2 s leave


def flown_by(law, lag, offset, course, until):
    return captures.exact(captures.fly(captures.by_law(law), lag, offset, course, until=until))


@pytest.fixture(scope="module")
def limited():
    """A law that meets both limits, from the left on a runway to the north-east, and what is identified."""
    law = captures.route_law(0.06, 0.95, 700.0, 9.0)
    flown = captures.fly(captures.by_law(law), 1.5, -3200.0, math.asin(0.06 * 700.0 / 0.95 / 95.0), until=170.0)
    return law, identify(captures.exact(flown, heading=0.9))


@pytest.fixture(scope="module")
def late():
    """A heading that is held until 500 m before the line: the law meets neither limit. The line is 20 m off the leg."""
    law = captures.route_law(0.06, 0.9, 1200.0, 30.0)

    def bank(time, cross_track, course, speed):
        return captures.by_law(law)(time, cross_track, course, speed) if cross_track < 500.0 else 0.0

    flown = captures.fly(bank, 1.0, 500.0 + 40.0 * 50.0, -math.radians(30.0), until=140.0)
    beside = flown._replace(cross_track=flown.cross_track + 20.0)
    return law, float(flown.time[flown.cross_track < 500.0][0]), identify(captures.exact(beside))


@pytest.fixture(scope="module")
def by_hand():
    """Two banks, a roll-out beside the line and corrections of 10 degrees."""
    headings = [(0.0, 60.0), (40.0, 15.0), (70.0, 5.0), (84.0, 12.0), (100.0, -5.0), (115.0, 3.0)]  # s, deg

    def bank(time, cross_track, course, speed):
        wanted = next(math.radians(heading) for since, heading in reversed(headings) if time >= since)
        return max(-0.35, min(0.35, 12.0 * (wanted - course)))

    return identify(captures.exact(captures.fly(bank, 0.8, -5200.0, math.radians(60.0), until=150.0)))


def test_a_law_is_found_from_its_path(limited):
    law, fit = limited
    for name in ("k1", "k2", "cross_track_limit", "bank_limit"):
        assert getattr(fit, name).value == pytest.approx(getattr(law, name), rel=EXACT), name
        assert getattr(fit, name).met
    assert fit.lag.value == pytest.approx(1.5, abs=0.05)
    assert fit.explained
    assert fit.engaged is None
    assert fit.cross_track_rms < 0.5
    assert fit.damping == pytest.approx(law.damping, rel=2 * EXACT)


def test_limits_that_never_act_are_bounds_and_a_late_law_is_seen(late):
    law, since, fit = late
    assert fit.k1.value == pytest.approx(law.k1, rel=EXACT)
    assert fit.k2.value == pytest.approx(law.k2, rel=EXACT)
    assert fit.engaged == pytest.approx(since, abs=0.2)
    assert fit.line.value == pytest.approx(20.0, abs=0.5)
    for name in ("cross_track_limit", "bank_limit"):
        bound = getattr(fit, name)
        assert not bound.met
        assert math.isnan(bound.sigma)
        assert 0.0 < bound.value < getattr(law, name)


def test_a_flight_by_hand_is_not_explained(by_hand):
    assert not by_hand.explained
    assert "bank residuals" in " ".join(by_hand.objections)


def test_only_place_and_velocity_are_looked_at(limited, late):
    """Records of a recording have nothing else: all other fields of those above are NaN, and so is the answer never."""
    for fit in (limited[-1], late[-1]):
        assert np.isfinite(fit.capture.bank).all()
        assert np.isfinite(fit.flown.bank).all()


def test_a_turn_is_found_by_its_rate():
    time = np.arange(0.0, 100.0, 1.0)
    course = np.interp(time, [20.0, 40.0, 60.0, 70.0], np.radians([60.0, 0.0, 0.0, 20.0]))
    turn = last_turn(time, course)
    assert (turn.begin, turn.end) == pytest.approx((60.0, 70.0), abs=1.0)
    assert turn.angle == pytest.approx(math.radians(20.0), abs=math.radians(2.0))
    first = last_turn(time[:58], course[:58])
    assert (first.begin, first.end) == pytest.approx((20.0, 40.0), abs=1.0)
    assert last_turn(time, np.radians(10.0) * np.sin(time / 5.0)) is not None  # 20 deg from side to side
    assert last_turn(time, np.radians(5.0) * np.sin(time / 5.0)) is None


@pytest.mark.parametrize(
    ("turned", "sentence"),
    [(0.0, "no turn of 15 deg"), (150.0, "is one of 150 deg"), (40.0, "ends 40 deg off"), (-30.0, "30 s after")],
)
def test_what_is_no_capture_is_told(turned, sentence):
    """Straight on, a turn too far, one onto another course, and one at the end of the record."""
    time = np.arange(0.0, 120.0, 1.0)
    begin = {40.0: 0.0, 150.0: 150.0, -30.0: 30.0}.get(turned, 0.0)
    at = (100.0, 110.0) if turned == -30.0 else (30.0, 90.0)
    course = np.radians(begin + np.interp(time, at, [0.0, -turned if turned == 150.0 else turned]))
    north, east = -20e3 + np.cumsum(80.0 * np.cos(course)), np.cumsum(80.0 * np.sin(course))
    flight = captures.flight_of(time, north, east, 80.0 * np.cos(course), 80.0 * np.sin(course))
    with pytest.raises(ScenarioError) as told:
        identify(flight)
    assert sentence.replace("30 s after", "9 s after") in str(told.value)


def test_a_leg_that_is_not_there_is_told():
    time = np.arange(0.0, 60.0)
    with pytest.raises(ScenarioError, match="legs 0 to 0, not 3"):
        identify(captures.flight_of(time, -9e3 + 80.0 * time, 0.0 * time, 80.0 + 0.0 * time, 0.0 * time), 3)


def test_a_path_is_smoothed_as_the_recursion_smooths_it():
    """The matrix against Rauch, Tung and Striebel's steps, on noise about a turn."""
    time = np.arange(50.0)
    track_error = np.radians(np.interp(time, [10.0, 40.0], [60.0, 0.0]))
    z = 30.0 * np.random.default_rng(1).standard_normal((50, 2))
    c, s = np.cos(track_error), np.sin(track_error)
    turn = np.moveaxis(np.array([[c, -s], [s, c]]), -1, 0)
    R = turn @ np.diag([21.0**2, 2.8**2]) @ turn.swapaxes(1, 2)
    pick = np.zeros((2, 6))
    pick[0, 0] = pick[1, 3] = 1.0
    kalman = Kalman(captures.LinearMeasurement(tuple(map(tuple, pick))), captures.WhiteJerk())
    prior = captures.Gaussian(np.zeros(6), 1e6 * np.eye(6))
    judged = smooth(track(kalman, Measurements(("a", "b"), time, time, z[..., None], R), prior), captures.WhiteJerk())
    ours = smoother_of(track_error, 21.0, 2.8, captures.JERK) @ z.T.ravel()
    theirs = judged.mean[:, [0, 3], 0].T.ravel()
    inside = np.tile((time >= 6) & (time < 44), 2)
    # the recursion integrates the jerk over each second, the matrix takes third differences
    assert np.abs(ours - theirs)[inside].max() < 0.03 * np.abs(theirs).max()


def test_slopes_are_those_of_the_residuals(limited):
    """A step a thousand times as long, by another formula."""
    search = Search(limited[-1].capture, math.radians(5.0))
    x = search.starts()[:, :1]
    slopes = search.slopes(x)[1][:, 1, 0]
    up, down = x.copy(), x.copy()
    up[1], down[1] = x[1] + 5e-3, x[1] - 5e-3
    judged = (search.errors(up) - search.errors(down))[:, 0] / 1e-2
    assert np.abs(slopes - judged).max() < 0.05 * np.abs(judged).max()
    assert (search.slopes(x)[1][:, 8] == 0.0).all()  # this law is on from the beginning


def test_a_response_is_that_of_the_test_s_integrator(limited):
    """The fitted loop, simulated in steps of .25 s, beside the record of steps of .02 s."""
    _, fit = limited
    assert np.abs(fit.flown.cross_track - fit.capture.cross_track).max() < 1.0
    assert np.degrees(np.abs(fit.flown.bank - fit.capture.bank).max()) < 0.2


def test_bounds_count_as_what_lies_beyond_them():
    """Five numbers by hand (Kaplan and Meier): 1, 2, at least 2, 3, at least 4."""
    given = [Parameter(1.0, 0.1), Parameter(2.0, 0.1), Parameter(2.0, math.nan, False), Parameter(3.0, 0.1)]
    spread = spread_of([*given, Parameter(4.0, math.nan, False)])
    # shares at or below 1, 2, 3: .2, .4, 1 - .6 / 2 = .7; the middles of the steps are .1, .3, .55
    assert spread.quantiles[1] == pytest.approx(1.75)
    assert spread.quantiles[2] == pytest.approx(2.8)
    assert math.isnan(spread.quantiles[3])
    assert (spread.lowest, spread.highest, spread.estimated, spread.bounds) == (1.0, 3.0, 3, 2)


@pytest.fixture(scope="module")
def found(limited, late, by_hand):
    fits = {"A1": limited[-1], "B2": late[-1], "<C&3>": by_hand}
    return Survey("made", fits, {"D4": "no turn"}, spreads([*fits.values()]))


def test_the_law_of_the_medians_is_one_that_a_study_can_draw(found):
    """Pasted under a scenario it is read, and its axes are those of the explained captures."""
    tables = tomllib.loads(law_text(found))
    scenario = read({**CAPTURE, **tables})
    assert scenario.law["k2"] == pytest.approx(found.spread["k2"].quantiles[2], rel=1e-3)
    assert scenario.autopilot.bank_limit == pytest.approx(found.spread["bank_limit"].highest, rel=1e-3)
    drawn = set(tables["study"]["axes"])
    assert drawn == {"autopilot.law.k1_deg_per_m", "autopilot.law.k2_deg_per_mps"}  # of the limits one is known


def test_nothing_is_left_out_of_what_is_told(found):
    told = as_json(found)
    assert (told["flights"], told["captures"], told["explained"]) == (4, 3, 2)
    assert set(told["each"]) == {"A1", "B2", "<C&3>"}
    assert told["each"]["B2"]["bank_limit_deg"]["met"] is False
    assert "the bank limit was never met" in " ".join(told["each"]["B2"]["why"])
    assert told["refused"] == {"D4": "no turn"}
    text = summary(found, lambda rows, words: [" | ".join(map(str, row)) for row in rows])
    assert "4 flights, 3 captures: law (4) explains 2 of 3." in text
    assert "D4: no capture: no turn" in text


def test_a_survey_tells_flights_without_a_capture():
    time = np.arange(0.0, 90.0)
    straight = captures.flight_of(time, -9e3 + 80.0 * time, 0.0 * time, 80.0 + 0.0 * time, 0.0 * time)
    result = survey("made", {"one": straight})
    assert result.refused == {"one": "no turn of 15 deg or more leads onto leg 0"}
    assert law_text(result) is None
    assert "no turn of 15 deg" in page(result, None)


def test_bad_input_is_one_sentence(tmp_path):
    (tmp_path / "other").mkdir()
    for source, runway, sentence in (
        (tmp_path / "tracks.csv", None, "say --runway FILE"),
        (tmp_path / "other", None, "not a run folder"),
        (tmp_path / "other", tmp_path / "runway.toml", "leave out --runway"),
    ):
        with pytest.raises(OutputError, match=sentence):
            identify_to_folder(source, runway, tmp_path / "out")
