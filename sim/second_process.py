"""A second process that takes a part of a run's work: half of the trackers, and the figures of the flight.

Whatever it is asked for is the same when it is done here instead, and is done here where there is no second processor
or the process is lost.
"""

from __future__ import annotations

import multiprocessing
import os
import signal
from collections import deque
from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import Future, ProcessPoolExecutor, ThreadPoolExecutor
from concurrent.futures.process import BrokenProcessPool
from contextlib import contextmanager, suppress
from typing import Any

FEW = 4  # trackers are done before a second process has got ready


class SecondProcess:
    """Calls in another process, or in this one where there is no other."""

    def __init__(self, pool: ProcessPoolExecutor | None = None) -> None:
        self.pool = pool

    def later(self, function: Callable[..., Any], *arguments: Any) -> Callable[[], Any]:
        """Begin a call there, at once; what is returned gives its result, and makes it here where it must."""
        begun: Future[Any] | None = None
        if self.pool is not None:
            with suppress(BrokenProcessPool):
                begun = self.pool.submit(function, *arguments)

        def result() -> Any:
            if begun is not None:
                with suppress(BrokenProcessPool):
                    return begun.result()
            return function(*arguments)

        return result

    def shared(self, function: Callable[..., Any], calls: Sequence[tuple[Any, ...]]) -> list[Any]:
        """The results of a function for several arguments: this process begins with the first, the other with the last.

        Raises what the function raises.
        """
        found: dict[int, Any] = {}
        waiting = deque(enumerate(calls))

        def here() -> None:
            while (call := _taken(waiting.popleft)) is not None:
                found[call[0]] = function(*call[1])

        def there(pool: ProcessPoolExecutor) -> None:
            while (call := _taken(waiting.pop)) is not None:
                try:
                    found[call[0]] = pool.submit(function, *call[1]).result()
                except BrokenProcessPool:
                    waiting.append(call)
                    return

        if self.pool is not None:
            with ThreadPoolExecutor(1) as feeder:
                fed = feeder.submit(there, self.pool)
                try:
                    here()
                except BaseException:
                    waiting.clear()  # nothing more is begun there
                    raise
                fed.result()
        here()  # all of it, or what a lost process has left
        return [found[number] for number in range(len(calls))]


ALONE = SecondProcess()


def _taken(end: Callable[[], Any]) -> Any:
    """A call from one end of those that wait; None when there is none."""
    try:
        return end()
    except IndexError:
        return None


@contextmanager
def second_process(trackers: int) -> Iterator[SecondProcess]:
    """One for a run with so many trackers, where it saves time."""
    if trackers < FEW or len(os.sched_getaffinity(0) if hasattr(os, "sched_getaffinity") else range(2)) < 2:
        yield SecondProcess()
        return
    pool = ProcessPoolExecutor(1, multiprocessing.get_context("spawn"), _get_ready)
    try:
        pool.submit(_import)
        yield SecondProcess(pool)
    finally:
        pool.shutdown(cancel_futures=True)


def _get_ready() -> None:
    signal.signal(signal.SIGINT, signal.SIG_IGN)  # Ctrl-C is the first process's affair


def _import() -> None:
    """What takes long to import, while the aircraft still flies."""
    from sim.reporting.report import charts  # noqa: F401
    from sim.reporting.style import get_ready
    from sim.trackers import track  # noqa: F401

    get_ready()
