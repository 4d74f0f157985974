"""The Python of the README as a reader types it: from the wheel, in a new process, in an empty folder."""

from __future__ import annotations

import importlib.util
import os
import re
import subprocess
import sys
import zipfile
from pathlib import Path

import pytest

pytestmark = pytest.mark.acceptance
ROOT = Path(__file__).resolve().parents[2]
BLOCK = re.compile(r"^```python\n(.*?)^```$", re.MULTILINE | re.DOTALL)


def test_the_python_of_the_readme_runs_from_the_wheel(tmp_path, row):
    pytest.importorskip("hatchling")
    build = [sys.executable, "-m", "hatchling", "build", "-t", "wheel", "-d", str(tmp_path / "wheel")]
    subprocess.run(build, cwd=ROOT, check=True, capture_output=True, timeout=120)
    (wheel,) = (tmp_path / "wheel").glob("*.whl")
    with zipfile.ZipFile(wheel) as archive:
        archive.extractall(tmp_path / "site")
    text = (ROOT / "README.md").read_text(encoding="utf-8")
    every = [block for block in BLOCK.findall(text) if "def test_" not in block]  # those are of pytest
    pandas = importlib.util.find_spec("pandas") is not None
    blocks = [block for block in every if pandas or "to_dataframe" not in block]
    (tmp_path / "empty").mkdir()
    program = "\n".join(blocks) + "\nprint(sim.__file__)\n"
    done = subprocess.run(
        [sys.executable, "-W", "error", "-c", program],
        cwd=tmp_path / "empty",
        env={**os.environ, "PYTHONPATH": str(tmp_path / "site"), "OPENBLAS_NUM_THREADS": "1"},
        capture_output=True,
        text=True,
        timeout=300,
    )
    left = sorted(path.name for path in (tmp_path / "empty").iterdir())
    from_wheel = str(tmp_path / "site") in done.stdout
    met = done.returncode == 0 and from_wheel and left == ["out", "plan.png"]
    without = "" if pandas else "; pandas is not installed: its block was left out"
    row("README: its Python from the wheel", "runs", f"{len(blocks)} of {len(every)} blocks{without}", met)
    assert met, done.stdout + done.stderr
