"""The command as people use it: exit codes, one sentence for bad input, nothing written where nothing was asked."""

from __future__ import annotations

import json
import os
import subprocess
import sys
import tomllib
from pathlib import Path

import pytest
from jsonschema import Draft202012Validator

import sim
from sim.experiment import run_to_folder
from tests.capture import capture
from tests.hostile.foreign import FOREIGN

RADAR = """
[sensors.radar]
kind = "surveillance_radar"
position_sigma_m = 100
[trackers.constant_velocity]
kind = "kalman"
"""
CAPTURE = capture(RADAR, name="short", draws=4, until_s=20)


def process(*arguments, cwd):
    """In a process of its own, as at a prompt."""
    home = cwd / "home"
    home.mkdir(exist_ok=True)
    environment = {**os.environ, "OPENBLAS_NUM_THREADS": "1", "NO_COLOR": "1", "HOME": str(home)}
    for name in ("MPLCONFIGDIR", "XDG_CACHE_HOME"):
        environment.pop(name, None)
    done = subprocess.run(
        [sys.executable, "-m", "sim", *map(str, arguments)],
        capture_output=True,
        text=True,
        cwd=cwd,
        env=environment,
        timeout=120,
        check=False,
    )
    assert "Traceback" not in done.stderr
    return done


@pytest.fixture
def scenario(tmp_path):
    file = tmp_path / "short.toml"
    file.write_text(CAPTURE)
    return file


@pytest.fixture(scope="module")
def ran(tmp_path_factory):
    """The folder of a run of the scenario in this process, for tests that only read it."""
    place = tmp_path_factory.mktemp("ran")
    (place / "short.toml").write_text(CAPTURE)
    folder, _ = run_to_folder(str(place / "short.toml"), {}, place / "a")
    return folder


def test_a_run_writes_its_folder_and_says_where(command, scenario, tmp_path):
    done = command("run", scenario)
    assert done.returncode == 0, done.stderr
    assert {path.name for path in tmp_path.iterdir()} == {"short.toml", "out"}  # nothing beside its folder
    folder = tmp_path / "out" / "short"
    names = {file.name for file in folder.iterdir()}
    wanted = {
        "scenario.toml",
        "flight.npz",
        "measurements.npz",
        "tracks.npz",
        "metrics.json",
        "timing.json",
        "report.html",
    }
    assert names == {*wanted, ".shortfinal"}
    assert "out/short/report.html" in done.stdout
    assert (folder / "report.html").stat().st_size < 3e6
    metrics = json.loads((folder / "metrics.json").read_text())
    assert metrics["trackers"]["constant_velocity"]["overall"]["position_m"]["raw"] > 0
    assert command("run", scenario).returncode == 0  # written again


def test_two_processes_write_the_same_bytes(scenario, tmp_path):
    for name in ("a", "b"):
        assert process("run", scenario, "-o", tmp_path / name, cwd=tmp_path).returncode == 0
    assert_same_bytes(tmp_path / "a", tmp_path / "b")
    assert list((tmp_path / "home").iterdir()) == []  # nothing in the user's home, a plotting library's cache included


def assert_same_bytes(one, other):
    """All files of two runs but the wall times."""
    names = {file.name for file in one.iterdir()} - {"timing.json"}
    assert {"metrics.json", "report.html", "scenario.toml", "flight.npz", "tracks.npz"} < names
    for name in names:
        assert (one / name).read_bytes() == (other / name).read_bytes(), name


def test_the_resolved_scenario_repeats_the_run(command, scenario, tmp_path):
    slow = "autopilot.estimate_lag_s=2", "wind.turbulence=light"  # the law of this design is made slower
    sets = [word for change in slow for word in ("--set", change)]
    assert command("run", scenario, *sets, "-o", tmp_path / "a").returncode == 0
    assert command("run", tmp_path / "a/scenario.toml", "-o", tmp_path / "b").returncode == 0
    assert_same_bytes(tmp_path / "a", tmp_path / "b")


