"""Another Python process that does one call after another, within optional limits of time and memory.

Both processes run the same code and exchange pickles. The helper ends with its parent, or when a call exceeds its
limits; the caller then learns how it ended, and loses only that call.
"""

from __future__ import annotations

import contextlib
import os
import pickle
import subprocess
import sys
import threading
import time
import traceback
from collections.abc import Callable
from tempfile import TemporaryDirectory
from typing import Any

from sim.workers.blas import THREADS
from sim.workers.executors import CLOCK_FACTOR, limited, prepare_worker
from sim.workers.last_words import LastWords, ending
from sim.workers.partners import watch

MARK = "SHORTFINAL_HELPER"  # set in a helper's environment
START = "import sys; sys.path[:] = {path!r}; from sim.workers.helper_process import serve; serve({limit!r})"


class Lost(Exception):
    """A helper that has ended.

    ``ending`` says how (a signal), ``late`` whether because its call gave no answer in time, ``computed`` what
    processor time the call had used (s), ``said`` what was written to standard error, on one line.
    """

    def __init__(self, ending: str, late: bool, computed: float, said: str) -> None:
        super().__init__(ending)
        self.ending, self.late, self.computed, self.said = ending, late, computed, said


class HelperProcess:
    """A process, and the two pipes to it."""

    def __init__(self, memory_limit: int | None = None) -> None:
        """Start it; with a limit of memory (bytes) it is for risky work, which may kill it.

        The last words of aborting C++ code are then kept for ``Lost``, and temporary files are removed with it. Raises
        ``OSError`` where no process can be started.
        """
        risky = memory_limit is not None
        self.folder = TemporaryDirectory(prefix="shortfinal-") if risky else None
        temporary = dict.fromkeys(("TMPDIR", "TEMP", "TMP"), self.folder.name) if self.folder is not None else {}
        self.process = subprocess.Popen(
            [sys.executable, "-P", "-c", START.format(path=sys.path, limit=memory_limit)],
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            stderr=subprocess.PIPE if risky else None,
            env={**dict.fromkeys(THREADS, "1"), **os.environ, **temporary, MARK: "1"},
        )
        watch(self.process)
        self._said = LastWords(self.process.stderr)
        self._before = 0.0  # s of processor time, when the last call had ended

    def call(self, function: Callable[..., Any], *arguments: Any, time_limit: float | None = None) -> Any:
        """``function(*arguments)`` in the helper; raises what it raises, or ``Lost`` when the helper has ended.

        ``time_limit`` is of processor time, s, and ``CLOCK_FACTOR`` times as long on the clock; None = none.
        """
        given = (function, arguments) if time_limit is None else (limited, (time_limit, function, arguments))
        work = pickle.dumps(given, pickle.HIGHEST_PROTOCOL)
        to, back, late = self.process.stdin, self.process.stdout, threading.Event()
        assert to is not None
        assert back is not None

        def too_late() -> None:
            late.set()
            self.process.kill()

        timer = threading.Timer(CLOCK_FACTOR * (time_limit or 0.0), too_late)
        timer.daemon = True
        if time_limit is not None:
            timer.start()
        try:
            to.write(work)
            to.flush()
            is_done, answer, self._before = pickle.load(back)
        except (EOFError, OSError, ValueError, pickle.UnpicklingError):  # ValueError: a pipe that is closed already
            before = _of_children()
            how = self.end()
            computed = max(0.0, _of_children() - before - self._before)
            raise Lost(how, late.is_set(), computed, self._said.read()) from None
        except BaseException:
            self.end()
            raise
        finally:
            timer.cancel()
        if not is_done:
            raise answer
        return answer

    def end(self) -> str:
        """Stop it at once; returns how it had ended where it already had."""
        with contextlib.suppress(subprocess.TimeoutExpired):
            self.process.wait(0.2)  # one that is dying says of what
        self.process.kill()
        code = self.process.wait()
        self._said.end()
        for pipe in (self.process.stdin, self.process.stdout, self.process.stderr):
            if pipe is not None:
                with contextlib.suppress(OSError):
                    pipe.close()
        if self.folder is not None:
            self.folder.cleanup()
        return ending(code)


def _of_children() -> float:
    """Processor time of all children that have ended, s."""
    ended = os.times()
    return ended.children_user + ended.children_system


def is_helper() -> bool:
    """Whether this process is one itself."""
    return MARK in os.environ


def serve(memory_limit: int | None) -> None:
    """Answer calls from standard input, one after another, until it closes."""
    answers = os.fdopen(os.dup(1), "wb")
    silence = os.open(os.devnull, os.O_WRONLY)
    os.dup2(silence, 1)  # whatever a model prints is not an answer
    prepare_worker(memory_limit)
    while True:
        try:
            function, arguments = pickle.load(sys.stdin.buffer)
        except EOFError:
            return
        try:
            answer = (True, function(*arguments), time.process_time())
        except Exception as error:  # whatever it is, the caller gets it as if it had called the function itself
            error.add_note(traceback.format_exc())
            answer = (False, error, time.process_time())
        pickle.dump(answer, answers, pickle.HIGHEST_PROTOCOL)
        answers.flush()
