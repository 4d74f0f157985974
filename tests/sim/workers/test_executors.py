"""Workers that abort, hang, raise or run out of memory; studies whose workers or parent are killed."""

from __future__ import annotations

import json
import math
import operator
import os
import signal
import subprocess
import sys
import time
from pathlib import Path

import pytest

from sim.scenario.reading import read
from sim.studies import study as studies
from sim.studies.job import Job
from sim.workers import executors
from sim.workers.executors import LocalExecutor, Lost
from tests.capture import capture

AIR = """
[wind]
turbulence = "light"
[study.axes]
"wind.speed_mps" = [0, 4, 8]
"""
TABLES = capture(AIR, name="killed", until_s=20, flights=4)
STUDIES = 12  # flights


def ended(executor):
    try:
        return dict(executor.finished())
    finally:
        executor.close()


def complain_and_abort():
    os.write(2, b"much more " * 100_000)  # more than a pipe holds
    os.write(2, b"terminate called after throwing an instance of 'X'\n  what():  the \x1b[31mwing\n is \x07off")
    os.abort()


def test_a_lost_job_costs_nothing_but_itself(monkeypatch):
    monkeypatch.setattr(executors, "CLOCK_FACTOR", 1000.0)  # nothing waits here, however busy the machine
    monkeypatch.setattr(executors, "ATTEMPTS", 2)
    executor = LocalExecutor(workers=2, time_limit=0.4, memory_limit=2 << 30)
    jobs = {
        0: (operator.add, 1, 2),
        1: (os.abort,),
        3: (bytearray, 8 << 30),
        4: (math.sqrt, -1.0),
        5: (operator.add, 3, 4),
        6: (sum, range(10**12)),
        7: (complain_and_abort,),
    }
    for number, (function, *arguments) in jobs.items():
        executor.submit(number, function, *arguments)
    found = ended(executor)
    assert (found[0], found[5]) == (3, 7)
    assert found[1] == Lost("its worker process died 2 times (SIGABRT)")
    assert found[7] == Lost("its worker process died 2 times (SIGABRT: the wing is off)")
    assert found[3] == Lost("out of memory (2048 MB for each worker)")
    assert found[6] == Lost("no answer within 0.4 s of processor time")
    assert isinstance(found[4], Lost)
    assert "ValueError" in found[4].reason


def test_a_job_that_waits_is_not_said_to_compute():
    executor = LocalExecutor(time_limit=0.1)
    executor.submit(0, time.sleep, 1000)
    assert ended(executor) == {0: Lost("no answer for 1 s, most of which it did not compute")}


def leave_once(file):
    """In good order, while the job is read; the next time the job can be read."""
    if not file.exists():
        file.touch()
        os._exit(0)
    return 5


class LeavesWhileRead:
    """As a worker does that finds half a file of byte code: ``EOFError`` ends it in good order."""

    def __init__(self, *call):
        self.call = call

    def __reduce__(self):
        function, *arguments = self.call
        return function, tuple(arguments)


def test_a_job_whose_worker_left_without_a_word_is_done_by_another(tmp_path, monkeypatch):
    monkeypatch.setattr(executors, "UNTAKEN", 4.0)  # more than a start takes; on a slow machine it is tried again
    monkeypatch.setattr(executors, "ATTEMPTS", 30)
    executor = LocalExecutor()
    executor.submit(0, operator.add, LeavesWhileRead(leave_once, tmp_path / "seen"), 3)
    assert ended(executor) == {0: 8}


def test_a_job_at_which_every_worker_leaves_is_given_up(monkeypatch):
    monkeypatch.setattr(executors, "UNTAKEN", 2.0)
    monkeypatch.setattr(executors, "ATTEMPTS", 1)
    executor = LocalExecutor()
    executor.submit(0, operator.add, LeavesWhileRead(os._exit, 0), 3)
    assert ended(executor) == {0: Lost("its worker process died 1 times (each left without a word)")}


def test_a_worker_that_died_between_two_jobs_is_replaced():
    executor = LocalExecutor()
    worker = executor._worker()
    worker.pool.stop()
    executor.submit(0, operator.add, 1, 2)
    executor._start(worker)
    assert ended(executor) == {0: 3}


def test_workers_have_one_thread_and_leave_the_environment_alone(monkeypatch):
    monkeypatch.delenv("OPENBLAS_NUM_THREADS", raising=False)
    executor = LocalExecutor()
    executor.submit(0, os.getenv, "OPENBLAS_NUM_THREADS")
    assert ended(executor) == {0: "1"}
    assert "OPENBLAS_NUM_THREADS" not in os.environ


# ---- studies in processes of their own


@pytest.fixture(scope="module")
def whole(tmp_path_factory, inline):
    """An uninterrupted study in this process: the bytes that every other way must reach."""
    folder = tmp_path_factory.mktemp("whole")
    (folder / "killed.toml").write_text(TABLES)
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr("sim.studies.page.page", lambda *given: "")
        studies.study(folder / "killed.toml", folder / "o", inline())
    return folder


