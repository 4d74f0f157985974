"""Judge: an attacker. Every hostile model gets an answer in one sentence, and reaches nothing."""

from __future__ import annotations

import re

import pytest

from tests.hostile.models import FLIES, MODELS, ODD_NAME
from tests.hostile.scenario_base import CAPTURE
from tests.hostile.watched import Answer, Case, Sandbox

LONGEST_SENTENCE = 500  # characters
PRECIOUS = "years of work"
INJECTION = """'></script><script>alert(1)</script><img src=x onerror=alert(2)> $\\\\frac{1}{ $ {{7*7}} ]]> -->"""
CHECK = f'[[checks]]\nmetric = "bank_deg"\nmax = 0.001\nname = "{INJECTION}"\nsource = "{INJECTION}"\n'


def made(sandbox: Sandbox, names: list[str]) -> list[Case]:
    """Models in their folders: each is loaded, trimmed and begun, and one is flown; the acceptance flies all."""
    scenarios, models = sandbox.place("scenarios"), sandbox.place("models")
    (sandbox.place("target") / "precious.txt").write_text(PRECIOUS)
    (scenarios / "short.toml").write_text(CAPTURE)
    (scenarios / "marked.toml").write_text(CAPTURE + CHECK)
    for name in names:
        MODELS[name].write(models / name, sandbox.place("target"))
    cases = [
        Case(name, ("validate", scenarios / "short.toml", "--set", f"aircraft.model={models / name}")) for name in names
    ]
    odd = f"aircraft.model={models / ODD_NAME}"
    return [*cases, Case("marked", ("run", scenarios / "marked.toml", "-o", "out/marked", "--set", odd))]


def complaint(name: str, answer: Answer) -> str:
    """What is wrong with the answer to a model; empty where it is as it should be."""
    said = MODELS[name].said
    if said == FLIES or (said == "." and answer.code == 0):
        good = answer.code == 0 and not answer.err
    else:
        placed = re.match(r"shortfinal: (short|\S*/short\.toml(:\d+)?): \[aircraft\]", answer.err)
        good = answer.is_one_sentence and placed is not None and len(answer.err[placed.end() :]) < LONGEST_SENTENCE
        good = good and re.search(said, answer.err) is not None
    return "" if good else f"{name}: wanted '{said}', got {answer}"


@pytest.mark.parametrize(
    "names",
    [
        pytest.param(sorted({*[*MODELS][::5], ODD_NAME}), id="some"),
        pytest.param([*MODELS], marks=pytest.mark.soak, id="all"),
    ],
)
def test_hostile_models_get_one_sentence_or_fly_without_their_devices_and_reach_nothing(names, tmp_path):
    sandbox = Sandbox(tmp_path)
    cases = made(sandbox, names)
    before = sandbox.files()
    answers = sandbox.answers(cases)
    assert list(answers) == [case.name for case in cases]
    complaints = [complaint(name, answers[name]) for name in names]
    assert "\n".join(filter(None, complaints)) == ""
    assert sandbox.files() == before
    assert sandbox.offences() == []
    assert (sandbox.place("target") / "precious.txt").read_text() == PRECIOUS
    assert list(sandbox.place("tmp").iterdir()) == []

    assert answers["marked"].code == 1  # its check fails
    page = (sandbox.place("cwd") / "out" / "marked" / "report.html").read_text()
    assert "onerror=alert(2)&gt;" in page
    for live in ("<script>alert", "<img src=x", "<co>"):  # no text of a scenario becomes part of the page
        assert live not in page
