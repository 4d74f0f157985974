"""Folders that somebody else made: nothing outside is touched, nothing hangs, and nothing enters the figures unseen."""

from __future__ import annotations

import contextlib
import hashlib
import io
import json
import os
import shutil
import signal
import socket

import numpy as np
import pytest

from sim import claims, files
from sim.claims import row_cache
from sim.claims.ledger import Claim, Measured, Reading, Row, exactly
from sim.cli.exporting.spreadsheet import export_spreadsheet
from sim.errors import OutputError, ScenarioError
from sim.flight.preparation import prepare
from sim.scenario.reading import read
from sim.studies import folder as folders
from sim.studies import study as studies
from sim.studies.kept import flight_cache, flight_log
from tests.capture import CAPTURE
from tests.sim.conftest import Inline

TABLES = {
    **CAPTURE,
    "name": "theirs",
    "aircraft": {"model": "point_mass"},
    "until_s": 1.0,
    "draws": 2,
    "sensors": {"radar": {"kind": "surveillance_radar", "period_s": 0.5}},
    "trackers": {"plain": {"kind": "kalman"}},
    "checks": [{"metric": "bank_deg", "max": 60}],
    "study": {"axes": {"sensors.radar.position_sigma_m": [50.0, 100.0]}},
}
PRECIOUS = "years of work"
LOG, METRICS = flight_log.LOG, "metrics.json"


@pytest.fixture(scope="module")
def good(tmp_path_factory):
    place = tmp_path_factory.mktemp("good") / "f"
    studies.study(TABLES, place, Inline())
    return place


@pytest.fixture
def folder(good, tmp_path):
    """A copy, with a file of somebody else beside it that must stay as it is."""
    shutil.copytree(good, tmp_path / "f")
    (tmp_path / "v").mkdir()
    (tmp_path / "v/precious.txt").write_text(PRECIOUS)
    os.utime(tmp_path / "v/precious.txt", (1, 1))
    return tmp_path / "f"


@contextlib.contextmanager
def in_time(seconds=20):
    """A hang fails."""

    def late(number, frame):
        pytest.fail("hangs")

    before = signal.signal(signal.SIGALRM, late)
    signal.alarm(seconds)
    try:
        yield
    finally:
        signal.alarm(0)
        signal.signal(signal.SIGALRM, before)


def resume(folder, told=None):
    return studies.resume(folder, Inline(), remark=None if told is None else told.append)


VERBS = {"resume": resume, "export": lambda folder: export_spreadsheet(folder), "anew": lambda folder: anew(folder)}


def anew(folder):
    return studies.study(TABLES, folder, Inline(), anew=True)


def outside(folder):
    return folder.parent / "v/precious.txt"


def instead(folder, name, make):
    """Something else in the place of a file or folder."""
    place = folder / name
    if place.is_dir():
        shutil.rmtree(place)
    else:
        place.unlink(missing_ok=True)
    make(place)


def pipe(folder, name):
    instead(folder, name, os.mkfifo)


def link(folder, name, to=None):
    instead(folder, name, lambda place: place.symlink_to(to or outside(folder)))


def listener(folder, name):
    with socket.socket(socket.AF_UNIX) as made:
        here = os.getcwd()
        os.chdir(folder)
        try:
            made.bind(name)
        finally:
            os.chdir(here)


STRANGE = {
    "partial link": lambda f: link(f, ".metrics.json.partial"),
    "staging link": lambda f: link(f, ".partial", f.parent / "v"),
    "log link": lambda f: link(f, LOG),
    "result link": lambda f: link(f, METRICS),
    "table link": lambda f: link(f, "flights.csv"),
    "mark link": lambda f: link(f, ".shortfinal"),
    "lock link": lambda f: link(f, "cache/lock"),
    "identity link": lambda f: link(f, "cache/identity.json"),
    "dangling link": lambda f: link(f, "cache/lock", f.parent / "nothing"),
    "flights link": lambda f: link(f, "cache/flights", f.parent / "v"),
    "cache link": lambda f: link(f, "cache", f.parent / "v"),
    "kept flight link": lambda f: link(f, next((f / "cache/flights").iterdir()).relative_to(f)),
    "log pipe": lambda f: pipe(f, LOG),
    "scenario pipe": lambda f: pipe(f, "scenario.toml"),
    "identity pipe": lambda f: pipe(f, "cache/identity.json"),
    "mark pipe": lambda f: pipe(f, ".shortfinal"),
    "lock pipe": lambda f: pipe(f, "cache/lock"),
    "kept flight pipe": lambda f: pipe(f, next((f / "cache/flights").iterdir()).relative_to(f)),
    "socket": lambda f: listener(f, "s"),
}


