"""Twenty rows of a study flown again by the commands that its log prints: the same figures to the last bit."""

from __future__ import annotations

import json
import os
import shlex
import subprocess
import sys
from pathlib import Path

import pytest

from sim.studies import study as studies
from sim.workers.executors import LocalExecutor
from tests.capture import CAPTURE

pytestmark = pytest.mark.acceptance
ROOT = Path(__file__).resolve().parents[2]
TABLES = {
    **CAPTURE, "name": "rows", "until_s": 20.0, "flights": 2, "draws": 2,
    "start": {"leg": 0, "cross_track_m": 1500.0}, "wind": {"turbulence": "by_wind"},
    "sensors": {"radar": {"kind": "surveillance_radar"}}, "trackers": {"plain": {"kind": "kalman"}},
    "checks": [{"metric": "bank_max_deg", "max": 16.0}],
    "study": {"samples": 5, "axes": {
        "autopilot.roll_rate_limit_degps": [4, 6], "wind.headwind_kt": {"normal": [7.5, 7.5, -10, 30]},
        "wind.crosswind_kt": {"quantiles": [[0, -20], [0.5, 0], [1, 20]]},
        "autopilot.bank_limit_deg": {"normal": [15, 2]},
    }},
}  # fmt: skip


def flown(typed: str, folder: Path) -> dict:
    """The metrics of what a reader types in the folder of the study."""
    words = shlex.split(typed)
    assert words[0] == "shortfinal"
    environment = {**os.environ, "PYTHONPATH": str(ROOT), "OPENBLAS_NUM_THREADS": "1"}
    command = [sys.executable, "-m", "sim", *words[1:], "-o", "again", "--json"]
    done = subprocess.run(command, cwd=folder, env=environment, capture_output=True, text=True, check=False)
    assert done.returncode in (0, 1), done.stderr  # 1 = a check is broken, as it was
    found: dict = json.loads(done.stdout)
    return found


def test_twenty_rows_are_flown_again_by_their_commands(row, tmp_path):
    folder = tmp_path / "an operator's study"
    studies.study(TABLES, folder, LocalExecutor(2))
    records = [json.loads(line) for line in (folder / "flights.jsonl").read_text().splitlines()]
    assert len({record["again"] for record in records}) == 20
    same = 0
    for record in records:
        again = flown(record["again"], folder)
        verdicts = [check["passed"] for check in again["checks"]] == [one["passed"] for one in record["checks"]]
        figures = {**again["flight"], "trackers": again["trackers"], "navigated": None}
        same += verdicts and figures == {**record["metrics"], "navigated": None}
    told = f"{same} of {len(records)} equal"
    row("20 rows of a study flown again by the commands of its log", "equal figures", told, same == 20)
    assert same == 20
