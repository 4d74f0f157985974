"""A study that is done is neither flown nor drawn again, and whatever has changed is noticed."""

from __future__ import annotations

import os
import shutil

import pytest

from sim.cache import user_cache
from sim.errors import OutputError
from sim.studies import study as studies
from sim.studies.kept import finished
from tests.capture import CAPTURE
from tests.sim.conftest import Inline

TABLES = {
    **CAPTURE,
    "name": "done",
    "aircraft": {"model": "point_mass"},
    "until_s": 1.0,
    "checks": [{"metric": "bank_deg", "max": 60}],
    "study": {"axes": {"start.cross_track_m": [50.0, 100.0]}},
}


@pytest.fixture(scope="module")
def done(tmp_path_factory):
    """A study that was flown with a cache: its folder, the cache, and its figures."""
    place = tmp_path_factory.mktemp("done")
    with pytest.MonkeyPatch.context() as patch:
        patch.setenv(user_cache.SWITCH, "on")
        patch.setenv("XDG_CACHE_HOME", str(place / "home"))
        return place, studies.study(TABLES, place / "f", Inline())


@pytest.fixture
def folder(done, tmp_path, monkeypatch):
    """A copy of both."""
    shutil.copytree(done[0] / "f", tmp_path / "f")
    shutil.copytree(done[0] / "home", tmp_path / "home")
    monkeypatch.setenv(user_cache.SWITCH, "on")
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path / "home"))
    return tmp_path / "f"


@pytest.fixture
def works(monkeypatch):
    """What is done again: 'planned' where anything is, 'drawn' where the page is."""
    found = []
    plan, remember = studies.plan, finished.remember
    monkeypatch.setattr(studies, "plan", lambda *given: found.append("planned") or plan(*given))
    monkeypatch.setattr(finished, "remember", lambda *given: found.append("drawn") or remember(*given))
    return found


DOORS = {
    "study": lambda folder: studies.study(TABLES, folder, Inline()),
    "resume": lambda f: studies.resume(f, Inline()),
}


@pytest.mark.parametrize("door", DOORS)
def test_nothing_is_done_again(done, folder, works, door):
    before = {path.name: path.stat().st_mtime_ns for path in folder.iterdir()}
    assert DOORS[door](folder) == done[1]
    assert works == []
    assert {path.name: path.stat().st_mtime_ns for path in folder.iterdir()} == before


@pytest.mark.parametrize("name", [name for name in finished.FILES if name != "cache/identity.json"])
def test_a_changed_byte_brings_all_back(done, folder, works, name):
    content = (folder / name).read_bytes()
    at = len(content) // 2
    (folder / name).write_bytes(content[:at] + bytes([content[at] ^ 1]) + content[at + 1 :])
    DOORS["study"](folder)
    assert works == ["planned", "drawn"]
    assert all((folder / one).read_bytes() == (done[0] / "f" / one).read_bytes() for one in finished.FILES)
    DOORS["study"](folder)
    assert works == ["planned", "drawn"]


@pytest.mark.parametrize("name", ["metrics.json", "report.html", "flights.jsonl"])
def test_a_missing_file_comes_back(done, folder, works, name):
    (folder / name).unlink()
    DOORS["resume"](folder)
    assert works == ["planned", "drawn"]
    assert (folder / name).read_bytes() == (done[0] / "f" / name).read_bytes()


def test_a_folder_of_somebody_else_is_not_believed(folder, works, monkeypatch):
    """That it is done is remembered by who did it, not in the folder."""
    monkeypatch.setenv("XDG_CACHE_HOME", str(folder.parent / "another"))
    DOORS["study"](folder)
    assert works == ["planned", "drawn"]


def test_another_program_draws_again(folder, works, monkeypatch):
    monkeypatch.setattr(user_cache, "program", lambda: "another")
    DOORS["study"](folder)
    assert works == ["planned", "drawn"]


def test_another_version_of_what_draws_draws_again(folder, works, monkeypatch):
    version = finished.importlib.metadata.version
    monkeypatch.setattr(finished.importlib.metadata, "version", lambda name: "0" if name == "jinja2" else version(name))
    DOORS["study"](folder)
    assert works == ["planned", "drawn"]


def test_a_study_that_was_begun_with_other_versions_is_refused_as_ever(folder, works):
    """Also once it has gone on with these all the same, which is remembered."""
    identity = folder / "cache/identity.json"
    identity.write_text(identity.read_text().replace('"shortfinal": "', '"shortfinal": "9'))
    (folder / "flights.jsonl").unlink()
    studies.resume(folder, Inline(), anyway=True)
    with pytest.raises(OutputError, match="begun with shortfinal 9"):
        DOORS["resume"](folder)


def test_without_a_cache_all_is_done_again(folder, works, monkeypatch):
    monkeypatch.setenv(user_cache.SWITCH, user_cache.OFF)
    DOORS["study"](folder)
    assert works == ["planned", "drawn"]


def test_a_file_that_the_scenario_names_counts(tmp_path, monkeypatch):
    """Whatever it is: the model of an aircraft with its folder, a recording."""
    (tmp_path / "model").mkdir()
    (tmp_path / "model" / "model.toml").write_text("a = 1")
    (tmp_path / "plots.csv").write_text("1")
    monkeypatch.chdir(tmp_path)
    text = (
        'name = "done"\n[aircraft]\nmodel = "model"\n[study.axes]\n"sensors.radar.file" = ["plots.csv", "none.csv"]\n'
    )
    found = [finished._decides(text, finished.Catalogue())]
    (tmp_path / "model" / "model.toml").write_text("a = 2")
    found.append(finished._decides(text, finished.Catalogue()))
    (tmp_path / "plots.csv").write_text("2")
    found.append(finished._decides(text, finished.Catalogue()))
    os.utime(tmp_path / "plots.csv", (1, 1))
    assert found[0] != found[1] != found[2] == finished._decides(text, finished.Catalogue())
    assert [*found[0][3]] == ["model", "plots.csv"]
