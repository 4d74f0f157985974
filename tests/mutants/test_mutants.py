"""Every misprint and trap, put into a copy of the code, must make a test fail: it proves that the tests can.

``mutants.toml`` names for each mutant the file, the text that it replaces and the tests that must notice. The copy is
fresh for each mutant, the code itself is never touched.
"""

from __future__ import annotations

import json
import os
import shutil
import signal
import subprocess
import sys
import tomllib
from collections.abc import Callable, Iterator
from pathlib import Path

import pytest

HERE = Path(__file__).resolve().parent
ROOT = HERE.parent.parent
COPIED = ("aircraft", "autopilot", "tracking", "sim", "tests", "pyproject.toml")
NOT_COPIED = ("acceptance", "benchmarks", "*.tmp*")
MUTANTS = tomllib.loads((HERE / "mutants.toml").read_text())
EVERY = 8  # `make test` tries one mutant in so many, `make soak` the others
OPTIONS = ["-p", "no:cacheprovider", "--no-header", "--tb=line"]

ALL_PASSED, SOME_FAILED, NEVER_ENDED = 0, 1, (-signal.SIGPROF, -signal.SIGALRM)  # others: nothing was tested

Runner = Callable[[Path, list[str]], tuple[int, str]]


@pytest.fixture(scope="session")
def run() -> Iterator[Runner]:
    """Runs tests in a folder, seeing only the packages there: (exit code, output)."""
    own = {key: value for key, value in os.environ.items() if not key.startswith(("PYTEST", "COV"))}
    environment = own | {"PYTEST_DISABLE_PLUGIN_AUTOLOAD": "1", "OPENBLAS_NUM_THREADS": "1"}
    command = [sys.executable, "-P", str(HERE / "fork_server.py")]
    with subprocess.Popen(command, env=environment, stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True) as server:

        def tested(folder: Path, arguments: list[str]) -> tuple[int, str]:
            output = folder / "output.txt"
            server.stdin.write(json.dumps([str(folder), str(output), OPTIONS + arguments]) + "\n")
            server.stdin.flush()
            return int(server.stdout.readline()), output.read_text()[-3000:]

        yield tested
        server.stdin.close()


def copy(to: Path) -> None:
    """The packages and their tests, with their compiled files."""
    for name in COPIED:
        source = ROOT / name
        if source.is_dir():
            shutil.copytree(source, to / name, ignore=shutil.ignore_patterns(*NOT_COPIED))
        else:
            shutil.copy2(source, to / name)


NAMED = sorted({test for mutant in MUTANTS.values() for test in mutant["tests"]})
FILES = {test.partition("::")[0]: test for test in NAMED}


@pytest.mark.parametrize(
    "tests",
    [pytest.param([*FILES.values()][::4], id="some"), pytest.param(NAMED, marks=pytest.mark.soak, id="all")],
)
def test_the_copy_passes_unchanged(tests, tmp_path, run):
    """Else a mutant would be killed by the copying."""
    copy(tmp_path)
    code, output = run(tmp_path, tests)
    assert code == ALL_PASSED, output


@pytest.mark.parametrize("name", MUTANTS)
def test_what_a_mutant_changes_stands_there_once(name):
    mutant = MUTANTS[name]
    assert (ROOT / mutant["file"]).read_text().count(mutant["original"]) == 1, f"{mutant['file']} no longer has it so"


@pytest.mark.parametrize(
    "name",
    [pytest.param(name, marks=pytest.mark.soak if (number + 2) % EVERY else ()) for number, name in enumerate(MUTANTS)],
)
def test_mutant_is_killed(name, tmp_path, run):
    mutant = MUTANTS[name]
    copy(tmp_path)
    file = tmp_path / mutant["file"]
    file.write_text(file.read_text().replace(mutant["original"], mutant["mutated"]))
    code, output = run(tmp_path, ["-x", *mutant["tests"]])
    assert code != ALL_PASSED, f"{mutant['tests']} do not notice that {mutant['about']}"
    assert code in (SOME_FAILED, *NEVER_ENDED), output
