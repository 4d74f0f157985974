"""Runs commands one after another in this process, and says how each ended; a JSON list of them stands in a file."""

from __future__ import annotations

import contextlib
import io
import json
import os
import sys
import traceback
from pathlib import Path


def answer(arguments: list[str], folder: str) -> dict[str, object]:
    """Exit code, output and traceback of one command."""
    from sim.cli.commands import main

    out, err, trace = io.StringIO(), io.StringIO(), ""
    sys.argv = ["shortfinal", *arguments]
    os.chdir(folder)
    with contextlib.redirect_stdout(out), contextlib.redirect_stderr(err):
        try:
            main()
            code = 0
        except SystemExit as end:
            code = end.code if isinstance(end.code, int) else 0 if end.code is None else 1
        except BaseException:
            code, trace = -1, traceback.format_exc()
    return {"code": code, "out": out.getvalue(), "err": err.getvalue(), "trace": trace}


def all_answers(asked: Path, told: Path) -> None:
    """One line for each command, written as soon as it ended."""
    with told.open("w") as file:
        for name, arguments, folder in json.loads(asked.read_text()):
            print(json.dumps([name, answer(arguments, folder)]), file=file, flush=True)


if __name__ == "__main__":
    all_answers(Path(sys.argv[1]), Path(sys.argv[2]))
