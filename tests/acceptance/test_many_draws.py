"""What an ensemble of the default run takes of memory, and that going through in parts moves no byte of its files."""

from __future__ import annotations

import filecmp
import subprocess
import sys
import threading
from pathlib import Path

import pytest

from sim.experiment import run_to_folder
from sim.scenario import budget

pytestmark = pytest.mark.acceptance

ASKED = 1500.0  # MB of all processes together


def resident(process: int) -> float:
    """MB of a process and of all that it started; 0 where it has ended."""
    try:
        status = Path(f"/proc/{process}/status").read_text(encoding="utf-8")
        children = Path(f"/proc/{process}/task/{process}/children").read_text(encoding="utf-8").split()
    except OSError:
        return 0.0
    lines = (line for line in status.splitlines() if line.startswith("VmRSS:"))
    return sum(int(line.split()[1]) / 1024 for line in lines) + sum(resident(int(child)) for child in children)


def peak_of_a_run(draws: int, folder: Path) -> float:
    """Most MB of all its processes at once, looked at every 20 ms."""
    command = [sys.executable, "-m", "sim", "run", "an26_pattern", "--set", f"draws={draws}", "-o", str(folder)]
    peak, ended = 0.0, threading.Event()
    with subprocess.Popen([*command, "--no-cache"], stdout=subprocess.DEVNULL) as process:
        while process.poll() is None:
            peak = max(peak, resident(process.pid))
            ended.wait(0.02)
    assert process.returncode in (0, 1)
    return peak


@pytest.mark.parametrize("draws", [512, 1300, 5000])
def test_memory_is_bounded(draws, row, tmp_path):
    peak = peak_of_a_run(draws, tmp_path / "run")
    row(f"default run, {draws} draws: memory of all processes, MB", f"<= {ASKED:.0f}", f"{peak:.0f}", peak <= ASKED)
    assert peak <= ASKED


def test_parts_leave_every_byte_of_the_files(row, tmp_path, monkeypatch):
    """640 draws: 512 and 128, both whole vectors of the processor."""
    from sim import experiment
    from sim.estimation.tracked import watch

    folders = []
    for together in (budget.TOGETHER, 10_000):
        for module in (watch, experiment):
            monkeypatch.setattr(module, "TOGETHER", together)
        folders.append(run_to_folder("an26_pattern", {"draws": 640}, tmp_path / str(together))[0])
    names = ["metrics.json", "flight.npz", "measurements.npz", "tracks.npz", "report.html"]
    same, different, missing = filecmp.cmpfiles(*folders, names, shallow=False)
    row(
        "default run, 640 draws in parts of 512 and at once: files with the same bytes", "5 of 5", f"{len(same)} of 5",
        len(same) == 5,
    )  # fmt: skip
    assert (different, missing) == ([], [])