def test_the_resolved_scenario_with_another_bank_limit_is_designed_for_it(command, ran, scenario, tmp_path):
    other = "--set", "autopilot.bank_limit_deg=25"
    done = command("run", ran / "scenario.toml", *other, "-o", tmp_path / "b")
    assert "warning: the gains of [designed] were made for other inputs (bank_limit): designed anew" in done.stdout
    assert command("run", scenario, *other, "-o", tmp_path / "c").returncode == 0
    for name in ("scenario.toml", "flight.npz", "tracks.npz"):
        assert (tmp_path / "b" / name).read_bytes() == (tmp_path / "c" / name).read_bytes()


def test_another_seed_gives_other_measurements(command, ran, scenario, tmp_path):
    assert command("run", scenario, "--seed", 2, "-o", tmp_path / "2").returncode == 0
    one, two = (json.loads((folder / "metrics.json").read_text()) for folder in (ran, tmp_path / "2"))
    assert one["flight"] == two["flight"]  # calm air: the flight has no random numbers
    assert one["trackers"] != two["trackers"]


def test_a_failed_check_is_exit_one(command, scenario, tmp_path):
    scenario.write_text(CAPTURE + '[[checks]]\nmetric = "bank_deg"\nmax = 0.1\nsource = "test"\n')
    done = command("run", scenario)
    assert done.returncode == 1
    assert "FAILED" in done.stdout


def test_trackers_can_be_taken_out(command, scenario, tmp_path):
    done = command("run", scenario, "--set", "trackers={}", "--json")
    assert done.returncode == 0
    assert json.loads(done.stdout)["trackers"] == {}


@pytest.mark.parametrize(
    ("change", "said"),
    [
        (("wind.speed_mps=nan",), "must be a finite number"),
        (("wind.speed_furlong=3",), "no such key"),
        (("aircraft.model=an62",), "did you mean"),
        (("aircraft.mass_kg=-5",), "mass_kg: must be above 0"),
        (("start.height_m=-10",), "a flight starts above the ground"),
        (("autopilot.law.k1_deg_per_m=0.5", "autopilot.law.cross_track_limit_m=9000"), "orbit"),
        (("aircraft.model=an26", "route.legs.0.speed_mps=30"), "cannot be trimmed at"),
        (("nonsense",), "table.key=value"),
        (("start.leg=7",), "leg must lie within 0 and 0"),
    ],
)
def test_bad_input_is_one_sentence_and_exit_two(command, scenario, tmp_path, change, said):
    sets = [word for item in change for word in ("--set", item)]
    done = command("run", scenario, *sets, "-o", tmp_path / "o")
    assert done.returncode == 2, done.stdout + done.stderr
    assert said in done.stderr
    assert not (tmp_path / "o").exists()


def test_a_route_too_tight_for_the_bank_limit_names_the_legs(command, tmp_path):
    file = tmp_path / "tight.toml"
    legs = [((0, 0), (4000, 0)), ((4000, 0), (4000, 1500)), ((4000, 1500), (0, 1500))]
    tables = "".join(
        f"[[route.legs]]\nfrom_m = {list(a)}\nto_m = {list(b)}\nspeed_mps = 72\nheight_m = 500\n" for a, b in legs
    )
    file.write_text(f'name = "tight"\n[route]\nkind = "legs"\n{tables}')
    done = command("validate", file)
    assert done.returncode == 2
    assert "leg 1" in done.stderr
    assert "15 deg of bank" in done.stderr


def test_a_foreign_folder_is_left_alone(command, scenario, tmp_path):
    (tmp_path / "mine").mkdir()
    (tmp_path / "mine/thesis.txt").write_text("years of work")
    done = command("run", scenario, "-o", tmp_path / "mine")
    assert done.returncode == 2
    assert "did not write" in done.stderr
    assert [file.name for file in (tmp_path / "mine").iterdir()] == ["thesis.txt"]


