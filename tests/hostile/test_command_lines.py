"""Judge: a newcomer who types whatever. Each wrong command is one sentence and exit 2, and nothing is written."""

from __future__ import annotations

import os
import re
from pathlib import Path

import pytest

from tests.hostile.command_lines import LINES, VALUES
from tests.hostile.scenario_base import CAPTURE
from tests.hostile.scenarios import SCENARIOS
from tests.hostile.watched import Case, Sandbox

ASKED = ("file/x", "xxx", "/proc", "loop.toml", "short.toml", "no/such/x.toml")  # that cannot be, but are tried
LONGEST_SENTENCE = 1100  # characters; the names of all aircraft are in some


@pytest.fixture(scope="module")
def sandbox(tmp_path_factory):
    """A folder with scenarios, files, pipes, links and folders of others."""
    made = Sandbox(tmp_path_factory.mktemp("commands"))
    cwd = made.place("cwd")
    (cwd / "short.toml").write_text(CAPTURE)
    (cwd / "study.toml").write_text(CAPTURE + "[study.axes]\n'start.cross_track_m' = [10, 20]\n")
    (cwd / "folder").mkdir()
    (cwd / "foreign").mkdir()
    (cwd / "foreign" / "thesis.txt").write_text("years of work")
    (cwd / "file").write_text("")
    (cwd / "claimed").mkdir()
    (cwd / "claimed" / ".shortfinal").write_text("written by shortfinal run\n")
    (cwd / "baited").mkdir()
    (cwd / "baited" / ".shortfinal").symlink_to(cwd / "foreign" / "thesis.txt")
    os.mkfifo(cwd / "fifo.toml")
    (cwd / "loop.toml").symlink_to("loop.toml")
    for name, (content, _) in SCENARIOS.items():
        raw = content if isinstance(content, bytes) else content.encode()
        (made.place("scenarios") / f"{name}.toml").write_bytes(raw)
    return made


def cases(scenarios: Path) -> dict[str, Case]:
    """All commands by a name."""
    values = [Case(f"--set {text}"[:80], ("validate", "short.toml", "--set", text)) for text, _ in VALUES]
    lines = [Case(" ".join(line)[:80], line) for line, _ in LINES]
    files = [Case(name, ("validate", scenarios / f"{name}.toml")) for name in SCENARIOS]
    return {case.name: case for case in (*values, *lines, *files)}


EXPECTED = (
    {f"--set {text}"[:80]: re.escape(said).replace(r"\|", "|") for text, said in VALUES}
    | {" ".join(line)[:80]: re.escape(said).replace(r"\|", "|") for line, said in LINES}
    | {name: said for name, (_, said) in SCENARIOS.items()}
)


@pytest.fixture(scope="module")
def before(sandbox):
    """What there was before the first command."""
    return sandbox.files()


@pytest.fixture(scope="module")
def answers(sandbox, before):
    """What each command answers."""
    return sandbox.answers(list(cases(sandbox.place("scenarios")).values()))


@pytest.mark.parametrize("name", EXPECTED)
def test_a_wrong_command_is_one_sentence_and_exit_two(name, answers):
    answer = answers[name]
    assert not answer.trace, answer.trace[-2000:]
    assert answer.code == 2, answer
    assert not answer.out
    lines = answer.err.splitlines()
    assert len(lines) == 1 or (len(lines) == 21 and "more faults" in lines[-1]), answer.err
    assert all(line.startswith("shortfinal: ") and line.isprintable() for line in lines), answer.err
    assert re.search(EXPECTED[name], answer.err, re.IGNORECASE), answer.err
    assert max(map(len, lines)) < LONGEST_SENTENCE


def test_no_wrong_command_wrote_anything(sandbox, before, answers):
    assert len(answers) == len(EXPECTED)
    assert sandbox.files() == before
    assert sandbox.offences(ASKED) == []
    assert list(sandbox.place("tmp").iterdir()) == []
    assert not (sandbox.place("cwd") / "out").exists()
