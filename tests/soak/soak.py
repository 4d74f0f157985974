"""Kills workers and parents of studies at random and holds what is left against an uninterrupted study, byte by byte.

Run by ``make soak``; ``--studies`` and ``--parents`` say how often. Prints one line for each study, ends with 1 if a
finished flight was lost, a file was broken or a byte differs. On a busy machine a worker may not live long enough to
fly at all: then the flight is given up and marked, unless ``--every`` gives it more time.
"""

from __future__ import annotations

import argparse
import json
import os
import signal
import subprocess
import sys
import tempfile
import time
from pathlib import Path

import numpy as np

from tests.capture import capture

ROOT = Path(__file__).resolve().parents[2]
TABLES = """
[wind]
turbulence = "moderate"
[sensors.radar]
kind = "surveillance_radar"
[trackers.plain]
kind = "kalman"
"""
AXES = """
[study.axes]
"sensors.radar.position_sigma_m" = [50, 100]
"wind.speed_mps" = [0, 6, 12]
"""
SCENARIO = capture(TABLES, AXES, name="soak", until_s=60, flights=50, draws=5, to_m=40000, cross_track_m=1000)
SAME = "the same bytes"
COMPARED = ("metrics.json", "flights.jsonl", "scenario.toml", "report.html")


def start(*arguments: object) -> subprocess.Popen[bytes]:
    environment = {**os.environ, "OPENBLAS_NUM_THREADS": "1"}
    command = [sys.executable, "-m", "sim", *map(str, arguments)]
    return subprocess.Popen(command, cwd=ROOT, env=environment, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)


def workers(process: subprocess.Popen[bytes]) -> list[int]:
    """Processes that fly for a study."""
    found = []
    for task in Path(f"/proc/{process.pid}/task").iterdir():
        for pid in (task / "children").read_text().split():
            if b"spawn_main" in Path(f"/proc/{pid}/cmdline").read_bytes():
                found.append(int(pid))
    return found


def finished(folder: Path) -> set[str]:
    """Whole lines of the log: flights that must never be lost."""
    log = folder / "flights.jsonl"
    return set(log.read_text().split("\n")[:-1]) if log.exists() else set()


def faults(folder: Path, whole: Path, before: set[str]) -> list[str]:
    """What differs from the uninterrupted study; a flight that was given up is marked, and all others are the same."""
    lost = before - finished(folder)
    told = [f"{len(lost)} finished flights lost"] if lost else []
    if given_up(folder):
        other = finished(folder) - finished(whole)
        told += [f"{len(other) - given_up(folder)} flights differ"] if len(other) != given_up(folder) else []
    else:
        told += [f"{name} differs" for name in COMPARED if (folder / name).read_bytes() != (whole / name).read_bytes()]
    return told + [f"{path.name} left" for path in folder.rglob("*.partial")]


def given_up(folder: Path) -> int:
    """Flights whose workers were killed too often."""
    return sum("its worker process was killed" in line for line in finished(folder))


def with_killed_workers(file: Path, folder: Path, every: float, generator: np.random.Generator) -> int:
    """A study, a random worker of which is killed every few seconds; how many were."""
    process, killed = start("study", file, "-o", folder, "-j", 2), 0
    while True:
        try:
            process.wait(every)
            return killed
        except subprocess.TimeoutExpired:
            found = workers(process)
            if found:
                os.kill(int(generator.choice(found)), signal.SIGKILL)
                killed += 1


def with_killed_parent(file: Path, folder: Path, after: float) -> tuple[set[str], int]:
    """A study whose parent is killed once, then resumed; what was finished by then, and the exit code."""
    process = start("study", file, "-o", folder, "-j", 2)
    time.sleep(after)
    process.kill()
    process.wait()
    time.sleep(0.2)  # a line that is on its way
    before = finished(folder)
    if (folder / "cache/identity.json").exists():
        return before, start("resume", folder, "-j", 2).wait()
    return before, start("study", file, "-o", folder, "-j", 2).wait()  # killed before there was anything to resume


def main() -> int:
    """Everything, in a temporary folder."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--studies", type=int, default=20)
    parser.add_argument("--parents", type=int, default=25)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--every", type=float, default=5.0, help="s between two kills of a worker")
    asked = parser.parse_args()
    generator = np.random.default_rng(asked.seed)
    bad = 0
    with tempfile.TemporaryDirectory() as name:
        place = Path(name)
        file, whole = place / "soak.toml", place / "whole"
        file.write_text(SCENARIO)
        began = time.monotonic()
        assert start("study", file, "-o", whole, "-j", 2).wait() == 0
        lasts = time.monotonic() - began
        flights = json.loads((whole / "metrics.json").read_text())["flights"]
        print(f"uninterrupted: {flights} flights in {lasts:.0f} s", flush=True)
        for number in range(asked.studies):
            folder = place / f"workers{number}"
            killed = with_killed_workers(file, folder, asked.every, generator)
            told = faults(folder, whole, set())
            bad += bool(told)
            good = f"{given_up(folder)} flights given up, all others the same" if given_up(folder) else SAME
            print(f"study {number}: {killed} workers killed: {'; '.join(told) or good}", flush=True)
        for number in range(asked.parents):
            folder, after = place / f"parent{number}", float(generator.uniform(0.0, lasts))
            before, code = with_killed_parent(file, folder, after)
            told = faults(folder, whole, before) + ([f"exit code {code}"] if code else [])
            bad += bool(told)
            kept = f"{len(before)} of {flights} flights kept"
            print(f"parent killed after {after:.1f} s, {kept}: {'; '.join(told) or SAME}", flush=True)
    print(f"{bad} of {asked.studies + asked.parents} studies at fault")
    return int(bad > 0)


if __name__ == "__main__":
    sys.exit(main())
