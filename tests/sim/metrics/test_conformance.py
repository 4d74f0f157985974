"""The conformance alert: Page's test against likelihoods worked out by hand, and flights that are left on purpose."""

from __future__ import annotations

import math
from types import SimpleNamespace

import numpy as np
import pytest

import sim
from sim.cli.explain import explain
from sim.errors import ScenarioError
from sim.estimation.setup import build
from sim.flight.preparation import prepare
from sim.metrics.conformance import conformance_sentence, figures
from sim.scenario.reading import read
from tracking.conformance import CONFORMANCE, ConformanceTest

INTENTS = ("route law", "route law", "beacon law", "manual")


class Frozen:
    """Four hypotheses that nothing ever switches between, so that only likelihoods move their probabilities."""

    intents = INTENTS

    def switched(self, probabilities, dt, mean):
        return probabilities


def record(likelihoods):
    """The probabilities by Bayes' rule from a likelihood of each hypothesis at each look (k, 4)."""
    weights = np.cumprod(np.array(likelihoods, float), axis=0)
    weights /= weights.sum(axis=1, keepdims=True)
    return SimpleNamespace(
        time=np.arange(1.0, len(weights) + 1.0), model_probabilities=weights[:, :, None], mean=weights[:, :, None]
    )


def test_the_sum_is_the_log_likelihood_ratio_since_it_last_spoke_for_the_told_law():
    """Two looks for the law (floor at zero), then three against it by a factor of 4 each."""
    looks = [(4, 4, 1, 1)] * 2 + [(1, 1, 4, 4)] * 3
    watched = ConformanceTest(looks_between_false_alarms=50.0).watch(Frozen(), record(looks))
    np.testing.assert_allclose(watched.sum[:, 0], np.log([1.0, 1.0, 4.0, 16.0, 64.0]), atol=1e-12)
    assert watched.alarm[:, 0].tolist() == [False, False, False, False, True]
    assert watched.limit == pytest.approx(math.log(50.0))


def test_hypotheses_of_one_intent_are_one():
    """What moves the weight from one limit of the law to another says nothing about the law."""
    watched = CONFORMANCE.watch(Frozen(), record([(9, 1, 5, 5), (9, 1, 5, 5)]))
    assert watched.belief["route law"][0, 0] == pytest.approx(0.5)
    # by the second look the law's weight lies nine to one on the limit that fits: 82 / 10 against 5
    assert watched.sum[1, 0] == pytest.approx(max(0.0, math.log(5.0 / (82.0 / 10.0))))


def test_an_alarm_stands_until_the_law_is_believed_again():
    looks = [(1, 1, 100, 100)] + [(3, 3, 1, 1)] * 5 + [(1, 1, 1, 1)]
    watched = ConformanceTest(looks_between_false_alarms=20.0).watch(Frozen(), record(looks))
    assert watched.alarm[:, 0].tolist() == [True, True, False, False, False, False, False]
    believed = watched.belief["route law"][:, 0]
    assert believed[3] < 0.5 < believed[5]
    lasting = ConformanceTest(looks_between_false_alarms=2.0).watch(Frozen(), record(looks))
    assert lasting.alarm[:4, 0].all()
    assert lasting.sum[5, 0] == 0.0


def test_while_the_law_is_flown_alarms_are_rarer_than_stated():
    """Looks drawn from the assumed law's own density against a shifted one, forgotten at an even rate: 400 x 400 looks.

    Page's bound says at most one alarm in 100 looks on average; a run of 400 looks then has four at most.
    """
    rng = np.random.default_rng(5)
    z = rng.standard_normal((400, 400))
    density = np.stack([np.exp(-0.5 * (z - shift) ** 2) for shift in (0.0, 0.0, 1.0, 1.0)], axis=1)

    class Switching(Frozen):
        def switched(self, probabilities, dt, mean):
            return 0.98 * probabilities + 0.02 / 4

    weights, before = [], np.full((4, 400), 0.25)
    for look in density:
        after = before * look
        weights.append(after / after.sum(axis=0))
        before = Switching().switched(weights[-1], 1.0, None)
    made = SimpleNamespace(time=np.arange(400.0), model_probabilities=np.array(weights), mean=np.zeros(400))
    watched = ConformanceTest(looks_between_false_alarms=100.0).watch(Switching(), made)
    begun = np.diff(watched.alarm.astype(int), axis=0) == 1
    assert 0.1 < begun.sum(axis=0).mean() <= 4.0


def test_a_lost_draw_is_an_alarm():
    made = record([(1, 1, 1, 1)] * 3)
    made.model_probabilities[1:] = np.nan
    assert CONFORMANCE.watch(Frozen(), made).alarm[:, 0].tolist() == [False, False, True]


