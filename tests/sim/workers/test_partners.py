"""Partners that are stopped, or listen and say nothing: the work goes on without them, or a sentence says so."""

from __future__ import annotations

import os
import resource
import signal
import socket
import subprocess
import sys
import time
from pathlib import Path

import pytest

from sim.errors import OutputError, ScenarioError
from sim.workers import cluster, executors, isolation, partners
from sim.workers.executors import LEAST_MEMORY, MEMORY_LIMIT, LocalExecutor, Lost
from sim.workers.sharing import helper

ROOT = Path(__file__).resolve().parents[3]


@pytest.fixture
def impatient(monkeypatch):
    monkeypatch.setattr(partners, "LOOK", 0.02)
    monkeypatch.setattr(executors, "LOOK", 0.02)
    monkeypatch.setattr(partners, "PATIENCE", 3)


def test_a_call_has_an_end():
    assert partners.within(5.0, divmod, 7, 2) == (3, 1)
    with pytest.raises(ZeroDivisionError):
        partners.within(5.0, divmod, 7, 0)
    began = time.monotonic()
    with pytest.raises(TimeoutError, match=r"no answer for 0\.1 s"):
        partners.within(0.1, time.sleep, 30)
    assert time.monotonic() - began < 10


def test_who_stands_still_only_for_a_while_is_left_alone(impatient):
    child = subprocess.Popen([sys.executable, "-c", "input()"], stdin=subprocess.PIPE)
    try:
        one = partners.Watch()
        for signal_ in (signal.SIGSTOP, signal.SIGCONT) * 3:
            child.send_signal(signal_)
            time.sleep(0.05)
            for _ in range(2):
                one.look([child.pid])
        assert child.poll() is None
        child.send_signal(signal.SIGSTOP)
        time.sleep(0.05)
        for _ in range(3):
            one.look([child.pid])
        assert child.wait(10) == -signal.SIGKILL
    finally:
        child.kill()
        child.communicate()


def stop_elsewhere(number, home):
    if os.getpid() != home and number == 3:
        os.kill(os.getpid(), signal.SIGSTOP)
    return -number


def test_what_a_stopped_helper_owes_is_done_here(impatient):
    with helper() as sharing:
        if sharing.helper is None:
            pytest.skip("one processor")
        assert sharing.in_order(stop_elsewhere, [(number, os.getpid()) for number in range(4)]) == [0, -1, -2, -3]
        assert sharing.helper.process.returncode == -signal.SIGKILL


def stop_once(mark):
    if not Path(mark).exists():
        Path(mark).touch()
        os.kill(os.getpid(), signal.SIGSTOP)
    return "flown"


def test_a_stopped_worker_is_ended_and_its_flight_flown_by_another(impatient, tmp_path):
    executor = LocalExecutor(1)
    executor.submit(0, stop_once, str(tmp_path / "mark"))
    try:
        assert dict(executor.finished()) == {0: "flown"}
    finally:
        executor.close()


def test_a_cluster_address_that_says_nothing(monkeypatch):
    pytest.importorskip("distributed", reason="dask.distributed is not installed")
    monkeypatch.setattr(cluster, "ANSWER", 0.2)
    with socket.create_server(("127.0.0.1", 0)) as server:
        began = time.monotonic()
        with pytest.raises(OutputError, match=r"does not answer as a Dask scheduler \(TimeoutError\)"):
            cluster.connect(f"127.0.0.1:{server.getsockname()[1]}")
        assert time.monotonic() - began < 20


class Future:
    key = "flight-1"


class Computing:
    """A scheduler with one worker, whose flight has used so many seconds of processor time."""

    def __init__(self, used):
        self.used, self.restarted, self.asked = used, [], 0

    def processing(self):
        return {"idle": (), "busy": ("flight-1",)}

    def run(self, function, workers, on_error):
        self.asked += 1
        assert (function, workers) == (cluster.computed, ["busy"])
        return {"busy": self.used}

    def cancel(self, futures, force):
        pass

    def restart_workers(self, workers, timeout, raise_for_error):
        self.restarted += workers


