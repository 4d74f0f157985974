"""What a process leaves that dies: how it ended, and what it wrote to standard error at last."""

from __future__ import annotations

import contextlib
import os
import re
import signal
import threading
from typing import Protocol

LAST = 4096  # bytes of what was written to standard error
LONGEST_REASON = 300  # characters of it in a sentence
ESCAPES = re.compile(r"\x1b\[[0-9;]*[A-Za-z]")  # colours of a terminal
PRIVATE = re.compile(r"/\S*/shortfinal-[^/\s]*/")  # folders that the user never saw


class Pipe(Protocol):
    """The end of a pipe that is read."""

    def fileno(self) -> int:
        """Its number."""
        ...


class LastWords:
    """What is written to a pipe at last; it is emptied all the time, or its writer would have to wait."""

    def __init__(self, pipe: Pipe | None) -> None:
        self._kept = b""
        self._thread = threading.Thread(target=self._empty, args=(pipe,), daemon=True)
        if pipe is not None:
            self._thread.start()

    def _empty(self, pipe: Pipe) -> None:
        with contextlib.suppress(OSError, ValueError):
            while some := os.read(pipe.fileno(), 65536):
                self._kept = (self._kept + some)[-LAST:]

    def end(self) -> None:
        """Wait for the end of the pipe, whose writer is gone."""
        if self._thread.ident is not None:
            self._thread.join(1.0)

    def read(self) -> str:
        """On one line, printable, of an exception what it says; empty where nothing was written."""
        text = ESCAPES.sub("", self._kept.decode(errors="replace"))
        _, exception, message = text.rpartition("what():")
        text = " ".join(PRIVATE.sub("", message).split())
        text = "".join(letter for letter in text if letter.isprintable())
        return text[:LONGEST_REASON] if exception else text[-LONGEST_REASON:]


def ending(code: int) -> str:
    """How a process ended, by its exit code: the name of a signal, or the code itself."""
    with contextlib.suppress(ValueError):
        return signal.Signals(-code).name
    return f"exit code {code}"