@pytest.mark.parametrize("verb", VERBS)
@pytest.mark.parametrize("spoil", STRANGE)
def test_links_and_special_files_are_refused_in_a_sentence(folder, spoil, verb):
    STRANGE[spoil](folder)
    with in_time(), pytest.raises(OutputError, match=r"\A[^\n]+\Z"):
        VERBS[verb](folder)
    assert [path.name for path in outside(folder).parent.iterdir()] == ["precious.txt"]
    assert outside(folder).read_text() == PRECIOUS
    assert not (folder.parent / "nothing").exists()


@pytest.mark.parametrize("what", ["run", "study", "claims"])
def test_a_link_in_the_folder_of_any_command_is_refused(tmp_path, what):
    files.claim(tmp_path / "o", what)
    (tmp_path / "o/report.html").symlink_to("/etc/passwd")
    with pytest.raises(OutputError, match=r"report\.html in it is a link"):
        files.claim(tmp_path / "o", what)


def test_the_folder_itself_may_be_a_link(folder, tmp_path):
    (tmp_path / "disk").symlink_to(folder)
    assert resume(tmp_path / "disk")["flights"] == 2


def test_a_link_that_comes_later_is_not_followed(tmp_path):
    """After a folder was looked at: what is opened is a regular file, and its own one."""
    (tmp_path / "theirs").write_text(PRECIOUS)
    (tmp_path / ".a.partial").symlink_to(tmp_path / "theirs")
    files.replace(tmp_path / "a", "ours")
    assert (tmp_path / "a").read_text() == "ours"
    (tmp_path / "rows").symlink_to(tmp_path / "theirs")
    os.mkfifo(tmp_path / "pipe")
    os.link(tmp_path / "theirs", tmp_path / "second_name")
    for name in ("rows", "pipe", "second_name"):
        with in_time(), pytest.raises(OSError, match=r"regular file|second name"):
            files.opened(tmp_path / name, os.O_WRONLY | os.O_APPEND)
    with in_time(), pytest.raises(OSError, match="regular file"):
        files.read_bytes(tmp_path / "pipe")
    assert (tmp_path / "theirs").read_text() == PRECIOUS


def test_a_log_with_a_second_name_outside_stays_there_as_it_is(folder):
    log = (folder / LOG).read_bytes()
    os.truncate(folder / LOG, len(log) - 3)
    os.link(folder / LOG, folder.parent / "theirs")
    resume(folder)
    assert (folder.parent / "theirs").read_bytes() == log[:-3]
    assert (folder / LOG).read_bytes() == log


def test_a_folder_in_the_place_of_a_file_leaves_the_others_alone(tmp_path):
    files.claim(tmp_path, "run")
    (tmp_path / "a").write_text("before")
    (tmp_path / "b").mkdir()

    def write():
        with files.staged(tmp_path) as place:
            for name in ("a", "b"):
                (place / name).write_text("after")

    with pytest.raises(OutputError, match="b in it is a folder"):
        write()
    assert (tmp_path / "a").read_text() == "before"


# ---- lines of the log


def first(folder, change, signed=True):
    """The first line with a change; signed as somebody does who knows how."""
    lines = (folder / LOG).read_text().splitlines()
    record = json.loads(lines[0])
    change(record)
    if signed:
        record = {name: value for name, value in record.items() if name != flight_log.DIGEST}
        digest = hashlib.sha256(f"{folders.stamp(folder)}\n{text(record)}".encode()).hexdigest()[:16]
        record[flight_log.DIGEST] = digest
    (folder / LOG).write_text("\n".join([text(record), *lines[1:]]) + "\n")


