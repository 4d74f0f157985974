"""Mistakes of who is new at the command line: each answer leads on."""

from __future__ import annotations

import shutil

import pytest

from sim.scenario import catalogue

MISTAKES = (
    (["foo.txt"], "to fly a scenario, say: run foo.txt"),
    (["an26_pattern"], "to fly a scenario, say: run an26_pattern"),
    (["version"], "say --version"),
    (["validat", "my.toml"], "Did you mean 'validate'?"),
    (["run", "foo.txt"], "not TOML: Expected '=' after a key in a key/value pair (at line 1, column 7); a scenario is"),
    (["validate", "foo.txt"], "foo.txt:1: not TOML: "),
    (["run", "my"], "did you mean my.toml?"),
    (["run", "my.tml"], "did you mean my.toml?"),
    (["run", "mi.toml"], "mi.toml: no such file; did you mean my.toml?"),
    (["run", "folder"], "name a scenario file in it, such as folder/inner.toml"),
    (["run", "an26"], "did you mean an26_crosswind, "),
    (["run", "zzz"], "'shortfinal list' shows those that are bundled"),
    (["run", "my.toml", "--set", "speed_kt=5"], "it belongs to another table: start.speed_kt or wind.speed_kt"),
    (["run", "my.toml", "--set", "wind_speed_kt=5"], "it belongs to another table: wind.speed_kt"),
    (["run", "my.toml", "--set", "wind.speed=5"], "it needs its unit: speed_mps or"),
    (["run", "my.toml", "--set", "wind.speed_kt", "5"], "--set TABLE.KEY=VALUE, without blanks"),
    (["run", "my.toml", "--wind", "5"], "--set TABLE.KEY=VALUE"),
    (["run", "my.toml", "--output", "x"], "Possible options: --out"),
    (["run", "my.toml", "my.toml"], "a run is of one scenario"),
    (["list", "sensors"], "--kinds sensors, trackers"),
    (["doctor", "an26"], "--aircraft PATH checks an aircraft"),
    (["study", "my.toml"], "has no [study]; say what is to be varied"),
    (["compare", "my.toml", "my.toml"], "name the folder that 'shortfinal run' or 'study' wrote"),
    (["new", "foo"], "name it NAME.toml"),
)


@pytest.mark.parametrize(
    ("line", "said"), MISTAKES, ids=lambda value: " ".join(value) if isinstance(value, list) else ""
)
def test_a_mistake_is_answered_by_what_leads_on(line, said, tmp_path, monkeypatch, command):
    monkeypatch.chdir(tmp_path)
    shutil.copy(catalogue.bundled("route_capture_point_mass"), "my.toml")
    (tmp_path / "foo.txt").write_text("colour: red")
    (tmp_path / "folder").mkdir()
    shutil.copy("my.toml", "folder/inner.toml")
    code, _, told = command(*line)
    assert (code, told.count("\n")) == (2, 1), told
    assert said in told


def test_a_file_of_another_ending_is_called_by_what_comes_before_it(tmp_path, monkeypatch, command):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "mine.txt").write_text("[wind]\nspeed_kt = 5\n")
    assert command("validate", "mine.txt") == (0, "mine: good\n", "")
