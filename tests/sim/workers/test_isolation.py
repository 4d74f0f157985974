"""A model that is not ours costs one sentence, whatever it does to the process that loads it."""

from __future__ import annotations

import os
import signal
import time
from types import SimpleNamespace

import pytest

from sim.errors import ScenarioError
from sim.workers.isolation import run_isolated


def flown_by(model):
    return SimpleNamespace(name="mine", parts=(), aircraft=SimpleNamespace(model=model))


STOCK, OURS = flown_by("c172x"), flown_by("an26")


def test_ours_are_flown_here_and_others_elsewhere():
    assert run_isolated(OURS, 60.0, os.getpid) == os.getpid()
    assert run_isolated(flown_by("point_mass"), 60.0, os.getpid) == os.getpid()
    assert run_isolated(STOCK, 60.0, os.getpid) != os.getpid()
    assert run_isolated(flown_by("./an26"), 60.0, os.getpid) != os.getpid()


def test_a_child_serves_call_after_call():
    assert run_isolated(STOCK, 60.0, os.getpid) == run_isolated(STOCK, 60.0, os.getpid)


def test_an_abort_is_one_sentence_and_the_next_call_is_answered():
    with pytest.raises(ScenarioError, match=r"^mine: \[aircraft\] the model 'c172x' aborts the simulation \(SIGABRT\)"):
        run_isolated(STOCK, 60.0, os.abort)
    assert run_isolated(STOCK, 60.0, abs, -3) == 3


def test_a_child_that_died_after_its_answer_is_not_the_next_ones_fault():
    os.kill(run_isolated(STOCK, 60.0, os.getpid), signal.SIGKILL)
    assert run_isolated(STOCK, 60.0, abs, -3) == 3


def test_a_model_that_waits_has_an_end_and_is_not_said_to_compute():
    said = r"the model 'c172x' gives no answer for 1 s, in which it computed for 0 s: it waits for something"
    with pytest.raises(ScenarioError, match=said):
        run_isolated(STOCK, 0.1, time.sleep, 60.0)


def test_a_model_that_computes_for_ever_has_an_end():
    with pytest.raises(ScenarioError, match=r"gives no answer within 0\.5 s of processor time"):
        run_isolated(STOCK, 0.5, sum, range(10**12))
    assert run_isolated(STOCK, 60.0, abs, -3) == 3


def test_the_time_of_a_busy_machine_is_not_the_models():
    run_isolated(STOCK, 60.0, abs, -3)  # started and warm
    assert run_isolated(STOCK, 0.5, time.sleep, 0.8) is None  # longer on the clock than it may compute


def test_each_call_has_the_whole_limit_for_itself():
    begun = run_isolated(STOCK, 60.0, time.process_time)
    used = 0.0
    while used < 1.0:  # s, in calls of less than a second: the system counts whole ones
        run_isolated(STOCK, 0.9, sum, range(10**7))
        used = run_isolated(STOCK, 60.0, time.process_time) - begun


def test_a_model_that_aborts_says_why():
    with pytest.raises(ScenarioError) as caught:
        run_isolated(
            STOCK, 60.0, complaining, "the \x1b[31mwing\x1b[0m of /tmp/shortfinal-abc/aircraft/x.xml\n is \x07off" * 40
        )
    said = str(caught.value).partition("(SIGABRT: ")[2].partition("); it cannot be flown")[0]
    assert said.startswith("the wing of aircraft/x.xml is off")
    assert said.isprintable()
    assert len(said) <= 500


def complaining(text):
    os.write(2, b"much more " * 100_000)  # more than a pipe holds
    os.write(2, f"terminate called after throwing an instance of 'X'\n  what():  {text}".encode()[-4000:])
    os.abort()


def test_memory_has_an_end():
    with pytest.raises(ScenarioError, match="needs more than 4096 MB of memory"):
        run_isolated(STOCK, 60.0, bytearray, 8 << 30)


def test_exceptions_come_through_and_leave_the_child_alive():
    child = run_isolated(STOCK, 60.0, os.getpid)
    with pytest.raises(ValueError, match="invalid literal"):
        run_isolated(STOCK, 60.0, int, "x")
    assert run_isolated(STOCK, 60.0, os.getpid) == child


def test_what_a_child_prints_is_no_answer(capfd):
    assert run_isolated(STOCK, 60.0, os.write, 1, b"noise") == 5
    assert run_isolated(STOCK, 60.0, abs, -3) == 3
    assert capfd.readouterr() == ("", "")
