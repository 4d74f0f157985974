"""What there is to choose from: scenarios, aircraft, kinds; read without importing any of it."""

from __future__ import annotations

import ast
from importlib import resources

from sim import catalogue


def scenario_lines() -> list[str]:
    """Bundled scenarios, then bundled studies, with the first comment line of each."""
    rows = []
    for name in (*catalogue.scenarios(), *catalogue.studies()):
        first = catalogue.bundled(name).read_text().splitlines()[0]
        rows.append((name, ("study: " if name in catalogue.studies() else "") + first.lstrip("# ").strip()))
    return _aligned(rows)


def kind_lines() -> list[str]:
    """Kinds of every family with the first line of each file."""
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
            text = (resources.files(package) / f"{kind}.py").read_text()
            rows.append((kind, (ast.get_docstring(ast.parse(text)) or "").splitlines()[0]))
        lines += [title, *(f"  {line}" for line in _aligned(rows)), ""]
    return lines[:-1]


def aircraft_lines() -> list[str]:
    """Aircraft that a scenario can name."""
    from aircraft.model_files import available

    return _aligned([("point_mass", "the papers' kinematics, no aerodynamics"), *available().items()])


def _aligned(rows: list[tuple[str, str]]) -> list[str]:
    width = max((len(name) for name, _ in rows), default=0)
    return [f"{name:{width}}  {text}".rstrip() for name, text in rows]
