"""Where the flights of a study are flown: one interface of three calls, and worker processes on this machine.

An executor takes jobs, returns each result as it ends, in any order, and is closed. A job that is lost (its worker
aborted, hung or ran out of memory) returns ``Lost``; other jobs go on.
"""

from __future__ import annotations

import contextlib
import math
import multiprocessing
import os
import signal
import time
from collections import deque
from collections.abc import Callable, Iterator
from concurrent.futures import FIRST_COMPLETED, Future, wait
from dataclasses import dataclass, field
from typing import Any, NamedTuple, Protocol

from sim.errors import OutputError
from sim.workers.blas import THREADS
from sim.workers.last_words import LastWords, ending
from sim.workers.partners import LOOK, Watch

ATTEMPTS = 3  # a flight whose worker aborts as often is at fault itself
KILLS = 30  # a worker that is killed from outside is not its flight's fault, unless it happens this often
FLIGHT_TIME_LIMIT = 600.0  # s of processor time; the longest flight of 1800 s takes a small part of it
UNTAKEN = 120.0  # s; a worker that has not taken its job by then never will: one starts in seconds
CLOCK_FACTOR = 10.0  # times as long on the clock: a busy machine is not the model's fault, but what waits must end
MEMORY_LIMIT = 4 << 30  # bytes of address space of one worker
LEAST_MEMORY = 600 << 20  # in which flights with a few trackers fit; measured: 500 MB are enough for the bundled ones


class Lost(NamedTuple):
    """A job without a result."""

    reason: str


def late(time_limit: float) -> str:
    """Why a job is given up that computes for too long."""
    return f"no answer within {time_limit:g} s of processor time"


class Executor(Protocol):
    """Runs jobs somewhere."""

    def submit(self, number: int, function: Callable[..., Any], *arguments: Any) -> None:
        """Take a job; returns at once."""
        ...

    def finished(self) -> Iterator[tuple[int, Any]]:
        """Each job's number and its result or ``Lost``, as they end; ends when no job is left."""
        ...

    def close(self) -> None:
        """Stop all running jobs; those not started are dropped."""
        ...


def limit_here(wanted: int) -> int:
    """Bytes of address space that a worker can have: as many as are wanted, or as this machine allows a process."""
    try:
        import resource
    except ImportError:  # not a Unix
        return wanted
    _, hard = resource.getrlimit(resource.RLIMIT_AS)
    return wanted if hard == resource.RLIM_INFINITY else min(wanted, hard)


def refuse_small_limit() -> None:
    """Raise ``OutputError`` where no worker can fly within the limit that this machine sets to a process."""
    if (limit := limit_here(MEMORY_LIMIT)) < LEAST_MEMORY:
        raise OutputError(
            f"a process may have {limit >> 20} MB of memory here (ulimit -v), and a worker needs at least "
            f"{LEAST_MEMORY >> 20} MB; raise that limit"
        )


def prepare_worker(memory_limit: int | None, errors: Any = None) -> None:
    """What every worker does first: leave Ctrl-C to the parent, and limit memory where a limit is given.

    With ``errors``, the writing end of a pipe, what is written to standard error goes there.
    """
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    if errors is not None:
        with contextlib.suppress(OSError):  # on systems whose pipes are no files
            os.dup2(errors.fileno(), 2)
    if memory_limit is None:
        return
    try:
        import resource
    except ImportError:  # not a Unix
        return
    _, hard = resource.getrlimit(resource.RLIMIT_AS)
    resource.setrlimit(resource.RLIMIT_AS, (limit_here(memory_limit), hard))
    resource.setrlimit(resource.RLIMIT_CORE, (0, resource.getrlimit(resource.RLIMIT_CORE)[1]))  # no core file


def limited(time_limit: float, function: Callable[..., Any], arguments: tuple[Any, ...]) -> Any:
    """``function(*arguments)``, in a worker that ends by SIGXCPU when it takes ``time_limit`` s of processor time.

    The system counts whole seconds, and nothing where it is not a Unix.
    """
    try:
        import resource
    except ImportError:
        return function(*arguments)
    _, hard = resource.getrlimit(resource.RLIMIT_CPU)
    until = math.ceil(time.process_time() + time_limit)
    resource.setrlimit(resource.RLIMIT_CPU, (until if hard == resource.RLIM_INFINITY else min(until, hard), hard))
    return function(*arguments)


class Job(NamedTuple):
    """What is to be run, and how often its worker has died of it or was killed."""

    number: int
    function: Callable[..., Any]
    arguments: tuple[Any, ...]
    aborts: int = 0
    kills: int = 0


class Worker(NamedTuple):
    """A process that holds one job at a time, and what it writes to standard error."""

    pool: Any
    said: LastWords
    pipe: tuple[Any, Any]  # of what it says: the end that is read, and the worker's

    def stop(self) -> str:
        """End it now; returns its last words."""
        self.pool.stop()
        self.pool.join()
        heard, told = self.pipe
        told.close()
        self.said.end()
        heard.close()
        return self.said.read()


class Held(NamedTuple):
    """A job in the hands of a worker."""

    worker: Worker
    job: Job
    since: float  # s, by the monotonic clock

    def is_lost(self, future: Future[Any]) -> bool:
        """Whether its worker has gone without a word.

        A pool replaces a worker that left in good order while it took the job, and then waits for ever.
        """
        waits = time.monotonic() - self.since
        return not self.worker.pool.active or (not future.running() and waits > UNTAKEN)


