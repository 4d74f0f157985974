"""Parts from outside: found by three ways, the same by all of them, and one sentence for each that is at fault."""

from __future__ import annotations

import importlib
import importlib.util
import json
import operator
import shutil
import sys
from pathlib import Path
from types import SimpleNamespace

import pytest

import sim
from sim.cli.commands import main
from sim.errors import OutputError, ScenarioError
from sim.experiment import run, run_to_folder
from sim.scenario import plugins as plugins_module
from sim.scenario.plugins import catalogue_with, load_parts
from sim.scenario.reading import read
from sim.studies import study as studies
from sim.studies.job import Job, fly
from sim.workers.executors import LocalExecutor
from sim.workers.isolation import run_isolated

FILE = Path(__file__).parent / "foreign_parts.py"
TABLES = {
    "name": "line",
    "until_s": 6.0,
    "draws": 3,
    "route": {"kind": "legs", "legs": [{"from_m": [0, 0], "to_m": [20000, 0], "speed_mps": 72, "height_m": 600}]},
    "start": {"leg": 0, "cross_track_m": 300.0},
    "wind": {"events": {"lift": {"kind": "thermal"}}},
    "sensors": {"beacon": {"kind": "beacon"}},
    "trackers": {"calm": {"kind": "calm"}},
}
STUDY = {**TABLES, "study": {"axes": {"wind.speed_mps": [0, 4]}}}
NAMED = {"sensors.beacon", "trackers.calm", "wind_events.thermal"}
SENSOR = """
from dataclasses import dataclass
from typing import Annotated
from sim.observation.sensors.surveillance_radar import SurveillanceRadar
@dataclass(frozen=True)
class Mine:
    period: Annotated[float, "s"] = 1.0
    {member}
    def step(self, state, before, after): return state, []
    def begin(self, time, streams): return None
    def truth(self, state): return state.north, state.east
"""


@pytest.fixture
def site(tmp_path, monkeypatch):
    """What makes an installed package of entry points, without installing anything."""
    made = []

    def make(package, entries, text, version="1.0"):
        folder = tmp_path / f"site-{package}-{version}"
        (folder / package).mkdir(parents=True)
        (folder / package / "__init__.py").write_text("")
        (folder / package / "parts.py").write_text(text)
        about = folder / f"{package}-{version}.dist-info"
        about.mkdir()
        (about / "METADATA").write_text(f"Metadata-Version: 2.1\nName: {package}\nVersion: {version}\n")
        (about / "entry_points.txt").write_text(
            "\n".join(f"[shortfinal.{family}]\n{kind} = {package}.parts:{name}\n" for family, kind, name in entries)
        )
        monkeypatch.syspath_prepend(str(folder))
        forget(package)
        made.append(package)
        return folder

    def forget(package):
        for name in [name for name in sys.modules if name.partition(".")[0] == package]:
            del sys.modules[name]
            plugins_module._digests.pop(name, None)

    yield make
    for package in made:
        forget(package)


ENTRIES = (("sensors", "beacon", "Beacon"), ("trackers", "calm", "Calm"), ("wind_events", "thermal", "Thermal"))


def without_versions(result):
    return {key: value for key, value in result.metrics.items() if key != "versions"}


def faults(tables=TABLES, plugins=()):
    with pytest.raises(ScenarioError) as caught:
        read(tables, plugins=plugins)
    (line,) = str(caught.value).splitlines()
    return line


def test_a_file_a_module_and_an_installed_package_fly_the_same(site, monkeypatch):
    by_file = run(TABLES, plugins=[FILE])
    monkeypatch.syspath_prepend(str(FILE.parent))
    module = importlib.import_module("foreign_parts")
    by_module = run(TABLES, plugins=module)
    assert type(by_module.scenario.sensors["beacon"]) is module.Beacon
    site("foreign", ENTRIES, FILE.read_text())
    by_package = run(TABLES)
    assert without_versions(by_file) == without_versions(by_module) == without_versions(by_package)
    for result in (by_file, by_module, by_package):
        assert set(result.metrics["versions"]["parts"]) == NAMED
    assert by_file.metrics["versions"] == by_module.metrics["versions"] != by_package.metrics["versions"]


def test_only_parts_that_are_named_are_among_the_versions():
    plain = {key: value for key, value in TABLES.items() if key not in ("wind", "sensors", "trackers")}
    assert "parts" not in run(plain, plugins=[FILE]).metrics["versions"]
    assert {part.address for part in read({**TABLES, "trackers": {}}, plugins=[FILE]).parts} == {
        "sensors.beacon",
        "wind_events.thermal",
    }


