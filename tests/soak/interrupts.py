"""Interrupts run, study, resume and claims at random moments, and has two runs write one folder at once.

Run by ``make soak``; ``--interrupts`` and ``--pairs`` say how often. Whatever is stopped ends with the exit code of its
signal and leaves no process behind; a folder holds the files of one run, byte by byte, and never a mixture; a study and
a ledger go on to the bytes that they would have had, and lose nothing that was finished. Prints one line for each case,
ends with 1 if anything was otherwise.
"""

from __future__ import annotations

import argparse
import os
import shutil
import signal
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable
from pathlib import Path
from typing import NamedTuple

import numpy as np

from tests.capture import capture
from tests.soak.soak import COMPARED, TABLES, finished

ROOT = Path(__file__).resolve().parents[2]
AXES = """
[study.axes]
"sensors.radar.position_sigma_m" = [50, 100]
"wind.speed_mps" = [0, 6]
"""
SIGNALS = (signal.SIGINT, signal.SIGTERM, signal.SIGHUP)
PAPER = "glistin"
ENDS = 120.0  # s in which a command that is stopped must have ended
WALL_TIMES = "timing.json"  # the only file of a run that two runs do not share


class Command(NamedTuple):
    """A command that writes a folder, and how what it left is judged."""

    name: str
    arguments: tuple[object, ...]  # -o FOLDER is added, or the folder alone
    prepare: Callable[[Path], None]  # what lies in the folder before
    judge: Callable[[Path], list[str]]  # faults of what it left; it may go on first


def start(arguments: tuple[object, ...], folder: Path) -> subprocess.Popen[bytes]:
    """The command in a session of its own, so that nobody else gets its signals."""
    place = [folder] if arguments[0] == "resume" else ["-o", folder]
    command = [sys.executable, "-m", "sim", *map(str, arguments), *map(str, place)]
    environment = {**os.environ, "OPENBLAS_NUM_THREADS": "1"}
    quiet = subprocess.DEVNULL
    return subprocess.Popen(
        command, cwd=ROOT, env=environment, stdout=quiet, stderr=quiet, start_new_session=True, stdin=quiet
    )


def done(arguments: tuple[object, ...], folder: Path) -> float:
    """The command to its end, which must be good; how long it takes."""
    began = time.monotonic()
    assert start(arguments, folder).wait() == 0, arguments
    return time.monotonic() - began


def bytes_of(folder: Path) -> dict[str, bytes]:
    """The files of a run but its wall times."""
    return {path.name: path.read_bytes() for path in folder.iterdir() if path.is_file() and path.name != WALL_TIMES}


def left_behind(group: int) -> list[str]:
    """Processes that a command started and that outlive it, one sentence for each; they are ended."""
    until = time.monotonic() + 10.0  # s; workers may be ending
    while found := in_group(group):
        if time.monotonic() > until:
            os.killpg(group, signal.SIGKILL)
            return [f"left behind: {one}" for one in found]
        time.sleep(0.1)
    return []


def in_group(group: int) -> list[str]:
    """Commands of the processes of a group that live."""
    found = []
    for entry in Path("/proc").glob("[0-9]*"):
        try:
            state, _, own = (entry / "stat").read_text().rpartition(")")[2].split()[:3]
            if int(own) == group and state != "Z":
                found.append((entry / "cmdline").read_bytes().replace(b"\0", b" ").decode(errors="replace")[:120])
        except OSError:  # it has just ended
            continue
    return found


def interrupted(command: Command, folder: Path, after: float, number: int) -> tuple[str, list[str]]:
    """Stop a command; how it ended, and what was not as it should be."""
    command.prepare(folder)
    before = finished(folder)
    process = start(command.arguments, folder)
    time.sleep(after)
    process.send_signal(number)
    try:
        code = process.wait(ENDS)
    except subprocess.TimeoutExpired:
        process.kill()
        return "hangs", [f"runs on for {ENDS:g} s after the signal"]
    told = [] if code in (0, 128 + number, -number) else [f"exit code {code}"]  # -number: before it could listen
    told += left_behind(process.pid)
    told += [f"{path.name} left" for path in (folder.rglob("*.partial") if code != -number else ())]
    lost = before - finished(folder)
    told += [f"{len(lost)} finished flights lost"] if lost else []
    return f"exit code {code}", told + command.judge(folder)


