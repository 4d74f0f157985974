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
from concurrent.futures import Future, ThreadPoolExecutor
from contextlib import contextmanager
from queue import SimpleQueue
from typing import Any


class Lost(Exception):
    """The second process is gone, and what it was asked for with it."""


class SecondProcess:
    """Calls in another process, one after the other, or in this one where there is no other."""

    def __init__(self, there: bool = False) -> None:
        self.process: Any = None
        if there:
            context = multiprocessing.get_context("spawn")
            calls, self._calls = context.Pipe(duplex=False)  # two pipes: one for both ways would be a socket
            self._answers, answers = context.Pipe(duplex=False)
            self._thread = ThreadPoolExecutor(1)  # waits for the answers
            self.process = context.Process(target=_serve, args=(calls, answers), daemon=True)
            self.process.start()
            answers.close()  # so that its death is heard
            calls.close()

    def stop(self) -> None:
        """End the process at once, whatever it does."""
        if self.process is not None:
            self.process.kill()
            self.process.join()
            self._thread.shutdown(cancel_futures=True)

    def _call(self, function: Callable[..., Any], *arguments: Any) -> Any:
        try:
            self._calls.send((function, arguments))
            good, answer = self._answers.recv()
        except (EOFError, OSError):
            raise Lost from None
        if not good:
            raise answer
        return answer

    def later(self, function: Callable[..., Any], *arguments: Any) -> Callable[[], Any]:
        """Begin a call there, at once; what is returned gives its result, and makes it here where it must."""
        begun: Future[Any] | None = None
        if self.process is not None:
            begun = self._thread.submit(self._call, function, *arguments)

        def result() -> Any:
            if begun is not None:
                try:
                    return begun.result()
                except Lost:
                    pass
            return function(*arguments)

        return result

    def as_done(self, function: Callable[..., Any], calls: Sequence[tuple[Any, ...]]) -> Iterator[tuple[int, Any]]:
        """Number and result of a function for several arguments, as each ends.

        This process begins with the first call, the other with the last. Raises what the function raises.
        """
        waiting = deque(enumerate(calls))
        done: SimpleQueue[tuple[int, Any]] = SimpleQueue()

        def there() -> None:
            while (call := _taken(waiting.pop)) is not None:
                try:
                    done.put((call[0], self._call(function, *call[1])))
                except Lost:
                    waiting.append(call)
                    return

        def here() -> Iterator[tuple[int, Any]]:
            while (call := _taken(waiting.popleft)) is not None:
                yield call[0], function(*call[1])
                while not done.empty():
                    yield done.get()

        if self.process is not None:
            fed = self._thread.submit(there)
            try:
                yield from here()
                fed.result()
            except BaseException as error:
                waiting.clear()  # nothing more is begun there
                if not isinstance(error, Exception):
                    self.process.kill()  # stopped: its last call is not waited for
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
    second = SecondProcess(there=True)
    try:
        if ready is not None:
            second.later(ready)
        yield second
    finally:
        second.stop()


def _serve(calls: Any, answers: Any) -> None:
    """In the second process: answer call after call, until the first one is gone."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)  # Ctrl-C is the first process's affair
    while True:
        try:
            function, arguments = calls.recv()
        except EOFError:
            return
        try:
            answer = True, function(*arguments)
        except Exception as error:  # the caller gets it as if it had called the function itself
            answer = False, error
        answers.send(answer)
