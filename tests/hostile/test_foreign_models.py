"""Aircraft of others as they lie on disk load, or are refused with everything that is missing."""

from __future__ import annotations

import re
from collections.abc import Iterable

import pytest

from aircraft.airframe import load
from aircraft.errors import ModelError
from aircraft.model_files import read
from tests.hostile.foreign import ENGINE, FOREIGN, lay
from tests.hostile.models import FLIES
from tests.hostile.scenario_base import CAPTURE
from tests.hostile.watched import Answer, Case, Sandbox

DIES = "aborts"
SAMPLE = ("on or off",)
REPAIRED = "aircraft.repairs=true"


def cases(sandbox: Sandbox, names: Iterable[str], flown: bool) -> list[Case]:
    """Each as it lies by its name, and with repairs, flown or only explained, by ``repaired name``."""
    scenario = sandbox.place("scenarios") / "short.toml"
    scenario.write_text(CAPTURE)
    found = []
    for name, path in lay(sandbox.place("models"), names).items():
        asked = ("validate", scenario, "--set", f"aircraft.model={path}")
        verb = ("run", scenario, "-o", f"out/{path.parent.name}") if flown else ("explain", scenario)
        repaired = (*verb, *asked[2:], "--set", REPAIRED)
        found += [Case(name, asked), Case(f"repaired {name}", repaired)]
    return found


def complaint(name: str, answers: dict[str, Answer]) -> str:
    """What is wrong with the answers to a model; empty where they are as they should be."""
    foreign, lies, repaired = FOREIGN[name], answers[name], answers[f"repaired {name}"]
    if foreign.said == FLIES:
        good = lies.code == 0 and not lies.err
    else:
        good = lies.is_one_sentence and re.search(foreign.said, lies.err) is not None
    if foreign.held is None:
        good = good and repaired.is_one_sentence
    else:
        good = good and repaired.code == 0 and all(held in repaired.err + repaired.out for held in foreign.held)
    return "" if good else f"{name}: wanted '{foreign.said}' and {foreign.held}, got {lies} and {repaired}"


@pytest.mark.parametrize("name", [name for name in FOREIGN if name != DIES])
def test_it_loads_or_says_all_that_is_missing(name, tmp_path):
    foreign, path = FOREIGN[name], FOREIGN[name].write(tmp_path)
    if foreign.said == FLIES:
        assert load(path).mass == pytest.approx(20000.0, rel=1e-6)
    else:
        with pytest.raises(ModelError, match=foreign.said):
            load(path)
    if foreign.held is None:
        with pytest.raises(ModelError):
            load(path, repaired=True)
    else:
        wanted = (f"nothing sets {', '.join(foreign.held)}: held at 0",) if foreign.held else ()
        assert load(path, repaired=True).repairs == wanted


def test_some_of_them_under_watch(tmp_path):
    sandbox = Sandbox(tmp_path)
    asked = cases(sandbox, SAMPLE, flown=False)
    before = sandbox.files()
    answers = sandbox.answers(asked)
    assert "\n".join(filter(None, (complaint(name, answers) for name in SAMPLE))) == ""
    assert "the model is repaired: nothing sets /sim/on, /sim/on-too: held at 0" in answers["repaired on or off"].out
    assert sandbox.files() == before
    assert sandbox.offences() == []
    assert list(sandbox.place("tmp").iterdir()) == []


def test_the_files_of_its_root_come_after_its_own_and_before_those_of_jsbsim(tmp_path):
    path = FOREIGN["usual root"].write(tmp_path)
    text = (path / "plane.xml").read_text().replace("my_engine", "PT6A-27").replace("my_thruster", "direct")
    (path / "plane.xml").write_text(text)
    engine = tmp_path / "root" / "engine" / "PT6A-27.xml"

    def power() -> list[str]:
        return [tree.get("name", "") for tree in read(path).files.values()]

    assert "none" not in power()
    engine.write_text(ENGINE)
    assert "none" in power()
    (path / "Engines").mkdir()
    (path / "Engines" / engine.name).write_text(ENGINE.replace("none", "own"))
    assert "own" in power()
    assert "none" not in power()