def commands(place: Path) -> tuple[list[Command], dict[str, float]]:
    """All commands, with how long each takes when nobody stops it."""
    run_file, study_file = place / "one.toml", place / "many.toml"
    run_file.write_text(capture(TABLES, name="one", until_s=60, draws=20, to_m=40000, cross_track_m=1000))
    study_file.write_text(
        capture(TABLES + AXES, name="many", until_s=60, flights=20, draws=5, to_m=40000, cross_track_m=1000)
    )
    runs = {seed: ("run", run_file, "--seed", seed) for seed in (11, 22)}
    study, claims = ("study", study_file, "-j", 2), ("claims", PAPER, "--quick")
    lasts = {"run": max(done(runs[seed], place / f"run{seed}") for seed in runs)}
    lasts["study"] = lasts["resume"] = done(study, place / "study")
    lasts["claims"] = done(claims, place / "claims")
    whole_runs = [bytes_of(place / f"run{seed}") for seed in runs]
    whole_claims = (place / "claims/claims.json").read_bytes()

    def first_run(folder: Path) -> None:
        shutil.copytree(place / "run11", folder)

    def half_study(folder: Path) -> None:
        shutil.copytree(place / "study", folder)
        lines = (folder / "flights.jsonl").read_bytes().splitlines(keepends=True)
        (folder / "flights.jsonl").write_bytes(b"".join(lines[: len(lines) // 2]))
        for name in ("metrics.json", "report.html"):
            (folder / name).unlink()

    def one_run(folder: Path) -> list[str]:
        return [] if bytes_of(folder) in whole_runs else ["a mixture of two runs"]

    def goes_on(folder: Path) -> list[str]:
        begun = (folder / "cache/identity.json").exists()
        arguments = ("resume",) if begun else study
        if code := start((*arguments, "-j", 2) if begun else arguments, folder).wait():
            return [f"does not go on: exit code {code}"]
        return [f"{n} differs" for n in COMPARED if (folder / n).read_bytes() != (place / "study" / n).read_bytes()]

    def measures_on(folder: Path) -> list[str]:
        if code := start(claims, folder).wait():
            return [f"does not go on: exit code {code}"]
        return [] if (folder / "claims.json").read_bytes() == whole_claims else ["claims.json differs"]

    def nothing(folder: Path) -> None:
        pass

    return [
        Command("run", runs[22], first_run, one_run),
        Command("study", study, nothing, goes_on),
        Command("resume", ("resume", "-j", 2), half_study, goes_on),
        Command("claims", claims, nothing, measures_on),
    ], lasts


def pair(folder: Path, later: float, place: Path) -> tuple[str, list[str]]:
    """Two runs of two seeds into one folder: one wins whole, or the second is refused."""
    first = start(("run", place / "one.toml", "--seed", 11), folder)
    time.sleep(later)
    second = start(("run", place / "one.toml", "--seed", 22), folder)
    codes = (first.wait(), second.wait())
    told = [] if set(codes) <= {0, 2} and 0 in codes else ["an exit code that nobody wrote down"]
    wholes = [bytes_of(place / f"run{seed}") for seed in (11, 22)]
    told += [] if bytes_of(folder) in wholes else ["a mixture of two runs"]
    return f"exit codes {codes[0]} and {codes[1]}", told


def main() -> int:
    """Everything, in a temporary folder."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--interrupts", type=int, default=30)
    parser.add_argument("--pairs", type=int, default=10)
    parser.add_argument("--seed", type=int, default=1)
    asked = parser.parse_args()
    generator = np.random.default_rng(asked.seed)
    bad = 0
    with tempfile.TemporaryDirectory() as name:
        place = Path(name)
        every, lasts = commands(place)
        print("uninterrupted: " + ", ".join(f"{name} {seconds:.1f} s" for name, seconds in lasts.items()), flush=True)
        for number in range(asked.interrupts):
            command = every[number % len(every)]
            sent = SIGNALS[int(generator.integers(len(SIGNALS)))]
            after = float(generator.uniform(0.0, lasts[command.name]))
            ended, told = interrupted(command, place / f"interrupted{number}", after, sent)
            bad += bool(told)
            print(f"{command.name}, {sent.name} after {after:.1f} s, {ended}: {'; '.join(told) or 'good'}", flush=True)
        for number in range(asked.pairs):
            later = float(generator.uniform(0.0, lasts["run"]))
            ended, told = pair(place / f"pair{number}", later, place)
            bad += bool(told)
            print(f"two runs, {later:.1f} s apart, {ended}: {'; '.join(told) or 'good'}", flush=True)
    print(f"{bad} of {asked.interrupts + asked.pairs} at fault")
    return int(bad > 0)


if __name__ == "__main__":
    sys.exit(main())
