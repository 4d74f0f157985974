"""Work shared with a helper process: trackers of a run, figures of a ledger.

Code with calls to share asks for `current`. Within `with helper():` a part of the calls runs in the helper; results are
the same as in this process, where all calls run if there is no helper or it is lost.
"""

from __future__ import annotations

import os
from collections import deque
from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import Future, ThreadPoolExecutor
from contextlib import contextmanager
from contextvars import ContextVar
from queue import SimpleQueue
from typing import Any

from sim.workers.helper_process import HelperProcess, Lost


class Sharing:
    """Runs calls in a helper process and in this one, one at a time in each."""

    def __init__(self, helper: HelperProcess | None = None) -> None:
        self.helper = helper
        self._thread = ThreadPoolExecutor(1)  # waits for the answers; costs nothing until it is used

    def later(self, function: Callable[..., Any], *arguments: Any) -> Callable[[], Any]:
        """Start a call in the helper; what is returned gives its result, computed here where the helper is lost."""
        begun: Future[Any] | None = None
        if self.helper is not None:
            begun = self._thread.submit(self.helper.call, function, *arguments)

        def result() -> Any:
            if begun is not None:
                try:
                    return begun.result()
                except Lost:
                    pass
            return function(*arguments)

        return result

    def as_done(
        self, function: Callable[..., Any], calls: Sequence[tuple[Any, ...]], common: tuple[Any, ...] = ()
    ) -> Iterator[tuple[int, Any]]:
        """Number and result of a function for several arguments, as each ends.

        This process takes calls from the front, the helper from the back. ``common`` are arguments of every call,
        before the others, which travel to the helper only once. Raises what the function raises.
        """
        waiting = deque(enumerate(calls))
        done: SimpleQueue[tuple[int, Any]] = SimpleQueue()
        to_helper = (with_kept, function) if common else (function,)

        def there(helper: HelperProcess) -> None:
            try:
                if common and waiting:
                    helper.call(keep, common)
            except Lost:
                return
            while (call := _taken(waiting.pop)) is not None:
                try:
                    done.put((call[0], helper.call(*to_helper, *call[1])))
                except Lost:
                    waiting.append(call)
                    return

        def here() -> Iterator[tuple[int, Any]]:
            while (call := _taken(waiting.popleft)) is not None:
                yield call[0], function(*common, *call[1])
                while not done.empty():
                    yield done.get()

        if self.helper is not None:
            fed = self._thread.submit(there, self.helper)
            try:
                yield from here()
                fed.result()
            except BaseException as error:
                waiting.clear()  # nothing more is begun there
                if not isinstance(error, Exception):
                    self.helper.process.kill()  # stopped: its last call is not waited for
                raise
        while not done.empty():
            yield done.get()
        yield from here()  # all of it, or what a lost process has left

    def in_order(
        self, function: Callable[..., Any], calls: Sequence[tuple[Any, ...]], common: tuple[Any, ...] = ()
    ) -> list[Any]:
        """The results of `as_done` in the order of the calls."""
        found = dict(self.as_done(function, calls, common))
        return [found[number] for number in range(len(calls))]

    def stop(self) -> None:
        """Stop the helper at once."""
        if self.helper is not None:
            self.helper.process.kill()
            self._thread.shutdown(cancel_futures=True)
            self.helper.end()


_kept: list[Any] = []  # in a helper: the common arguments of the calls that come


def keep(common: tuple[Any, ...]) -> None:
    """In a helper: take the common arguments of further calls, in place of earlier ones."""
    _kept[:] = common


def with_kept(function: Callable[..., Any], *arguments: Any) -> Any:
    """In a helper: a call with the common arguments before its own."""
    return function(*_kept, *arguments)


ALONE = Sharing()
_current: ContextVar[Sharing] = ContextVar("sharing", default=ALONE)


def current() -> Sharing:
    """The sharing in force: with a helper, or without."""
    return _current.get()


@contextmanager
def helper(worth_it: bool = True, ready: Callable[[], None] | None = None) -> Iterator[Sharing]:
    """Share work with a helper process that first runs ``ready``; without one where it does not pay, as on one CPU."""
    processors = len(os.sched_getaffinity(0) if hasattr(os, "sched_getaffinity") else range(2))
    sharing = Sharing(HelperProcess()) if worth_it and processors > 1 else ALONE
    before = _current.set(sharing)
    try:
        if ready is not None and sharing is not ALONE:
            sharing.later(ready)
        yield sharing
    finally:
        _current.reset(before)
        sharing.stop()


def _taken(end: Callable[[], Any]) -> Any:
    """Take a waiting call from one end of the queue; None when it is empty."""
    try:
        return end()
    except IndexError:
        return None
