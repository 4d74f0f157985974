"""Aircraft that a controller leads to their path: `intent_imm` vectored, and `saturated_control` that waits."""

from __future__ import annotations

import math
from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest

from autopilot.modes.radio_beacon import RadioBeacon
from sim.estimation.trial import maker
from tests.tracking.law_truth import (
    CROSS_TRACK,
    LINE,
    NOMINAL,
    ONE_LEG,
    PLANE,
    Lateral,
    errors,
    prior,
    record,
    route_truth,
)
from tracking.conformance import ConformanceTest
from tracking.contract import broken_promises
from tracking.gaussian import Gaussian, Mixture
from tracking.law_bank import LawBank
from tracking.reference_path import Legs
from tracking.track import follow
from tracking.trackers.intent_imm import DECELERATION, IntentImm
from tracking.trackers.saturated_control import SaturatedControl
from tracking.vectored_switching import MANOEUVRE_STAY, OVERDUE, RARELY, TAKEN_UP, law_is_met, unlimited

VECTORED = IntentImm(NOMINAL, ONE_LEG, PLANE, vectored=True, limit_factors=(0.4, 1.0, 2.4), mean_stay=60.0)
LATE = 4.0  # s, by which the crew arms the law too late
RUNS = 20


def share(probabilities, *words):
    """Probability (k, N) of the modes whose name has one of the words."""
    chosen = [any(word in mode for word in words) for mode in VECTORED.modes]
    return probabilities[:, chosen].sum(axis=1)


def on_a_heading(rate=-70.0, until=260.0, leave=math.inf):
    """An aircraft that crosses towards the line at ``rate`` until the law turns it onto the line, a little late.

    At ``leave`` (s) it banks by 15 deg for 20 s and flies straight on.
    """
    due = np.full(RUNS, np.inf)

    def control(time, x, to_go):
        nonlocal due
        wanted = NOMINAL(Lateral(x[0], x[1], to_go))
        due = np.where(np.isinf(due) & (-NOMINAL.k1 * x[0] - NOMINAL.k2 * x[1] > 0.0), time + LATE, due)
        flown = np.where(time >= due, wanted, 0.0)
        return flown if time < leave else np.full(RUNS, math.radians(15.0) if time < leave + 20.0 else 0.0)

    start = (0.0, math.sqrt(100.0**2 - rate**2), 6000.0, rate)
    return route_truth(NOMINAL, ONE_LEG, start, until, np.random.default_rng(71), RUNS, density=0.02, control=control).x


@pytest.mark.parametrize(
    ("cls", "example"),
    [(IntentImm, {"vectored": True, "limit_factors": (1.0,)}), (SaturatedControl, {"begins": "engaged"})],
)
def test_it_keeps_the_contract(cls, example):
    kind = type(cls.__name__, (cls,), {"example": example})
    assert broken_promises(kind, maker(kind)) == []


def test_the_heading_is_held_until_the_law_turns_towards_the_course():
    """Right of the line, by hand: too shallow an intercept is not steepened, and too steep a one is turned in time.

    At 60 m/s towards the line the law at .6 of its frequency asks for 0.0072 z - 0.3 60 deg to the left: nothing at
    2500 m.
    """
    bank = LawBank(NOMINAL, (unlimited(NOMINAL),), (), 1)

    def flown(cross_track, rate, speed=100.0):
        leg = ONE_LEG.deviation(
            np.zeros((1, 1), int),
            (np.zeros((1, 1)), np.full((1, 1), cross_track)),
            (np.full((1, 1), math.copysign(math.sqrt(100.0**2 - rate**2), speed)), np.full((1, 1), rate)),
        )
        return math.degrees(bank(leg)[0, 0])

    assert flown(4000.0, -60.0) == 0.0
    assert flown(2600.0, -60.0) == 0.0
    assert flown(2400.0, -60.0) == pytest.approx(0.72)
    assert flown(1000.0, -60.0) == pytest.approx(10.8)
    assert flown(-1000.0, 60.0) == pytest.approx(-10.8)
    assert flown(300.0, 0.0) == 0.0  # beside the line and along it: nothing is captured
    assert flown(1000.0, -60.0, speed=-100.0) == 0.0  # it flies away from the end of the leg
    assert flown(300.0, 10.0) == pytest.approx(-5.16)  # half a minute ago it met the line, and is overdue
    assert flown(700.0, 10.0) == 0.0  # that was more than a minute ago: it follows another line


