"""A second process that takes a part of the work: trackers and figures of a run, claims of a ledger.

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
from queue import SimpleQueue
from typing import Any


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

    def as_done(self, function: Callable[..., Any], calls: Sequence[tuple[Any, ...]]) -> Iterator[tuple[int, Any]]:
        """Number and result of a function for several arguments, as each ends.

        This process begins with the first call, the other with the last. Raises what the function raises.
        """
        waiting = deque(enumerate(calls))
        done: SimpleQueue[tuple[int, Any]] = SimpleQueue()

        def there(pool: ProcessPoolExecutor) -> None:
            while (call := _taken(waiting.pop)) is not None:
                try:
                    done.put((call[0], pool.submit(function, *call[1]).result()))
                except BrokenProcessPool:
                    waiting.append(call)
                    return

        def here() -> Iterator[tuple[int, Any]]:
            while (call := _taken(waiting.popleft)) is not None:
                yield call[0], function(*call[1])
                while not done.empty():
                    yield done.get()

        if self.pool is not None:
            with ThreadPoolExecutor(1) as feeder:
                fed = feeder.submit(there, self.pool)
                try:
                    yield from here()
                    fed.result()
                except BaseException as error:
                    waiting.clear()  # nothing more is begun there
                    if not isinstance(error, Exception):  # stopped: its last call is not waited for
                        for child in multiprocessing.active_children():
                            child.kill()
                    raise
        while not done.empty():
            yield done.get()
        yield from here()  # all of it, or what a lost process has left

    def shared(self, function: Callable[..., Any], calls: Sequence[tuple[Any, ...]]) -> list[Any]:
        """The results of `as_done` in the order of the calls."""
        found = dict(self.as_done(function, calls))
        return [found[number] for number in range(len(calls))]


ALONE = SecondProcess()


def _taken(end: Callable[[], Any]) -> Any:
    """A call from one end of those that wait; None when there is none."""
    try:
        return end()
    except IndexError:
        return None


@contextmanager
def second_process(worth_it: bool = True, ready: Callable[[], None] | None = None) -> Iterator[SecondProcess]:
    """One that first gets ``ready``; none where it is not worth it or there is no second processor."""
    if not worth_it or len(os.sched_getaffinity(0) if hasattr(os, "sched_getaffinity") else range(2)) < 2:
        yield ALONE
        return
    pool = ProcessPoolExecutor(1, multiprocessing.get_context("spawn"), _begin)
    try:
        if ready is not None:
            pool.submit(ready)
        yield SecondProcess(pool)
    finally:
        pool.shutdown(cancel_futures=True)


def _begin() -> None:
    signal.signal(signal.SIGINT, signal.SIG_IGN)  # Ctrl-C is the first process's affair
