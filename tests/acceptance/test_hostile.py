"""Issue 7: hostile and broken files, and two thousand scenarios bent at random, all watched."""

from __future__ import annotations

import pytest

from tests.hostile.foreign import FOREIGN
from tests.hostile.models import FLIES, MODELS
from tests.hostile.scenario_base import CAPTURE
from tests.hostile.scenarios import SCENARIOS
from tests.hostile.test_foreign_models import cases as foreign_cases
from tests.hostile.test_foreign_models import complaint
from tests.hostile.watched import Answer, Case, Sandbox

pytestmark = pytest.mark.acceptance

ASKED = "an answer each; no file outside -o, no socket, no traceback"
MUTATED = 2000
REPORTED = 50  # one in so many of those that fly is run with its report


def told(answers: list[Answer], sandbox: Sandbox, changed: int) -> tuple[str, bool]:
    """What was measured, and whether it is what was asked."""
    codes = [answer.code for answer in answers]
    bad = [answer for answer in answers if answer.trace or (answer.code == 2) != bool(answer.err)]
    left = len(list(sandbox.place("tmp").glob("shortfinal-*")))
    offences = len(sandbox.offences(["bent.toml"])) + changed + left
    text = (
        f"{len(answers)} answers: {codes.count(0) + codes.count(1)} flown, {codes.count(2)} refused in one sentence; "
        f"{len(bad)} tracebacks or silences, {offences} files outside or sockets"
    )
    return text, not bad and not offences


def test_hostile_corpus(tmp_path, row):
    sandbox = Sandbox(tmp_path)
    scenario = sandbox.place("scenarios") / "short.toml"
    scenario.write_text(CAPTURE)
    cases = []
    for number, (name, model) in enumerate(MODELS.items()):
        model.write(sandbox.place("models") / name, sandbox.place("target"))
        verb = ("run", scenario, "-o", f"out/{number}") if model.said == FLIES else ("validate", scenario)
        cases.append(Case(name, (*verb, "--set", f"aircraft.model={sandbox.place('models') / name}")))
    for name, (content, _) in SCENARIOS.items():
        file = sandbox.place("scenarios") / f"{name}.toml"
        file.write_bytes(content if isinstance(content, bytes) else content.encode())
        cases.append(Case(f"{name}.toml", ("run", file, "-o", f"out/{name}")))
    before = sandbox.files()
    answers = sandbox.answers(cases, time_limit=1800.0)
    assert len(answers) == len(cases)
    measured, met = told(list(answers.values()), sandbox, len(set(before.items()) ^ set(sandbox.files().items())))
    row(f"hostile corpus, {len(cases)} files", f">= 25 files; {ASKED}", measured, met)
    assert met


def test_mutated_scenarios(tmp_path, row):
    sandbox = Sandbox(tmp_path)
    before = sandbox.files()
    answers = [answer for _, answer in sandbox.mutations(MUTATED, REPORTED, time_limit=7200.0)]
    assert len(answers) == MUTATED
    (sandbox.place("cwd") / "bent.toml").unlink()
    measured, met = told(answers, sandbox, len(set(before.items()) ^ set(sandbox.files().items())))
    row("mutated scenarios", f"2,000; {ASKED}", measured, met)
    assert met


def test_foreign_layouts(tmp_path, row):
    sandbox = Sandbox(tmp_path)
    asked = foreign_cases(sandbox, FOREIGN, flown=True)
    before = sandbox.files()
    answers = sandbox.answers(asked, time_limit=1800.0)
    complaints = [text for name in FOREIGN if (text := complaint(name, answers))]
    offences = [*sandbox.offences(), *map(str, set(before.items()) ^ set(sandbox.files().items()))]
    loaded = sum(answers[name].code == 0 for name in FOREIGN)
    repaired = sum(answers[f"repaired {name}"].code == 0 for name in FOREIGN)
    figures = (
        f"{loaded} load as they lie, {repaired} with repairs; {len(complaints)} other than wanted, "
        f"{len(offences)} files outside or sockets"
    )
    met = not complaints and not offences
    row(f"foreign layouts, {len(FOREIGN)} aircraft", ">= 25; each loads or is refused with all reasons", figures, met)
    assert "\n".join((*complaints, *offences)) == ""
    assert len(FOREIGN) >= 25