OTHER = RadioBeacon(6.0, 1.2, math.radians(15.0), math.radians(5.0))
ON_PATH, BESIDE = ((0.0, 100.0, offset, 0.0) for offset in (20.0, 2000.0))  # along the leg, to the right of it


def switching(tracker, place, dt):
    """Probabilities (M, M) of its switching over dt at an estimate; rows are "from"."""
    count = len(tracker.modes)
    mean = np.tile(np.array(place)[None, :, None], (count, 1, 1))
    return tracker.switched(np.eye(count)[:, :, None], dt, mean)[:, :, 0]


@pytest.mark.parametrize("place", [ON_PATH, BESIDE], ids=["met", "away"])
def test_the_switching_is_a_semigroup(place):
    short, long = (switching(VECTORED, place, dt) for dt in (0.4, 4.0))
    np.testing.assert_allclose(np.linalg.matrix_power(short, 10), long, atol=1e-14)
    np.testing.assert_allclose(long.sum(axis=1), 1.0, rtol=1e-14)


ARMED_MODES = ("law armed", "law armed, slowing")


def test_modes_are_left_as_stated():
    """Rates by hand, at the line (law at 0.4 deg) and 2 km beside it, where it would bank to its limit."""
    tracker = replace(VECTORED, alternative_laws=(OTHER,))
    tiny = 1e-6
    met, away = ((switching(tracker, place, tiny) - np.eye(len(tracker.modes))) / tiny for place in (ON_PATH, BESIDE))
    of = {
        name: [name in mode for mode in tracker.modes] for name in ("law x", "slowing", "armed", OTHER.intent, "turn")
    }
    of["even"] = [mode.startswith("law x") and "slowing" not in mode for mode in tracker.modes]
    of["slowing"] = ["law x" in mode and "slowing" in mode for mode in tracker.modes]
    of["free"] = [mode in tracker._free for mode in tracker.modes]
    of["armed even"], of["armed slowing"] = ([mode == name for mode in tracker.modes] for name in ARMED_MODES)
    of["straight"], of["slowing down"] = ([mode == name for mode in tracker.modes] for name in tracker._free[:2])
    free = (np.array(tracker._vectors.switching) / tracker._vectors.period).tolist()

    def rate(rates, source, target):
        """For each hypothesis of the one, into all of the other."""
        return rates[of[source]][:, of[target]].sum(axis=1)

    stay = 1.0 / tracker.mean_stay
    for rates, taken, left, given_up in (
        (met, 1.0 / TAKEN_UP, 1.0 / RARELY, 1.0 / OVERDUE),
        (away, 1.0 / RARELY, 1.0 / MANOEUVRE_STAY, stay),
    ):
        for source, target, expected in (
            ("free", "law x", taken),
            ("free", OTHER.intent, taken),
            ("armed", "law x", taken),
            ("armed", OTHER.intent, 0.0),
            ("law x", "free", left),
            (OTHER.intent, "free", left),
            ("law x", "armed", 0.0),  # an autopilot that has captured its path does not wait for it again
            (OTHER.intent, "armed", 0.0),
            ("free", "armed", stay),
            ("armed even", "armed slowing", free[0][1]),
            ("armed slowing", "armed even", free[1][0]),
            ("armed even", "straight", given_up if rates is away else 0.25 * given_up),
            ("armed slowing", "slowing down", given_up if rates is away else 0.25 * given_up),
            ("armed even", "slowing down", 0.0 if rates is away else 0.25 * given_up),
            ("armed even", "turn", 2.0 * free[0][2] if rates is away else 0.5 * given_up),
            ("armed slowing", "turn", 2.0 * free[1][2] if rates is away else 0.5 * given_up),
            ("straight", "armed even", stay),
            ("slowing down", "armed slowing", stay),
            ("turn", "armed even", stay),
            ("even", "slowing", stay),
            ("slowing", "even", 1.0 / MANOEUVRE_STAY),
        ):
            np.testing.assert_allclose(rate(rates, source, target), expected, rtol=1e-4, atol=1e-8, err_msg=source)


def test_several_epochs_are_switched_as_each_by_itself():
    rng = np.random.default_rng(3)
    before = rng.dirichlet(np.ones(len(VECTORED.modes)), (3, 2)).swapaxes(1, 2)
    mean = np.tile(np.array(ON_PATH)[None, :, None], (3, 1, 2))
    mean[1, :, 1] = BESIDE
    after = VECTORED.switched(before, np.array([4.0, 1.0, 4.0])[:, None, None], mean)
    np.testing.assert_allclose(after[1, :, 0], switching(VECTORED, ON_PATH, 1.0).T @ before[1, :, 0], rtol=1e-12)
    np.testing.assert_allclose(after[1, :, 1], switching(VECTORED, BESIDE, 1.0).T @ before[1, :, 1], rtol=1e-12)