WITHOUT_PAGE = """
import sys
from sim.cli.commands import main
from sim.studies import page
page.page = lambda *given: ""  # drawn elsewhere
sys.argv[0] = "shortfinal"
main()
"""


def start(*arguments):
    environment = {**os.environ, "OPENBLAS_NUM_THREADS": "1", "NO_COLOR": "1"}
    root = Path(__file__).resolve().parents[3]
    command = [sys.executable, "-c", WITHOUT_PAGE, *map(str, arguments)]
    return subprocess.Popen(
        command,
        cwd=root,
        env=environment,
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
        # a test run in the background inherits a shell's "ignore Ctrl-C", which is not what is tested
        preexec_fn=lambda: signal.signal(signal.SIGINT, signal.SIG_DFL),
    )


def study(file, folder, workers):
    return start("study", file, "-o", folder, "-j", workers)


def finish(process):
    """To its end, which must be a good one."""
    _, told = process.communicate(timeout=120)
    assert process.returncode == 0, told


def flown(folder):
    log = folder / "flights.jsonl"
    return log.read_bytes().count(b"\n") if log.exists() else 0


def wait_for(condition, process):
    """Until something has happened; a study that ends before is an error of the test."""
    end = time.monotonic() + 60
    while not condition():
        assert process.poll() is None, process.stderr.read()
        assert time.monotonic() < end
        time.sleep(0.005)


def workers_of(process):
    """Children that work; the one that tracks resources does not."""
    tasks = Path(f"/proc/{process.pid}/task")
    if not (tasks / str(process.pid) / "children").exists():
        pytest.skip("the system does not tell the children of a process")
    found = [pid for task in tasks.iterdir() for pid in (task / "children").read_text().split()]
    return [int(pid) for pid in found if b"spawn_main" in Path(f"/proc/{pid}/cmdline").read_bytes()]


def assert_same(folder, whole):
    for name in ("metrics.json", "flights.jsonl", "scenario.toml"):
        assert (folder / name).read_bytes() == (whole / "o" / name).read_bytes(), name


def test_two_workers_write_the_bytes_of_one(whole, tmp_path):
    with study(whole / "killed.toml", tmp_path / "o", 2) as process:
        finish(process)
    assert_same(tmp_path / "o", whole)


def test_a_killed_worker_costs_time_only(whole, tmp_path):
    with study(whole / "killed.toml", tmp_path / "o", 2) as process:
        wait_for(lambda: flown(tmp_path / "o") >= 2, process)
        os.kill(workers_of(process)[0], signal.SIGKILL)
        finish(process)
    assert_same(tmp_path / "o", whole)


@pytest.mark.parametrize(
    ("number", "code"),
    [pytest.param(signal.SIGKILL, -signal.SIGKILL, marks=pytest.mark.soak), (signal.SIGINT, 130)],
)
def test_a_killed_parent_is_resumed_to_the_same_bytes(whole, tmp_path, number, code):
    with study(whole / "killed.toml", tmp_path / "o", 1) as process:
        wait_for(lambda: flown(tmp_path / "o") >= 3, process)
        left = workers_of(process)
        process.send_signal(number)
        assert process.wait(60) == code
        if number == signal.SIGINT:
            assert "shortfinal resume" in process.stderr.read()
    assert 3 <= flown(tmp_path / "o") < STUDIES
    assert not (tmp_path / "o/metrics.json").exists()
    with (tmp_path / "o/flights.jsonl").open("a") as log:
        log.write('{"cell": 0, "torn')  # what a crash in the middle of a line leaves
    with start("resume", tmp_path / "o", "-j", 2) as process:
        finish(process)
    assert_same(tmp_path / "o", whole)
    assert not [pid for pid in left if Path(f"/proc/{pid}").exists() and alive(pid)], "orphans"


def alive(pid):
    return ") Z " not in Path(f"/proc/{pid}/stat").read_text()


def test_workers_never_import_what_only_designers_need(whole):
    """A flight as a worker flies it, in a process that does nothing else."""
    planned = studies.plan(read(whole / "killed.toml"))
    job = Job(0, 0, 0, {}, {**studies.designed_cells(planned)[0], "until_s": 1.0}, {})
    probe = (
        "import json, sys\n"
        "from sim.studies.job import Job, fly\n"
        "record = fly(Job(*json.load(sys.stdin)))\n"
        "print(record['metrics']['outcome'], {'control', 'matplotlib', 'filterpy', 'jinja2'} & set(sys.modules))"
    )
    root = Path(__file__).resolve().parents[3]
    done = subprocess.run(
        [sys.executable, "-c", probe], input=json.dumps(job), capture_output=True, text=True, cwd=root, check=True
    )
    assert done.stdout.split() == ["completed", "set()"]