def text(record):
    return json.dumps(record, sort_keys=True, separators=(",", ":"))


def more(folder, line):
    with (folder / LOG).open("a") as file:
        file.write(f"{line}\n")


def huge(folder):
    lines = (folder / LOG).read_text()
    (folder / LOG).write_text(lines.replace('"bank_max_deg":', '"bank_max_deg":' + "9" * 400 + ',"x":', 1))


BAD_LINES = {
    "changed figure": lambda f: first(f, lambda d: d["metrics"].update(bank_max_deg=1.0), signed=False),
    "other outcome": lambda f: first(f, lambda d: d["metrics"].update(outcome="landed"), signed=False),
    "no digest": lambda f: first(f, lambda d: d.pop("digest"), signed=False),
    "no metrics": lambda f: first(f, lambda d: d.pop("metrics")),
    "metrics a list": lambda f: first(f, lambda d: d.update(metrics=[])),
    "no outcome": lambda f: first(f, lambda d: d["metrics"].pop("outcome")),
    "reason a number": lambda f: first(f, lambda d: d["metrics"].update(reason=7)),
    "cell a word": lambda f: first(f, lambda d: d.update(cell="x")),
    "cell true": lambda f: first(f, lambda d: d.update(cell=True)),
    "cell a list": lambda f: first(f, lambda d: d.update(cell=[])),
    "other cell": lambda f: first(f, lambda d: d.update(cell=2)),
    "other flight": lambda f: first(f, lambda d: d.update(flight=1)),
    "negative sample": lambda f: first(f, lambda d: d.update(sample=-1)),
    "other values": lambda f: first(f, lambda d: d.update(values={"sensors.radar.position_sigma_m": 51.0})),
    "values a list": lambda f: first(f, lambda d: d.update(values=[])),
    "nan": lambda f: first(f, lambda d: d["metrics"].update(bank_max_deg=float("nan"))),
    "infinity": lambda f: first(f, lambda d: d["metrics"].update(bank_max_deg=float("inf"))),
    "half a letter": lambda f: first(f, lambda d: d["metrics"].update(reason="\ud800")),
    "checks missing": lambda f: first(f, lambda d: d.update(checks=[])),
    "checks a table": lambda f: first(f, lambda d: d.update(checks={})),
    "check of text": lambda f: first(f, lambda d: d["checks"][0].update(margin="much")),
    "check without value": lambda f: first(f, lambda d: d["checks"][0].pop("value")),
    "check passed 1": lambda f: first(f, lambda d: d["checks"][0].update(passed=1)),
    "more keys": lambda f: first(f, lambda d: d.update(more=1)),
    "deep figures": lambda f: first(f, lambda d: d["metrics"].update(deep=json.loads('{"a":' * 40 + "1" + "}" * 40))),
    "null": lambda f: more(f, "null"),
    "number": lambda f: more(f, "7"),
    "no JSON": lambda f: more(f, "{'cell': 0}"),
    "deep": lambda f: more(f, "[" * 100_000),
    "long number": lambda f: more(f, "9" * 5000),
    "no text": lambda f: (f / LOG).write_bytes((f / LOG).read_bytes() + b"\xff\xfe\n"),
    "huge number": huge,
}


@pytest.fixture(scope="module")
def planned():
    planned = studies.plan(read(TABLES))
    values = {(cell, 0, 0): planned.cells[cell] for cell in (0, 1)}
    return flight_log.Planned(values, 1)


@pytest.mark.parametrize("spoil", BAD_LINES)
def test_a_line_that_no_flight_of_the_study_left_is_not_read(folder, planned, spoil):
    whole = flight_log.read(folder, folders.stamp(folder), planned)
    assert (len(whole.records), whole.faults) == (2, [])
    BAD_LINES[spoil](folder)
    found = flight_log.read(folder, folders.stamp(folder), planned)
    assert len(found.faults) == 1
    assert found.records == {place: whole.records[place] for place in found.records}


