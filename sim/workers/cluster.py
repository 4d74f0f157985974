"""Flights on a cluster: dask.distributed behind the three calls of an executor.

Anyone who can reach the ports of a cluster can run code on it and on its clients. So an address on another
machine is used only with TLS, or when the user insists.
"""

from __future__ import annotations

import contextlib
import functools
import ipaddress
import logging
import math
import platform
import socket
import threading
import time
from collections import deque
from collections.abc import Callable, Iterator
from concurrent.futures import CancelledError
from contextlib import contextmanager
from dataclasses import dataclass, field
from typing import Any, NamedTuple
from urllib.parse import urlsplit

from sim.errors import OutputError
from sim.workers.executors import CLOCK_FACTOR, FLIGHT_TIME_LIMIT, Job, Lost, late
from sim.workers.partners import within

ANSWER = 5.0  # s; a scheduler that listens answers at once
PATIENCE = 60.0  # s without any worker, or any answer; who was killed is back by then, where somebody restarts it
TLS_KEYS = ("ca-file", "client.cert", "client.key")  # of distributed.comm.tls in Dask's configuration
FLYING = threading.Lock()  # of a worker process: flights share it with no other flight
_begun = [math.inf]  # s, processor time at which the flight of a worker process began; a process is state


class Running(NamedTuple):
    """A job on a worker; times are of this clock, s."""

    job: Job
    since: float
    look: float  # when it can have used up its processor time, or its time on the clock, at the earliest


class Refused(NamedTuple):
    """The answer of a worker that would compute other numbers."""

    reason: str


