"""Studies on a real Dask cluster of one scheduler and two workers, which these tests start and end."""

from __future__ import annotations

import contextlib
import os
import signal
import socket
import subprocess
import sys
import threading
import time
from pathlib import Path
from typing import NamedTuple

import pytest

from sim.errors import OutputError
from sim.studies import study as studies
from sim.workers.cluster import _checked, connect
from tests.capture import capture

ROOT = Path(__file__).resolve().parents[3]
AIR = """
[wind]
turbulence = "light"
[study.axes]
"wind.speed_mps" = [0, 4]
"""
TABLES = capture(AIR, name="cluster", until_s=30, flights=4)
FLIGHTS = 8
WRITTEN = ("metrics.json", "flights.jsonl", "scenario.toml", "report.html")


class Cluster(NamedTuple):
    """A running cluster."""

    address: str
    scheduler: subprocess.Popen
    workers: list[subprocess.Popen]


@contextlib.contextmanager
def processes():
    """A function that starts a process in a group of its own; all groups are killed at the end, whatever happens."""
    started = []

    def start(*command, **given):
        environment = {**os.environ, "OPENBLAS_NUM_THREADS": "1", "PYTHONPATH": str(ROOT)}
        process = subprocess.Popen(
            [sys.executable, *map(str, command)],
            env=environment,
            stdout=given.get("out", subprocess.DEVNULL),
            stderr=given.get("out", subprocess.DEVNULL),
            text=True,
            start_new_session=True,
            cwd=given["where"],
        )
        started.append(process)
        return process

    try:
        yield start
    finally:
        for process in started:
            with contextlib.suppress(ProcessLookupError):
                os.killpg(process.pid, signal.SIGKILL)
            process.communicate()


def free_port():
    with socket.socket() as place:
        place.bind(("127.0.0.1", 0))
        return place.getsockname()[1]


def begin_cluster(start, where):
    pytest.importorskip("distributed", reason="dask.distributed is not installed: pip install 'shortfinal[cluster]'")
    address = f"127.0.0.1:{free_port()}"
    host, port = address.split(":")
    quiet = "--host", host, "--no-dashboard"
    scheduler = start("-m", "distributed.cli.dask_scheduler", *quiet, "--port", port, where=where)
    worker = "-m", "distributed.cli.dask_worker", f"tcp://{address}", *quiet, "--nthreads", 1, "--no-nanny"
    return Cluster(address, scheduler, [start(*worker, where=where) for _ in range(2)])


def told_in(where):
    return {"where": where, "out": subprocess.PIPE}


def finish(process):
    out, err = process.communicate(timeout=120)
    return process.returncode, out + (err or "")


def wait_for_workers(address, count):
    """Until the workers have found their scheduler."""
    end = time.monotonic() + 60
    while True:
        with contextlib.suppress(OutputError):
            executor = connect(address)
            found = len(executor.client.nthreads())
            executor.close()
            if found == count:
                return
        assert time.monotonic() < end
        time.sleep(0.2)


def flown(folder):
    log = folder / "flights.jsonl"
    return log.read_bytes().count(b"\n") if log.exists() else 0


def assert_same(folder, whole):
    for name in WRITTEN:
        assert (folder / name).read_bytes() == (whole / name).read_bytes(), name


@pytest.mark.parametrize("killed", ["worker", pytest.param("scheduler", marks=pytest.mark.soak)])
def test_a_cluster_writes_the_bytes_of_one_process_whatever_is_killed(killed, tmp_path, inline):
    """A killed worker costs time only; a killed scheduler is one sentence, and the study is resumed without it."""
    file = tmp_path / "cluster.toml"
    file.write_text(TABLES)
    with processes() as start:
        cluster = begin_cluster(start, tmp_path)
        studies.study(file, tmp_path / "whole", inline())
        wait_for_workers(cluster.address, 2)

        folder = tmp_path / "there"
        study = start("-m", "sim", "study", file, "-o", folder, "--cluster", cluster.address, **told_in(tmp_path))
        end = time.monotonic() + 60
        while flown(folder) < 2:
            assert study.poll() is None, study.stdout.read()
            assert time.monotonic() < end
            time.sleep(0.005)
        (cluster.workers[0] if killed == "worker" else cluster.scheduler).kill()
        code, told = finish(study)
    if killed == "worker":
        assert code == 0, told
        assert f"{FLIGHTS} flights in 2 cells" in told
    else:
        assert (code, told) == (2, f"shortfinal: cluster {cluster.address}: has gone; finished flights are kept\n")
        assert flown(folder) < FLIGHTS
        studies.resume(folder, inline())
    assert_same(folder, tmp_path / "whole")


@pytest.mark.parametrize(
    ("address", "said"),
    [
        ("nonsense", "write the address of its scheduler as HOST:PORT"),
        ("127.0.0.1", "HOST:PORT"),
        ("127.0.0.1:port", "HOST:PORT"),
        ("127.0.0.1:99999", "HOST:PORT"),
        ("http://127.0.0.1:80", "HOST:PORT"),
        ("192.0.2.1:8786", "without TLS whoever reaches it can run code here"),
        ("cluster.example:8786", "without TLS"),
        ("127.evil.example:8786", "without TLS"),
    ],
)
def test_an_address_that_may_not_be_used_is_refused_before_anybody_is_called(monkeypatch, address, said):
    monkeypatch.setattr(socket, "create_connection", lambda *_, **__: pytest.fail("somebody was called"))
    with pytest.raises(OutputError) as caught:
        connect(address)
    assert said in str(caught.value)
    assert len(str(caught.value).splitlines()) == 1


@pytest.mark.parametrize("host", ["127.0.0.1", "127.8.8.8", "localhost", "[::1]"])
def test_loopback_needs_no_permission(monkeypatch, host):
    called = []
    monkeypatch.setattr(socket, "create_connection", lambda address, **_: called.append(address) or socket.socket())
    assert _checked(f"{host}:8786", insecure=False) == f"tcp://{host}:8786"
    assert _checked(f"tls://{host}:8786", insecure=False) == f"tls://{host}:8786"
    assert called == [(host.strip("[]"), 8786)] * 2
    assert _checked("192.0.2.1:8786", insecure=True) == "tcp://192.0.2.1:8786"


def test_tls_without_its_settings_says_which(monkeypatch):
    pytest.importorskip("distributed", reason="dask.distributed is not installed")
    monkeypatch.setattr(socket, "create_connection", lambda *_, **__: socket.socket())
    with pytest.raises(OutputError, match=r"TLS needs distributed\.comm\.tls\.ca-file, .* in the configuration"):
        connect("tls://192.0.2.1:8786")


def test_nobody_listens():
    with pytest.raises(OutputError, match="does not answer: Connection refused"):
        connect(f"127.0.0.1:{free_port()}")


def test_a_listener_that_is_no_scheduler():
    pytest.importorskip("distributed", reason="dask.distributed is not installed")
    with socket.create_server(("127.0.0.1", 0)) as server:

        def hang_up():
            with contextlib.suppress(OSError):
                while True:
                    other, _ = server.accept()
                    other.sendall(b"HTTP/1.0 400 Bad Request\r\n\r\n")
                    other.close()

        threading.Thread(target=hang_up, daemon=True).start()
        with pytest.raises(OutputError, match="does not answer as a Dask scheduler"):
            connect(f"127.0.0.1:{server.getsockname()[1]}")