def test_a_scenario_that_was_read_keeps_its_parts():
    assert run(read(TABLES, plugins=[FILE])).metrics == run(TABLES, plugins=[FILE]).metrics


def test_a_scenario_alone_runs_no_code(tmp_path):
    (tmp_path / "foreign_parts.py").write_text(FILE.read_text())
    with pytest.raises(ScenarioError) as caught:
        read(TABLES)
    told = str(caught.value).splitlines()
    assert len(told) == 3
    assert "[trackers.calm] kind: no kind 'calm'; did you mean 'kalman'?" in told[1]
    assert (
        "[wind.events.lift] kind: no kind 'thermal'; allowed: gust, microburst, wind_shift; others come with" in told[2]
    )


def test_a_package_that_cannot_be_read_hides_no_other(site):
    site("foreign", ENTRIES, FILE.read_text())
    folder = site("garbled", [("sensors", "wreck", "Wreck")], "")
    (folder / "garbled-1.0.dist-info" / "entry_points.txt").write_bytes(b"\xff\xfe[shortfinal.sensors]\x00")
    assert "beacon" in catalogue_with().kinds("sensors")
    assert read(TABLES).parts


def test_packages_are_imported_only_when_a_scenario_names_them(site, capsys):
    site("foreign", ENTRIES, FILE.read_text())
    site("broken", [("sensors", "wreck", "Wreck")], "1 / 0")
    assert "beacon" in catalogue_with().kinds("sensors")
    with pytest.raises(SystemExit):
        call("list", "--kinds")
    told = capsys.readouterr().out
    assert "beacon            from foreign 1.0" in " ".join(told.split()) or "from foreign 1.0" in told
    assert "from broken 1.0" in told
    assert not [name for name in sys.modules if name.startswith(("foreign.", "broken."))]
    read(TABLES)  # the broken one stops only who names it
    assert "foreign.parts" in sys.modules
    said = faults({**TABLES, "sensors": {"beacon": {"kind": "wreck"}}})
    assert said == (
        "scenario: [sensors.beacon] kind 'wreck' of broken 1.0 cannot be imported: ZeroDivisionError: division by zero"
    )


def test_a_package_cannot_bear_the_name_of_a_bundled_kind(site):
    site("usurper", [("trackers", "kalman", "Calm")], FILE.read_text())
    kalman = {
        **TABLES,
        "wind": {},
        "sensors": {"r": {"kind": "surveillance_radar"}},
        "trackers": {"k": {"kind": "kalman"}},
    }
    assert read(kalman).trackers["k"].cls.__module__ == "tracking.trackers.kalman"
    assert read(kalman).parts == ()


def test_two_parts_of_one_name_stop_only_who_names_it(site, tmp_path):
    site("foreign", ENTRIES, FILE.read_text())
    site("other", ENTRIES[:1], FILE.read_text())
    two = {**TABLES, "wind": {}, "trackers": {}}
    assert "[sensors.beacon] kind 'beacon' comes from " in faults(two)
    assert "other 1.0" in faults(two)
    assert "foreign 1.0" in faults(two)
    assert read({**two, "sensors": {}, "wind": TABLES["wind"]}).parts
    copy = tmp_path / "copy.py"
    copy.write_text(FILE.read_text() + "# another\n")
    event = {**two, "sensors": {}, "wind": TABLES["wind"]}
    assert f"comes from {FILE} and from {copy} and from foreign 1.0; leave one of them out" in faults(
        event, [FILE, copy]
    )


