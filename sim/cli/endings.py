"""How a command ends: its exit code, one sentence for every fault, and what happens when it is stopped.

A fault that nobody foresaw has a code of its own, so that a script never takes it for a check that failed; its
traceback goes to a private file of the temporary folder, which the sentence names.
"""

from __future__ import annotations

import contextlib
import os
import signal
import sys
import tempfile
import traceback
from collections.abc import Callable, Iterator
from types import FrameType
from typing import Any

from sim.cli.terminal import say
from sim.errors import printable

GOOD, CHECK_FAILED, BAD_INPUT, FLIGHTS_CRASHED, UNFORESEEN = 0, 1, 2, 3, 4
STOPPED = 128  # and the number of the signal, as shells have it
STOPPING = (signal.SIGTERM, signal.SIGHUP)


class SignalCame(KeyboardInterrupt):
    """A signal that is to stop the command, with its number.

    Its own class, because of a plain `KeyboardInterrupt` that passes through code which an extension runs Python keeps
    a note, and ends the process as SIGINT would, whatever exit code it was given.
    """


class Interrupted(Exception):
    """A command that was stopped, with its exit code."""

    def __init__(self, code: int) -> None:
        super().__init__("stopped")
        self.code = code


class ReaderGone(Exception):
    """Standard output that nobody reads any more, as after ``head``."""


class Unwritable(Exception):
    """Standard output that does not take what a command has to say."""


def stop_code(stop: KeyboardInterrupt) -> int:
    """The exit code of what was stopped: 130 for Ctrl-C, 143 and 129 for SIGTERM and SIGHUP."""
    return STOPPED + (stop.args[0] if stop.args else signal.SIGINT)


@contextlib.contextmanager
def told_apart() -> Iterator[None]:
    """What stops a command from outside, as exceptions of our own: typer makes exit codes of the common ones."""
    try:
        yield
    except KeyboardInterrupt as stop:
        raise Interrupted(stop_code(stop)) from stop
    except BrokenPipeError as gone:
        raise ReaderGone from gone


@contextlib.contextmanager
def stopped_by_signals() -> Iterator[list[int]]:
    """Within, batch systems can stop this process as Ctrl-C does: nothing is left behind. Gives the signals that came.

    A signal that is ignored already, as ``nohup`` has it, stays ignored. A second one does not disturb the cleaning up,
    but for a second Ctrl-C.
    """
    came: list[int] = []

    def stop(number: int, frame: FrameType | None) -> None:
        came.append(number)
        for each in STOPPING:
            signal.signal(each, signal.SIG_IGN)
        if number == signal.SIGINT:  # a second Ctrl-C is meant
            signal.signal(number, signal.default_int_handler)
        raise SignalCame(number)

    before = {number: signal.getsignal(number) for number in (*STOPPING, signal.SIGINT)}
    for number, handler in before.items():
        if handler in (signal.SIG_DFL, signal.default_int_handler):
            signal.signal(number, stop)
    try:
        yield came
    finally:
        for number, handler in before.items():
            signal.signal(number, handler)


def unforeseen(error: BaseException) -> int:
    """Tell of a fault of the program in one sentence; the traceback is kept."""
    what = printable(f"{type(error).__name__}: {error}".partition("\n")[0].rstrip(": "))
    try:
        handle, path = tempfile.mkstemp(prefix="shortfinal-", suffix=".traceback")  # nobody else may read it
        with os.fdopen(handle, "w", encoding="utf-8", errors="backslashreplace") as file:
            traceback.print_exception(error, file=file)
        kept = f"the traceback is in {path}"
    except OSError as full:
        kept = f"its traceback cannot be kept: {full.strerror}"
    say(f"shortfinal: a fault of the program, not of your input: {what}; {kept}; please report it")
    return UNFORESEEN


def written(command: Callable[[], Any]) -> Any:
    """What a command returns, once its output is out; raises ``Unwritable`` where that is impossible.

    A reader that has gone, as ``head`` does, is not a fault: the process ends as one that SIGPIPE ends.
    """
    try:
        code = command()
        sys.stdout.flush()
        return code
    except (BrokenPipeError, ReaderGone):
        _drop_output()
        return STOPPED + signal.SIGPIPE
    except OSError:
        try:  # whether it was standard output, or something else that failed
            print(flush=True)
        except OSError as error:
            _drop_output()
            raise Unwritable(f"what it has to say cannot be written: {error.strerror}") from None
        raise


def _drop_output() -> None:
    """What is left in the buffer cannot be written: the end of the process must not try again."""
    with contextlib.suppress(OSError, ValueError, AttributeError):
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
