"""The default pattern at full size: who is below its measurements in every phase, over seeds that nothing was tuned on.

Each seed is one set of 130 noise draws on the one JSBSim flight; the interval of a phase is over all draws.
"""

from __future__ import annotations

import json
import os
import subprocess
import sys
import time
from functools import cache

import numpy as np
import pytest

from sim.estimation.setup import height_profile
from sim.estimation.tracking_run import track
from sim.experiment import fly
from sim.flight.interpolation import truth_at
from sim.flight.preparation import prepare
from sim.metrics import comparison
from sim.observation.record import observe
from sim.scenario.reading import read
from tracking.intervals import gain

pytestmark = pytest.mark.acceptance
SEEDS = (5001, 5002, 5003)
TRACKERS = ("saturated_control", "intent_imm")


@cache
def runs():
    """Squared position errors (k, draws) of trackers and their measurements with the phase, all draws of all seeds."""
    kept = {name: read("an26_pattern").tables["trackers"][name] for name in everyone()}
    flight, found = None, {name: [] for name in kept}
    for seed in SEEDS:
        prepared = prepare(read("an26_pattern", {"seed": seed, "trackers": kept, "checks": []}))
        scenario = prepared.scenario
        flight = flight or fly(prepared)  # still air: the seed is the measurements' alone
        records = observe(flight, scenario.sensors, seed, 0, scenario.draws)
        tracked, _ = track(prepared, flight, records, {})
        for name, one in tracked.items():
            found[name].append(squares(prepared, flight, one, scenario.trackers[name].sensors))
    return {
        name: (np.hstack([own for own, _, _ in parts]), np.hstack([raw for _, raw, _ in parts]), parts[0][2])
        for name, parts in found.items()
    }


def everyone():
    return tuple(name + twin for name in TRACKERS for twin in ("", "_told_wrong"))


def squares(prepared, flight, one, heard):
    """Squared position errors of one tracker and of its plots, where there is a plot."""
    sensors = {name: prepared.scenario.sensors[name] for name in heard}
    truth = truth_at(flight, one.track.time)
    cov = one.track.cov if one.track.cov.ndim == 4 else one.track.cov[..., None]
    own = comparison.compare(flight, truth, one.track.channels, one.track.mean, cov, sensors)["position_m"]
    order = np.argsort(one.measurements.arrival, kind="stable")
    taken = truth_at(flight, one.measurements.time[order])
    z = one.measurements.z[order]
    plots = comparison.raw(flight, taken, one.measurements.channels, z, sensors, height_profile(prepared))["position_m"]
    raw = comparison.squared(plots)
    seen = np.isfinite(raw).all(axis=1)
    return comparison.squared(own)[seen], raw[seen], np.array(flight.phases)[truth.phase[seen]]


@pytest.mark.parametrize("name", everyone())
def test_below_raw_in_every_measured_phase(row, name):
    own, raw, phase = runs()[name]
    gains = {
        part: gain(raw[phase == part].mean(axis=0), own[phase == part].mean(axis=0)) for part in dict.fromkeys(phase)
    }
    told_right = name in TRACKERS
    met = all(figure.low > 1.0 for figure in gains.values())
    row(
        f"an26_pattern: {name}, gain over raw by phase, {len(SEEDS)} x 130 draws",
        "> 1 in every measured phase" if told_right else "shown",
        ", ".join(
            f"{part} {figure.value:.2f} ({figure.low:.2f} to {figure.high:.2f})" for part, figure in gains.items()
        ),
        met or not told_right,
    )
    if told_right:
        assert met, gains


def test_cost_of_the_default_run(row, tmp_path):
    """Seconds hold on a quiet machine of two cores; the load beside them says whether it was one."""
    command = [sys.executable, "-m", "sim", "run", "an26_pattern", "-o", str(tmp_path / "o")]
    walls, tracking, peaks = [], [], []
    busy = os.getloadavg()[0]
    for _ in range(3):
        started = time.perf_counter()
        with subprocess.Popen(command, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL) as process:
            _, status, used = os.wait4(process.pid, 0)  # of this process alone, and of the children that it waited for
            process.returncode = os.waitstatus_to_exitcode(status)
        assert process.returncode == 0
        peaks.append(used.ru_maxrss / 1024)
        walls.append(time.perf_counter() - started)
        tracking.append(json.loads((tmp_path / "o" / "timing.json").read_text())["track_s"])
    peak = max(peaks)
    size = (tmp_path / "o" / "report.html").stat().st_size / 1e6
    for what, asked, limit, value, digits in (
        ("twelve trackers, 130 draws, s (best of 3)", "<= 6", 6.0, min(tracking), 2),
        ("process start to report, s (best of 3)", "<= 12", 12.0, min(walls), 2),
        ("peak memory, MB", "< 500", 500.0, peak, 0),
        ("report, MB", "<= 3", 3.0, size, 2),
    ):
        beside = f" (load {busy:.1f} before)" if what.endswith("(best of 3)") else ""
        row(f"default run: {what}", asked, f"{value:.{digits}f}{beside}", value <= limit)
    assert peak < 500.0
    assert size <= 3.0