def test_the_same_file_by_two_paths_is_one(tmp_path, monkeypatch):
    monkeypatch.chdir(FILE.parent)
    assert read(TABLES, plugins=[FILE, FILE.name]).parts


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ("import no_such_module", "cannot be imported: ModuleNotFoundError: No module named 'no_such_module' (line 1)"),
        ("x = 1\n1 / 0", "cannot be imported: ZeroDivisionError: division by zero (line 2)"),
        ("def f(:\n", "cannot be imported: SyntaxError: invalid syntax (line 1)"),
        ("raise SystemExit(0)", "cannot be imported: SystemExit: 0 (line 1)"),
        ("raise ValueError('a\\nb\\x1b[2J')", "cannot be imported: ValueError: a b"),
        ("x = '\0'", "cannot be imported"),
        ("", "does not say what it brings; write SHORTFINAL = {"),
        ("SHORTFINAL = []", "SHORTFINAL must be a table of tables"),
        ("SHORTFINAL = {}", "SHORTFINAL must be a table of tables"),
        ("SHORTFINAL = {'sensors': []}", "SHORTFINAL must be a table of tables"),
        ("SHORTFINAL = {'sensor': {}}", "SHORTFINAL: no family 'sensor'; did you mean 'sensors'?"),
        ("SHORTFINAL = {1: {}}", "SHORTFINAL: no family 1"),
        ("SHORTFINAL = {'truths': {'x': int}}", "no family 'truths'"),
        ("SHORTFINAL = {'sensors': {'beacon': 7}}", "SHORTFINAL sensors: 'beacon' is no class"),
        ("SHORTFINAL = {'sensors': {'Be con': int}}", "'Be con' is no name of a kind"),
        ("SHORTFINAL = {'sensors': {3: int}}", "3 is no name of a kind"),
        ("SHORTFINAL = {'sensors': {'mls': int}}", "'mls' is a bundled kind; give yours another name"),
    ],
)
def test_a_file_that_brings_nothing_usable_is_one_sentence(tmp_path, text, said):
    file = tmp_path / "mine.py"
    file.write_text(text)
    told = faults(plugins=[file])
    assert told.startswith(f"{file}: ")
    assert said in told


def test_a_file_must_be_a_small_file_of_text(tmp_path):
    assert faults(plugins=[tmp_path / "none.py"]) == f"{tmp_path}/none.py: no such file"
    assert faults(plugins=[tmp_path]) == f"{tmp_path}: is a folder; name a file in it"
    large = tmp_path / "large.py"
    large.write_bytes(b"#" * (2 << 20))
    assert "larger than 1048576 bytes" in faults(plugins=str(large))
    large.write_bytes(b"# \xe9")
    assert "not UTF-8 text" in faults(plugins=large)
    assert "no regular file" in faults(plugins="/dev/null")
    assert faults(plugins="a\0b\n") == "a\\x00b\\n: no such file"


def test_an_entry_point_must_name_a_class(site):
    site("foreign", [("sensors", "beacon", "np")], FILE.read_text())
    assert faults({**TABLES, "wind": {}, "trackers": {}}).endswith("kind 'beacon' of foreign 1.0 is no class")
    folder = site("other", [("sensors", "pulse", "Beacon")], FILE.read_text())
    (folder / "other-1.0.dist-info/entry_points.txt").write_text("[shortfinal.sensors]\npulse = other.parts\n")
    pulse = {**TABLES, "wind": {}, "trackers": {}, "sensors": {"p": {"kind": "pulse"}}}
    assert faults(pulse).endswith("cannot be imported: ValueError: write its entry point as module:Class")


@pytest.mark.parametrize(
    ("change", "said"),
    [
        ("@dataclass(frozen=True)->", "is no frozen dataclass; write @dataclass(frozen=True) above its class"),
        ("@dataclass(frozen=True)->@dataclass", "is no frozen dataclass"),
        ("def step->def stop", "has no 'step'; 'shortfinal contract' says what it needs"),
        (
            '"s"]->"furlong"]',
            "cannot be read: the unit 'furlong' of 'period' is not one of m, s, Hz",
        ),
        ("Annotated[float->Annotated[floaty", "has parameters that cannot be read: NameError"),
        ("period->kind", "has a parameter 'kind', and its table has that key already"),
    ],
)
def test_a_part_that_lacks_something_stops_only_who_names_it(tmp_path, change, said):
    before, _, after = change.partition("->")
    text = "from __future__ import annotations\n" + SENSOR.replace("{member}", 'channels = ("north", "east")')
    file = tmp_path / "mine.py"
    assert before in text
    file.write_text(text.replace(before, after) + "\nSHORTFINAL = {'sensors': {'mine': Mine}}\n")
    plain = {**TABLES, "wind": {}, "trackers": {}}
    assert said in faults({**plain, "sensors": {"mine": {"kind": "mine"}}}, [file])
    assert faults({**plain, "sensors": {"mine": {"kind": "mine"}}}, [file]).startswith(
        f"scenario: [sensors.mine] kind 'mine' of {file} "
    )
    assert read({**plain, "sensors": {}}, plugins=[file]).parts == ()


def test_a_class_that_no_other_process_could_find_is_refused(tmp_path):
    file = tmp_path / "mine.py"
    inner = SENSOR.replace("{member}", "channels = ()").replace("\n", "\n    ")
    file.write_text(f"def make():{inner}\n    return Mine\nSHORTFINAL = {{'sensors': {{'mine': make()}}}}")
    assert "define it at the top of its file" in faults({**TABLES, "sensors": {"m": {"kind": "mine"}}}, [file, FILE])


