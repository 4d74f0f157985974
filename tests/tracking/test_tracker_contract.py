"""Every kind of tracker keeps its contract, and a class that does not is told which member breaks it."""

from __future__ import annotations

import numpy as np
import pytest

from sim.estimation.trial import maker
from sim.scenario import catalogue
from tracking.contract import MEMBERS, broken_promises
from tracking.gaussian import Gaussian
from tracking.trackers.huber import Huber
from tracking.trackers.imm import InteractingMultipleModel
from tracking.trackers.kalman import Kalman


@pytest.mark.parametrize("kind", catalogue.kinds("trackers"))
def test_each_kind_keeps_the_contract(kind):
    cls = catalogue.load("trackers", kind)
    assert broken_promises(cls, maker(cls, kind)) == []


def told(cls, **members):
    """What a class like another, with other members, is told; None takes one away."""
    wrong = type("Wrong", (cls,), members)
    return broken_promises(wrong, maker(wrong))


@pytest.mark.parametrize("member", MEMBERS)
def test_a_member_that_is_missing_is_told_with_what_it_is_for(member):
    (sentence,) = told(Kalman, **{member: None})
    assert sentence.startswith(f"has no '{member}': ")
    assert len(sentence) > len(f"has no '{member}': ") + 20


@pytest.mark.parametrize("member", MEMBERS)
def test_a_member_that_raises_is_told_with_what_it_said(member):
    def broken(self, *arguments):
        return 1 / 0

    (sentence,) = told(Kalman, **{member: property(broken) if member == "channels" else broken})
    assert sentence.endswith(f"{member} raises ZeroDivisionError: division by zero")


def step(self, state, dt, z, R):
    return Kalman(self.measurement, self.motion).step(state, dt, z, R)


def of_all_runs(self, state, dt, z, R):
    (mean, cov), innovation = step(self, state, dt, z, R)
    return Gaussian(np.broadcast_to(mean.mean(axis=-1, keepdims=True), mean.shape), cov), innovation


def in_place(self, state, dt, z, R):
    state.mean[0] += 1.0
    return step(self, state, dt, z, R)


def restless(self, state, dt, z, R):
    return step(self, state, dt + 0.1, z, R)


def borrowed(self, state, dt, z, R):
    return step(self, state, dt, None if z is None else np.where(np.isnan(z), z[:, -1:], z), R)


def deaf(self, state, dt, z, R):
    return step(self, state, dt, None, None)


def poisoned(self, state, dt, z, R):
    moved, innovation = step(self, state, dt, z, R)
    return (moved if z is None else Gaussian(moved.mean + 0.0 * z.sum(axis=0), moved.cov)), innovation


def gullible(self, state, dt, z, R):
    (mean, cov), innovation = step(self, state, dt, z, R)
    return Gaussian(mean, cov - (1e6 * np.eye(4)[..., None] if z is not None and not R.any() else 0.0)), innovation


WRONG = {
    "negative in some direction once a look is exact": {"step": gullible},
    "a run comes out otherwise alone": {"step": of_all_runs},
    "step changes the state that is passed to it": {"step": in_place},
    "step over no time, without a measurement, changes the estimate": {"step": restless},
    "step gives NoneType where something was measured": {"step": deaf},
    "absent in one run makes its estimate not finite": {"step": poisoned},
    "a run without a measurement is not its prediction": {"step": borrowed},
    "step gives Gaussian, not (state, Innovation or None)": {"step": lambda self, *of: step(self, *of)[0]},
    "estimate gives ndarray, not a Gaussian or a Mixture": {"estimate": lambda self, state: state.mean},
    "estimate has a mean of (2,)": {"estimate": lambda self, state: Gaussian(state.mean[:2], state.cov[:2, :2])},
    "a covariance that is not symmetric": {
        "estimate": lambda self, state: Gaussian(state.mean, state.cov + np.eye(4, 4, 1)[..., None])
    },
    "a covariance that is negative in some direction": {
        "estimate": lambda self, state: Gaussian(state.mean, state.cov - 1e6 * np.eye(4)[..., None])
    },
    "estimate is not finite": {"estimate": lambda self, state: Gaussian(state.mean * np.nan, state.cov)},
    "steer changes a value of no age": {"steer": lambda self, state, z, age: z + 1.0},
    "channels gives": {"channels": ["north", "north_rate", "east", "east_rate"]},
}


@pytest.mark.parametrize("sentence", WRONG)
def test_a_wrong_answer_is_told_in_one_line(sentence):
    sentences = told(Kalman, **WRONG[sentence])
    assert any(sentence in one for one in sentences), sentences
    assert all(len(one.splitlines()) == 1 for one in sentences)


def test_names_of_hypotheses_are_as_many_as_there_are():
    assert told(InteractingMultipleModel, modes=("straight",)) == ["modes names 1 hypotheses, estimate weighs 4"]
    named = {"intents": ("law", "law", "manual", "manual"), "switched": lambda self, weights, dt, mean: weights[:, :2]}
    assert told(InteractingMultipleModel, **named) == ["switched gives no probabilities of the same hypotheses"]


def test_what_cannot_be_made_is_told():
    needy = type("Needy", (Huber,), {"__post_init__": lambda self: 1 / 0})
    assert broken_promises(needy, maker(needy)) == ["making one raises ZeroDivisionError: division by zero"]
    without_sensors = catalogue.load("trackers", "elevation")

    def make():
        raise ValueError("needs one sensor that measures 'elevation'")

    (sentence,) = broken_promises(without_sensors, make)
    assert sentence.endswith("needs one sensor that measures 'elevation'")
