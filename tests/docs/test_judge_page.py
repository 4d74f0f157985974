"""The tracker of docs/judge.md, in another language: plots out, estimates in, a verdict."""

from __future__ import annotations

import re
import shutil
import subprocess
from pathlib import Path

import numpy as np
import pytest

import sim
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
    judged = sim.run(with_track(tmp_path / "run", "mine", tmp_path / "mine.csv", None))
    assert judged.metrics["trackers"]["mine"]["track"]["completeness"] == 1.0
    mine, ours = (judged.tracks[name].track for name in ("mine", "constant_velocity"))
    # the same filter but for its start, which it forgets within a minute or two
    late = mine.time > 180.0
    assert late.sum() > 10
    np.testing.assert_allclose(mine.mean[late], ours.mean[ours.time > 180.0], rtol=0, atol=0.5)
    np.testing.assert_allclose(mine.cov[late][:, 0, 0, 0], ours.cov[ours.time > 180.0][:, 0, 0, 0], rtol=1e-4)