def test_delays_count_from_the_departure_and_alarms_before_it_are_false():
    """Draw 0 answers after 2 s, draw 1 alarms too early and again after 3 s, draw 2 never."""
    against, none = (1, 1, 1e4, 1e4), (1, 1, 1, 1)
    time = np.arange(1.0, 9.0)
    sums = np.zeros((8, 3))
    sums[5:, 0] = 10.0
    sums[1, 1] = sums[6:, 1] = 10.0
    watched = CONFORMANCE.watch(Frozen(), record([against, none]))._replace(
        time=time, sum=sums, belief={"route law": np.full((8, 3), 0.1), "manual": np.full((8, 3), 0.9)}
    )
    found = figures(watched, 4.0)
    assert found["false_alarm_fraction"] == pytest.approx(1 / 3)
    assert found["detected_fraction"] == pytest.approx(2 / 3)
    assert found["delay_s"]["p5"] == pytest.approx(2.05)
    assert found["delay_s"]["p95"] == pytest.approx(2.95)
    assert found["alarm_fraction"] == pytest.approx(2 / 3)
    words = conformance_sentence("mine", found)
    assert "was left at 4 s; alarm after 2 s (median) in 67% of the draws, 33.3% before; most likely: manual" in words
    flown = figures(watched, None)
    assert flown["departure_s"] is None
    assert flown["false_alarm_fraction"] == pytest.approx(2 / 3)


# ---- flights that are left on purpose ----------------------------------------------------------------------------

POINT_MASS = {"aircraft": {"model": "point_mass"}, "checks": []}


def told(scenario, departures, **changes):
    """What `intent_imm` says of a flight of the default radars, 20 draws."""
    trackers = {"intent_imm": {"kind": "intent_imm"}}
    overrides = {**POINT_MASS, "trackers": trackers, "departures": departures, **changes}
    result = sim.run(scenario, overrides=overrides, seed=8, draws=20)
    return result, result.metrics["trackers"]["intent_imm"]["conformance"]


def test_a_flight_on_the_law_is_left_in_peace():
    _, found = told("an26_departure", [], until_s=200.0)
    assert found["alarm_fraction"] <= 0.05  # 1 % of whole approaches at full size
    assert found["departure_s"] is None


def test_hands_on_the_wheel_are_noticed_and_so_is_their_end():
    """10 deg of bank for 10 s part at 18 m/s: three standard deviations of a plot after 20 s."""
    departures = read("an26_departure").tables["departures"]
    result, found = told("an26_departure", departures, until_s=155.0)
    assert found["detected_fraction"] == 1.0
    assert found["false_alarm_fraction"] == 0.0
    assert 8.0 <= found["delay_s"]["p50"] <= 32.0
    assert max(found["believed_at_alarm"], key=found["believed_at_alarm"].get) == "manual"
    (left, level, back) = [event for event in result.flight.events if event.name == "departure"]
    assert (left.time, level.time, back.time) == (60.0, 70.0, 110.0)
    assert left.detail == "flown by hand, 10 deg to the left"
    assert abs(result.flight.deviation.cross_track[-1]) < 50.0  # the law has brought it back
    tracker, _ = build(result.prepared, "intent_imm", result.scenario.trackers["intent_imm"])
    watched = CONFORMANCE.watch(tracker, result.tracks["intent_imm"].track)
    assert not watched.alarm[-1].any()


def test_the_beacon_law_is_told_from_the_route_law():
    departures = [{"at_s": 0.0, "flies": "beacon"}]
    _, found = told("an26_wrong_mode", departures, until_s=150.0)
    assert found["detected_fraction"] >= 0.9
    assert found["believed_at_alarm"]["beacon law"] > 0.6


def test_an_offset_is_noticed():
    _, found = told("an26_departure", [{"at_s": 60.0, "flies": "offset", "offset_m": 300.0}], until_s=150.0)
    assert found["detected_fraction"] == 1.0
    assert found["delay_s"]["p50"] <= 40.0


def test_explain_tells_what_trackers_are_not_told():
    told_so = explain(read("an26_departure", POINT_MASS))
    assert "60                    flown by hand, 10 deg to the left" in told_so
    assert "70                    flown by hand, wings level" in told_so
    assert "110                   the route law flies" in told_so


@pytest.mark.parametrize(
    ("departure", "said"),
    [
        ({"at_s": -1.0, "flies": "beacon"}, r"\[\[departures\]\] entry 0 at_s: must be at least 0"),
        ({"at_s": 1.0, "flies": "bank"}, 'bank belongs to flies = "bank"'),
        ({"at_s": 1.0, "flies": "beacon", "bank_deg": 3.0}, 'bank belongs to flies = "bank"'),
        ({"at_s": 1.0, "flies": "bank", "bank_deg": 75.0}, "bank_deg: must be at (least -60|most 60)"),
        ({"at_s": 1.0, "flies": "home"}, "flies"),
        ({"at_s": 1.0, "flies": "offset", "offset_m": float("nan")}, "offset"),
    ],
)
def test_a_departure_that_cannot_be_is_refused_in_one_sentence(departure, said):
    with pytest.raises(ScenarioError, match=said) as caught:
        prepare(read("an26_departure", {**POINT_MASS, "departures": [departure]}))
    assert str(caught.value).count("\n") == 0