@pytest.mark.parametrize("spoil", ["changed figure", "nan", "deep", "other cell"])
def test_what_is_not_read_is_told_and_flown_again(good, folder, spoil):
    BAD_LINES[spoil](folder)
    before = {path: path.read_bytes() for path in folder.rglob("*") if path.is_file()}
    if spoil != "other cell":  # to see that, one needs the plan
        with pytest.raises(OutputError, match=r"\A[^\n]*line \d+ [^\n]*'shortfinal resume [^\n]+\Z"):
            export_spreadsheet(folder)
        assert {path: path.read_bytes() for path in folder.rglob("*") if path.is_file()} == before
    told = []
    resume(folder, told)
    for name in (LOG, METRICS, "report.html"):
        assert (folder / name).read_bytes() == (good / name).read_bytes()
    (sentence,) = told
    assert "one line is left out (line " in sentence


def test_lines_of_another_study_are_not_ours(good, folder, tmp_path):
    """Same cells, same flights, another seed."""
    studies.study({**TABLES, "seed": 2}, tmp_path / "other", Inline())
    (folder / LOG).write_bytes((tmp_path / "other" / LOG).read_bytes())
    told = []
    resume(folder, told)
    assert "2 lines are left out (line 1 was changed, or belongs to another study)" in told[0]
    assert (folder / METRICS).read_bytes() == (good / METRICS).read_bytes()


def test_an_undamaged_folder_is_not_remarked_upon(folder):
    told = []
    resume(folder, told)
    assert told == []


# ---- scenario and identity


@pytest.mark.parametrize(
    "content",
    [b"a = " + b"[" * 5000 + b"]" * 5000, b"seed = 1" + b"0" * 5000, b"\xff", b"a." * 200 + b"b = 1", b"seed ="],
)
def test_a_scenario_that_nobody_can_read_is_a_sentence(folder, content):
    (folder / "scenario.toml").write_bytes(content)
    with pytest.raises((OutputError, ScenarioError), match=r"\Ascenario\.toml: [^\n]+\Z"):
        resume(folder)


@pytest.mark.parametrize(
    "content",
    [
        "[" * 100_000,
        "9" * 5000,
        '{"seed": "1", "scenario": "", "versions": {}}',
        '{"seed": 1, "scenario": [], "versions": {}}',
        '{"seed": 1, "scenario": "", "versions": {"numpy": 1}}',
        '{"seed": 1, "scenario": "", "versions": {"numpy": "1\\n2"}}',
        '{"seed": 1, "scenario": "", "versions": {"parts": {"sensors.x": {}}}}',
        '{"seed": 1, "scenario": "", "versions": {"parts": {"x": "y"}}}',
    ],
)
@pytest.mark.parametrize("verb", ["resume", "export"])
def test_an_identity_of_other_types_is_a_sentence(folder, content, verb):
    (folder / "cache/identity.json").write_text(content)
    with pytest.raises(OutputError, match=r"\A[^\n]*its cache/identity\.json is damaged\Z"):
        VERBS[verb](folder)


# ---- kept flights


def changed(arrays, **more):
    return {**arrays, **more}


BAD_FLIGHTS = {
    "nan": lambda a: changed(a, state=np.where(np.arange(a["state"].size).reshape(a["state"].shape) == 40, np.nan, 1)),
    "short": lambda a: changed(a, leg=a["leg"][:-1]),
    "narrow": lambda a: changed(a, state=a["state"][:, :-1]),
    "flat": lambda a: changed(a, state=a["state"].ravel()),
    "empty": lambda a: {**a, **{name: a[name][:0] for name in ("state", "command", "leg", "phase")}},
    "leg beyond": lambda a: changed(a, leg=a["leg"] + 5),
    "phase beyond": lambda a: changed(a, phase=a["phase"] - 1),
    "legs as numbers": lambda a: changed(a, leg=a["leg"].astype(float)),
    "words": lambda a: changed(a, state=a["state"].astype(str)),
    "backwards": lambda a: changed(a, state=a["state"][::-1]),
    "told a number": lambda a: changed(a, told=np.array("7")),
    "no outcome": lambda a: changed(a, told=np.array(str(a["told"]).replace('"outcome"', '"x"'))),
    "outcome a number": lambda a: changed(a, told=np.array(str(a["told"]).replace('"completed"', "7"))),
    "no state": lambda a: {name: array for name, array in a.items() if name != "state"},
}


