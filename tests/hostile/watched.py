"""Commands run under watch: what they answer, and what they did outside the folder that they were told to write."""

from __future__ import annotations

import json
import os
import re
import subprocess
import sys
from collections.abc import Sequence
from pathlib import Path
from typing import NamedTuple

HERE = Path(__file__).resolve().parent
WATCH = HERE / "watch"
ROOT = HERE.parents[1]
OWN_PROCESSES = re.compile(r"from sim\.workers\.helper_process import serve|^uname -p$")  # Python's platform asks uname


class Answer(NamedTuple):
    """How a command ended."""

    code: int
    out: str
    err: str
    trace: str

    @property
    def is_one_sentence(self) -> bool:
        """Bad input, said in one line."""
        return self.code == 2 and not self.trace and len(self.err.strip().splitlines()) == 1


class Case(NamedTuple):
    """A command and where it is called."""

    name: str
    arguments: Sequence[object]


class Sandbox(NamedTuple):
    """A world of its own for watched commands: home, temporary files, the working folder, and what attackers aim at."""

    root: Path

    def place(self, name: str) -> Path:
        """One of its folders."""
        path = self.root / name
        path.mkdir(parents=True, exist_ok=True)
        return path

    def files(self) -> dict[str, tuple[int, int]]:
        """Size and time of change of all that a command must leave alone."""
        return {
            str(path.relative_to(self.root)): (path.lstat().st_size, path.lstat().st_mtime_ns)
            for name in ("home", "cwd", "target", "models", "scenarios")
            for path in sorted(self.place(name).rglob("*"))
            if not path.is_relative_to(self.place("cwd") / "out")
        }

    def environment(self) -> dict[str, str]:
        """Variables of a watched process."""
        kept = {name: value for name, value in os.environ.items() if not name.startswith(("XDG", "MPL", "PYTEST"))}
        return kept | {
            "HOME": str(self.place("home")),
            "TMPDIR": str(self.place("tmp")),
            "PYTHONPATH": os.pathsep.join((str(WATCH), str(ROOT))),
            "PYTHONDONTWRITEBYTECODE": "1",
            "HYPOTHESIS_STORAGE_DIRECTORY": str(self.place("tmp") / "hypothesis"),
            "OPENBLAS_NUM_THREADS": "1",
            "NO_COLOR": "1",
            "COLUMNS": "500",
            "WATCH_LOG": str(self.root / "watch.log"),
            "WATCH_SOCKETS": "barred",
        }

    def answers(self, cases: Sequence[Case], time_limit: float = 600.0) -> dict[str, Answer]:
        """What each command answers; all run in one process, which must outlive them."""
        asked, told = self.root / "asked.json", self.root / "told.jsonl"
        folder = str(self.place("cwd"))
        asked.write_text(json.dumps([(case.name, [*map(str, case.arguments)], folder) for case in cases]))
        self.watched("batch.py", asked, told, time_limit=time_limit)
        return dict(self.told(told))

    def mutations(self, examples: int, every: int, time_limit: float) -> list[tuple[str, Answer]]:
        """Scenarios bent at random, and what each is answered; of those that fly, ``every`` so many gets its report."""
        told = self.root / "told.jsonl"
        self.watched("mutate.py", told, examples, every, time_limit=time_limit)
        return self.told(told)

    def watched(self, script: str, *arguments: object, time_limit: float) -> None:
        """Run a script of the watch; it must outlive all that it runs, and print nothing of its own."""
        done = subprocess.run(
            [sys.executable, str(WATCH / script), *map(str, arguments)],
            env=self.environment(),
            cwd=self.place("cwd"),
            capture_output=True,
            text=True,
            timeout=time_limit,
            check=False,
        )
        told = self.root / "told.jsonl"
        last = self.told(told)[-1][0] if told.is_file() and told.stat().st_size else "none"
        assert done.returncode == 0, f"the process died after '{last}': {done.returncode} {done.stderr[-2000:]}"
        assert not done.stdout, "something printed past the command"

    @staticmethod
    def told(file: Path) -> list[tuple[str, Answer]]:
        """What a script wrote down."""
        lines = [json.loads(line) for line in file.read_text().splitlines()]
        return [(name, Answer(**answer)) for name, answer in lines]

    def acts(self) -> list[list[str]]:
        """All that was noted: [event, path or text, ...]."""
        log = self.root / "watch.log"
        return [json.loads(line) for line in log.read_text().splitlines()] if log.is_file() else []

    def offences(self, asked: Sequence[str] = ()) -> list[str]:
        """Acts outside ``out``, ``asked`` places and the temporary folder; sockets; processes of others."""
        places = [str(self.place("cwd") / name) for name in ("out", *asked)]
        allowed = (*places, str(self.place("tmp")), os.devnull, str(self.root / "told.jsonl"))
        return [
            " ".join(act)
            for act in self.acts()
            if not (act[0] == "subprocess.Popen" and OWN_PROCESSES.search(act[1]))
            and not all(path.startswith(allowed) for path in act[1:])
        ]
