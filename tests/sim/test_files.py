"""Folders of a run: whole or not at all, also where two processes want the same one, or a signal comes."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
import threading
from pathlib import Path

import pytest

from sim import files
from sim.errors import OutputError


def write(folder, text, ready=None, go=None):
    """Two files that belong together, staged."""
    files.claim(folder, "run")
    with files.staged(folder) as place:
        for name in ("a", "b"):
            (place / name).write_text(text, encoding="utf-8")
        if ready is not None:
            ready.set()
            assert go.wait(30)


def contents(folder):
    return {(folder / name).read_text(encoding="utf-8") for name in ("a", "b")}


def test_a_second_writer_waits_and_its_files_stay(tmp_path):
    folder, ready, go = tmp_path / "out", threading.Event(), threading.Event()
    first = threading.Thread(target=write, args=(folder, "first", ready, go))
    first.start()
    assert ready.wait(30)
    second = threading.Thread(target=write, args=(folder, "second"))
    second.start()
    second.join(0.3)
    assert second.is_alive()  # it waits
    assert not (folder / "a").exists()
    go.set()
    first.join(30)
    second.join(30)
    assert contents(folder) == {"second"}
    assert not (folder / ".partial").exists()


def test_a_writer_that_never_ends_is_told_of(tmp_path, monkeypatch):
    monkeypatch.setattr(files, "WAIT", 0.2)
    folder = tmp_path / "out"
    folder.mkdir()
    with files.only_writer(folder), pytest.raises(OutputError, match="another process is writing into it"):
        write(folder, "second")
    write(folder, "third")
    assert contents(folder) == {"third"}


def test_a_signal_in_the_middle_leaves_no_mixture(tmp_path, monkeypatch):
    """It is answered once all files are in their place."""
    folder, replace = tmp_path / "out", os.replace
    write(folder, "first")

    def interrupted(source, target):
        if target.name == "b":
            signal.raise_signal(signal.SIGINT)
        replace(source, target)

    monkeypatch.setattr(os, "replace", interrupted)
    with pytest.raises(KeyboardInterrupt):
        write(folder, "second")
    assert contents(folder) == {"second"}
    assert signal.getsignal(signal.SIGINT) is signal.default_int_handler


def test_a_folder_that_another_kind_has_just_claimed_is_refused(tmp_path, monkeypatch):
    """Both looked before either wrote its mark."""
    folder = tmp_path / "out"
    refuse, calls = files.refuse_foreign, []

    def slow(place, what):
        refuse(place, what)
        if not calls:
            calls.append(what)
            files.claim(place, "study")

    monkeypatch.setattr(files, "refuse_foreign", slow)
    with pytest.raises(OutputError, match="holds a study, not a run"):
        files.claim(folder, "run")


def test_a_signal_that_nobody_handles_waits_too(tmp_path):
    """Where the folder is written from somebody's own program, SIGTERM ends it, but only after the files are whole."""
    program = (
        "import os, pathlib, signal; from sim import files\n"
        f"folder, replace = pathlib.Path({str(tmp_path / 'out')!r}), os.replace\n"
        "def interrupted(source, target):\n"
        "    if target.name == 'b':\n"
        "        os.kill(os.getpid(), signal.SIGTERM)\n"
        "    replace(source, target)\n"
        "os.replace = interrupted\n"
        "files.claim(folder, 'run')\n"
        "with files.staged(folder) as place:\n"
        "    for name in ('a', 'b'):\n"
        "        (place / name).write_text('whole', encoding='utf-8')\n"
    )
    home = Path(__file__).parents[2]
    done = subprocess.run([sys.executable, "-c", program], cwd=home, check=False)
    assert done.returncode == -signal.SIGTERM
    assert contents(tmp_path / "out") == {"whole"}
