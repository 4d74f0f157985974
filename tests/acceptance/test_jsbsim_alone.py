"""The autopilot as a system of JSBSim: in lock step, and flown by JSBSim alone beside our own loop."""

from __future__ import annotations

import re
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

from sim.experiment import fly, read
from sim.flight.jsbsim_root.folder import SCRIPT, write_jsbsim_root
from sim.flight.preparation import prepare
from sim.metrics.flight import flight_metrics
from tests.jsbsim_alone import Alone, departures

pytestmark = pytest.mark.acceptance
STEPS = 2000
SAME_AIR = ("an26_pattern", "an26_crosswind", "an26_gust", "an26_windshear", "an26_departure", "beacon_homing")
OTHER_ENGINES = ("a320", "b747", "c172x")  # whose engines settle otherwise in a script than in our start
NOTICE = re.compile(r"shortfinal/touchdown/(\S+) = (\S+)")


def test_lock_step(row, tmp_path):
    prepared = prepare(read("an26_pattern"))
    write_jsbsim_root(prepared, tmp_path / "root")
    alone = Alone(prepared, tmp_path / "root")
    apart = [(alone.apart(orders), alone.phase) for orders in alone.steps()]
    worst, phases = max(one for one, _ in apart), dict.fromkeys(phase for _, phase in apart)
    met = worst <= 1e-12 and len(apart) >= STEPS
    said = f"{worst:.1e} over {len(apart)} steps: {', '.join(phases)}"
    row("controls and commands of the system beside Python's, an26_pattern", "1e-12 over 2,000 steps", said, met)
    assert met
    assert {"downwind", "base", "final", "glide", "flare"} <= {*phases}


def test_capture(row, tmp_path):
    prepared = prepare(read("route_capture"))
    write_jsbsim_root(prepared, tmp_path / "root")
    flight = fly(prepared, 0)
    assert abs(flight.deviation.cross_track[0]) == pytest.approx(3000.0)
    assert flight.time[-1] == pytest.approx(300.0)
    place, bank = departures(Alone(prepared, tmp_path / "root"), flight)
    bank = float(np.degrees(bank))
    met = place < 0.01 and bank < 0.02
    row("3 km capture by JSBSim alone, 300 s", "within .01 m and .02 deg", f"{place:.1e} m, {bank:.1e} deg", met)
    assert met


def test_stock_console(row, tmp_path):
    """The whole pattern with the program that comes with JSBSim's own package."""
    prepared = prepare(read("an26_pattern"))
    root = write_jsbsim_root(prepared, tmp_path / "root")
    console = Path(sys.executable).parent / "jsbsim"
    line = [console, f"--root={tmp_path / 'root'}", f"--script={SCRIPT}", f"--simulation-rate={root.rate:g}"]
    ended = subprocess.run([*line, "--nohighlight"], cwd=tmp_path, capture_output=True, text=True, timeout=300)
    assert ended.returncode == 0, ended.stderr
    assert "landed (Event" in ended.stdout
    there = {name: float(value) for name, value in NOTICE.findall(ended.stdout)}
    flight = fly(prepared, 0)
    ours = flight_metrics(flight, prepared.scenario.runway, prepared.law.bank_limit, prepared.stall_speed)["touchdown"]
    along = there["past-threshold-m"] - ours["past_threshold_m"]
    across = there["right-of-centreline-m"] - ours["cross_track_m"]
    sink = there["sink-mps"] - ours["sink_mps"]
    met = flight.outcome == "landed" and np.hypot(along, across) < 5.0 and abs(sink) < 0.1
    said = f"landed {there['past-threshold-m']:.1f} m past the threshold: {along:+.2f} m, {sink:+.3f} m/s beside ours"
    row("whole an26_pattern with stock jsbsim --script", "lands, within 5 m and .1 m/s of ours", said, met)
    assert met


@pytest.mark.parametrize(("names", "within"), [(SAME_AIR, 1e-4), (OTHER_ENGINES, 1.0)])
def test_bundled_scenarios(row, tmp_path, names, within):
    """The way of the whole flight: wind worked out in the system, a law that is left, other laws, other aircraft."""
    found = {}
    for name in names:
        prepared = prepare(read(name))
        write_jsbsim_root(prepared, tmp_path / name)
        found[name], _ = departures(Alone(prepared, tmp_path / name), fly(prepared, 0))
    met = max(found.values()) < within
    said = ", ".join(f"{name} {place:.1g} m" for name, place in found.items())
    row(f"whole flights by JSBSim alone beside ours: {', '.join(names)}", f"within {within:g} m", said, met)
    assert met
