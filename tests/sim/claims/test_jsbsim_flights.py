"""Flights of the ledger: drawn by the seed, shared, and each counted once."""

from __future__ import annotations

import numpy as np
import pytest

from sim.claims import jsbsim_flights
from sim.claims.jsbsim_flights import WIND, flights, per_flight, root_mean, side_by_side

SCENARIO = "vasylyev2003_jsbsim"
RANGES = (("start.cross_track_m", 4000.0, 6000.0), *WIND)


@pytest.fixture
def asked(monkeypatch):
    """What would be flown."""
    monkeypatch.setattr(jsbsim_flights, "flown", lambda name, *changes: (name, dict(changes)))
    return lambda seed, count, *changes: flights(SCENARIO, seed, count, RANGES, *changes)


def test_a_flight_hangs_on_its_seed_and_number_alone(asked):
    few, many = asked(7, 2), asked(7, 5)
    assert many[:2] == few
    assert len({str(flight) for flight in many}) == 5
    assert asked(8, 2)[0] != few[0]
    changed = asked(7, 2, ("until_s", 5.0))
    assert [values | {"until_s": 5.0} for _, values in few] == [values for _, values in changed]


def test_values_fill_their_ranges(asked):
    drawn = [values for _, values in asked(1, 200)]
    for key, low, high in RANGES:
        values = np.array([one[key] for one in drawn])
        assert low <= values.min() < low + 0.05 * (high - low)
        assert high - 0.05 * (high - low) < values.max() <= high


def test_the_same_flights_are_flown_once():
    short = ("until_s", 2.0)
    first, second = flights(SCENARIO, 3, 2, RANGES, short)
    assert flights(SCENARIO, 3, 2, RANGES, short)[1] is second
    beside = [flight.state.east[0] for flight in (first, second)]
    assert 4000.0 <= min(beside) < max(beside) <= 6000.0


def test_a_flight_counts_once_however_many_draws_it_has():
    generator = np.random.default_rng(1)
    each = np.array([1.0, 2.0, 9.0])
    few, many = (np.repeat(each, n) * (1.0 + 0.01 * generator.standard_normal(3 * n)) for n in (2, 2000))
    assert per_flight(many, 3) == pytest.approx(each, rel=0.01)
    narrow, wide = root_mean(many, 3), root_mean(few, 3)
    assert narrow.runs == wide.runs == 3
    assert narrow.value == pytest.approx(2.0, rel=0.01)
    assert narrow.high / narrow.low == pytest.approx(wide.high / wide.low, rel=0.05)
    assert per_flight([[1.0, np.nan, 4.0, 6.0]], 2).tolist() == [[1.0, 5.0]]


def test_the_interval_over_few_flights_holds_as_often_as_it_says():
    """Six flights whose mean squares spread by a half, as they do: a thousand rows, 95 % within three deviations."""
    generator = np.random.default_rng(2)
    found = [root_mean(generator.gamma(4.0, 0.25, 6), 6) for _ in range(1000)]
    share = np.mean([interval.contains(1.0) for interval in found])
    assert 0.92 <= share <= 0.97


def test_flights_of_different_length_stand_side_by_side():
    both = side_by_side([np.ones((2, 3)), np.zeros((4, 3))])
    assert both.shape == (4, 3, 2)
    assert np.isnan(both[2:, :, 0]).all()
    assert not both[:, :, 1].any()
