"""Runs pytest in forks of a process that has imported the slow packages once, a tenth of a start from nothing.

One request per line of the standard input, JSON: folder to run in, file for the output, arguments of pytest. The
answer is the exit code, negative for a signal.
"""

from __future__ import annotations

import json
import os
import signal
import sys

import filterpy.kalman  # noqa: F401 (imported for the forks)
import hypothesis.strategies  # noqa: F401
import jsbsim  # noqa: F401
import pydantic  # noqa: F401
import pytest
import scipy.integrate
import scipy.interpolate
import scipy.optimize
import scipy.stats  # noqa: F401

LONGEST = (
    60  # s of processor time, ten times as long on the clock; a mutant that never ends is as dead as one that fails
)


def child(folder: str, output: str, arguments: list[str]) -> int:
    """The exit code of pytest in ``folder``, which holds the packages to test."""
    signal.setitimer(signal.ITIMER_PROF, LONGEST)
    signal.alarm(10 * LONGEST)
    log = os.open(output, os.O_WRONLY | os.O_CREAT, 0o600)
    os.dup2(log, 1)
    os.dup2(log, 2)
    os.chdir(folder)
    sys.path.insert(0, folder)
    return int(pytest.main(arguments))


def serve() -> None:
    """Answer until the input ends."""
    for line in sys.stdin:
        pid = os.fork()
        if pid == 0:
            code = 1
            try:
                code = child(*json.loads(line))
            finally:
                sys.stdout.flush()
                os._exit(code)
        _, status = os.waitpid(pid, 0)
        print(os.waitstatus_to_exitcode(status), flush=True)


if __name__ == "__main__":
    serve()
