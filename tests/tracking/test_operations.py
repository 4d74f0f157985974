"""Operation counts against the printed formulas and an independent hand count."""

import numpy as np
import pytest

from tracking.gaussian import Gaussian, merge
from tracking.measurement import LinearMeasurement
from tracking.motion import ConstantVelocity, CoordinatedTurn
from tracking.operations import (
    FUNCTION,
    Bank,
    Number,
    Operations,
    Tally,
    charged_inverse,
    counted,
    counted_interacting,
    counted_inverse,
    full_filter_operations,
    interacting,
    memory,
    numbers,
    saving,
    stored_gain_operations,
    values,
)
from tracking.trackers.elevation import Model
from tracking.trackers.imm import InteractingMultipleModel, ModelSet

SIZES = [(n, m) for n in (1, 2, 3, 4) for m in (1, 2, 3)]


@pytest.mark.parametrize(("n", "m"), SIZES)
def test_counted_operations_are_the_printed_polynomials(n, m):
    assert counted(1, n, m) == full_filter_operations(n, m)
    assert counted(4, n, m) == stored_gain_operations(n, m)


def test_elevation_filter_costs_what_is_printed():
    assert counted(1, 2, 1) == (45, 31)
    assert counted(4, 2, 1) == (8, 6)
    assert saving(2, 1) == (pytest.approx(0.8222, abs=5e-5), pytest.approx(0.8065, abs=5e-5))


@pytest.mark.parametrize(("n", "m", "joseph"), [(2, 1, (50, 34)), (3, 2, (177, 141))])
def test_a_free_gain_does_not_make_the_joseph_form_cheaper(n, m, joseph):
    assert counted(2, n, m) == joseph
    assert counted(2, n, m).multiplications > counted(1, n, m).multiplications
    assert counted(2, 3, 3).multiplications < counted(1, 3, 3).multiplications  # it is from m = n up


def test_inversion_is_charged_by_the_print_and_counted_beside_it():
    charged, really = counted(1, 2, 1), counted(1, 2, 1, counted_inverse)
    assert charged == Operations(really.multiplications, really.additions + 1)  # 1 / s needs no addition
    tally = Tally()
    counted_inverse(numbers(np.eye(4) + 0.1, tally))
    assert tally.multiplications == 4**3  # n^3 in place; one of them per column is the division by the pivot
    assert tally.additions == 4 * 3 * 4  # n rows, each cleared in n - 1 others, n entries
    charged_inverse(numbers(np.eye(4) + 0.1, tally := Tally()))
    assert tally.total() == (64, 64)


def test_counting_inverse_inverts():
    A = np.random.default_rng(1).standard_normal((4, 4))
    S = A @ A.T + np.eye(4)
    np.testing.assert_allclose(values(counted_inverse(numbers(S, Tally()))) @ S, np.eye(4), atol=1e-13)


def test_numbers_count_every_operation_once():
    tally = Tally()
    a, b = numbers(np.array([2.0, 3.0]), tally)
    assert [(a * b).value, (a / b).value, (2.0 * a).value, (1.0 / b).value] == [6.0, 2 / 3, 4.0, 1 / 3]
    assert [(a + b).value, (a - b).value, (1.0 + a).value, (1.0 - a).value] == [5.0, -1.0, 3.0, -1.0]
    assert tally.total() == (4, 4)


def test_stored_gains_cost_memory():
    """The print asks for accuracy against the volume of resources: what realisation 4 saves in time it takes in ROM."""
    assert memory(1, 2, 1) == (4 + 4 + 2 + 1, 2 + 4)
    assert memory(4, 2, 1, gains=3239) == (4 + 2 + 2 * 3239, 2)
    assert memory(4, 2, 1, gains=200).rom == 406  # cut where the gain has settled
    assert memory(2, 2, 1, gains=1) == (11 + 2, 6)
    assert memory(3, 2, 1) == memory(1, 2, 1)


def test_there_are_four_realisations():
    for function in (counted, memory):
        with pytest.raises(ValueError, match="1, 2, 3 or 4"):
            function(5, 2, 1)


def test_functions_are_charged_as_polynomials_and_comparisons_as_subtractions():
    tally = Tally()
    number = Number(4.0, tally)
    assert np.sqrt(number).value == 2.0
    assert np.exp(number).value == pytest.approx(np.exp(4.0))
    assert tally.total() == (2 * FUNCTION, 2 * FUNCTION)
    assert number > 3.0
    assert not number > number
    assert tally.total() == (2 * FUNCTION, 2 * FUNCTION + 2)


def test_the_cycle_that_is_counted_is_the_one_of_the_tracker():
    models = (CoordinatedTurn(-0.045, 0.1), CoordinatedTurn(0.02, 0.3), ConstantVelocity(0.01))
    switching = ((0.9, 0.08, 0.02), (0.3, 0.6, 0.1), (0.0, 0.25, 0.75))
    H, R, z = np.eye(4)[[0, 2]], np.diag([400.0, 900.0]), np.array([40.0, -25.0])
    prior = Gaussian(np.array([0.0, 60.0, 10.0, -20.0]), np.diag([900.0, 25.0, 900.0, 25.0]))
    tracker = InteractingMultipleModel(
        LinearMeasurement(tuple(map(tuple, H))), ModelSet(models, switching, (0.5, 0.3, 0.2))
    )
    judge = tracker.begin(prior)
    bank = Bank(*(numbers(part, Tally()) for part in (judge.weights, judge.mean.T, np.moveaxis(judge.cov, -1, 0))))
    matrices = [Model(*model.transition(0.7, None)[:2], H, R) for model in models]
    for _ in range(3):
        bank, mean, cov = interacting(bank, np.array(switching), matrices, z, counted_inverse)
        judge, _ = tracker.step(judge, 0.7, z, R)
    merged = merge(tracker.estimate(judge))
    for ours, his in ((bank.weights, judge.weights), (mean, merged.mean), (cov, merged.cov)):
        np.testing.assert_allclose(values(ours), his, rtol=1e-9, atol=1e-9)


@pytest.mark.parametrize("count", [1, 2, 3, 5])
def test_operations_of_interacting_models_by_hand(count):
    """Mixing and merging of M means and covariances of n states, M filters, M likelihoods of two channels, weights."""
    n, m, one = 4, 2, full_filter_operations(4, 2)
    moments = Operations(count * (n + 2 * n * n), (2 * count - 1) * (n + n * n))
    density = Operations(  # form, half, determinant, constant, ...; a root and an exponential
        m * m + m + 1 + 3 + 1 + 1 + 2 * FUNCTION, m * m - 1 + 1 + 2 * FUNCTION
    )
    weights = Operations(2 * count * count + 2 * count, count * (count - 1) + count - 1)
    by_hand = (count * (a + b + c) + a + d for a, b, c, d in zip(moments, one, density, weights, strict=True))
    assert counted_interacting(count, n, m) == Operations(*by_hand)
