"""What a user may get wrong about a study, from the command line: one clear sentence, exit 2, nothing half-written."""

from __future__ import annotations

import os
import resource
import subprocess
import sys
from pathlib import Path

import pytest

from sim.studies import study as studies
from tests.capture import capture

ROOT = Path(__file__).resolve().parents[3]
LINE = capture(name="line", until_s=2, draws=2)
AXES = """
[study.axes]
"wind.speed_mps" = [0, 4, 8]
"""


@pytest.fixture
def file(tmp_path):
    place = tmp_path / "line.toml"
    place.write_text(LINE + AXES)
    return place


@pytest.fixture
def refused(command):
    """A command that must end with one sentence and exit 2; returns the sentence."""

    def call(*arguments):
        done = command(*arguments)
        assert (done.returncode, done.stdout) == (2, ""), done.stdout + done.stderr
        (line,) = done.stderr.splitlines()
        return line

    return call


def content(folder):
    return {path: path.read_bytes() for path in folder.rglob("*") if path.is_file()}


@pytest.mark.parametrize(
    ("axes", "said"),
    [
        ('"wind.sped_mps" = [1]', "did you mean 'speed_mps'?"),
        ('"speed_mps" = [1]', "no such key"),
        ('"wind.speed_mps" = []', "the list is empty"),
        ('"wind.speed_mps" = { grid = [0, 5, 0] }', "a grid has 1 to 10000 values, not 0"),
        ('"wind.speed_mps" = { normal = [5, -1] }', "sigma must not be negative, not -1"),
        ('"wind.speed_mps" = { grid = [0, 20, 1001] }\n"wind.from_deg" = { grid = [0, 350, 100] }', "100100 flights"),
        ('"wind.speed_mps" = "5"', "write a list of values"),
        ("", "a study varies at least one value"),
    ],
)
def test_bad_axes(refused, tmp_path, axes, said):
    (tmp_path / "bad.toml").write_text(f"{LINE}\n[study.axes]\n{axes}\n")
    assert said in refused("study", "bad.toml", "-o", "o")
    assert not (tmp_path / "o").exists()


def test_more_flights_than_the_budget_by_an_option(refused, file, tmp_path):
    said = refused("study", file, "-o", "o", "--flights", 50_000)
    assert "150000 flights are more than the budget of 100000" in said
    assert not (tmp_path / "o").exists()


def test_more_memory_than_there_is(refused, file, tmp_path):
    assert "use -j" in refused("study", file, "-o", "o", "-j", 100_000)
    assert not (tmp_path / "o").exists()


def test_a_cluster_that_does_not_answer(refused, file, tmp_path):
    """Port 9 of this machine is the discard service, which nobody runs."""
    assert "cluster 127.0.0.1:9: does not answer" in refused("study", file, "-o", "o", "--cluster", "127.0.0.1:9")
    assert "not both" in refused("study", file, "-o", "o", "--cluster", "127.0.0.1:9", "-j", 2)
    assert not (tmp_path / "o").exists()


def test_folders_of_others(refused, file, tmp_path, inline):
    studies.study(file, tmp_path / "o", inline())
    before = content(tmp_path / "o")
    assert "o: holds a study, not a run" in refused("run", file, "-o", "o")
    assert "a study with seed 1, not 2" in refused("study", file, "-o", "o", "--seed", 2)
    assert "a study of another scenario" in refused("study", file, "-o", "o", "--set", "until_s=1")
    assert "no study folder" in refused("resume", "nowhere")
    assert content(tmp_path / "o") == before

    (tmp_path / "theirs").mkdir()
    (tmp_path / "theirs/thesis.txt").write_text("years of work")
    assert "did not write" in refused("study", file, "-o", "theirs")
    assert [path.name for path in (tmp_path / "theirs").iterdir()] == ["thesis.txt"]
    (tmp_path / "run").mkdir()
    (tmp_path / "run/.shortfinal").write_text("written by shortfinal run\n")
    assert "run: holds a run, not a study" in refused("study", file, "-o", "run")
    assert "is a file" in refused("study", file, "-o", file)


def test_a_read_only_place(refused, file, tmp_path):
    place = tmp_path / "read_only"
    place.mkdir()
    place.chmod(0o555)
    if os.geteuid():
        assert "cannot be written: Permission denied" in refused("study", file, "-o", place / "o")
    else:  # root may write anywhere but where nothing can be
        assert "flights need up to 0.06 MB of disk, and 0 MB are free" in refused("study", file, "-o", "/proc/o")
    assert not list(place.iterdir())


def test_a_disk_that_fills_is_one_sentence_and_the_study_is_resumed(file, tmp_path, inline, monkeypatch):
    """No file may grow beyond two records and a half, which is what a full disk does to the log."""
    monkeypatch.setattr("sim.studies.page.page", lambda *given: "")  # drawn elsewhere
    studies.study(file, tmp_path / "whole", inline())
    lines = (tmp_path / "whole/flights.jsonl").read_bytes().splitlines(keepends=True)
    room = len(lines[0] + lines[1]) + len(lines[2]) // 2
    assert (tmp_path / "whole/scenario.toml").stat().st_size < room  # only the log is stopped
    done = subprocess.run(
        [sys.executable, "-m", "sim", "study", str(file), "-o", "full", "-j", "1"],
        cwd=tmp_path,
        # without byte code: CPython 3.11 leaves halves of such files too, at which whoever imports them next stumbles
        env={**os.environ, "PYTHONPATH": str(ROOT), "PYTHONDONTWRITEBYTECODE": "1"},
        capture_output=True,
        text=True,
        timeout=120,
        preexec_fn=lambda: resource.setrlimit(resource.RLIMIT_FSIZE, (room, room)),
        check=False,
    )
    assert done.returncode == 2, done.stderr
    assert done.stderr == "shortfinal: full: cannot be written: File too large; finished flights are kept\n"
    assert (tmp_path / "full/flights.jsonl").read_bytes().startswith(lines[0] + lines[1])
    assert not [path for path in (tmp_path / "full").rglob("*") if path.suffix == ".partial"]
    assert not (tmp_path / "full/metrics.json").exists()
    studies.resume(tmp_path / "full", inline())
    for name in ("flights.jsonl", "metrics.json"):
        assert (tmp_path / "full" / name).read_bytes() == (tmp_path / "whole" / name).read_bytes()
