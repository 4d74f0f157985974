"""Lists of scenarios, aircraft and kinds, read without importing any of them."""

from __future__ import annotations

import ast
import tomllib
from importlib.util import find_spec
from pathlib import Path
from typing import Any

from sim.scenario import catalogue
from sim.scenario.plugins import catalogue_with, class_of, installed_kinds

OSCILLATIONS = ("phugoid", "short_period", "dutch_roll")
HEADINGS = tuple(mode.replace("_", " ") for mode in OSCILLATIONS)


def scenario_lines() -> list[str]:
    """Bundled scenarios, then bundled studies, with the first comment line of each."""
    rows = []
    for name in (*catalogue.scenarios(), *catalogue.studies()):
        first = catalogue.bundled(name).read_text(encoding="utf-8").splitlines()[0]
        rows.append((name, ("study: " if name in catalogue.studies() else "") + first.lstrip("# ").strip()))
    return _aligned(rows)


def kind_lines(plugins: Any = ()) -> list[str]:
    """Kinds of every family with the first line of each file; then those from outside, and where they are from."""
    brought = catalogue_with(plugins)
    lines = []
    for family, title in (
        ("modes", "[autopilot] kind"),
        ("sensors", "[sensors.NAME] kind"),
        ("trackers", "[trackers.NAME] kind"),
        ("wind_events", "[wind.events.NAME] kind"),
    ):
        package, _ = catalogue.FOLDERS[family]
        rows = []
        for kind in catalogue.kinds(family):
            spec = find_spec(f"{package}.{kind}")
            text = "" if spec is None or spec.origin is None else Path(spec.origin).read_text(encoding="utf-8")
            rows.append((kind, (ast.get_docstring(ast.parse(text)) or " ").splitlines()[0]))
        own = [part for part in brought.parts if part.family == family]
        outside = [(part.kind, f"{_first_line(class_of(part))} [{part.origin}]") for part in own]
        outside += [(kind, f"from {origin}") for kind, origin in installed_kinds(family)]
        rows += sorted(outside)
        lines += [title, *(f"  {line}" for line in _aligned(rows)), ""]
    return lines[:-1]


def _first_line(cls: type) -> str:
    """What a class says of itself."""
    return (cls.__doc__ or "").strip().partition("\n")[0]


def aircraft_lines() -> list[str]:
    """Aircraft that a scenario can name, and how each of JSBSim's own flew when the table of the fleet was made."""
    from aircraft.model_files import available
    from sim.cli.fleet import TABLE
    from sim.cli.terminal import table

    measured = tomllib.loads(TABLE.read_text(encoding="utf-8")) if TABLE.is_file() else {"aircraft": {}}
    flown = measured["aircraft"]
    head = ("aircraft", "capture m/s", "approach m/s", *HEADINGS, "overshoot m", "bank deg", "straight in")
    rows, notes = [], []
    for name in available():
        row = flown.get(name, {})
        if "route_capture" in row:
            rows.append(_flown(name, row))
        notes += [(name, text) for text in _notes(name, row)]
    lines = _aligned([("point_mass", "the papers' kinematics, no aerodynamics"), ("an26", "own model")])
    if rows:
        lines += ["", *_origin(measured["versions"]), "", *table([head, *rows], 1)]
    return [*lines, "", *_aligned(notes)] if notes else lines


def _origin(versions: dict[str, str]) -> list[str]:
    """What the figures are, and under which JSBSim they were measured."""
    from importlib.metadata import version

    here = version("jsbsim")
    other = "" if here == versions["jsbsim"] else f"; here is {here}: `make fleet` measures again"
    return [
        "stock aircraft of JSBSim, gains by the one recipe: capture of a line from 3 km, landing from a long final;",
        f"frequency rad/s and damping of the oscillations; measured under JSBSim {versions['jsbsim']}{other}",
    ]


def _flown(name: str, row: dict[str, Any]) -> tuple[str, ...]:
    capture, modes = row["route_capture"], row.get("modes", {})
    paired = [" ".join(map(str, modes.get(mode, ["-"]))) for mode in OSCILLATIONS]
    figures = [f"{capture[key]:.2f}" if key in capture else "-" for key in ("overshoot_m", "bank_max_deg")]
    speeds = [f"{row[key]:.1f}" for key in ("speed_mps", "approach_speed_mps")]
    return (name, *speeds, *paired, *figures, row.get("straight_in", {}).get("outcome", "-"))


def _notes(name: str, row: dict[str, Any]) -> list[str]:
    """Why an aircraft does not fly or land, and what was repaired."""
    told = [row["reason"]] if "reason" in row else []
    for key, good in (("route_capture", "completed"), ("straight_in", "landed")):
        part = row.get(key, {})
        if part and part["outcome"] != good:
            told.append(f"{key}: {part['reason']}")
    if "reason" in row.get("modes", {}):
        told.append(f"modes: {row['modes']['reason']}")
    return [*told, *(f"repaired: {text}" for text in row.get("repairs", []))]


def _aligned(rows: list[tuple[str, str]]) -> list[str]:
    width = max((len(name) for name, _ in rows), default=0)
    return [f"{name:{width}}  {text}".rstrip() for name, text in rows]
