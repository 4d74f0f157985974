"""The plugin in a foreign project that has nothing of ours but the wheel."""

from __future__ import annotations

import os
import re
import subprocess
import sys
import zipfile
from pathlib import Path

import pytest

from tests.capture import capture

ROOT = Path(__file__).resolve().parents[2]
SCENARIO = capture(until_s=4, draws=2, cross_track_m=3000)
GOOD = """
[[checks]]
name = "bank"
metric = "bank_deg"
max = 16
source = "autopilot limit"
"""
BAD = """
[[checks]]
name = "tight bank"
metric = "bank_deg"
max = 2
source = "no airline"
"""
UNFLOWN = """
[[checks]]
metric = "sink_mps"
during = "glide"
max = 5
source = "stabilised approach"
"""
TESTS = """
def test_an_override_changes_the_flight(shortfinal):
    wide = shortfinal("line.scenario.toml")
    narrow = shortfinal("line.scenario.toml", {"autopilot.bank_limit_deg": 5})
    assert narrow.metrics["flight"]["bank_max_deg"] < wide.metrics["flight"]["bank_max_deg"]

def test_the_same_scenario_is_flown_once(shortfinal):
    assert shortfinal("line.scenario.toml") is shortfinal("line.scenario.toml", seed=1)
    assert shortfinal("line.scenario.toml", seed=2) is not shortfinal("line.scenario.toml")

def test_a_scenario_at_fault(shortfinal):
    shortfinal("line.scenario.toml", {"wind.sped_mps": 5})
"""
PARTS = (ROOT / "tests/sim/scenario/foreign_parts.py").read_text()
WITH_PARTS = """
[sensors.beacon]
kind = "beacon"
[trackers.calm]
kind = "calm"
[[checks]]
metric = "trackers.calm.overall.position_m.rmse"
max = 100
source = "a beacon of 20 m"
"""
LOUD = 'SHORTFINAL = {"sensors": {"loud_beacon": Beacon}}'
TESTS_OF_PARTS = """
def test_parts_of_the_ini_file(shortfinal):
    assert set(shortfinal("parts.scenario.toml").metrics["versions"]["parts"]) == {"sensors.beacon", "trackers.calm"}

def test_parts_of_a_test(shortfinal):
    loud = shortfinal("parts.scenario.toml", {"sensors.beacon.kind": "loud_beacon"}, plugins=["loud.py"])
    assert "sensors.loud_beacon" in loud.metrics["versions"]["parts"]
    assert loud is shortfinal("parts.scenario.toml", {"sensors.beacon.kind": "loud_beacon"}, plugins=["loud.py"])

def test_nobody_brings_it(shortfinal):
    shortfinal("parts.scenario.toml", {"sensors.beacon.kind": "loud_beacon"})
"""


@pytest.fixture(scope="module")
def installed(tmp_path_factory):
    """A folder into which the wheel was unpacked, entry points and all."""
    pytest.importorskip("hatchling")
    folder = tmp_path_factory.mktemp("wheel")
    build = [sys.executable, "-m", "hatchling", "build", "-t", "wheel", "-d", str(folder)]
    subprocess.run(build, cwd=ROOT, check=True, capture_output=True, timeout=120)
    (wheel,) = folder.glob("*.whl")
    with zipfile.ZipFile(wheel) as archive:
        archive.extractall(folder / "site")
        names = archive.namelist()
    assert {name.split("/")[0] for name in names} >= {"sim", "autopilot", "tracking", "aircraft"}
    assert not [name for name in names if name.startswith("tests")]
    assert {f"{package}/py.typed" for package in ("sim", "autopilot", "tracking", "aircraft")} <= set(names)
    return folder / "site"


@pytest.fixture
def project(tmp_path, installed):
    """A foreign project, and pytest in it."""
    folder = tmp_path / "project"
    folder.mkdir()
    (folder / "line.scenario.toml").write_text(SCENARIO + GOOD + BAD + UNFLOWN)

    def call(*arguments):
        kept = {name: value for name, value in os.environ.items() if not name.startswith("PYTEST_")}
        environment = {**kept, "PYTHONPATH": str(installed), "OPENBLAS_NUM_THREADS": "1", "PY_COLORS": "0"}
        command = [sys.executable, "-m", "pytest", "--rootdir", str(folder), "-p", "no:cacheprovider", *arguments]
        done = subprocess.run(command, cwd=folder, env=environment, capture_output=True, text=True, timeout=120)
        return done.returncode, done.stdout + done.stderr

    call.folder = folder
    return call


def test_every_check_is_a_test_and_a_failure_says_what_when_and_why(project):
    (project.folder / "test_flights.py").write_text(TESTS)
    code, told = project("-v", "--strict-markers", "--shortfinal-report=kept", "-rs")
    assert code == 1, told
    assert "line.scenario.toml::bank PASSED" in told
    assert "line.scenario.toml::tight bank FAILED" in told
    assert "line.scenario.toml::sink_mps SKIPPED" in told
    assert "no glide was flown" in told
    said = re.search(
        r"tight bank: bank_deg = (\S+) deg at (\S+) s, limit 2 deg, beyond it by (\S+) deg; source: no airline; "
        r"flight 0, seed 1: shortfinal run line\.scenario\.toml --flight 0\n",
        told,
    )
    assert said, told
    assert float(said[1]) - 2 == pytest.approx(float(said[3]), abs=0.01)  # four figures are printed
    assert "test_an_override_changes_the_flight PASSED" in told
    assert "test_the_same_scenario_is_flown_once PASSED" in told
    assert "test_a_scenario_at_fault FAILED" in told
    assert "did you mean 'speed_mps'?" in told
    assert "report: kept/line/report.html" in told
    assert (project.folder / "kept/line/report.html").stat().st_size > 10_000
    assert [path.name for path in (project.folder / "kept").iterdir()] == ["line"]


