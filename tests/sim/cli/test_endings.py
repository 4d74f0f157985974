"""How commands end: a code for each kind of end, a sentence for each fault, nothing left behind."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
import tempfile
import time
from pathlib import Path

import pytest

from sim.cli import commands, endings
from tests.capture import capture

STOPPABLE = """
import sys, time
from sim.cli import commands, listing

def scenario_lines():
    print("ready", flush=True)
    time.sleep(60)

listing.scenario_lines = scenario_lines
sys.argv[1:] = ["list"]
commands.main()
"""


ROOT = Path(__file__).resolve().parents[3]


def started(*arguments, **how):
    """A process of the project's own code."""
    return subprocess.Popen(
        [sys.executable, *arguments], text=True, stdout=subprocess.PIPE, stderr=subprocess.PIPE, **how
    )


@pytest.mark.parametrize(("name", "code"), [("SIGTERM", 143), ("SIGHUP", 129), ("SIGINT", 130)])
def test_a_batch_system_stops_a_command_as_ctrl_c_does(name, code):
    process = started("-c", STOPPABLE)
    assert process.stdout.readline() == "ready\n"
    process.send_signal(getattr(signal, name))
    _, told = process.communicate(timeout=30)
    assert (process.returncode, told) == (code, "stopped\n")


@pytest.mark.parametrize(("name", "code"), [("SIGTERM", 143), ("SIGHUP", 129), ("SIGINT", 130)])
def test_a_command_that_is_stopped_while_its_words_are_read_ends_the_same(monkeypatch, name, code):
    def parse(*given):
        os.kill(os.getpid(), getattr(signal, name))
        time.sleep(10)

    monkeypatch.setattr(sys, "argv", ["shortfinal", "list"])
    monkeypatch.setattr("typer.core.TyperGroup.parse_args", parse)
    monkeypatch.setattr("typer.core.TyperGroup.make_context", parse)
    with pytest.raises(SystemExit) as ended:
        commands.main()
    assert ended.value.code == code


def test_what_an_extension_makes_of_a_signal_is_a_stop_too(monkeypatch, capsys, tmp_path):
    """One that is imported at that moment says that its initialization failed."""

    def parse(*given):
        try:
            os.kill(os.getpid(), signal.SIGTERM)
            time.sleep(10)
        except KeyboardInterrupt:
            raise ImportError("initialization failed") from None

    monkeypatch.setattr(tempfile, "tempdir", str(tmp_path))
    monkeypatch.setattr(sys, "argv", ["shortfinal", "list"])
    monkeypatch.setattr("typer.core.TyperGroup.make_context", parse)
    with pytest.raises(SystemExit) as ended:
        commands.main()
    assert (ended.value.code, capsys.readouterr().err) == (143, "stopped\n")
    assert not list(tmp_path.iterdir())


def test_a_signal_within_code_that_an_extension_runs_keeps_the_exit_code(tmp_path):
    """Python notes a plain KeyboardInterrupt there, and ends as SIGINT does whatever exit code is asked for."""
    embedded = """
import ctypes, sys
from sim.cli.endings import stopped_by_signals
run = ctypes.pythonapi.PyRun_String
run.restype = ctypes.py_object
run.argtypes = ctypes.c_char_p, ctypes.c_int, ctypes.py_object, ctypes.py_object
with stopped_by_signals() as came:
    try:
        run(b"import os, signal, time; os.kill(os.getpid(), signal.SIGTERM); time.sleep(10)", 257, {}, {})
    except KeyboardInterrupt:
        sys.exit(128 + came[0])
"""
    (tmp_path / "embedded.py").write_text(embedded, encoding="utf-8")
    process = started("-m", "embedded", env={**os.environ, "PYTHONPATH": f"{tmp_path}{os.pathsep}{ROOT}"})
    process.communicate(timeout=30)
    assert process.returncode == 143


