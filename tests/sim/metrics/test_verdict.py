"""The verdict over flights, judged by binomial sums and by flights whose results are given."""

from __future__ import annotations

import math

import numpy as np
import pytest
from scipy import stats

import sim
from sim.metrics.ensemble.trackers import over_flights
from sim.metrics.ensemble.verdict import (
    failures_allowed,
    fewest_flights,
    refuse_unfit,
    share_low,
    verdicts,
    worst_first,
)
from sim.scenario.tables import Check
from tests.capture import CAPTURE


def record(margin, number=0, limit=10.0, **more):
    """A flight whose one check has a margin; None = its phases were not flown."""
    passed = None if margin is None else margin >= 0
    value = None if margin is None else limit - margin
    result = {"limit": limit, "value": value, "margin": margin, "time_s": 1.0, "passed": passed}
    return {"flight": number, "metrics": {"outcome": "completed"}, "checks": [result], **more}


def records(*margins):
    return [record(margin, number) for number, margin in enumerate(margins)]


def verdict(given, **asked):
    (found,) = verdicts([Check("bank_deg", max=10.0, **asked)], given)
    return found


def test_any_flight_that_fails_fails_the_check_and_the_worst_is_named():
    found = verdict(records(1.0, -0.5, 2.0, -3.0))
    assert (found["passed"], found["flight"], found["value"], found["margin"]) == (False, 3, 13.0, -3.0)
    assert (found["flights"], found["within"], found["not_flown"]) == (4, 2, 0)
    kept = verdict(records(1.0, 0.25, 2.0))
    assert (kept["passed"], kept["flight"], kept["margin"]) == (True, 1, 0.25)


def test_a_flight_that_did_not_fly_the_phases_neither_keeps_nor_breaks_a_check():
    found = verdict(records(None, 1.0, None))
    assert (found["passed"], found["within"], found["not_flown"], found["flight"]) == (True, 1, 2, 1)
    assert verdict(records(None, -1.0))["passed"] is False
    none = verdict(records(None, None))
    assert (none["passed"], none["value"], none["limit"]) == (None, None, 10.0)
    assert verdict(records(None, None), share=0.5, confidence=0.5)["passed"] is None


def by_hand(kept, flights, share):
    """Probability that so many or more of the flights keep it where each does with the probability ``share``."""
    return sum(math.comb(flights, k) * share**k * (1 - share) ** (flights - k) for k in range(kept, flights + 1))


@pytest.mark.parametrize(("flights", "share", "confidence"), [(45, 0.95, 0.9), (93, 0.95, 0.95), (100, 0.8, 0.9)])
def test_a_share_passes_exactly_where_the_binomial_sum_says(flights, share, confidence):
    """So many kept are rarer than 1 - confidence if the share is as asked: only then is more than it shown."""
    for broken in range(flights + 1):
        margins = [-1.0 - i for i in range(broken)] + [1.0 + i for i in range(flights - broken)]
        found = verdict(records(*margins), share=share, confidence=confidence)
        assert found["passed"] is (by_hand(flights - broken, flights, share) <= 1 - confidence)
        assert (found["margin"] >= 0) is found["passed"]  # the flight that decides
        judge = stats.binomtest(flights - broken, flights).proportion_ci(2 * confidence - 1, "exact").low
        assert found["share_low"] == pytest.approx(judge, abs=1e-12)  # one-sided is two-sided at half the rest


def test_at_exactly_the_stated_share_at_most_one_in_ten_passes():
    generator = np.random.default_rng(20)
    passed = 0
    for _ in range(400):
        margins = np.where(generator.random(100) < 0.9, 1.0, -1.0)
        passed += verdict(records(*margins.tolist()), share=0.9, confidence=0.9)["passed"]
    exact = by_hand(100 - failures_allowed(100, 0.9, 0.9), 100, 0.9)
    assert exact <= 0.1
    assert passed / 400 <= 0.13
    assert abs(passed / 400 - exact) < 4 * math.sqrt(exact * (1 - exact) / 400)  # four standard errors


def test_59_good_flights_show_95_percent_with_95_percent_confidence():
    """Wilks's numbers: 59 without a failure, 93 with one, 124 with two."""
    assert fewest_flights(0.95, 0.95) == 59
    assert [failures_allowed(n, 0.95, 0.95) for n in (58, 59, 92, 93, 123, 124)] == [-1, 0, 0, 1, 1, 2]
    assert share_low(10, 10, 0.975) == pytest.approx(0.025 ** (1 / 10))  # closed form when all are good
    assert share_low(0, 10, 0.9) == 0.0


def test_a_probability_is_the_share_that_may_break():
    good = records(*[1.0] * 45)
    one, other = verdict(good, probability_max=0.05, confidence=0.9), verdict(good, share=0.95, confidence=0.9)
    assert one["share"] == pytest.approx(other["share"])
    assert one["passed"] is other["passed"] is True
    assert verdict(records(*[1.0] * 44), probability_max=0.05, confidence=0.9)["passed"] is False


