"""Robustness margins of checks against rtamt's signal temporal logic, on random signals."""

from __future__ import annotations

import warnings

import numpy as np
import pytest

from sim.metrics.checks import evaluate_checks
from sim.scenario.tables import Check, Runway

STEP = 1 / 30


@pytest.fixture(scope="module")
def rtamt():
    """The judge; its parser uses what newer Pythons warn of, and lack from 3.13 on."""
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", DeprecationWarning)
        return pytest.importorskip("rtamt", reason="rtamt does not import here")


def robustness(rtamt, signal, predicate, lasting):
    """Of "never beyond the limit for ``lasting`` records on end", where the windows lie within the signal."""
    specification = rtamt.StlDiscreteTimeSpecification()
    specification.declare_var("x", "float")
    specification.declare_var("kept", "float")
    last = len(signal) - 1 - lasting
    specification.spec = f"kept = always[0:{last}] (eventually[0:{lasting}] ({predicate}))"
    specification.parse()
    return specification.evaluate({"time": list(range(len(signal))), "x": signal.tolist()})[0][1]


def random_signal(generator, length):
    """A drifting walk with jumps, so that limits are passed for short and for long."""
    walk = np.cumsum(generator.normal(size=length)) + 8 * np.sign(
        np.sin(np.arange(length) * generator.uniform(0.05, 2))
    )
    return 70 + walk


@pytest.mark.parametrize("seed", range(12))
@pytest.mark.parametrize("lasting", [0, 1, 7])
def test_margins_are_those_of_temporal_logic(rtamt, make_flight, seed, lasting):
    generator = np.random.default_rng(seed)
    airspeed = random_signal(generator, 60)
    error = airspeed - 70.0  # the schedule of the flight; the signal that checks see
    low, high = -abs(generator.normal(0, 10)), abs(generator.normal(0, 10))
    flight = make_flight(np.arange(60) * STEP, ["final"] * 60, airspeed=airspeed)
    judged = {}
    for name, limits in (("max", {"max": high}), ("min", {"min": low}), ("both", {"max": high, "min": low})):
        (judged[name],) = evaluate_checks(
            (Check("airspeed_error_mps", for_=lasting * STEP, **limits),), flight, Runway(), {}
        )
    above = robustness(rtamt, error, f"x <= {high!r}", lasting)
    below = robustness(rtamt, error, f"x >= {low!r}", lasting)
    # sums of some ten numbers of size 100 in another order
    assert judged["max"]["margin"] == pytest.approx(above, abs=1e-11)
    assert judged["min"]["margin"] == pytest.approx(below, abs=1e-11)
    assert judged["both"]["margin"] == pytest.approx(min(above, below), abs=1e-11)
    for result in judged.values():
        assert result["passed"] is (result["margin"] >= 0)
        k = round(result["time_s"] / STEP)
        held = error[k : k + lasting + 1]
        worst = held.min() if result["limit"] == high else held.max()
        assert worst == pytest.approx(result["value"], abs=1e-11)  # the time is when the worst stretch begins


@pytest.mark.parametrize("seed", range(6))
def test_a_phase_flown_twice_is_the_worse_of_both(rtamt, make_flight, seed):
    generator = np.random.default_rng(100 + seed)
    airspeed = random_signal(generator, 90)
    phase = ["glide"] * 30 + ["final"] * 20 + ["glide"] * 40
    flight = make_flight(np.arange(90) * STEP, phase, airspeed=airspeed)
    (result,) = evaluate_checks(
        (Check("airspeed_error_mps", max=5.0, during="glide", for_=3 * STEP),), flight, Runway(), {}
    )
    parts = airspeed[:30] - 70.0, airspeed[50:] - 70.0
    judge_says = min(robustness(rtamt, part, "x <= 5.0", 3) for part in parts)
    assert result["margin"] == pytest.approx(judge_says, abs=1e-11)
