"""Partners that fall silent: a call to another machine gets an end, and a process of ours that stands still is ended.

A process that somebody stops (SIGSTOP, a debugger) neither answers nor ends. What it owes is then done by another one.
"""

from __future__ import annotations

import contextlib
import os
import signal
import subprocess
import threading
import time
from collections.abc import Callable, Iterable
from queue import Empty, SimpleQueue
from typing import Any

LOOK = 1.0  # s between two looks at the children
PATIENCE = 30  # looks at a child that stands still, one after another; where we were stopped too, we do not look


def within(seconds: float, function: Callable[..., Any], *arguments: Any, **named: Any) -> Any:
    """``function(*arguments)``; raises what it raises, or ``TimeoutError`` where it has not ended in so many seconds.

    It then goes on in a thread that nobody waits for.
    """
    ended: SimpleQueue[tuple[bool, Any]] = SimpleQueue()

    def call() -> None:
        try:
            ended.put((True, function(*arguments, **named)))
        except BaseException as error:
            ended.put((False, error))

    threading.Thread(target=call, daemon=True).start()
    try:
        is_done, answer = ended.get(timeout=seconds)
    except Empty:
        raise TimeoutError(f"no answer for {seconds:g} s") from None
    if not is_done:
        raise answer
    return answer


def stands_still(child: int) -> bool:
    """Whether a child process has been stopped and not continued."""
    try:
        return os.waitid(os.P_PID, child, os.WSTOPPED | os.WNOHANG | os.WNOWAIT) is not None
    except (OSError, AttributeError):  # it is no more; or such systems do not stop a process
        return False


class Watch:
    """Ends children that stand still for too long."""

    def __init__(self) -> None:
        self._seen: dict[int, int] = {}

    def look(self, children: Iterable[int]) -> None:
        """Look at the children that there are now; the ``PATIENCE``-th time that one stands still is its last."""
        self._seen = {child: self._seen.get(child, 0) + 1 for child in children if stands_still(child)}
        for child, looks in self._seen.items():
            if looks >= PATIENCE:
                with contextlib.suppress(ProcessLookupError):
                    os.kill(child, signal.SIGKILL)


def watch(process: subprocess.Popen[Any]) -> None:
    """Have a thread look at a child until it has ended."""

    def looking() -> None:
        one = Watch()
        while process.returncode is None:
            one.look([process.pid])
            time.sleep(LOOK)

    threading.Thread(target=looking, daemon=True).start()
