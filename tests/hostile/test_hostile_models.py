"""Judge: an attacker. Every hostile model gets an answer in one sentence, and reaches nothing."""

from __future__ import annotations

import re

import pytest

from tests.hostile.models import FLIES, MODELS, ODD_NAME
from tests.hostile.scenario_base import CAPTURE
from tests.hostile.watched import Case, Sandbox

PRECIOUS = "years of work"
INJECTION = """'></script><script>alert(1)</script><img src=x onerror=alert(2)> $\\\\frac{1}{ $ {{7*7}} ]]> -->"""
CHECK = f'[[checks]]\nmetric = "bank_deg"\nmax = 0.001\nname = "{INJECTION}"\nsource = "{INJECTION}"\n'


@pytest.fixture(scope="module")
def sandbox(tmp_path_factory):
    """All hostile models flown one after another by one watched process."""
    made = Sandbox(tmp_path_factory.mktemp("hostile"))
    (made.place("target") / "precious.txt").write_text(PRECIOUS)
    (made.place("scenarios") / "short.toml").write_text(CAPTURE)
    (made.place("scenarios") / "marked.toml").write_text(CAPTURE + CHECK)
    for name, model in MODELS.items():
        model.write(made.place("models") / name, made.place("target"))
    return made


@pytest.fixture(scope="module")
def before(sandbox):
    """What there was before the first command."""
    return sandbox.files()


@pytest.fixture(scope="module")
def answers(sandbox, before):
    """What is said of each model: the first is flown into a folder, the others are loaded, trimmed and begun."""
    scenario = sandbox.place("scenarios") / "short.toml"
    cases = []
    for number, name in enumerate(MODELS):
        verb = ("run", scenario, "-o", f"out/{number}") if number == 0 else ("validate", scenario)
        cases.append(Case(name, (*verb, "--set", f"aircraft.model={sandbox.place('models') / name}")))
    marked, odd = sandbox.place("scenarios") / "marked.toml", sandbox.place("models") / ODD_NAME
    cases.append(Case("marked", ("run", marked, "-o", "out/marked", "--set", f"aircraft.model={odd}")))
    return sandbox.answers(cases)


@pytest.mark.parametrize("name", MODELS)
def test_a_hostile_model_gets_one_sentence_or_is_flown_without_its_devices(name, answers):
    answer = answers[name]
    assert not answer.trace, answer.trace
    said = MODELS[name].said
    if said == FLIES or (said == "." and answer.code == 0):
        assert answer.code == 0, answer.err
        return
    assert answer.is_one_sentence, answer
    assert re.search(said, answer.err), answer.err
    assert answer.err.startswith("shortfinal: short: [aircraft]")
    assert len(answer.err) < 500


def test_no_hostile_model_reached_anything(sandbox, before, answers):
    assert len(answers) == len(MODELS) + 1
    assert sandbox.files() == before
    assert sandbox.offences() == []
    assert (sandbox.place("target") / "precious.txt").read_text() == PRECIOUS
    assert [path.name for path in sandbox.place("tmp").iterdir()] == []


def test_no_text_of_a_scenario_becomes_part_of_the_page(sandbox, answers):
    assert answers["marked"].code == 1  # its check fails
    page = (sandbox.place("cwd") / "out" / "marked" / "report.html").read_text()
    assert "onerror=alert(2)&gt;" in page
    for live in ("<script>alert", "<img src=x", "<co>"):
        assert live not in page
