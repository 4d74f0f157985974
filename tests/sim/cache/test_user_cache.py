"""The cache of the user: what it gives is what would be computed, and whatever is wrong with it harms nothing."""

from __future__ import annotations

import json
import math
import os
import subprocess
import sys

import pytest

from aircraft.data import FlapSetting
from sim.cache import user_cache
from sim.cli.doctor import _cache
from sim.experiment import read
from sim.flight import gains
from sim.flight.preparation import prepare
from tests.hostile.foreign import FOREIGN


@pytest.fixture
def cache(tmp_path, monkeypatch):
    """A cache of this test's own, not made yet."""
    monkeypatch.setenv(user_cache.SWITCH, "on")
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path))
    return tmp_path / user_cache.NAME


def counted(values):
    """A function that gives its values one after another."""
    return lambda: values.pop(0)


def test_what_is_remembered_is_made_once(cache):
    made = counted([{"a": [1.5, float("inf")]}])
    first = user_cache.remembered("thing", ["x"], made)
    assert user_cache.remembered("thing", ["x"], made) == first == {"a": [1.5, float("inf")]}
    assert cache.stat().st_mode & 0o777 == 0o700
    assert [entry.stat().st_mode & 0o777 for entry in cache.iterdir()] == [0o600]


@pytest.mark.parametrize(("what", "decides"), [("other", ["x"]), ("thing", ["y"])])
def test_another_input_is_another_entry(cache, what, decides):
    user_cache.store("thing", ["x"], 1)
    assert user_cache.load(what, decides) is None


@pytest.mark.parametrize("changed", ["versions", "processor", "program"])
def test_another_program_is_another_entry(cache, monkeypatch, changed):
    user_cache.store("thing", ["x"], 1)
    assert user_cache.load("thing", ["x"]) == 1
    monkeypatch.setattr(user_cache, changed, lambda: "another")
    assert user_cache.load("thing", ["x"]) is None


def test_an_exception_is_not_remembered(cache):
    with pytest.raises(ZeroDivisionError):
        user_cache.remembered("thing", ["x"], lambda: 1 // 0)
    assert user_cache.remembered("thing", ["x"], lambda: 7) == 7


DAMAGES = {
    "a byte": lambda entry: entry.write_bytes(entry.read_bytes().replace(b"1234", b"1235")),
    "cut": lambda entry: entry.write_bytes(entry.read_bytes()[:-1]),
    "empty": lambda entry: entry.write_bytes(b""),
    "a folder": lambda entry: (entry.unlink(), entry.mkdir()),
    "a pipe": lambda entry: (entry.unlink(), os.mkfifo(entry)),
    "of another name": lambda entry: entry.write_bytes(
        (user_cache.store("other", ["x"], 99), next(entry.parent.glob("other-*")).read_bytes())[1]
    ),
}


@pytest.mark.parametrize("damage", DAMAGES)
def test_a_damaged_entry_is_made_again(cache, damage):
    user_cache.store("thing", ["x"], 1234)
    DAMAGES[damage](next(cache.glob("thing-*")))
    assert user_cache.remembered("thing", ["x"], lambda: 5678) == 5678


def test_a_link_in_place_of_an_entry_is_not_followed(cache, tmp_path):
    user_cache.store("thing", ["x"], 1234)
    (entry,) = cache.iterdir()
    entry.rename(tmp_path / "elsewhere")
    entry.symlink_to(tmp_path / "elsewhere")
    assert user_cache.load("thing", ["x"]) is None


def too_open(cache):
    cache.mkdir(mode=0o755)
    cache.chmod(0o755)


def linked(cache):
    (cache.parent / "there").mkdir(mode=0o700)
    cache.symlink_to(cache.parent / "there")


UNFIT = {
    "open": (too_open, "open to others"),
    "link": (linked, "no folder"),
    "file": (lambda c: c.touch(), "no folder"),
}


@pytest.mark.parametrize("unfit", UNFIT)
def test_a_folder_that_is_not_fit_is_passed_over(cache, unfit):
    make, why = UNFIT[unfit]
    make(cache)
    made = counted([1, 2])
    assert [user_cache.remembered("thing", ["x"], made) for _ in range(2)] == [1, 2]
    assert why in _cache()
    assert not cache.is_dir() or not [*cache.iterdir()]


def test_a_folder_of_somebody_else_is_passed_over(cache, monkeypatch):
    user_cache.store("thing", ["x"], 1)
    monkeypatch.setattr(os, "geteuid", lambda: cache.stat().st_uid + 1)
    assert user_cache.load("thing", ["x"]) is None
    assert "somebody else" in _cache()


def test_a_home_that_takes_nothing_is_passed_over(cache, monkeypatch, tmp_path):
    (tmp_path / "file").touch()
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path / "file"))
    assert user_cache.remembered("thing", ["x"], lambda: 3) == 3


