"""Judge: a newcomer who types whatever. Each wrong command is one sentence and exit 2, and nothing is written."""

from __future__ import annotations

import os
import re
from pathlib import Path

import pytest

from tests.hostile.command_lines import LINES, VALUES
from tests.hostile.scenario_base import CAPTURE
from tests.hostile.scenarios import SCENARIOS
from tests.hostile.watched import Answer, Case, Sandbox

ASKED = ("file/x", "xxx", "/proc", "loop.toml", "short.toml", "no/such/x.toml")  # that cannot be, but are tried
LONGEST_SENTENCE = 1100  # characters; the names of all aircraft are in some


def furnish(sandbox: Sandbox) -> None:
    """A folder with scenarios, files, pipes, links and folders of others."""
    cwd = sandbox.place("cwd")
    (cwd / "short.toml").write_text(CAPTURE)
    (cwd / "study.toml").write_text(CAPTURE + "[study.axes]\n'start.cross_track_m' = [10, 20]\n")
    for name in ("folder", "foreign", "claimed", "baited"):
        (cwd / name).mkdir()
    (cwd / "foreign" / "thesis.txt").write_text("years of work")
    (cwd / "claimed" / ".shortfinal").write_text("written by shortfinal run\n")
    (cwd / "baited" / ".shortfinal").symlink_to(cwd / "foreign" / "thesis.txt")
    (cwd / "file").write_text("")
    (cwd / "loop.toml").symlink_to("loop.toml")
    os.mkfifo(cwd / "fifo.toml")
    for name, (content, _) in SCENARIOS.items():
        raw = content if isinstance(content, bytes) else content.encode()
        (sandbox.place("scenarios") / f"{name}.toml").write_bytes(raw)


def expected(scenarios: Path) -> dict[str, tuple[Case, str]]:
    """All commands and what must be said, by a name; a bar stands between what may be said."""
    values = [(f"--set {text}", ("validate", "short.toml", "--set", text), literal(said)) for text, said in VALUES]
    lines = [(" ".join(line), line, literal(said)) for line, said in LINES]
    files = [(name, ("validate", scenarios / f"{name}.toml"), said) for name, (_, said) in SCENARIOS.items()]
    return {name[:80]: (Case(name[:80], line), said) for name, line, said in (*values, *lines, *files)}


def literal(said: str) -> str:
    """A pattern of texts as they are."""
    return re.escape(said).replace(r"\|", "|")


def complaint(name: str, said: str, answer: Answer) -> str:
    """What is wrong with the answer to a command; empty where it is as it should be."""
    lines = answer.err.splitlines()
    good = (
        answer.code == 2
        and not answer.trace
        and not answer.out
        and (len(lines) == 1 or (len(lines) == 21 and "more faults" in lines[-1]))
        and all(line.startswith("shortfinal: ") and line.isprintable() for line in lines)
        and re.search(said, answer.err, re.IGNORECASE)
        and max(map(len, lines)) < LONGEST_SENTENCE
    )
    return "" if good else f"{name}: wanted '{said}', got {answer}"


@pytest.mark.parametrize("every", [8, pytest.param(1, marks=pytest.mark.soak)])
def test_a_wrong_command_is_one_sentence_and_exit_two_and_writes_nothing(every, tmp_path):
    sandbox = Sandbox(tmp_path)
    furnish(sandbox)
    wanted = dict([*expected(sandbox.place("scenarios")).items()][::every])
    before = sandbox.files()
    answers = sandbox.answers([case for case, _ in wanted.values()])
    assert list(answers) == list(wanted)
    complaints = [complaint(name, said, answers[name]) for name, (_, said) in wanted.items()]
    assert "\n".join(filter(None, complaints)) == ""
    assert sandbox.files() == before
    assert sandbox.offences(ASKED) == []
    assert list(sandbox.place("tmp").iterdir()) == []
    assert not (sandbox.place("cwd") / "out").exists()
