"""Checks the installation: versions, shadowed names, JSBSim, a place to write; or one aircraft of somebody's."""

from __future__ import annotations

import importlib.metadata
import importlib.util
import os
import platform
import shutil
import subprocess
import sys
import tempfile
from pathlib import Path
from textwrap import wrap as wrapped

from sim.cache import user_cache
from sim.versions import DISTRIBUTIONS, EXTRAS

WIDTH = 120  # of a line on an aircraft, which may lack much
PROBE = "import jsbsim; jsbsim.FGJSBBase().debug_lvl = 0; f = jsbsim.FGFDMExec(None); print(f.get_version())"


def examine() -> tuple[list[str], bool]:
    """Lines to show, and whether all is well."""
    rows: list[tuple[bool, str, str]] = [(sys.version_info >= (3, 11), "python", platform.python_version())]
    for name in DISTRIBUTIONS:
        try:
            rows.append((True, name, importlib.metadata.version(name)))
        except importlib.metadata.PackageNotFoundError:
            rows.append((False, name, "missing; install shortfinal again"))
    home = Path(__file__).resolve().parents[2]
    for name in ("aircraft", "autopilot", "tracking"):
        spec = importlib.util.find_spec(name)
        place = Path(spec.origin).resolve().parent if spec is not None and spec.origin else None
        good = place is not None and place.parent == home
        rows.append((good, f"package {name}", str(place) if good else f"shadowed by {place}; remove that distribution"))
    probe = subprocess.run([sys.executable, "-c", PROBE], capture_output=True, text=True, timeout=60, check=False)
    rows.append((probe.returncode == 0, "JSBSim runs", probe.stdout.strip() or probe.stderr.strip().splitlines()[-1]))
    rows.append((os.access(tempfile.gettempdir(), os.W_OK), "temporary folder", tempfile.gettempdir()))
    rows.append(
        (os.access(".", os.W_OK), "this folder", "can be written" if os.access(".", os.W_OK) else "read-only: use -o")
    )
    extras = [(f"extra {extra}", _extra(extra, name)) for extra, name in EXTRAS.items()]
    chromium = shutil.which("chromium") or shutil.which("google-chrome")
    width = max(len(name) for name in (*(name for _, name, _ in rows), *(name for name, _ in extras)))
    lines = [f"{'good' if good else 'BAD ':4}  {name:{width}}  {text}" for good, name, text in rows]
    lines += [f"note  {name:{width}}  {text}" for name, text in extras]
    lines.append(f"note  {'browser':{width}}  {chromium or 'none on the PATH: report tests are skipped'}")
    lines.append(f"note  {'cache':{width}}  {_cache()}")
    return lines, all(good for good, _, _ in rows)


def _extra(extra: str, distribution: str) -> str:
    """The version of what an extra brings, or how to get it."""
    try:
        return f"{distribution} {importlib.metadata.version(distribution)}"
    except importlib.metadata.PackageNotFoundError:
        return f"not installed: pip install 'shortfinal[{extra}]'"


def _cache() -> str:
    """Where designs and speeds of aircraft, and that studies are done, are kept between commands; or why nowhere."""
    place = user_cache.place()
    if place is None:
        return f"off ({user_cache.SWITCH}={user_cache.OFF}, or no home): every command computes anew"
    if why := user_cache.unfit(place):
        return f"{place} {why}: it is passed over, and every command computes anew"
    return f"{place}; 'rm -r' it at any time"


def examine_aircraft(model: str) -> tuple[list[str], bool]:
    """Lines on an aircraft as it lies and with repairs, each tried in a process of its own; whether it can be flown."""
    from aircraft.errors import FlightError, ModelError, TrimError
    from sim.errors import ScenarioError
    from sim.flight.preparation import MODEL_TIME_LIMIT
    from sim.scenario.reading import read
    from sim.workers.isolation import run_isolated

    scenario = read({"name": "doctor", "aircraft": {"model": model}})
    rows: list[tuple[str, str]] = []
    flies = False
    for repaired, how in ((False, "as it lies"), (True, "aircraft.repairs = true")):
        try:
            told, slowest = run_isolated(scenario, MODEL_TIME_LIMIT, _tried, model, repaired)
        except (ModelError, FlightError, TrimError, ScenarioError) as error:
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
    from aircraft.airframe import load
    from aircraft.slowest import complete, why_not

    airframe = load(model, repaired=repaired)
    settings = complete(model, repaired).flap_settings
    told = airframe.repairs if settings else (*airframe.repairs, why_not(airframe))
    return told, min((one.stall_speed for one in settings), default=None)


def reason(error: Exception) -> str:
    """The message, without the name of a scenario of our own."""
    return str(error).splitlines()[0].split("] ", 1)[-1]
