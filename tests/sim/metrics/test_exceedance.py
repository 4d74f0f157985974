"""How often flights go beyond limits, and intervals that cover what they say they cover."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.stats import binomtest, norm

from sim.metrics.ensemble.exceedance import answer, any_beyond, distribution, exceedances, interval
from sim.metrics.ensemble.verdict import verdicts
from sim.scenario.tables import Check

FLIGHTS = 200


def records(values):
    """One flight for each sink, judged against 3 m/s; None = no touchdown."""
    return [
        {
            "flight": number,
            "metrics": {"outcome": "landed", "touchdown": None if value is None else {"sink_mps": value}},
            "checks": [
                {"value": value, "limit": 3.0, "margin": None if value is None else 3.0 - value, "time_s": None}
                | {"passed": value is not None and value <= 3.0}
            ],
        }
        for number, value in enumerate(values)
    ]


def sink(**asked):
    return Check("touchdown.sink_mps", max=3.0, name="sink", **asked)


@pytest.mark.parametrize(("count", "flights"), [(0, 50), (1, 1000), (7, 20), (20, 20)])
def test_the_interval_is_the_exact_one(count, flights):
    theirs = binomtest(count, flights).proportion_ci(0.95, method="exact")
    assert interval(count, flights) == pytest.approx((theirs.low, theirs.high), abs=1e-12)


def test_intervals_cover_a_known_probability():
    """Normal sinks of which exactly 2 % are beyond the limit: exact intervals cover it at least as often as they say.

    3,000 repeats: three standard deviations of a share of 95 % are 1.2 points.
    """
    generator, true, repeats = np.random.default_rng(3), 0.02, 3000
    limit = norm.isf(true)
    beyond = (generator.standard_normal((repeats, FLIGHTS)) > limit).sum(axis=1)
    low, high = interval(beyond, FLIGHTS)
    assert ((low <= true) & (true <= high)).mean() >= 0.95 - 0.012
    _, upper = interval(beyond, FLIGHTS, 0.9)
    assert (true <= upper).mean() >= 0.95 - 0.012
    assert np.median(high) < 0.06  # and they are no wider than that many flights leave them


def test_the_tail_of_a_known_distribution_is_covered_at_each_value():
    generator, covered = np.random.default_rng(4), []
    for _ in range(100):
        found = distribution("touchdown.sink_mps", records(generator.standard_normal(FLIGHTS)), [sink()])
        at = np.searchsorted(found.above.value, 1.5, side="right") - 1  # a step holds until the next value
        covered.append(found.above.low[at] <= norm.sf(1.5) <= found.above.high[at])
    assert np.mean(covered) >= 0.95 - 3 * np.sqrt(0.95 * 0.05 / 100)


def test_both_tails_count_flights_without_the_figure_and_reach_the_limits():
    asked = [sink(probability_max=0.01, confidence=0.9), Check("touchdown.sink_mps", min=-1.0)]
    found = distribution("touchdown.sink_mps", records([1.0, 2.0, 3.0, 4.0, None]), asked)
    assert (found.flights, found.without) == (5, 1)
    assert found.above.value.tolist() == [3.0, 4.0]
    assert found.above.share.tolist() == [0.4, 0.2]
    assert found.below.value.tolist() == [2.0, 1.0, -1.0]
    assert found.below.share.tolist() == [0.4, 0.2, 0.2]
    assert found.limits_above[0].probability == pytest.approx(0.01)
    assert found.limits_below[0] == (-1.0, None)


def test_a_figure_that_no_flight_has_is_an_empty_distribution():
    found = distribution("touchdown.sink_mps", records([None, None]), [sink()])
    assert (found.without, found.distinct, len(found.above.value)) == (2, 0, 0)


def test_the_answer_counts_flights_once_and_names_what_they_broke():
    judged = records([1.0] * 97 + [3.5, 4.0, None])
    (found,) = exceedances(verdicts((sink(probability_max=0.1, confidence=0.9),), judged))
    assert (found["beyond"], found["flights"], found["probability"]) == (3, 100, 0.03)
    assert found["below"] == pytest.approx(binomtest(3, 100).proportion_ci(0.8, method="exact").high)
    metrics = {"flights": 100, "any_beyond": any_beyond(judged), "exceedances": [found]}
    assert answer(metrics) == "3 of 100 flights beyond a limit: 3 %, below 7.6 % with 95 % confidence; broken: sink (3)"
    none = {"flights": 1000, "any_beyond": 0, "exceedances": []}
    five = {**metrics, "any_beyond": 5, "flights": 1000, "exceedances": []}
    assert "0.5 %, below 1.1 % with" in answer(five)  # 1.048 %, which is not below 1 %
    assert answer(none) == "0 of 1000 flights beyond a limit: below 0.3 % with 95 % confidence"  # 1 - 0.05^(1/1000)
