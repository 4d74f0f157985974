"""A wheel of a foreign project brings a sensor, a tracker, a mode and a wind event, and every face uses them."""

from __future__ import annotations

import contextlib
import json
import os
import signal
import socket
import subprocess
import sys
import time
from pathlib import Path

import pytest

pytestmark = pytest.mark.acceptance
ROOT = Path(__file__).resolve().parents[2]
PARTS = ROOT / "tests/sim/scenario/foreign_parts.py"
ADDRESSES = {"sensors.beacon", "trackers.calm", "modes.track_hold", "wind_events.thermal"}
PROJECT = """
[build-system]
requires = ["hatchling"]
build-backend = "hatchling.build"
[project]
name = "foreign-parts"
version = "1.0"
[project.entry-points."shortfinal.sensors"]
beacon = "foreign.parts:Beacon"
[project.entry-points."shortfinal.trackers"]
calm = "foreign.parts:Calm"
[project.entry-points."shortfinal.modes"]
track_hold = "foreign.parts:TrackHold"
[project.entry-points."shortfinal.wind_events"]
thermal = "foreign.parts:Thermal"
[tool.hatch.build.targets.wheel]
only-include = ["foreign"]
"""
SCENARIO = """
name = "outside"
until_s = 20
draws = 3
[route]
kind = "legs"
[[route.legs]]
from_m = [0, 0]
to_m = [20000, 0]
speed_mps = 72
height_m = 600
[start]
leg = 0
cross_track_m = 300
[autopilot]
kind = "track_hold"
[wind.events.lift]
kind = "thermal"
[sensors.beacon]
kind = "beacon"
[trackers.calm]
kind = "calm"
[[checks]]
metric = "bank_deg"
max = 16
source = "limit of the bank"
"""
STUDY = """
[study.axes]
"wind.speed_mps" = [0, 4]
"wind.from_deg" = [0, 90]
"""
TEST = """
def test_it_is_flown(shortfinal):
    assert len(shortfinal("outside.scenario.toml", seed=2).metrics["versions"]["parts"]) == 4
"""


def python(*command, where, path=(), code=0):
    """A process of its own that imports this project and ``path``; what it said."""
    done = subprocess.run(
        [sys.executable, *map(str, command)], cwd=where, env=environment(path), capture_output=True, text=True,
        timeout=300, check=False,
    )  # fmt: skip
    assert "Traceback" not in done.stderr, done.stderr
    assert done.returncode == code, done.stdout + done.stderr
    return done.stdout + done.stderr


def environment(path):
    kept = {name: value for name, value in os.environ.items() if not name.startswith("PYTEST_")}
    return {
        **kept,
        "OPENBLAS_NUM_THREADS": "1",
        "PY_COLORS": "0",
        "PYTHONPATH": os.pathsep.join(map(str, (ROOT, *path))),
    }


def build(folder, text):
    """The folder into which the wheel of the foreign project was installed."""
    (folder / "foreign").mkdir(parents=True)
    (folder / "pyproject.toml").write_text(PROJECT)
    (folder / "foreign/__init__.py").write_text("")
    (folder / "foreign/parts.py").write_text(text)
    python("-m", "hatchling", "build", "-t", "wheel", where=folder)
    (wheel,) = (folder / "dist").glob("*.whl")
    python("-m", "pip", "install", "-q", "--no-deps", "--no-index", "--target", folder / "site", wheel, where=folder)
    return folder / "site"


@pytest.fixture(scope="module")
def installed(tmp_path_factory):
    """By entry points: what is on the path, and what the command is told."""
    pytest.importorskip("hatchling")
    return build(tmp_path_factory.mktemp("foreign"), PARTS.read_text())


@pytest.fixture(params=["entry points", "--plugin"])
def way(request, installed):
    """How the parts come: (what is on the path, what the command is told)."""
    return ((installed,), ()) if request.param == "entry points" else ((), ("--plugin", PARTS))


@pytest.fixture
def scenario(tmp_path):
    file = tmp_path / "outside.scenario.toml"
    file.write_text(SCENARIO + STUDY)
    return file


def written(folder):
    return json.loads((folder / "metrics.json").read_text())


def test_a_run_uses_them(tmp_path, scenario, way, row, request):
    path, told = way
    python("-m", "sim", "run", scenario, "-o", tmp_path / "out", *told, where=tmp_path, path=path)
    metrics = written(tmp_path / "out")
    met = set(metrics["versions"]["parts"]) == ADDRESSES and metrics["flight"]["outcome"] == "completed"
    error = metrics["trackers"]["calm"]["overall"]["position_m"]["rmse"]
    name = request.node.callspec.id
    row(f"run with four parts by {name}", "used", f"{len(metrics['versions']['parts'])} parts, {error:.1f} m", met)
    assert met
    assert "no kind" in python("-m", "sim", "run", scenario, "-o", tmp_path / "none", where=tmp_path, code=2)