def test_a_law_is_met_where_it_asks_for_less_than_all_its_bank():
    """By hand: 0.02 z + 0.5 z' deg, whatever the limit of the intercept, against 20 deg; the leg runs north.

    On a heading the law is met before the line, where it would begin to turn.
    """
    places = np.array([(999.0, 0.0), (1001.0, 0.0), (2490.0, -60.0), (2510.0, -60.0), (510.0, -60.0), (490.0, -60.0)]).T
    mean = np.array([0.0 * places[0], 0.0 * places[0] + 80.0, places[0], places[1]])
    found = law_is_met(unlimited(NOMINAL), Legs(ONE_LEG, NOMINAL.bank_limit), np.zeros(6, int), mean)
    assert found.tolist() == [True, False, True, False, True, False]


def test_the_step_switches_each_run_by_its_own_place():
    """Two runs, one on the path: each as if it were alone, and the probabilities as `switched` has them."""
    mean = np.array((ON_PATH, BESIDE)).T
    state = VECTORED.begin(Gaussian(mean, np.diag([1e4, 25.0, 1e4, 25.0])))
    after = VECTORED.step(state, 4.0, None, None)[0].mixture.weights
    for run, place in enumerate((ON_PATH, BESIDE)):
        alone = VECTORED.begin(Gaussian(mean[:, [run]], np.diag([1e4, 25.0, 1e4, 25.0])))
        expected = switching(VECTORED, place, 4.0).T @ state.mixture.weights[:, run]
        np.testing.assert_allclose(after[:, run], expected, rtol=1e-12)
        found = VECTORED.step(alone, 4.0, None, None)[0].mixture.weights[:, 0]
        np.testing.assert_allclose(found, expected, rtol=1e-12)


def test_half_of_the_laws_slow_down_along_their_own_course():
    """4 s of prediction with nothing mixed: 2 m/s and 4 m less, and the same turn to a thousandth."""
    tracker = replace(VECTORED, mean_stay=1e30)
    state = tracker.begin(Gaussian(np.array([0.0, 80.0, 3000.0, -60.0]), np.diag([1e4, 25.0, 1e4, 25.0])))
    moved = tracker._fly(Mixture(*(part[..., :8] for part in state.mixture)), state.place, 4.0)[0].mean
    even, slowing = moved[:, [0, 1, 2, 6]], moved[:, [3, 4, 5, 7]]
    speeds = [np.hypot(mean[1], mean[3]) for mean in (even, slowing)]
    np.testing.assert_allclose(speeds[0], 100.0, rtol=1e-12)
    np.testing.assert_allclose(speeds[1], 100.0 - 4.0 * DECELERATION, rtol=1e-12)
    courses = [np.arctan2(mean[3], mean[1]) for mean in (even, slowing)]
    np.testing.assert_allclose(courses[0], courses[1], atol=2e-3)
    np.testing.assert_allclose(np.hypot(*(even - slowing)[0::2]), 0.5 * DECELERATION * 16.0, rtol=1e-2)


def test_no_chart_tells_the_speed():
    route = replace(ONE_LEG, chart=())
    charted, free = (
        replace(VECTORED, route=route, vectored=vectored, limit_factors=(1.0,)) for vectored in (False, True)
    )
    start = Gaussian(np.array([0.0, 130.0, 0.0, 0.0]), np.diag([1e4, 25.0, 1e4, 25.0]))
    speeds = [tracker.step(tracker.begin(start), 20.0, None, None)[0].mixture.mean[1, 0] for tracker in (charted, free)]
    assert speeds[0] == pytest.approx(100.0 + 30.0 / math.e, abs=0.5)
    assert speeds[1] == pytest.approx(130.0, abs=4.0)  # mixed with those that slow down


