"""Checks an aircraft of somebody's: whether it loads and flies as it lies, or with repairs, and what it lacks."""

from __future__ import annotations

from textwrap import wrap as wrapped

from aircraft.airframe import load
from aircraft.errors import ModelError
from aircraft.slowest import complete, why_not
from sim.errors import ScenarioError
from sim.flight.preparation import MODEL_TIME_LIMIT
from sim.scenario.reading import read
from sim.workers.isolation import run_isolated

WIDTH = 120  # of a line; a model may lack much


def examine(model: str) -> tuple[list[str], bool]:
    """Lines on an aircraft as it lies and with repairs, each tried in a process of its own; whether it can be flown."""
    scenario = read({"name": "doctor", "aircraft": {"model": model}})
    rows: list[tuple[str, str]] = []
    flies = False
    for repaired, how in ((False, "as it lies"), (True, "aircraft.repairs = true")):
        try:
            told, slowest = run_isolated(scenario, MODEL_TIME_LIMIT, _tried, model, repaired)
        except (ModelError, ScenarioError) as error:
            rows.append(("BAD", f"{how}: {reason(error)}"))
            continue
        flies = slowest is not None
        rows += [("note", f"{how}: {text}") for text in told if text]
        if slowest is None:
            rows.append(("BAD", f"{how}: it loads, but has no level flight"))
        else:
            rows.append(("good", f"{how}: its slowest level flight is {slowest:.1f} m/s"))
            break
    lines = [part for grade, text in rows for part in wrapped(f"{grade:4}  {text}", WIDTH, subsequent_indent=6 * " ")]
    return lines, flies


def _tried(model: str, repaired: bool) -> tuple[tuple[str, ...], float | None]:
    """What is to be said of a model that loads, and its slowest level flight, m/s, if any."""
    airframe = load(model, repaired=repaired)
    settings = complete(model, repaired).flap_settings
    told = airframe.repairs if settings else (*airframe.repairs, why_not(airframe))
    return told, min((one.stall_speed for one in settings), default=None)


def reason(error: Exception) -> str:
    """The message, without the name of a scenario of our own."""
    return str(error).splitlines()[0].split("] ", 1)[-1]