def test_a_study_in_two_processes_and_on_a_cluster_uses_them(tmp_path, scenario, way, row, request):
    path, told = way
    study = ("-m", "sim", "study", scenario, *told)
    python(*study, "-j", 2, "-o", tmp_path / "local", where=tmp_path, path=path)
    metrics = written(tmp_path / "local")
    with cluster(tmp_path, path) as address:
        python(*study, "--cluster", address, "-o", tmp_path / "cluster", where=tmp_path, path=path)
    same = (tmp_path / "local/metrics.json").read_bytes() == (tmp_path / "cluster/metrics.json").read_bytes()
    met = same and set(metrics["versions"]["parts"]) == ADDRESSES and metrics["outcomes"] == {"completed": 4}
    name = request.node.callspec.id
    row(f"study -j 2 and on a cluster with four parts by {name}", "the same bytes", "same" if same else "differ", met)
    assert met


def test_a_cluster_without_the_package_is_refused(tmp_path, scenario, installed):
    with cluster(tmp_path, ()) as address:
        command = ("-m", "sim", "study", scenario, "--cluster", address, "-o", tmp_path / "out")
        said = python(*command, where=tmp_path, path=(installed,), code=2)
    assert "of foreign-parts 1.0 is not installed here; finished flights are kept" in said


def test_pytest_uses_them(tmp_path, way, scenario, row, request):
    path, told = way
    (tmp_path / "test_it.py").write_text(TEST)
    if told:
        (tmp_path / "pytest.ini").write_text(f"[pytest]\nshortfinal_plugins = {PARTS}\n")
    command = ("-m", "pytest", "-p", "sim.pytest_plugin", "--rootdir", tmp_path, "-p", "no:cacheprovider", "-q")
    said = python(*command, where=tmp_path, path=path)
    row(f"pytest with four parts by {request.node.callspec.id}", "2 passed", said.splitlines()[-1], "2 passed" in said)
    assert "2 passed" in said


def test_a_changed_part_flies_anew(tmp_path, scenario, installed, row):
    changed = PARTS.read_text().replace("gain: float = 1.0", "gain: float = 0.5")
    assert changed != PARTS.read_text()
    file = tmp_path / "mine.py"
    other = build(tmp_path / "changed", changed)
    for name, before, after in (
        ("entry points", ((installed,), ()), ((other,), ())),
        ("--plugin", ((), ("--plugin", file)), ((), ("--plugin", file))),
    ):
        out = tmp_path / name.strip("-")
        command = ("-m", "sim", "study", scenario, "-j", 2, "-o", out)
        file.write_text(PARTS.read_text())
        python(*command, *before[1], where=tmp_path, path=before[0])
        old, kept = written(out), {path.name for path in (out / "cache/flights").iterdir()}
        file.write_text(changed)
        assert "holds a study begun with modes.track_hold" in python(
            *command, *after[1], where=tmp_path, path=after[0], code=2
        )
        resume = ("-m", "sim", "resume", out, "--anyway", *after[1])
        assert "was begun with modes.track_hold" in python(*resume, where=tmp_path, path=after[0], code=2)
        python(*command, "--anew", *after[1], where=tmp_path, path=after[0])
        again = {path.name for path in (out / "cache/flights").iterdir()}
        anew = not kept & again and old["rows"] != written(out)["rows"]
        row(f"a changed part by {name}", "no old flight", f"{len(kept & again)} of {len(again)} old", anew)
        assert kept
        assert anew


@contextlib.contextmanager
def cluster(where, path):
    """The address of a scheduler with two workers."""
    pytest.importorskip("distributed")
    with socket.socket() as place:
        place.bind(("127.0.0.1", 0))
        address = f"127.0.0.1:{place.getsockname()[1]}"
    host, port = address.split(":")
    worker = ("-m", "distributed.cli.dask_worker", f"tcp://{address}", "--host", host, "--no-dashboard", "--no-nanny")
    started = [
        subprocess.Popen(
            [sys.executable, *command],
            cwd=where,
            env=environment(path),
            stdout=subprocess.DEVNULL,
            stderr=subprocess.DEVNULL,
            start_new_session=True,
        )
        for command in (
            ("-m", "distributed.cli.dask_scheduler", "--host", host, "--no-dashboard", "--port", port),
            (*worker, "--nthreads", "1"),
            (*worker, "--nthreads", "1"),
        )
    ]
    try:
        wait_for_workers(address, 2)
        yield address
    finally:
        for process in started:
            with contextlib.suppress(ProcessLookupError):
                os.killpg(process.pid, signal.SIGKILL)
            process.wait()


def wait_for_workers(address, count):
    from sim.errors import OutputError
    from sim.workers.cluster import connect

    end = time.monotonic() + 60
    while time.monotonic() < end:
        with contextlib.suppress(OutputError):
            executor = connect(address)
            found = len(executor.client.nthreads())
            executor.close()
            if found == count:
                return
        time.sleep(0.2)
    pytest.fail("no workers")