def test_what_making_a_part_raises_is_a_sentence(tmp_path):
    file = tmp_path / "mine.py"
    member = "channels = ()\n    def __post_init__(self): [][1]"
    file.write_text(SENSOR.replace("{member}", member) + "\nSHORTFINAL = {'sensors': {'mine': Mine}}\n")
    said = faults({**TABLES, "wind": {}, "trackers": {}, "sensors": {"m": {"kind": "mine"}}}, [file])
    assert said == "scenario: [sensors.m] making it raises IndexError: list index out of range"


def test_a_mode_that_cannot_be_designed_is_a_sentence(tmp_path):
    file = tmp_path / "mine.py"
    file.write_text(FILE.read_text().replace("return cls(**{", "return cls(*[][1], **{"))
    course = {**TABLES, "autopilot": {"kind": "track_hold"}}
    with pytest.raises(ScenarioError) as caught:
        run(course, plugins=[file])
    said = "kind 'track_hold' cannot be designed: IndexError: list index out of range"
    assert str(caught.value) == f"line: [autopilot.law] {said}"


def test_a_mode_from_outside_flies_and_a_crew_can_switch_to_it():
    course = {"name": "line", "until_s": 20, "route": TABLES["route"], "start": TABLES["start"]}
    held = run({**course, "autopilot": {"kind": "track_hold", "law": {"gain": 2.0}}}, plugins=FILE)
    assert abs(held.flight.deviation.cross_track - 300.0).max() < 1.0  # it holds the course, not the line
    switched = run({**course, "departures": [{"at_s": 5, "flies": "track_hold"}]}, plugins=FILE)
    assert set(switched.metrics["versions"]["parts"]) == {"modes.track_hold"}
    assert switched.flight.deviation.cross_track[-1] < 295.0  # the route law had begun to intercept


def test_parameters_of_a_part_are_read_with_their_units_and_limits():
    beacon = {"kind": "beacon", "sigma_ft": 100}
    assert read({**TABLES, "sensors": {"b": beacon}}, plugins=FILE).sensors["b"].sigma == pytest.approx(30.48)
    assert "sigma must be above 0" in faults({**TABLES, "sensors": {"b": {**beacon, "sigma_ft": 0}}}, [FILE])
    assert "sigma_ft: no such key" in faults(
        {**TABLES, "wind": {"events": {"lift": {"kind": "thermal", "sigma_ft": 1}}}}, [FILE]
    )


# ---- other processes


def test_a_child_process_gets_the_parts_before_their_values():
    scenario = read(TABLES, plugins=[FILE])
    foreign = SimpleNamespace(name="c172x", parts=scenario.parts, aircraft=SimpleNamespace(model="c172x"))
    assert run_isolated(foreign, 60.0, operator.attrgetter("up"), scenario.wind.events["lift"]) == 2.0
    assert run_isolated(foreign, 60.0, list, (scenario.wind.events["lift"],)) == [scenario.wind.events["lift"]]


def test_a_worker_process_flies_a_file_of_parts(tmp_path):
    metrics = studies.study(STUDY, tmp_path / "two", LocalExecutor(1), plugins=[FILE])
    assert metrics["outcomes"] == {"completed": 2}
    assert set(metrics["versions"]["parts"]) == NAMED


def test_a_worker_with_another_package_is_refused_and_no_flight_is_lost(site, tmp_path):
    site("foreign", ENTRIES, FILE.read_text())
    scenario = read(TABLES)
    job = Job(0, 0, 0, {}, {key: value for key, value in scenario.tables.items() if value is not None}, {})
    assert fly(job._replace(parts=scenario.parts))["metrics"]["outcome"] == "completed"
    others = tuple(part._replace(digest="0" * 64) for part in scenario.parts)
    with pytest.raises(OutputError, match=r"of foreign 1\.0 is another one here$"):
        fly(job._replace(parts=others))
    absent = tuple(part._replace(module="no_such.parts") for part in scenario.parts)
    with pytest.raises(OutputError, match=r"of foreign 1\.0 is not installed here$"):
        load_parts(absent)


# ---- studies


def test_a_changed_part_never_reuses_old_flights(tmp_path, inline):
    file, folder = tmp_path / "mine.py", tmp_path / "study"
    file.write_text(FILE.read_text())
    before = studies.study(STUDY, folder, inline(), plugins=[file])
    kept = {path.name for path in (folder / "cache/flights").iterdir()}
    file.write_text(FILE.read_text() + "# changed\n")
    with pytest.raises(OutputError, match=r"holds a study begun with sensors\.beacon \w{16}, not \w{16}; .*--anew$"):
        studies.study(STUDY, folder, inline(), plugins=[file])
    with pytest.raises(OutputError, match=r"was begun with sensors\.beacon \w{16}, not \w{16}; bring the one"):
        studies.resume(folder, inline(), plugins=[file], anyway=True)
    after = studies.study(STUDY, folder, inline(), plugins=[file], anew=True)
    assert kept
    assert not kept & {path.name for path in (folder / "cache/flights").iterdir()}
    assert before["versions"] != after["versions"]
    assert before["rows"] == after["rows"]  # a comment changes nothing else


