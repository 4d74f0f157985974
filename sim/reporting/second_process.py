"""The figures of a flight, drawn by a second process while the first one still tracks it."""

from __future__ import annotations

import multiprocessing
import os
import signal
from collections.abc import Iterator
from concurrent.futures import Future, ProcessPoolExecutor
from concurrent.futures.process import BrokenProcessPool
from contextlib import contextmanager, suppress
from typing import Any

from sim.flight import Flight
from sim.reporting.style import Chart

FEW = 4  # trackers are done before a second process has got ready


class Draughtsman:
    """Draws in another process, or in this one where there is no other or it is lost."""

    def __init__(self, pool: ProcessPoolExecutor | None = None) -> None:
        self.pool = pool
        self._given: tuple[Any, ...] = ()
        self._drawn: Future[list[Chart]] | None = None

    def draw(self, flight: Flight, scenario: Any, law: Any) -> None:
        """Begin with the figures of a flight; returns at once."""
        from sim.reporting.report import charts

        self._given = flight, scenario, law
        if self.pool is not None:
            with suppress(BrokenProcessPool):
                self._drawn = self.pool.submit(charts, *self._given)

    def charts(self) -> list[Chart]:
        """The figures, as soon as they are drawn."""
        from sim.reporting.report import charts

        if self._drawn is not None:
            with suppress(BrokenProcessPool):
                return self._drawn.result()
        return charts(*self._given)


@contextmanager
def draughtsman(trackers: int) -> Iterator[Draughtsman]:
    """One for a run with so many trackers: with a process of its own where that saves time."""
    if trackers < FEW or len(os.sched_getaffinity(0) if hasattr(os, "sched_getaffinity") else range(2)) < 2:
        yield Draughtsman()
        return
    pool = ProcessPoolExecutor(1, multiprocessing.get_context("spawn"), _get_ready)
    try:
        pool.submit(_import)
        yield Draughtsman(pool)
    finally:
        pool.shutdown(cancel_futures=True)


def _get_ready() -> None:
    signal.signal(signal.SIGINT, signal.SIG_IGN)  # Ctrl-C is the first process's affair


def _import() -> None:
    """What takes long to import, while the aircraft still flies."""
    from sim.reporting.report import charts  # noqa: F401
    from sim.reporting.style import import_matplotlib

    import_matplotlib()
    import matplotlib.backends.backend_svg
    import matplotlib.figure  # noqa: F401