@pytest.mark.parametrize("spoil", BAD_FLIGHTS)
def test_a_kept_flight_that_is_none_counts_as_absent(folder, spoil):
    """Its digest is right: somebody made it."""
    (kept,) = (folder / "cache/flights").iterdir()
    ready = prepare(read({**TABLES, "study": None}))
    assert flight_cache.load(kept.parent, kept.stem, ready) is not None
    with np.load(io.BytesIO(kept.read_bytes()[32:])) as arrays:
        made = BAD_FLIGHTS[spoil](dict(arrays.items()))
    buffer = io.BytesIO()
    np.savez(buffer, **made)
    kept.write_bytes(hashlib.sha256(buffer.getvalue()).digest() + buffer.getvalue())
    assert flight_cache.load(kept.parent, kept.stem, ready) is None
    assert not kept.exists()


def test_a_kept_flight_that_cannot_be_judged_is_flown_again(good, folder, monkeypatch):
    from sim import experiment

    calls, evaluate = [], experiment.evaluate

    def fails_at_first(prepared, flight, number, own=None):
        calls.append(number)
        if len(calls) == 1:
            raise IndexError("nothing that anybody foresaw")
        return evaluate(prepared, flight, number)

    monkeypatch.setattr(experiment, "evaluate", fails_at_first)
    (folder / LOG).unlink()
    resume(folder)
    assert len(calls) == 3
    assert (folder / METRICS).read_bytes() == (good / METRICS).read_bytes()


# ---- rows of a ledger


@pytest.mark.parametrize(
    "change",
    [
        lambda d: d["measured"][0].__setitem__(1, 0.5),
        lambda d: d.pop("digest"),
        lambda d: d.update(claim="another"),
        lambda d: d.update(measured=7),
        lambda d: d.clear(),
    ],
)
def test_a_row_that_was_changed_is_measured_again(tmp_path, change):
    line = {"stamp": "now", "paper": "p", "claim": "c", "measured": [["as printed", 1.0, 0.9, 1.1, 50]]}
    line["digest"] = row_cache._digest(line)
    file = tmp_path / row_cache.FILE
    file.write_text(json.dumps(line))
    assert [*row_cache.load_rows(tmp_path, "now")] == [("p", "c")]
    change(line)
    file.write_text(json.dumps(line))
    assert row_cache.load_rows(tmp_path, "now") == {}


def test_a_row_of_other_readings_is_measured_again(tmp_path, monkeypatch):
    """And so is a claim without any reading, of which nothing is kept."""
    reading = Reading("as printed", lambda seed, runs: exactly(2.0))
    made = tuple(Claim(name, "", "", None, readings) for name, readings in (("a", (reading,)), ("b", ())))
    monkeypatch.setattr(claims, "chosen", lambda papers: ("p",))
    monkeypatch.setattr(claims, "claims_of", lambda paper: made)
    rows = claims.measured(folder=tmp_path)
    assert [[one.value for one in row.measured] for row in rows] == [[2.0], []]
    (tmp_path / row_cache.FILE).unlink()
    mark = row_cache.stamp(claims.SEED, False)
    row_cache.add_row(tmp_path, mark, Row("p", made[0], claims.SEED, (Measured("another", 3.0, 3.0, 3.0, 1),)))
    assert claims.measured(folder=tmp_path)[0].measured[0].value == 2.0


@pytest.mark.parametrize("text", ["[" * 100_000, "9" * 5000, "null", "[]", '{"digest": 1}'])
def test_rows_of_other_types_count_as_absent(tmp_path, text):
    (tmp_path / row_cache.FILE).write_text(text)
    assert row_cache.load_rows(tmp_path, "now") == {}
