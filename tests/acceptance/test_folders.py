"""What folders and hosts may do to a study: interrupts at random moments, little memory, very many values."""

from __future__ import annotations

import json
import os
import resource
import subprocess
import sys
import time
import tomllib
from pathlib import Path

import pytest

from sim.experiment import read
from sim.studies.plan import plan
from tests.capture import capture

pytestmark = pytest.mark.acceptance
ROOT = Path(__file__).resolve().parents[2]
WATCHED = """
[sensors.radar]
kind = "surveillance_radar"
[trackers.plain]
kind = "kalman"
[study.axes]
"""


def called(*arguments: object, limit: int | None = None) -> subprocess.CompletedProcess[str]:
    """A module of ours in a process of its own, with a hard limit of its address space."""

    def limited() -> None:
        if limit is not None:
            resource.setrlimit(resource.RLIMIT_AS, (limit, limit))

    return subprocess.run(
        [sys.executable, "-m", *map(str, arguments)],
        cwd=ROOT,
        env={**os.environ, "OPENBLAS_NUM_THREADS": "1"},
        capture_output=True,
        text=True,
        preexec_fn=limited,
        check=False,
    )


def test_interrupts_at_random_moments_lose_and_mix_nothing(row):
    done = called("tests.soak.interrupts", "--interrupts", 30, "--pairs", 7)
    at_fault = [line for line in done.stdout.splitlines() if "after" in line or "apart" in line]
    at_fault = [line for line in at_fault if not line.endswith(": good")]
    last = done.stdout.splitlines()[-1] if done.stdout else done.stderr[-200:]
    row(
        "30 interrupts of run, study, resume, claims; 7 pairs of runs into one folder", "0 at fault", last, not at_fault
    )
    assert done.returncode == 0, done.stdout + done.stderr


def test_ten_thousand_values_of_an_axis_are_read_in_no_time(row):
    axis = '"sensors.radar.position_sigma_m" = { grid = [50, 100, 10000] }'
    file = capture(WATCHED + axis, name="many", until_s=2, draws=2)
    scenario = read(tomllib.loads(file))
    began = time.process_time()
    plan(scenario)
    took = time.process_time() - began
    row("10,000 values of an axis validated", "<= 3 s", f"{took:.1f} s of processor time", took <= 3.0)
    assert took <= 3.0


def test_three_gigabytes_are_enough_for_a_study_and_a_foreign_aircraft(row, tmp_path):
    file = tmp_path / "small.toml"
    file.write_text(capture(WATCHED + '"wind.speed_mps" = [0, 5]', name="small", until_s=2, draws=2))
    done = called("sim", "study", file, "-j", 1, "-o", tmp_path / "o", limit=3_000_000 << 10)
    assert done.returncode == 0, done.stderr
    outcomes = json.loads((tmp_path / "o/metrics.json").read_text(encoding="utf-8"))["outcomes"]
    foreign = called("sim", "explain", file, "--set", "aircraft.model=c172x", limit=3_000_000 << 10)
    told = f"{outcomes}; c172x: {(foreign.stderr or 'explained').splitlines()[0]}"
    met = outcomes == {"completed": 2} and "memory" not in foreign.stderr and foreign.returncode in (0, 2)
    row("a study and a model of others within ulimit -v 3000000", "both work", told, met)
    assert met
