"""Risky work in a child process: a model that is not ours may abort or hang whoever loads it, and costs one sentence.

One child serves all calls of this process, and is started when it is first needed, so runs of our own aircraft pay
nothing. It ends with its parent; where it is lost, the next call has a new one.

Parent and child run the same code and exchange pickles. A model is data for JSBSim, read from its stripped copy; what
is kept out here are its aborts, hangs and memory, not an attacker who could run code inside the child.
"""

from __future__ import annotations

import atexit
import contextlib
import multiprocessing
import os
import pickle
import signal
import subprocess
import sys
import threading
import traceback
from collections.abc import Callable
from tempfile import TemporaryDirectory
from typing import Any

from sim.errors import ScenarioError
from sim.workers.blas import THREADS
from sim.workers.executors import MEMORY_LIMIT, prepare_worker

MARK = "SHORTFINAL_QUARANTINE"  # set in the child's environment
START = "import sys; sys.path[:] = {path!r}; from sim.workers.isolation import serve; serve()"
KINEMATICS = "point_mass"


def apart(scenario: Any, time_limit: float, function: Callable[..., Any], *arguments: Any) -> Any:
    """``function(*arguments)``, in a child process where the scenario's aircraft is not one of ours.

    Raises what the function raises, and ``ScenarioError`` in one sentence where the child aborts, runs out of memory or
    gives no answer for ``time_limit`` seconds.
    """
    model = scenario.aircraft.model
    if _is_ours(model) or MARK in os.environ or multiprocessing.parent_process() is not None:
        return function(*arguments)
    try:
        done, answer = _asked(pickle.dumps((function, arguments)), time_limit)
    except _Gone as gone:
        raise ScenarioError(f"{scenario.name}: [aircraft] the model '{model}' {gone}; it cannot be flown") from None
    if not done:
        raise answer
    return answer


class _Gone(Exception):
    """A child that is lost, and how."""

    def __init__(self, how: str, late: bool) -> None:
        super().__init__(how)
        self.late = late


class _Child:
    """A process that does one thing after another, and the two pipes to it."""

    def __init__(self) -> None:
        self.folder = TemporaryDirectory(prefix="shortfinal-")  # what a child that aborts leaves behind, it leaves here
        temporary = dict.fromkeys(("TMPDIR", "TEMP", "TMP"), self.folder.name)
        self.process = subprocess.Popen(
            [sys.executable, "-P", "-c", START.format(path=sys.path)],
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            stderr=subprocess.DEVNULL,  # what a C++ library says when it aborts
            env={**os.environ, **dict.fromkeys(THREADS, "1"), **temporary, MARK: "1"},
        )
        assert self.process.stdin is not None  # pipes, as they were asked for
        assert self.process.stdout is not None
        self.calls, self.answers = self.process.stdin, self.process.stdout

    def ask(self, work: bytes, time_limit: float) -> tuple[bool, Any]:
        """Whether it is done, and the result or the exception; raises ``_Gone``, and then the child is no more."""
        late = threading.Event()

        def stop() -> None:
            late.set()
            self.process.kill()

        timer = threading.Timer(time_limit, stop)
        timer.daemon = True
        timer.start()
        try:
            self.calls.write(work)
            self.calls.flush()
            answer: tuple[bool, Any] = pickle.load(self.answers)
            return answer
        except (EOFError, OSError, pickle.UnpicklingError):
            ending = self.end()
            how = f"gives no answer for {time_limit:g} s" if late.is_set() else f"aborts the simulation ({ending})"
            raise _Gone(how, late.is_set()) from None
        except BaseException:
            self.end()
            raise
        finally:
            timer.cancel()

    def end(self) -> str:
        """End it, and how it had ended by itself where it had."""
        with contextlib.suppress(subprocess.TimeoutExpired):
            self.process.wait(0.2)  # one that is dying says of what
        self.process.kill()
        code = self.process.wait()
        for pipe in (self.calls, self.answers):
            with contextlib.suppress(OSError):
                pipe.close()
        self.folder.cleanup()
        with contextlib.suppress(ValueError):
            return signal.Signals(-code).name
        return f"exit code {code}"


_waiting: list[_Child] = []  # the child between two calls; a process is state, whatever one calls it


def _asked(work: bytes, time_limit: float) -> tuple[bool, Any]:
    while True:
        is_fresh = not _waiting
        child = _started() if is_fresh else _waiting.pop()
        try:
            answer = child.ask(work, time_limit)
        except _Gone as gone:
            if is_fresh or gone.late:
                raise
            continue  # it may have died of what it did before
        _waiting.append(child)
        return answer


def _started() -> _Child:
    try:
        return _Child()
    except OSError as error:
        raise _Gone(f"needs a process of its own, which cannot be started: {error.strerror}", False) from None


@atexit.register
def _end_waiting() -> None:
    while _waiting:
        child = _waiting.pop()
        child.process.kill()
        child.end()


def _is_ours(model: str) -> bool:
    from aircraft.model_files import OWN_MODELS, is_file

    return model == KINEMATICS or ("/" not in model and is_file(OWN_MODELS / model / f"{model}.xml"))


def serve() -> None:
    """Do what comes through standard input, one thing after another, until it closes."""
    answers = os.fdopen(os.dup(1), "wb")
    silence = os.open(os.devnull, os.O_WRONLY)
    os.dup2(silence, 1)  # whatever a model prints is not an answer
    prepare_worker(MEMORY_LIMIT)
    while True:
        try:
            function, arguments = pickle.load(sys.stdin.buffer)
        except EOFError:
            return
        try:
            answer = (True, function(*arguments))
        except MemoryError:
            answer = (False, ScenarioError(f"the model needs more than {MEMORY_LIMIT >> 20} MB of memory"))
        except Exception as error:  # whatever it is, the caller gets it as if it had called the function itself
            error.add_note(traceback.format_exc())
            answer = (False, error)
        pickle.dump(answer, answers, pickle.HIGHEST_PROTOCOL)
        answers.flush()