@dataclass(frozen=True)
class ClusterExecutor:
    """Workers of a cluster, one job each at a time, so that a worker that dies takes no other job with it.

    Jobs of workers that die are run again by the scheduler; one that hangs is lost, and its worker restarted.
    """

    client: Any
    address: str
    time_limit: float = FLIGHT_TIME_LIMIT
    _waiting: deque[Job] = field(default_factory=deque, repr=False)
    _running: dict[Any, Running] = field(default_factory=dict, repr=False)

    def submit(self, number: int, function: Callable[..., Any], *arguments: Any) -> None:
        """Take a job; returns at once."""
        self._waiting.append(Job(number, function, arguments))

    def finished(self) -> Iterator[tuple[int, Any]]:
        """Results as they end."""
        absent = None
        while self._waiting or self._running:
            with self._lost_scheduler():
                threads = sum(within(PATIENCE, self.client.nthreads).values())
            absent = None if threads else absent or time.monotonic()
            if absent is not None and time.monotonic() - absent > PATIENCE:
                raise OutputError(f"cluster {self.address}: has no worker left; finished flights are kept")
            while self._waiting and len(self._running) < threads:
                self._start(self._waiting.popleft())
            for future in self._ended():
                job = self._running.pop(future).job
                absent = None
                yield job.number, self._result(future)
            yield from self._overdue()

    def close(self) -> None:
        """Cancel all jobs that still run and disconnect."""
        self._waiting.clear()
        with contextlib.suppress(TimeoutError):  # of a cluster that is silent nothing more is asked
            if self.client.status == "running":
                within(ANSWER, self.client.cancel, list(self._running), force=True)
            within(ANSWER, self.client.close, timeout=ANSWER)
        self._running.clear()

    def _start(self, job: Job) -> None:
        with self._lost_scheduler():
            future = self.client.submit(_run, numerics(), job.function, *job.arguments, pure=False)
        now = time.monotonic()
        self._running[future] = Running(job, now, now + self.time_limit)

    def _ended(self) -> list[Any]:
        """Futures that are done; waits a second at most."""
        from distributed import wait

        if not self._running:
            time.sleep(0.1)
            return []
        with self._lost_scheduler():
            try:
                return list(wait(list(self._running), timeout=1.0, return_when="FIRST_COMPLETED").done)
            except TimeoutError:
                return []

    def _result(self, future: Any) -> Any:
        """The result of a job, or ``Lost``."""
        from distributed.scheduler import KilledWorker

        with self._lost_scheduler():
            error = future.exception(timeout=PATIENCE)
            result = future.result(timeout=PATIENCE) if error is None else None
        if isinstance(result, Refused):
            raise OutputError(f"cluster {self.address}: {result.reason}; finished flights are kept")
        if isinstance(error, OutputError):  # about the worker, not about the flight
            raise OutputError(f"cluster {self.address}: {error}; finished flights are kept")
        if isinstance(error, KilledWorker):  # the scheduler has tried it again as often as it is configured to
            return Lost(f"its worker process died {error.allowed_failures + 1} times")
        if isinstance(error, MemoryError):
            return Lost("out of memory")
        return result if error is None else Lost(f"{type(error).__name__}: {error}")

    def _overdue(self) -> Iterator[tuple[int, Any]]:
        """Gives up jobs that compute or wait for too long, with the workers that have them."""
        now, clock = time.monotonic(), CLOCK_FACTOR * self.time_limit
        for future, (job, since, _) in [item for item in self._running.items() if now >= item[1].look]:
            with self._lost_scheduler():
                processing = within(PATIENCE, self.client.processing)
            holders = [worker for worker, keys in processing.items() if future.key in keys]
            used = self._computed(holders) if holders else 0.0
            if used < self.time_limit and now - since < clock:
                later = min(now + self.time_limit - used, since + clock)
                self._running[future] = Running(job, since, later)
                continue
            del self._running[future]
            with self._lost_scheduler():
                within(PATIENCE, self.client.cancel, [future], force=True)
                within(PATIENCE, self.client.restart_workers, holders, timeout=PATIENCE, raise_for_error=False)
            waited = f"no answer for {clock:g} s, most of which it did not compute"
            yield job.number, Lost(late(self.time_limit) if used >= self.time_limit else waited)

    def _computed(self, workers: list[Any]) -> float:
        """Processor time that workers have used for their flights, the most of them, s; 0 where none says so."""
        try:
            told: dict[Any, float] = within(ANSWER, self.client.run, computed, workers=workers, on_error="ignore")
        except (OSError, TimeoutError):  # it computes without a breath, or has gone: others tell
            return 0.0
        return max([0.0, *told.values()])

    @contextmanager
    def _lost_scheduler(self) -> Iterator[None]:
        """Report a scheduler that is gone in one sentence; the errors of jobs do not pass through here."""
        try:
            yield
        except TimeoutError:
            silent = f"gives no answer for {PATIENCE:g} s"
            raise OutputError(f"cluster {self.address}: {silent}; finished flights are kept") from None
        except (OSError, CancelledError):
            raise OutputError(f"cluster {self.address}: has gone; finished flights are kept") from None


@functools.cache
def numerics() -> dict[str, str]:
    """What a machine must have in common with another to compute the same bytes."""
    from sim.versions import processor, versions

    found = {name: version for name, version in versions().items() if name != "platform"}
    return {**found, "machine": platform.machine(), "processor": processor(), "libc": "-".join(platform.libc_ver())}


def _run(expected: dict[str, str], function: Callable[..., Any], *arguments: Any) -> Any:
    """On a worker: one job, unless this worker would compute other numbers."""
    found = numerics()
    if found != expected:
        return Refused(_difference(f"the worker on {socket.gethostname()}", found, expected))
    with FLYING:
        _begun[0] = time.process_time()
        try:
            return function(*arguments)
        finally:
            _begun[0] = math.inf


def computed() -> float:
    """On a worker: the processor time that its flight has used, s."""
    return time.process_time() - _begun[0]


def _difference(worker: str, found: dict[str, str], expected: dict[str, str]) -> str:
    other = [
        f"{name} {found.get(name)}, not {expected[name]}" for name in expected if found.get(name) != expected[name]
    ]
    return f"{worker} has {'; '.join(other)}"