@pytest.mark.soak
def test_a_file_with_a_study_is_flown_as_the_study(project):
    (project.folder / "line.scenario.toml").unlink()
    (project.folder / "pytest.ini").write_text("[pytest]\nshortfinal_workers = 2\n")
    air = SCENARIO.replace("draws = 2", "draws = 1") + '[wind]\nturbulence = "moderate"\n'
    (project.folder / "air.scenario.toml").write_text(f"{air}{GOOD}{BAD}{UNFLOWN}[study]\nsamples = 3\n")
    few = GOOD + "share = 0.95\nconfidence = 0.9\n"
    (project.folder / "few.scenario.toml").write_text(f"{air}{few}[study]\nsamples = 3\n")
    (project.folder / "test_air.py").write_text(
        "def test_fixture(shortfinal):\n"
        "    checks = shortfinal('air.scenario.toml').metrics['checks']\n"
        "    assert [(check['passed'], check['flights']) for check in checks] == [(True, 3), (False, 3), (None, 3)]\n"
    )
    code, told = project("-v", "--continue-on-collection-errors", "--shortfinal-report=kept")
    assert code == 1, told
    assert "1 failed, 2 passed, 1 skipped, 1 error" in told, told
    assert "needs at least 45 flights, there are 3: none broken of 3 says only below 54 %" in told
    assert "tight bank: 0 of 3 flights keep it; bank_deg = " in told
    assert re.search(r"flight \d, seed 1: shortfinal run air\.scenario\.toml --flight \d\n", told)
    assert "report: kept/air/report.html" in told
    assert len((project.folder / "kept/air/flights.jsonl").read_text().splitlines()) == 3
    (project.folder / "pytest.ini").write_text("[pytest]\nshortfinal_workers = many\n")
    assert "shortfinal_workers: must be a whole number from 1 on, not 'many'" in project("air.scenario.toml")[1]


@pytest.mark.soak
def test_two_files_of_one_name_have_two_reports(project):
    for number in (1, 2):
        (project.folder / f"d{number}").mkdir()
        broken = BAD.replace("max = 2", f"max = 1.{number}")
        (project.folder / f"d{number}/line.scenario.toml").write_text(SCENARIO + broken)
    (project.folder / "line.scenario.toml").unlink()
    code, told = project("--shortfinal-report=kept")
    assert code == 1, told
    for name, limit in (("line", "1.1"), ("line-2", "1.2")):
        assert f"report: kept/{name}/report.html" in told
        assert f"limit {limit} deg" in told
        assert f"max    = {limit}" in (project.folder / "kept" / name / "scenario.toml").read_text()
    (project.folder / "d1/line.scenario.toml").unlink()
    (project.folder / "file").write_text("years of work")
    code, told = project("--shortfinal-report=file")
    assert code == 1, told
    assert "INTERNALERROR" not in told
    assert "no report: file/line: cannot be written: Not a directory" in told
    assert "limit 1.2 deg" in told
    assert (project.folder / "file").read_text() == "years of work"


@pytest.mark.soak
def test_a_broken_file_is_one_collection_error_with_file_and_key(project):
    (project.folder / "line.scenario.toml").write_text(SCENARIO)
    (project.folder / "typo.scenario.toml").write_text(SCENARIO.replace("cross_track_m", "cross_trak_m") + GOOD)
    (project.folder / "phase.scenario.toml").write_text(SCENARIO + UNFLOWN.replace("glide", "glyde"))
    code, told = project("--continue-on-collection-errors", "-v")
    assert code == 1, told
    assert "Traceback" not in told
    assert re.search(r"typo\.scenario\.toml: \[start\] cross_trak_m: no such key; did you mean 'cross_track_m'\?", told)
    assert "no phase 'glyde'" in told
    assert "line.scenario.toml::flies PASSED" in told
    assert "2 errors" in told


@pytest.mark.soak
def test_parts_from_outside_come_by_the_ini_file_and_by_the_fixture(project):
    (project.folder / "sub").mkdir()
    (project.folder / "sub/mine.py").write_text(PARTS)
    (project.folder / "pytest.ini").write_text("[pytest]\nshortfinal_plugins = sub/mine.py\n")
    (project.folder / "line.scenario.toml").unlink()
    (project.folder / "parts.scenario.toml").write_text(SCENARIO.replace("draws = 2", "draws = 3") + WITH_PARTS)
    (project.folder / "loud.py").write_text(PARTS.partition("SHORTFINAL")[0] + LOUD)
    (project.folder / "test_parts.py").write_text(TESTS_OF_PARTS)
    code, told = project("-v")
    assert code == 1, told
    assert "3 passed, 1 failed" in told or "1 failed, 3 passed" in told
    assert "parts.scenario.toml::trackers.calm.overall.position_m.rmse PASSED" in told
    assert "no kind 'loud_beacon'; did you mean 'beacon'?" in told
    assert "Traceback" not in told


@pytest.mark.soak
def test_xdist_flies_the_checks_of_a_file_in_one_worker(project):
    pytest.importorskip("xdist")
    code, told = project("-n", "2", "--dist", "loadfile", "-v", "--shortfinal-report=kept")
    assert code == 1, told
    assert "1 failed, 1 passed, 1 skipped" in told
    assert len(set(re.findall(r"\[(gw\d)\] .*line\.scenario", told))) == 1
    assert len(list((project.folder / "kept").iterdir())) == 1