def test_knows_a_turn_at_the_limit_and_a_change_of_speed():
    """Far beside the line and away from it; to the left the law would turn too. 0.5 m/s2 only show after some 30 s."""
    rng = np.random.default_rng(72)
    start = (0.0, -100.0, 20e3, 0.0)

    def turning(time, x, to_go):
        return np.full(RUNS, math.radians(20.0) if 60.0 <= time < 100.0 else 0.0)

    flown = route_truth(NOMINAL, ONE_LEG, start, 140.0, rng, RUNS, density=0.0, control=turning).x
    found = errors(VECTORED, flown, 73).probabilities
    left, right = (share(found, f"{side} turn")[19:25].mean() for side in ("left", "right"))
    assert right > 0.5
    assert left < 0.1

    time = 4.0 * np.arange(30)
    lost = DECELERATION * np.maximum(time - 40.0, 0.0)
    north = -100.0 * time + 0.5 * DECELERATION * np.maximum(time - 40.0, 0.0) ** 2
    alike = np.ones((len(time), RUNS))
    slowing = np.stack([north[:, None] * alike, (lost - 100.0)[:, None] * alike, 20e3 * alike, 0.0 * alike], axis=1)
    found = errors(VECTORED, slowing, 74).probabilities
    before, after = (
        share(found, "slowing")[rows].mean() / share(found, "straight")[rows].mean()
        for rows in (slice(5, 10), slice(22, None))
    )
    assert after > 3.0 * before


def test_waits_with_the_law_armed_and_then_believes_it():
    flown = on_a_heading()
    found = errors(VECTORED, flown, 75).probabilities
    waiting = share(found, "armed", "straight")
    law = share(found, "law x")
    assert waiting[6:14].mean() > 0.6  # 45 deg: too steep for what the law itself would fly
    assert law[45:].mean() > 0.6


def test_a_line_knows_no_headings():
    with pytest.raises(ValueError, match="vectored needs a route of legs"):
        IntentImm(NOMINAL, LINE, CROSS_TRACK, vectored=True)


def test_a_law_that_waits_is_engaged_by_the_looks_and_let_go():
    """Told to fly at once it is lost on the heading; one that waits is not, and follows the aircraft away again."""
    flown = on_a_heading(until=300.0, leave=220.0)
    at_once, waits = (
        SaturatedControl(NOMINAL, ONE_LEG, PLANE, 0.1, begins=begins) for begins in ("at once", "engaged")
    )
    lost, found = (errors(tracker, flown, 76).position() for tracker in (at_once, waits))
    at_once, waiting = (math.sqrt((one[10:16] ** 2).mean()) for one in (lost, found))
    assert at_once > 2.0 * waiting
    assert waiting < 100.0  # a plot has 141 m
    rng = np.random.default_rng(76)
    begun = prior(flown, rng)
    epochs = list(follow(waits, record(flown, rng), begun, start=0.0))
    for law, free, evidence, _ in (epoch.state for epoch in epochs):
        alike = (law.gaussian.mean == free.gaussian.mean).all(axis=0)
        assert alike[evidence == 0.0].all()  # the rival starts anew
        assert not alike[evidence > 0.0].any()
    engaged = np.array([epoch.state.engaged for epoch in epochs])
    assert engaged[16].mean() <= 0.2
    assert engaged[54].mean() >= 0.8
    assert engaged[70].mean() <= 0.2


def test_begins_is_one_of_two_words():
    with pytest.raises(ValueError, match="begins is 'at once' or 'engaged', not 'later'"):
        SaturatedControl(NOMINAL, ONE_LEG, PLANE, begins="later")


def test_the_alert_of_an_armed_law_waits_until_the_law_is_believed():
    """Against the law from the first look: no alarm before it has been more probable than not for 40 s on end."""
    tracker = SimpleNamespace(
        intents=("route law", "armed", "manual"), switched=lambda probabilities, dt, mean: probabilities
    )
    looks = [(1.0, 9.0, 1.0)] * 5 + [(9.0, 1.0, 1.0)] * 21 + [(1.0, 9.0, 1.0)] * 6
    weights = np.cumprod(np.array(looks), axis=0)
    weights /= weights.sum(axis=1, keepdims=True)
    made = SimpleNamespace(
        time=4.0 * np.arange(len(looks)), model_probabilities=weights[:, :, None], mean=weights[:, :, None]
    )
    watched = ConformanceTest(100.0).watch(tracker, made)
    believed = watched.belief["route law"][:, 0] > 0.5
    assert believed.tolist() == [False] * 10 + [True] * 22
    assert not watched.alarm[:19].any()
    assert (watched.sum[:19] == 0.0).all()
    assert watched.alarm[28, 0]
    always = SimpleNamespace(intents=("route law", "manual", "manual"), switched=tracker.switched)
    assert ConformanceTest(100.0).watch(always, made).alarm[4, 0]
