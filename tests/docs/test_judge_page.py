"""The tracker of docs/judge.md, in another language: plots out, estimates in, a verdict."""

from __future__ import annotations

import json
import re
import shutil
import subprocess
from pathlib import Path

import pytest

import sim
from sim.experiment import run_to_folder
from sim.results.judging import with_track

PAGE = Path(__file__).resolve().parents[2] / "docs" / "judge.md"
COLUMNS = ("time_s", "draw", "north_m", "north_sigma_m", "east_m", "east_sigma_m")


@pytest.mark.skipif(shutil.which("node") is None, reason="there is no node here, which runs the page's tracker")
def test_a_tracker_in_another_language_is_judged_beside_the_same_one_of_ours(tmp_path):
    (tmp_path / "tracker.js").write_text(re.search(r"```js\n(.*?)```", PAGE.read_text(), re.DOTALL)[1])
    q = {"trackers.constant_velocity.acceleration_density_m2ps3": 1.0}  # as the page's has it
    run = sim.run("route_capture_point_mass", draws=30, overrides=q)
    sim.report(run, tmp_path / "run")
    record = run.records["radar"]
    sigma = record.R[0, 0, 0] ** 0.5
    rows = [
        (time, draw, record.z[k, 0, draw], sigma, record.z[k, 1, draw], sigma)
        for k, time in enumerate(record.time)
        for draw in range(30)
    ]
    lines = [",".join(COLUMNS), *(",".join(map(repr, map(float, row))) for row in rows)]
    (tmp_path / "plots.csv").write_text("\n".join(lines) + "\n")
    made = subprocess.run(["node", "tracker.js", "plots.csv"], cwd=tmp_path, capture_output=True, text=True, timeout=60)
    assert made.returncode == 0, made.stderr
    (tmp_path / "mine.csv").write_text(made.stdout)
    run_to_folder(with_track(tmp_path / "run", "mine", tmp_path / "mine.csv", None), {}, tmp_path / "out")
    found = json.loads((tmp_path / "out" / "metrics.json").read_text())["trackers"]
    mine, ours = found["mine"], found["constant_velocity"]
    assert mine["track"]["completeness"] == 1.0
    # the same filter but for its start: without a prior of the speed it has the first two looks less
    assert mine["overall"]["position_m"]["rmse"] == pytest.approx(ours["overall"]["position_m"]["rmse"], rel=0.05)
    assert mine["anees"] == pytest.approx(ours["anees"], rel=0.1)