def test_too_few_flights_with_the_phases_show_nothing():
    found = verdict(records(*[1.0] * 40, *[None] * 20), share=0.95, confidence=0.9)
    assert (found["passed"], found["within"], found["not_flown"]) == (False, 40, 20)


def test_every_cell_of_a_study_must_show_the_share():
    """90 good flights in one cell do not make up for the other, whose flights met the same air."""
    cells = [record(1.0, n, cell=0) for n in range(50)] + [record(1.0 if n > 5 else -1.0, n, cell=1) for n in range(50)]
    found = verdict(cells, share=0.95, confidence=0.9)
    assert (found["passed"], found["flights"], found["within"]) == (False, 50, 44)
    assert verdict(cells[:50], share=0.95, confidence=0.9)["passed"] is True


@pytest.mark.parametrize(
    ("check", "said"),
    [
        ({"share": 0.9}, "has a share and no confidence: say one, such as 0.9"),
        ({"probability_max": 0.01}, "has a probability_max and no confidence"),
        ({"confidence": 0.9}, "has a confidence and no share"),
        ({"share": 0.9, "probability_max": 0.1, "confidence": 0.9}, "has 'share' and 'probability_max': say one"),
        ({"share": 1.0, "confidence": 0.9}, "share: must be below 1 (got 1.0)"),
        ({"share": 0.9, "confidence": 90.0}, "confidence: must be below 1 (got 90.0)"),
    ],
)
def test_half_of_a_share_is_one_sentence(check, said):
    with pytest.raises(sim.ScenarioError) as caught:
        sim.read({**CAPTURE, "checks": [{"metric": "bank_deg", "max": 1.0, **check}]})
    assert said in str(caught.value)
    assert len(str(caught.value).splitlines()) == 1


def test_too_few_flights_are_refused_before_anything_flies():
    check = Check("bank_deg", name="b", max=1.0, probability_max=1e-2, confidence=0.9)
    with pytest.raises(sim.ScenarioError) as caught:
        refuse_unfit("s", [check], 50, [])
    assert str(caught.value) == (
        "s: [[checks]] entry 0 ('b'): 99 % with 90 % confidence needs at least 230 flights, there are 50: "
        "none broken of 50 says only below 4.5 %"
    )
    refuse_unfit("s", [check], 230, [])


def test_the_worst_flight_comes_first():
    given = records(2.0, -1.0, 0.5, -4.0)
    given.append({"flight": 4, "metrics": {"outcome": "crashed"}, "checks": []})
    given.append({**record(3.0, 5), "metrics": {"outcome": "orbit"}})
    assert [one["flight"] for one in worst_first(given)] == [4, 3, 1, 5, 2, 0]


def test_trackers_over_flights_by_arithmetic():
    def tracker(rmse, raw, gain, anees, lost, early):
        channel = {"rmse": rmse, "low": 1.0, "high": 2.0, "raw": raw, "gain": gain}
        look = {"20_s": {"position_m": rmse}}
        alert = {"told": "route", "alarm_fraction": lost, "alarm_time_s": None if early is None else {"p50": early}}
        return {
            "kind": "kalman", "law_from": None, "overall": {"position_m": channel}, "by_phase": {}, "anees": anees,
            "look_ahead": look, "lost_fraction": lost, "lost_time_s": early, "conformance": alert,
        }  # fmt: skip

    given = [tracker(3.0, 6.0, 2.0, 1.0, 0.0, None), tracker(4.0, 8.0, 1.0, 2.0, 0.5, 30.0), {}]
    kept = [{"metrics": {"trackers": {"t": one} if one else {}}} for one in given]
    found = over_flights([*kept, {"metrics": {"outcome": "crashed"}}])["t"]
    assert found["overall"]["position_m"]["rmse"] == pytest.approx(math.sqrt(12.5))
    assert found["overall"]["position_m"]["raw"] == pytest.approx(math.sqrt(50))
    assert found["overall"]["position_m"]["gain"] == pytest.approx(math.sqrt(50 / ((6 / 2) ** 2 / 2 + 8**2 / 2)))
    assert found["look_ahead"]["20_s"]["position_m"] == pytest.approx(math.sqrt(12.5))
    half = stats.t.ppf(0.975, 1) * 0.5  # two samples: standard error 0.5
    assert (found["anees"], found["anees_low"]) == (1.5, pytest.approx(1.5 - half))
    assert (found["lost_fraction"], found["lost_time_s"]) == (0.25, 30.0)
    assert found["conformance"] == {"told": "route", "alarm_fraction": 0.25, "alarm_time_s": {"p50": 30.0}}
    assert (found["kind"], found["law_from"]) == ("kalman", None)
