"""Risky work in a helper process: a model from outside may abort or hang; that becomes one sentence.

One helper serves all calls of this process, and is started when it is first needed, so runs of our own aircraft pay
nothing. After a loss the next call starts a new one.

A model is data for JSBSim, read from its stripped copy; what is kept out here are its aborts, hangs and memory, not an
attacker who could run code inside the helper.
"""

from __future__ import annotations

import atexit
import multiprocessing
import os
from collections.abc import Callable
from typing import Any, TypeVar

from sim.errors import ScenarioError
from sim.scenario.plugins import carried
from sim.workers.executors import CLOCK_FACTOR, MEMORY_LIMIT, limit_here, refuse_small_limit
from sim.workers.helper_process import HelperProcess, Lost, is_helper

KINEMATICS = "point_mass"
T = TypeVar("T")


def run_isolated(scenario: Any, time_limit: float, function: Callable[..., T], *arguments: Any) -> T:
    """``function(*arguments)``, in a helper process where the scenario's aircraft is not one of ours.

    Raises what the function raises, and ``ScenarioError`` in one sentence where the helper aborts, runs out of memory,
    computes for ``time_limit`` s without an answer, or gives none for ``CLOCK_FACTOR`` times as long on the clock.
    """
    model = scenario.aircraft.model
    if _is_ours(model) or is_helper() or multiprocessing.parent_process() is not None:
        return function(*arguments)
    try:
        call, given = carried(scenario.parts, function, *arguments)
        found: T = _asked(time_limit, _in_folder, os.getcwd(), call, given)
        return found
    except Lost as lost:
        how = _in_words(lost, time_limit)
    except MemoryError:
        limit = limit_here(MEMORY_LIMIT)
        whose = ", and a process may not have more here (ulimit -v)" if limit < MEMORY_LIMIT else ""
        raise ScenarioError(f"the model needs more than {limit >> 20} MB of memory{whose}") from None
    except _NoProcess as error:
        how = f"needs a process of its own, which cannot be started: {error}"
    raise ScenarioError(f"{scenario.name}: [aircraft] the model '{model}' {how}; it cannot be flown")


def _in_words(lost: Lost, time_limit: float) -> str:
    """What a model did, or what happened to it."""
    if lost.ending == "SIGXCPU":
        return f"gives no answer within {time_limit:g} s of processor time"
    if lost.late:
        return (
            f"gives no answer for {CLOCK_FACTOR * time_limit:g} s, in which it computed for {lost.computed:.0f} s: "
            "it waits for something, or this machine does too much at once"
        )
    return f"aborts the simulation ({lost.ending}{': ' if lost.said else ''}{lost.said})"


def _in_folder(folder: str, function: Callable[..., T], arguments: tuple[Any, ...]) -> T:
    """In the helper: the call in the working folder of its caller, since a model may be named by a relative path."""
    os.chdir(folder)
    return function(*arguments)


class _NoProcess(Exception):
    """No further process can be started, and why."""


_waiting: list[HelperProcess] = []  # the helper between two calls; a process is state, whatever one calls it


def _asked(time_limit: float, function: Callable[..., T], *arguments: Any) -> T:
    while True:
        is_fresh = not _waiting
        helper = _started() if is_fresh else _waiting.pop()
        try:
            found: T = helper.call(function, *arguments, time_limit=time_limit)
            return found
        except Lost as lost:
            if is_fresh or lost.late or lost.ending == "SIGXCPU":
                raise
            continue  # it may have died of what it did before
        finally:
            if helper.process.returncode is None:
                _waiting.append(helper)


def _started() -> HelperProcess:
    refuse_small_limit()
    try:
        return HelperProcess(MEMORY_LIMIT)
    except OSError as error:
        raise _NoProcess(error.strerror) from None


@atexit.register
def _end_waiting() -> None:
    while _waiting:
        helper = _waiting.pop()
        helper.process.kill()
        helper.end()


def _is_ours(model: str) -> bool:
    from aircraft.model_files import OWN_MODELS, is_file

    return model == KINEMATICS or ("/" not in model and is_file(OWN_MODELS / model / f"{model}.xml"))
