"""The ledger's rows on Volovyk 2018: motion without disturbances, initial values, printed noises, word length."""

from __future__ import annotations

import numpy as np
import pytest

from sim.claims.manoeuvre_variance import PRINTED, SLIPS, angular_variance, slips_that_give
from sim.claims.papers.volovyk2018 import experiment
from sim.claims.papers.volovyk2018.experiment import FILTERS, JSBSIM, UNIFORM, UNIFORM_WIDE, over_theory, schedule
from sim.claims.papers.volovyk2018.initial_values import (
    APPROACH,
    INITIAL,
    LEVEL,
    RANGES,
    TOGETHER,
    angles,
    nearest_place,
)
from sim.claims.papers.volovyk2018.word_length import CASES, DOUBLE, SINGLE, Case, squares, store
from sim.claims.verdict import number
from tracking.trackers.elevation import PERIOD

SEED = 3


def test_motion_without_disturbances_is_uniformly_accelerated():
    F, Q = FILTERS[UNIFORM].transition(PERIOD)
    assert pytest.approx(np.array([[1.0, PERIOD, PERIOD**2 / 2], [0.0, 1.0, PERIOD], [0.0, 0.0, 1.0]]), rel=1e-7) == F
    assert not Q.any()


def test_far_out_it_is_as_accurate_as_it_says_and_uniform_motion_is_not():
    accelerated, wide, uniform = (
        over_theory(name, distance=10e3)(SEED, 40).value for name in (UNIFORM, UNIFORM_WIDE, "no manoeuvre noise")
    )
    assert 0.8 < accelerated < 1.2
    assert 0.8 < wide < 1.2
    assert uniform > 2.0
    _, _, believed = schedule(400)
    place = list(FILTERS).index
    assert believed[-1, place(UNIFORM_WIDE)] > believed[-1, place(UNIFORM)]


def test_flights_of_unequal_length_count_once_each_and_only_as_far_as_they_go(monkeypatch):
    longer = np.radians(0.8) * np.ones((600, 1))
    distance = np.linspace(15e3, 11e3, 600)[:, None]

    def made(seed, count):
        short = np.where(np.arange(600)[:, None] < 500, 1.0, np.nan)
        return experiment.Legs(
            np.hstack([longer, short * longer]), np.hstack([distance, short * distance]), np.zeros(2)
        )

    monkeypatch.setattr(experiment, "flown_legs", made)
    found = over_theory("no manoeuvre noise", JSBSIM, 10e3)(SEED, 2)
    assert found.runs == 2
    assert 0.8 < found.value < 1.2  # nothing moves, so it is what it believes
    nearer = experiment.mean_squares("no manoeuvre noise", JSBSIM, SEED, 2, distance=11.6e3)
    assert (nearer != experiment.mean_squares("no manoeuvre noise", JSBSIM, SEED, 2)).tolist() == [True, False]


def test_every_initial_value_holds_in_the_printed_ranges_and_all_three_below_the_printed_height():
    printed = [number(text) for text in ("0.7", "0.0122", "0.0002")]
    for derivative in TOGETHER:
        found = angles(*nearest_place((derivative,), LEVEL))[derivative]
        assert found == pytest.approx(INITIAL[derivative], rel=1e-6)
    together = nearest_place(TOGETHER, APPROACH)
    assert angles(*together) == pytest.approx(INITIAL, rel=1e-5)
    for value, (low, high) in zip(together, (*RANGES, APPROACH), strict=True):
        assert low - 1e-9 <= value <= high + 1e-9
    at_the_printed_height = angles(*nearest_place(TOGETHER, LEVEL))
    assert at_the_printed_height[0] > printed[0].high
    assert at_the_printed_height[1] < printed[1].low


@pytest.mark.parametrize("height", [61.0, 77.0, 93.0])
def test_where_all_three_lie_together_follows_from_the_formulas(height):
    """beta = H / D, beta' = beta V / D, beta'' = beta (2 (V / D)^2 - a / D): the height decides distance and speed."""
    angle, rate, acceleration = np.radians(INITIAL)
    distance = height / np.tan(angle)
    square = distance**2 + height**2
    speed = rate * square / height
    # the square of the distance to the beacon, not of the distance along the ground, as in the second derivative
    slower = (2.0 * height * speed**2 * distance / square - acceleration * square) / height
    assert angles(distance, speed, slower, height) == pytest.approx(INITIAL, rel=1e-9)
    for value, (low, high) in zip((distance, speed, slower), RANGES, strict=True):
        assert 0.99 * low <= value <= 1.01 * high  # heights are told in metres


def test_each_printed_noise_has_its_slip_and_no_slip_gives_two():
    given = [{(text, d) for text, d in PRINTED if number(text).side(slip(d)) == 0} for slip in SLIPS.values()]
    assert [len(one) for one in given] == [1, 1, 1, 1]
    assert set.union(*given) == set(PRINTED)
    assert [slips_that_give(slip) for slip in SLIPS.values()] == [1.0] * 4
    for across in (False, True):
        assert slips_that_give(lambda distance, across=across: angular_variance(distance, 200.0, across)) == 0.0


def test_a_word_rounds_to_its_last_digit_and_saturates():
    keep = store(np.ones(len(CASES)))
    place = next(i for i, case in enumerate(CASES) if case.digits == 7)
    values = np.linspace(-2.0, 2.0, 401)[:, None] * np.ones(len(CASES))
    stored = keep(values)[:, place]
    inside = np.abs(values[:, place]) < 127 / 128
    assert np.abs(stored - values[:, place])[inside].max() == pytest.approx(0.5 / 128, rel=0.3)
    assert (stored.min(), stored.max()) == (-1.0, 127 / 128)


def test_single_precision_costs_nothing_and_eight_bits_lose_the_filter_without_noise():
    found = squares(SEED, 4)
    for realisation in (1, 4):
        double = found[Case(UNIFORM, realisation, DOUBLE)].mean()
        assert found[Case(UNIFORM, realisation, SINGLE)].mean() == pytest.approx(double, rel=1e-2)
        assert found[Case(UNIFORM, realisation, 7)].mean() > 2.0 * double
    for digits in (SINGLE, 23):
        assert found[Case("as published", 4, digits)] == pytest.approx(found[Case("as published", 4, DOUBLE)], rel=1e-3)
    both = [found[Case("as published", realisation, DOUBLE)] for realisation in (1, 4)]
    assert both[0] == pytest.approx(both[1], rel=1e-12)  # a stored gain is the full filter