def test_a_study_is_resumed_only_with_its_parts_and_never_from_its_folder(tmp_path, inline):
    folder = tmp_path / "study"
    studies.study(STUDY, folder, inline(), plugins=[FILE])
    whole = (folder / "metrics.json").read_bytes()
    shutil.copy(FILE, folder / "foreign_parts.py")
    log = (folder / "flights.jsonl").read_bytes().splitlines(keepends=True)
    (folder / "flights.jsonl").write_bytes(log[0])
    with pytest.raises(
        OutputError, match=r"study: was begun with sensors\.beacon from outside; bring it again with --p"
    ):
        studies.resume(folder, inline())
    studies.resume(folder, inline(), plugins=[FILE])
    assert (folder / "metrics.json").read_bytes() == whole
    assert "foreign_parts" not in (folder / "scenario.toml").read_text()


@pytest.mark.parametrize("parts", [[], {"sensors": "x"}, {"truths.x": "y"}, 7])
def test_an_identity_with_parts_that_are_none_is_no_study(tmp_path, inline, parts):
    folder = tmp_path / "study"
    studies.study({**STUDY, "wind": {}, "sensors": {}, "trackers": {}, "until_s": 1}, folder, inline())
    identity = folder / "cache/identity.json"
    found = json.loads(identity.read_text())
    identity.write_text(json.dumps({**found, "versions": {**found["versions"], "parts": parts}}))
    with pytest.raises(OutputError, match="is no study folder"):
        studies.resume(folder, inline())


def test_an_axis_may_name_a_part(tmp_path, inline):
    axes = {"trackers.calm.kind": ["kalman", "calm"], "wind.speed_mps": [0.0]}
    base = {**TABLES, "wind": {}, "trackers": {"calm": {"kind": "kalman"}}, "study": {"axes": axes}}
    metrics = studies.study(base, tmp_path / "study", inline(), plugins=[FILE])
    assert set(metrics["versions"]["parts"]) == {"sensors.beacon", "trackers.calm"}
    assert metrics["outcomes"] == {"completed": 2}


# ---- the command


def call(*arguments, monkeypatch=None):
    before, sys.argv = sys.argv, ["shortfinal", *map(str, arguments)]
    try:
        main()
    finally:
        sys.argv = before


def test_a_run_by_the_command_tells_the_digests_and_names_no_file(tmp_path):
    folder, result = run_to_folder(TABLES, {}, tmp_path / "out", plugins=[FILE])
    written = json.loads((folder / "metrics.json").read_text())
    assert written["versions"]["parts"] == {
        part.address: part.digest[:16] for part in catalogue_with(FILE).parts if part.address in NAMED
    }
    assert not [path for path in folder.iterdir() if str(FILE).encode() in path.read_bytes()]
    assert "wind_events.thermal" in (folder / "report.html").read_text()
    assert sim.read((folder / "scenario.toml"), plugins=FILE).parts == result.scenario.parts


@pytest.mark.parametrize("verb", ["validate", "explain"])
def test_verbs_that_read_take_parts(tmp_path, capsys, verb):
    from sim.scenario.toml_writer import dumps

    file = tmp_path / "line.toml"
    file.write_text(dumps(read(TABLES, plugins=FILE).tables))
    call_good(verb, file, "--plugin", FILE)
    assert "line: " in capsys.readouterr().out
    with pytest.raises(SystemExit) as ended:
        call(verb, file)
    assert ended.value.code == 2
    assert "no kind 'beacon'" in capsys.readouterr().err


def call_good(*arguments):
    with pytest.raises(SystemExit) as ended:
        call(*arguments)
    assert not ended.value.code


def test_the_schema_and_the_list_of_kinds_have_the_parts(capsys):
    call_good("schema", "--plugin", FILE)
    assert "sigma_ft" in json.dumps(json.loads(capsys.readouterr().out)["$defs"]["Beacon"])
    call_good("list", "--kinds", "--plugin", FILE)
    assert f"Air that rises everywhere, as a sine for a while. [{FILE}]" in capsys.readouterr().out