@pytest.mark.parametrize(
    ("used", "since", "said"),
    [
        (9.0, 20.0, None),
        (10.0, 20.0, "no answer within 10 s of processor time"),
        (3.0, 101.0, "no answer for 100 s, most of which it did not compute"),
    ],
)
def test_a_flight_on_a_cluster_has_the_limits_of_one_here(used, since, said):
    client, flight, now = Computing(used), Future(), time.monotonic()
    executor = cluster.ClusterExecutor(client, "there:1", time_limit=10.0)
    executor._running[flight] = cluster.Running(executors.Job(7, abs, (1,)), now - since, now - 0.1)
    assert list(executor._overdue()) == ([] if said is None else [(7, Lost(said))])
    assert client.restarted == ([] if said is None else ["busy"])
    if said is None:  # it is asked again when it can have used up its time
        assert executor._running[flight].look == pytest.approx(now + 1.0, abs=0.5)
        assert list(executor._overdue()) == []
        assert client.asked == 1


def test_a_worker_of_a_cluster_counts_the_processor_time_of_its_flight():
    assert cluster._run(cluster.numerics(), cluster.computed) == pytest.approx(0.0, abs=0.1)
    assert cluster.computed() < 0.0  # nothing flies


class Silent:
    """A scheduler that was stopped after the client had connected."""

    status = "running"

    def nthreads(self):
        time.sleep(60)

    def cancel(self, *arguments, **named):
        time.sleep(60)

    close = cancel


def test_a_scheduler_that_falls_silent_is_a_sentence(monkeypatch):
    monkeypatch.setattr(cluster, "PATIENCE", 0.1)
    monkeypatch.setattr(cluster, "ANSWER", 0.1)
    executor = cluster.ClusterExecutor(Silent(), "there:1")
    executor.submit(0, abs, -1)
    with pytest.raises(OutputError, match=r"cluster there:1: gives no answer for 0\.1 s; finished flights are kept"):
        next(executor.finished())
    executor.close()


# ---- a machine that allows a process little memory


def test_a_worker_keeps_within_the_limit_of_the_machine():
    code = (
        "import resource; resource.setrlimit(resource.RLIMIT_AS, (3 << 30, 3 << 30));"
        "from sim.workers.executors import prepare_worker, refuse_small_limit;"
        "refuse_small_limit(); prepare_worker(4 << 30); print(resource.getrlimit(resource.RLIMIT_AS))"
    )
    environment = {**os.environ, "PYTHONPATH": str(ROOT)}
    done = subprocess.run([sys.executable, "-c", code], env=environment, capture_output=True, text=True, check=True)
    assert done.stdout.strip() == str((3 << 30, 3 << 30))


@pytest.fixture
def limit(monkeypatch):
    """A hard limit that only we see."""

    def set_to(size):
        monkeypatch.setattr(resource, "getrlimit", lambda which: (size, size))

    return set_to


def test_a_limit_that_is_too_small_is_a_sentence_about_the_machine(limit):
    limit(resource.RLIM_INFINITY)
    executors.refuse_small_limit()
    assert executors.limit_here(MEMORY_LIMIT) == MEMORY_LIMIT
    limit(LEAST_MEMORY)
    executors.refuse_small_limit()
    limit(LEAST_MEMORY - 1)
    with pytest.raises(OutputError, match=r"may have 599 MB of memory here \(ulimit -v\), and a worker needs"):
        executors.refuse_small_limit()
    with pytest.raises(OutputError, match=r"ulimit -v"):
        isolation._started()


class OutOfMemory:
    def done(self):
        return True

    def result(self):
        raise MemoryError


def test_a_flight_is_not_blamed_for_the_limit_of_the_machine(limit):
    given = executors.Job(0, abs, (1,)), OutOfMemory(), None
    limit(resource.RLIM_INFINITY)
    assert LocalExecutor()._ending(*given) == (Lost("out of memory (4096 MB for each worker)"), True)
    limit(3 << 30)
    with pytest.raises(OutputError, match=r"needs more than the 3072 MB of memory .* \(ulimit -v\)"):
        LocalExecutor()._ending(*given)


def test_a_foreign_model_hears_whose_limit_it_was(limit, monkeypatch):
    def too_much(*arguments):
        raise MemoryError

    class Scenario:
        name, parts = "s", ()

        class aircraft:
            model = "c172x"

    monkeypatch.setattr(isolation, "_asked", too_much)
    limit(3 << 30)
    with pytest.raises(ScenarioError, match=r"more than 3072 MB of memory, and a process may not have more here"):
        isolation.run_isolated(Scenario, 1.0, abs, -1)