def test_new_writes_a_scenario_that_is_valid(command, tmp_path):
    done = command("new", "mine.toml")
    assert done.returncode == 0, done.stderr
    text = (tmp_path / "mine.toml").read_text()
    assert 'name = "mine"' in text
    assert text.startswith("#:schema ./scenario.schema.json\n")
    schema = (tmp_path / "scenario.schema.json").read_text()
    assert schema == command("schema").stdout
    assert Draft202012Validator(json.loads(schema)).is_valid(tomllib.loads(text))
    assert command("validate", "mine.toml").returncode == 0
    assert "exists already" in command("new", "mine.toml").stderr
    (tmp_path / "scenario.schema.json").write_text("mine")
    assert "scenario.schema.json is there already, and kept" in command("new", "other.toml").stdout
    assert (tmp_path / "scenario.schema.json").read_text() == "mine"


def test_version_and_quiet(command):
    assert command("--version").stdout == f"shortfinal {sim.__version__}\n"
    done = command("validate", "an26_pattern", "a320", "-q")
    assert (done.returncode, done.stdout, done.stderr) == (0, "", "")


def test_lists_and_schema_and_doctor_answer(command, tmp_path):
    listed = command("list").stdout
    assert "an26_pattern" in listed
    assert "an26 " in command("list", "--aircraft").stdout
    assert "surveillance_radar" in command("list", "--kinds").stdout
    schema = json.loads(command("schema").stdout)
    assert "bank_limit_deg" in json.dumps(schema)
    assert "imm" in schema["properties"]["trackers"]["additionalProperties"]["properties"]["kind"]["enum"]
    assert command("doctor").returncode == 0


def test_doctor_names_every_extra_and_what_of_it_is_installed(monkeypatch):
    import importlib.metadata as metadata
    import tomllib

    from sim.cli.doctor import examine
    from sim.versions import EXTRAS

    root = Path(__file__).resolve().parents[3]
    asked = tomllib.loads((root / "pyproject.toml").read_text())["project"]["optional-dependencies"]
    assert {extra: asked[extra][0].split()[0] for extra in asked if extra not in ("docs", "dev")} == EXTRAS
    there = {"pyarrow": "17.0"}

    def version(name):
        if name in EXTRAS.values() and name not in there:
            raise metadata.PackageNotFoundError
        return there.get(name, "1.0")

    monkeypatch.setattr(metadata, "version", version)
    lines, healthy = examine()
    told = dict(line.removeprefix("note  extra ").split(maxsplit=1) for line in lines if "  extra " in line)
    assert told.pop("parquet") == "pyarrow 17.0"
    assert told == {
        extra: f"not installed: pip install 'shortfinal[{extra}]'" for extra in EXTRAS if extra != "parquet"
    }
    assert healthy  # an extra is none that must be there


def test_doctor_says_what_an_aircraft_lacks_and_what_repairs_do(command, tmp_path):
    path = FOREIGN["read by a switch"].write(tmp_path)
    told = command("doctor", "--aircraft", path)
    assert told.returncode == 0
    said = " ".join(told.stdout.split())
    assert "BAD as it lies: 'plane' cannot be used: nothing here sets /sim/a, /sim/b, /sim/c" in said
    assert "note aircraft.repairs = true: nothing sets /sim/a, /sim/b, /sim/c: held at 0" in said
    assert "good aircraft.repairs = true: its slowest level flight is" in said
    assert command("doctor", "--aircraft", tmp_path / "none").returncode == 2


def test_help_does_not_import_the_heavy_libraries(tmp_path):
    probe = (
        "import sys; sys.argv = ['shortfinal', '--help']\n"
        "import sim.cli.commands\n"
        "try: sim.cli.commands.main()\n"
        "except SystemExit: pass\n"
        "heavy = {'jsbsim', 'numpy', 'scipy', 'matplotlib', 'control', 'filterpy', 'pydantic'} & set(sys.modules)\n"
        "sys.exit(f'imported {heavy}' if heavy else 0)"
    )
    root = Path(__file__).resolve().parents[3]
    done = subprocess.run([sys.executable, "-c", probe], capture_output=True, text=True, cwd=root, check=False)
    assert done.returncode == 0, done.stderr
