"""Every mode of the catalogue keeps the contract of `autopilot.mode`, and what breaks it is told by its member."""

from __future__ import annotations

import math
from dataclasses import dataclass, field, replace
from typing import ClassVar

import pytest

from autopilot.mode import MEMBERS, TRIAL, LimitedInput, broken_promises, missing
from autopilot.modes.lateral_navigation import LateralNavigation
from autopilot.modes.radio_beacon import RadioBeacon
from sim.scenario import catalogue
from tests.parts.wings_level import WingsLevel

MODES = {kind: catalogue.load("modes", kind) for kind in catalogue.kinds("modes")}


@pytest.mark.parametrize("mode", [*MODES.values(), WingsLevel], ids=[*MODES, "wings_level"])
def test_every_mode_keeps_its_promises(mode):
    assert broken_promises(mode) == []


def test_a_mode_is_told_from_every_other_by_its_intent():
    intents = [mode.intent for mode in MODES.values() if mode.standard]
    assert len(set(intents)) == len(intents)


@pytest.mark.parametrize("mode", MODES.values(), ids=MODES)
def test_what_a_file_sets_of_a_law_is_flown(mode):
    """Every number that a file may set reaches the law; the bank limit is that of the autopilot."""
    law = mode.designed({}, TRIAL)
    for name in law.__dataclass_fields__:
        value = getattr(law, name)
        if name != "bank_limit" and isinstance(value, float):
            assert getattr(mode.designed({name: 1.25 * value}, TRIAL), name) == 1.25 * value
    assert mode.designed({}, TRIAL._replace(bank_limit=0.1)).bank_limit == 0.1


def test_a_course_that_a_file_names_is_flown():
    assert RadioBeacon.designed({"course": "heading"}, TRIAL).limits()[1].of == "heading_error"


def test_the_route_law_is_read_off_the_inputs_of_any_mode():
    law = LateralNavigation.designed({}, TRIAL)
    assert LateralNavigation.of(law) == law
    assert LateralNavigation.of(RadioBeacon.designed({}, TRIAL)) is None
    assert LateralNavigation.of(WingsLevel(0.2)) is None


def changed(**members):
    """Wings level with other members."""
    return type("Changed", (WingsLevel,), members)


class Drifting:
    """A law with a memory."""

    def __init__(self):
        self.count = 0

    def __call__(self, deviation):
        self.count += 1
        return 1e-6 * self.count + 0.0 * deviation.cross_track


@dataclass
class Loose:
    """As wings level, but not frozen."""

    bank_limit: float = 0.2
    intent: ClassVar[str] = "loose law"
    standard: ClassVar[bool] = False
    intercept: ClassVar[tuple[str, ...]] = ()
    designed = classmethod(lambda cls, given, case: cls())
    __call__ = WingsLevel.__call__
    limits, explain, check_convergence = WingsLevel.limits, WingsLevel.explain, WingsLevel.check_convergence


@dataclass(frozen=True)
class Remembering:
    """As wings level, with a count inside."""

    bank_limit: float = 0.2
    drift: Drifting = field(default_factory=Drifting)
    intent: ClassVar[str] = "drifting law"
    standard: ClassVar[bool] = False
    intercept: ClassVar[tuple[str, ...]] = ()
    designed = classmethod(lambda cls, given, case: cls())
    limits, explain, check_convergence = WingsLevel.limits, WingsLevel.explain, WingsLevel.check_convergence

    def __call__(self, deviation):
        return self.drift(deviation)


def fails(self, *_, **__):
    raise KeyError("k9")


def of_floats_only(self, deviation):
    return math.copysign(0.1, deviation.cross_track)


BROKEN = {
    "not frozen": (Loose, "dataclass: must be frozen"),
    "remembers": (Remembering, "__call__: gives another bank for the same deviation"),
    "no bound": (changed(__call__=lambda self, deviation: 0.01 * deviation.cross_track), "__call__: commands"),
    "another limit": (
        changed(__call__=lambda self, deviation: 0.2 + 0.0 * deviation.cross_track),
        "bank_limit: is not obeyed",
    ),
    "no arrays": (changed(__call__=of_floats_only), "__call__: fails: TypeError"),
    "one bank for all": (changed(__call__=lambda self, deviation: 0.0), "__call__: gives the shape ()"),
    "not a number": (changed(__call__=lambda self, deviation: math.nan), "__call__: must give one finite number"),
    "raises": (changed(explain=fails), "explain: fails: KeyError: 'k9'"),
    "says nothing": (changed(explain=lambda self: " "), "explain: must give a text"),
    "no design": (changed(designed=classmethod(fails)), "designed: fails with nothing set: KeyError: 'k9'"),
    "no such input": (changed(limits=lambda self: (LimitedInput("psi"),)), "limits: names 'psi'"),
    "false gain": (changed(limits=lambda self: (LimitedInput("cross_track", 1e-3),)), "limits: gains and limits do"),
    "no such field": (changed(intercept=("z_max",)), "intercept: names 'z_max', which is no field"),
    "intent of a number": (changed(intent=3), "intent: must be a str"),
    "an answer": (changed(check_convergence=lambda *_, **__: False), "check_convergence: must give nothing"),
}


@pytest.mark.parametrize(("cls", "sentence"), BROKEN.values(), ids=BROKEN)
def test_a_broken_promise_is_told_by_its_member(cls, sentence):
    told = broken_promises(cls)
    assert any(line.startswith(sentence) for line in told), told


@pytest.mark.parametrize("thing", [None, 3, lambda deviation: 0.0, dict])
def test_what_is_no_class_of_parameters_is_told_as_such(thing):
    assert broken_promises(thing) == ["a mode is a class that is a frozen dataclass"]


def test_a_missing_member_is_told_by_its_name():
    @dataclass(frozen=True)
    class Empty:
        gain: float = 1.0

    assert set(missing(Empty)) == set(MEMBERS)
    told = broken_promises(Empty)
    assert [line.partition(":")[0] for line in told] == [f"it has no '{name}'" for name in MEMBERS]
    assert told[0].startswith("it has no 'bank_limit': Largest bank command, rad")


def test_a_wider_intercept_keeps_a_law_that_converges():
    """What `intercept` names grows together: each law of a bank must reach its leg."""
    for mode in (mode for mode in MODES.values() if mode.intercept):
        law = mode.designed({}, TRIAL)
        for factor in (0.4, 1.6, 2.4):
            limit, *others = law.intercept
            wide = {limit: getattr(law, limit) * factor}
            wide |= {name: getattr(law, name) * max(factor, 1.0) for name in others}
            replace(law, **wide).check_convergence(ground_speed=math.inf)