def test_the_oldest_entries_go(cache, monkeypatch):
    monkeypatch.setattr(user_cache, "MOST", 3)
    monkeypatch.setattr(user_cache, "KEPT", 1)
    for number in range(5):
        user_cache.store("thing", [number], number)
        newest = next(entry for entry in cache.iterdir() if user_cache._name("thing", [number]) == entry.name)
        os.utime(newest, (number, number))
    assert [user_cache.load("thing", [number]) for number in range(5)] == [None, None, None, 3, 4]


def test_processes_that_store_the_same_leave_one_whole_entry(cache):
    text = "from sim.cache import user_cache\nfor i in range(60): user_cache.store('thing', ['x'], list(range(3000)))"
    running = [subprocess.Popen([sys.executable, "-c", text]) for _ in range(2)]
    while any(one.poll() is None for one in running):
        assert user_cache.load("thing", ["x"]) in (None, [*range(3000)])
    assert [one.returncode for one in running] == [0, 0]
    assert user_cache.load("thing", ["x"]) == [*range(3000)]
    assert len([*cache.iterdir()]) == 1


def test_a_design_from_the_cache_is_that_without_one(cache, monkeypatch):
    scenario = read("an26_pattern")
    kept = [prepare(scenario).gains.to_table() for _ in range(2)]
    assert [*cache.glob("design-*")]
    monkeypatch.setattr("sim.flight.preparing.loops.designed", lambda **_: pytest.fail("designed again"))
    kept.append(prepare(scenario).gains.to_table())
    monkeypatch.undo()
    monkeypatch.setenv(user_cache.SWITCH, user_cache.OFF)
    without = json.dumps(prepare(scenario).gains.to_table())
    assert [json.dumps(one) for one in kept] == [without] * 3


def test_slowest_speeds_are_measured_once_for_each_content_of_a_model(cache, monkeypatch, tmp_path):
    home = FOREIGN["root with systems"].write(tmp_path)
    measured = []

    def measure(model, repaired):
        measured.append(repaired)
        return (FlapSetting(0.0, math.inf, 30.0 + len(measured)),)

    monkeypatch.setattr(gains, "flap_settings", measure)
    first = gains.known_flap_settings(home, False)
    assert first == gains.known_flap_settings(home, False) == (FlapSetting(0.0, math.inf, 31.0),)
    assert gains.known_flap_settings(home, True)[0].stall_speed == 32.0
    (home / "plane.toml").write_text('title = "data beside it"')
    assert gains.known_flap_settings(home, False)[0].stall_speed == 33.0
    assert measured == [False, True, False]


def test_the_command_can_leave_the_cache_alone(cache, command, monkeypatch):
    for arguments, used in ((["--no-cache"], False), ([], True)):
        monkeypatch.setenv(user_cache.SWITCH, "on")
        assert command("validate", "an26_pattern", *arguments).returncode == 0
        assert cache.exists() is used