@dataclass(frozen=True)
class LocalExecutor:
    """Spawned processes with one BLAS thread each.

    Each worker is a pool of its own that holds one job at a time, so when a worker dies its job is known, and it shares
    no lock or queue that it could leave broken.
    """

    workers: int = 1
    time_limit: float = FLIGHT_TIME_LIMIT
    memory_limit: int = MEMORY_LIMIT
    _waiting: deque[Job] = field(default_factory=deque, repr=False)
    _running: dict[Future[Any], Held] = field(default_factory=dict, repr=False)

    def __post_init__(self) -> None:
        if self.workers < 1:
            raise ValueError("workers must be at least 1")

    def submit(self, number: int, function: Callable[..., Any], *arguments: Any) -> None:
        """Take a job; returns at once."""
        self._waiting.append(Job(number, function, arguments))

    def finished(self) -> Iterator[tuple[int, Any]]:
        """Results as they end."""
        stopped = Watch()
        while self._waiting and len(self._running) < self.workers:
            self._start(self._worker())
        while self._running:
            done, pending = wait(self._running, timeout=LOOK, return_when=FIRST_COMPLETED)
            if not done:
                stopped.look(child.pid for child in multiprocessing.active_children() if child.pid is not None)
            for future in done | {future for future in pending if self._running[future].is_lost(future)}:
                worker, job, _ = self._running.pop(future)
                ended, alive = self._ending(job, future, worker)
                if alive:
                    self._start(worker)
                else:
                    worker.stop()
                    if self._waiting:
                        self._start(self._worker())
                if ended is not None:
                    yield job.number, ended

    def close(self) -> None:
        """End all workers now."""
        self._waiting.clear()
        for held in self._running.values():
            held.worker.stop()
        self._running.clear()

    def _worker(self) -> Worker:
        from pebble import ProcessPool

        heard, told = multiprocessing.Pipe(duplex=False)
        with _one_thread():
            pool = ProcessPool(
                max_workers=1,
                initializer=prepare_worker,
                initargs=(self.memory_limit, told),
                context=multiprocessing.get_context("spawn"),
            )
            pool.active  # noqa: B018 (starts the process while the environment says one thread)
        return Worker(pool, LastWords(heard), (heard, told))

    def _start(self, worker: Worker) -> None:
        if not self._waiting:
            worker.stop()
            return
        job = self._waiting.popleft()
        call = self.time_limit, job.function, job.arguments
        try:
            future = worker.pool.schedule(limited, args=call, timeout=CLOCK_FACTOR * self.time_limit)
        except RuntimeError:  # it died between two jobs
            worker.stop()
            self._waiting.appendleft(job)
            self._start(self._worker())
        else:
            self._running[future] = Held(worker, job, time.monotonic())

    def _ending(self, job: Job, future: Future[Any], worker: Worker) -> tuple[Any, bool]:
        """The result of a job, None where it is tried again; and whether its worker lives."""
        from concurrent.futures.process import BrokenProcessPool

        from pebble import ProcessExpired

        if not future.done() and worker.pool.active:
            return self._again(job._replace(aborts=job.aborts + 1), "each left without a word"), False
        if not future.done():  # the worker died before it knew its job
            return self._again(job._replace(kills=job.kills + 1)), False
        try:
            return future.result(), True
        except TimeoutError:
            return Lost(f"no answer for {CLOCK_FACTOR * self.time_limit:g} s, most of which it did not compute"), False
        except BrokenProcessPool:  # the same, known to the pool
            return self._again(job._replace(kills=job.kills + 1)), False
        except ProcessExpired as error:
            if error.exitcode == -signal.SIGXCPU:
                return Lost(late(self.time_limit)), False
            if error.exitcode == -signal.SIGKILL:
                return self._again(job._replace(kills=job.kills + 1)), False
            words = worker.stop()
            how = f"{ending(error.exitcode)}{': ' if words else ''}{words}"
            return self._again(job._replace(aborts=job.aborts + 1), how), False
        except OutputError:  # about this machine, not about the flight
            raise
        except MemoryError:
            if (limit := limit_here(self.memory_limit)) < self.memory_limit:  # about this machine, too
                raise OutputError(
                    f"a flight needs more than the {limit >> 20} MB of memory that a process may have here "
                    f"(ulimit -v); raise that limit; finished flights are kept"
                ) from None
            return Lost(f"out of memory ({self.memory_limit >> 20} MB for each worker)"), True
        except Exception as error:
            return Lost(f"{type(error).__name__}: {error}"), True

    def _again(self, job: Job, how: str = "") -> Lost | None:
        """Puts a job back whose worker died, or gives it up, with how it died at last."""
        if job.aborts == ATTEMPTS:
            return Lost(f"its worker process died {ATTEMPTS} times ({how})")
        if job.kills == KILLS:
            return Lost(f"its worker process was killed {KILLS} times")
        self._waiting.appendleft(job)
        return None


@contextlib.contextmanager
def _one_thread() -> Iterator[None]:
    """Processes started within compute with one thread each."""
    before = {name: os.environ.get(name) for name in THREADS}
    os.environ.update(dict.fromkeys(THREADS, "1"))
    try:
        yield
    finally:
        for name, value in before.items():
            if value is None:
                os.environ.pop(name)
            else:
                os.environ[name] = value
