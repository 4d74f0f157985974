"""Approaches of Vasylyev 2003: what is lost, where no limit acts, and what the filters are told of a flight."""

from __future__ import annotations

import numpy as np
import pytest

from sim.claims.jsbsim_flights import flown
from sim.claims.ledger import DRAWS
from sim.claims.papers.vasylyev2003 import approaches
from sim.claims.papers.vasylyev2003.approaches import POINT_MASS, SCENARIO, TURNS, Approach

SCANS = 30


def made(linear: float = 4.0, saturated: float = 4.0, outside: int = 0) -> Approach:
    """Fifteen scans of downwind without limits, fifteen in a turn under them, some outside for half of the draws."""
    phase = np.array(["downwind"] * 15 + ["base_turn"] * 15)
    beyond = np.zeros((SCANS, DRAWS), bool)
    beyond[15 : 15 + outside, : DRAWS // 2] = True
    squares = {name: np.full((SCANS, DRAWS), value) for name, value in (("linear", linear), ("saturated", saturated))}
    return Approach(phase, phase == "downwind", squares, {"linear": beyond, "saturated": np.zeros_like(beyond)})


@pytest.mark.parametrize(("outside", "share"), [(9, 0.0), (10, 0.5)])
def test_a_run_is_lost_after_ten_scans_outside(outside, share):
    one = made(outside=outside)
    assert approaches.lost(one, "linear", TURNS["turn onto base"]) == share
    assert approaches.lost(one, "linear", ("downwind",)) == approaches.lost(one, "saturated", ("base_turn",)) == 0.0


@pytest.mark.parametrize(("linear", "share"), [(3.0, 0.5), (4.0, 0.5), (5.0, 0.0)])
def test_linear_feedback_is_adequate_where_no_limit_acts_and_it_is_no_worse(linear, share):
    assert approaches.no_worse(made(linear)).mean() == share


def test_errors_of_two_axes_are_set_beside_plots_of_two_axes():
    assert approaches.better_than_plots(made(1.9e4)).all()
    assert not approaches.better_than_plots(made(2.1e4)).any()


@pytest.fixture(scope="module")
def pattern():
    """The pattern of a point mass in still air, through its turn onto base."""
    return flown(SCENARIO, ("aircraft.model", POINT_MASS), ("until_s", 230.0))


def test_limits_act_in_turns_and_not_on_the_straight_before(pattern):
    free = approaches.unlimited(pattern)
    assert free[pattern.during("downwind")].mean() > 0.95  # what is left rolls into the turn
    assert free[pattern.during("base_turn")].mean() < 0.5


def test_what_is_lost_is_lost_in_the_turn(pattern):
    """Told the route, saturated control holds through the turn, and so does linear feedback before it."""
    one = approaches.followed(pattern, 1, 0)
    before, turn = one.phase == "downwind", one.phase == "base_turn"
    held = {name: np.sqrt(squares[before].mean()) for name, squares in one.squares.items()}
    assert max(held.values()) < 100.0  # plots have 141 m
    assert np.sqrt(one.squares["saturated"][turn].mean()) < 141.0
    assert not one.outside["saturated"].mean() > 0.05
