"""Every kind of wind event keeps its contract, and a class that does not is told which member breaks it."""

from __future__ import annotations

import dataclasses
import itertools

import pytest

from aircraft.wind_event import MEMBERS, broken_promises, circle
from sim.scenario import catalogue
from sim.scenario.parameters import construct
from sim.scenario.tables import Runway

KINDS = catalogue.kinds("wind_events")


def event(cls):
    return construct(cls, getattr(cls, "example", {}), runway=Runway())


@pytest.mark.parametrize("kind", KINDS)
def test_each_kind_keeps_the_contract(kind):
    cls = catalogue.load("wind_events", kind)
    assert broken_promises(cls, lambda: event(cls)) == []


@dataclasses.dataclass(frozen=True)
class Breeze:
    """Keeps the contract: 2 m/s from the south from 30 s on."""

    at: float = 30.0

    def velocity(self, time, position, airspeed):
        return (2.0, 0.0, 0.0) if time >= self.at else (0.0, 0.0, 0.0)

    def words(self):
        return "2 m/s from the south"

    def outline(self):
        return circle(0.0, 0.0, 500.0)

    def standing(self):
        return Breeze(-1.0)


def wrong(**members):
    """A class like `Breeze` with other members; None takes one away."""
    return type("Wrong", (Breeze,), members)


def test_a_class_that_keeps_it_is_told_nothing():
    assert broken_promises(Breeze, Breeze) == []


@pytest.mark.parametrize("member", MEMBERS)
def test_a_member_that_is_missing_is_told_with_what_it_is_for(member):
    cls = wrong(**{member: None})
    (told,) = broken_promises(cls, cls)
    assert told.startswith(f"has no '{member}': ")
    assert len(told) > len(f"has no '{member}': ") + 20


@pytest.mark.parametrize("member", MEMBERS)
def test_a_member_that_raises_is_told_with_what_it_said(member):
    cls = wrong(**{member: lambda self, *arguments: 1 / 0})
    assert f"{member} raises ZeroDivisionError: division by zero" in broken_promises(cls, cls)


CALLS = itertools.count()
WRONG = {
    "velocity gives (0.0, 2.0) at 0 s": {"velocity": lambda self, time, position, airspeed: (0.0, 2.0)},
    "velocity gives (0.0, 0.0, nan)": {"velocity": lambda self, time, position, airspeed: (0.0, 0.0, float("nan"))},
    "velocity gives 'north'": {"velocity": lambda self, time, position, airspeed: "north"},
    "before it begins at 30 s": {"velocity": lambda self, time, position, airspeed: (1.0, 0.0, 0.0)},
    "must not remember": {"at": None, "velocity": lambda self, *at: (float(next(CALLS)), 0.0, 0.0)},
    "words gives ''": {"words": lambda self: ""},
    "words gives '2 m/s\\n": {"words": lambda self: "2 m/s\nfrom the south"},
    "words gives None": {"words": lambda self: None},
    "outline gives None": {"outline": lambda self: None},
    "outline gives ((0.0, 0.0), (1.0, 1.0))": {"outline": lambda self: ((0.0, 0.0), (1.0, 1.0))},
    "standing gives 3": {"standing": lambda self: 3},
    "standing gives an event whose wind changes with time": {"standing": lambda self: Breeze(60.0)},
    "are not equal": {"__eq__": lambda self, other: False, "__hash__": None},
}


@pytest.mark.parametrize("told", WRONG)
def test_a_wrong_answer_is_told_in_one_line(told):
    cls = wrong(**WRONG[told])
    sentences = broken_promises(cls, cls if "at" not in WRONG[told] else lambda: cls(None))
    assert any(told in sentence for sentence in sentences), sentences
    assert all(len(sentence.splitlines()) == 1 for sentence in sentences)


def test_what_cannot_be_made_is_told():
    def make():
        raise ValueError("up must be positive")

    assert broken_promises(Breeze, make) == ["making one raises ValueError: up must be positive"]
