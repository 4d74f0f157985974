"""Every misprint and trap, put into a copy of the code, must make a test fail: it proves that the tests can.

``mutants.toml`` names for each mutant the file, the text that it replaces and the tests that must notice. The copy is
fresh for each mutant, the code itself is never touched.
"""

from __future__ import annotations

import os
import shutil
import subprocess
import sys
import tomllib
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parent.parent.parent
COPIED = ("aircraft", "autopilot", "tracking", "sim", "tests", "pyproject.toml")
MUTANTS = tomllib.loads((Path(__file__).parent / "mutants.toml").read_text())

ALL_PASSED, SOME_FAILED = 0, 1  # exit codes of pytest; any other means that nothing was tested


def copy(to: Path) -> None:
    """The packages and their tests, with their compiled files."""
    for name in COPIED:
        source = ROOT / name
        if source.is_dir():
            shutil.copytree(source, to / name, ignore=shutil.ignore_patterns("acceptance", "benchmarks", "*.tmp*"))
        else:
            shutil.copy2(source, to / name)


def run(where: Path, tests: list[str], *options: str) -> subprocess.CompletedProcess[str]:
    """The tests in a process that sees only the copy."""
    own = {key: value for key, value in os.environ.items() if not key.startswith(("PYTEST", "COV"))}
    environment = own | {"PYTHONPATH": str(where), "PYTEST_DISABLE_PLUGIN_AUTOLOAD": "1", "OPENBLAS_NUM_THREADS": "1"}
    command = [sys.executable, "-m", "pytest", "-p", "no:cacheprovider", "--no-header", "--tb=line", *options, *tests]
    return subprocess.run(command, cwd=where, env=environment, capture_output=True, text=True, timeout=120)


def test_the_copy_passes_unchanged(tmp_path):
    """Else a mutant would be killed by the copying."""
    copy(tmp_path)
    tests = sorted({test for mutant in MUTANTS.values() for test in mutant["tests"]})
    done = run(tmp_path, tests)
    assert done.returncode == ALL_PASSED, done.stdout[-3000:] + done.stderr[-1000:]


@pytest.mark.parametrize("name", MUTANTS)
def test_mutant_is_killed(name, tmp_path):
    mutant = MUTANTS[name]
    copy(tmp_path)
    file = tmp_path / mutant["file"]
    text = file.read_text()
    assert text.count(mutant["original"]) == 1, f"{mutant['file']} no longer has this text exactly once"
    file.write_text(text.replace(mutant["original"], mutant["mutated"]))
    done = run(tmp_path, mutant["tests"], "-x")
    assert done.returncode != ALL_PASSED, f"{mutant['tests']} do not notice that {mutant['about']}"
    assert done.returncode == SOME_FAILED, done.stdout[-3000:] + done.stderr[-1000:]