def connect(address: str, insecure: bool = False) -> ClusterExecutor:
    """The executor of a running cluster; raises ``OutputError`` in one sentence for one that cannot be used."""
    where = _checked(address, insecure)
    try:
        import distributed
    except ImportError:
        raise OutputError("--cluster needs dask.distributed: pip install 'shortfinal[cluster]'") from None
    for name in ("distributed", *(one for one in logging.root.manager.loggerDict if one.startswith("distributed."))):
        logging.getLogger(name).setLevel(logging.CRITICAL)  # what matters we report ourselves
    security = _security(distributed, address) if where.startswith("tls:") else None
    try:
        client = within(2 * ANSWER, distributed.Client, where, timeout=ANSWER, security=security)
    except Exception as error:  # its transports raise many kinds, and all mean that no scheduler answers there
        raise OutputError(f"cluster {address}: does not answer as a Dask scheduler ({type(error).__name__})") from None
    executor = ClusterExecutor(client, address)
    try:
        _examine(client, address)
    except BaseException:
        executor.close()
        raise
    return executor


def _checked(address: str, insecure: bool) -> str:
    """The address with its scheme, once a server listens there."""
    text = address if "://" in address else f"tcp://{address}"
    form = f"cluster {address}: write the address of its scheduler as HOST:PORT, tcp://HOST:PORT or tls://HOST:PORT"
    try:
        parts = urlsplit(text)
        host, port = parts.hostname, parts.port
    except ValueError:
        raise OutputError(form) from None
    if parts.scheme not in ("tcp", "tls") or not host or not port or parts.path.strip("/"):
        raise OutputError(form)
    if parts.scheme == "tcp" and not _is_loopback(host) and not insecure:
        raise OutputError(
            f"cluster {address}: is on another machine, and without TLS whoever reaches it can run code here; "
            "use tls://HOST:PORT, or insist with --insecure"
        )
    try:
        socket.create_connection((host, port), timeout=ANSWER).close()
    except OSError as error:
        raise OutputError(f"cluster {address}: does not answer: {error.strerror or error}") from None
    return f"{parts.scheme}://{parts.netloc}"


def _is_loopback(host: str) -> bool:
    try:
        return ipaddress.ip_address(host).is_loopback
    except ValueError:
        return host == "localhost"


def _security(distributed: Any, address: str) -> Any:
    """The TLS settings of Dask's own configuration."""
    import dask

    names = [f"distributed.comm.tls.{key}" for key in TLS_KEYS]
    absent = [name for name in names if not dask.config.get(name, None)]
    if absent:
        raise OutputError(f"cluster {address}: TLS needs {', '.join(absent)} in the configuration of Dask")
    return distributed.Security(require_encryption=True)


def _examine(client: Any, address: str) -> None:
    """Refuse a cluster without workers, with other numbers, or whose workers fly in threads."""
    try:
        client.wait_for_workers(1, timeout=ANSWER)
        found = within(PATIENCE, client.run, numerics, on_error="return")
        threads = within(PATIENCE, client.nthreads)
    except (OSError, TimeoutError):
        raise OutputError(f"cluster {address}: has no worker that answers") from None
    expected = numerics()
    for worker, facts in found.items():
        if isinstance(facts, ImportError):
            raise OutputError(f"cluster {address}: the worker {worker} has no shortfinal ({facts}); install it there")
        if isinstance(facts, BaseException):
            raise OutputError(f"cluster {address}: the worker {worker} is at fault: {facts}")
        if facts != expected:
            raise OutputError(f"cluster {address}: {_difference(f'the worker {worker}', facts, expected)}")
        if threads.get(worker, 1) > 1:
            raise OutputError(
                f"cluster {address}: the worker {worker} has {threads[worker]} threads, and flights need processes; "
                f"start it with --nthreads 1 --nworkers {threads[worker]}"
            )