def test_a_signal_that_is_ignored_stays_ignored():
    """As ``nohup`` has it: a terminal that closes does not stop the work."""
    process = started("-c", STOPPABLE, preexec_fn=lambda: signal.signal(signal.SIGHUP, signal.SIG_IGN))
    assert process.stdout.readline() == "ready\n"
    process.send_signal(signal.SIGHUP)
    time.sleep(0.2)
    assert process.poll() is None
    process.send_signal(signal.SIGTERM)
    process.communicate(timeout=30)
    assert process.returncode == 143


def test_what_nobody_foresaw_has_a_code_and_a_private_file(monkeypatch, capsys, tmp_path):
    monkeypatch.setattr(tempfile, "tempdir", str(tmp_path))
    monkeypatch.setattr(sys, "argv", ["shortfinal", "list"])
    monkeypatch.setattr("sim.cli.listing.scenario_lines", lambda: 1 / 0)
    with pytest.raises(SystemExit) as ended:
        commands.main()
    assert ended.value.code == endings.UNFORESEEN == 4
    (line,) = capsys.readouterr().err.splitlines()
    (file,) = tmp_path.iterdir()
    assert "ZeroDivisionError: division by zero" in line
    assert str(file) in line
    assert file.stat().st_mode & 0o777 == 0o600
    assert "1 / 0" in file.read_text(encoding="utf-8")


def test_where_no_file_can_be_written_the_sentence_says_so(monkeypatch, capsys, tmp_path):
    monkeypatch.setattr(tempfile, "tempdir", str(tmp_path / "nowhere"))
    assert endings.unforeseen(RuntimeError("two\nlines")) == 4
    (line,) = capsys.readouterr().err.splitlines()
    assert "RuntimeError: two; its traceback cannot be kept: No such file or directory" in line


@pytest.mark.parametrize(
    ("command", "code", "told"),
    [
        ("run nonexist 2>&-", 2, ""),
        ("list > /dev/full", 4, "shortfinal: what it has to say cannot be written: No space left on device\n"),
        ("schema | true; exit ${PIPESTATUS[0]}", 141, ""),
    ],
)
def test_streams_that_are_closed_or_full(command, code, told, tmp_path):
    home = Path(__file__).parents[3]
    process = started(
        "-c", "import os, sys; os.execvp('bash', ['bash', '-c', sys.argv[1]])", f"{sys.executable} -m sim {command}",
        cwd=tmp_path, env={**os.environ, "PYTHONPATH": str(home)},
    )  # fmt: skip
    _, error = process.communicate(timeout=60)
    assert (process.returncode, error) == (code, told)


def test_text_is_utf_8_whatever_the_locale(tmp_path):
    """A resolved scenario with Cyrillic words is read again; a terminal without these letters gets their codes."""
    words = "\N{CYRILLIC SMALL LETTER KA}\N{CYRILLIC SMALL LETTER ER}"
    check = f'[[checks]]\nmetric = "bank_deg"\nmax = 9\nname = "{words}"\n'
    (tmp_path / "short.toml").write_text(capture(check, name="short", until_s=2), encoding="utf-8")
    home = Path(__file__).parents[3]
    plain = {"LC_ALL": "C", "PYTHONCOERCECLOCALE": "0", "PYTHONUTF8": "0", "PYTHONPATH": str(home)}
    plain["PYTHONIOENCODING"] = "latin-1"
    for command in ("run short.toml", "explain out/short/scenario.toml"):
        process = started("-m", "sim", *command.split(), cwd=tmp_path, env={**os.environ, **plain})
        told, error = process.communicate(timeout=60)
        assert (process.returncode, error) == (0, "")
        assert "\\u043a\\u0440" in told
    assert words in (tmp_path / "out/short/scenario.toml").read_text(encoding="utf-8")


def test_a_fault_that_is_not_about_the_output_is_not_told_as_one(monkeypatch, capsys, tmp_path):
    def failing():
        raise OSError(28, "No space left on device")

    monkeypatch.setattr(tempfile, "tempdir", str(tmp_path))
    monkeypatch.setattr(sys, "argv", ["shortfinal", "list"])
    monkeypatch.setattr("sim.cli.listing.scenario_lines", failing)
    with pytest.raises(SystemExit) as ended:
        commands.main()
    assert ended.value.code == 4
    assert "a fault of the program, not of your input: OSError" in capsys.readouterr().err
