"""The first page of every package and room names the files that lie in it."""

from __future__ import annotations

import ast
import re
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parent.parent
CATALOGUES = (
    "aircraft/wind_events",
    "autopilot/modes",
    "sim/flight/truths",
    "sim/observation/sensors",
    "tracking/trackers",
)
HOMES = sorted(
    home.parent.relative_to(ROOT).as_posix()
    for package in ("aircraft", "autopilot", "tracking", "sim")
    for home in (ROOT / package).rglob("__init__.py")
)


def first_page(home: str) -> str:
    """The docstring of a package."""
    return ast.get_docstring(ast.parse((ROOT / home / "__init__.py").read_text(encoding="utf-8"))) or ""


@pytest.mark.parametrize("home", [home for home in HOMES if home not in (*CATALOGUES, "sim", "sim/claims/papers")])
def test_a_first_page_names_every_file(home):
    files = {file.stem for file in (ROOT / home).glob("*.py")} - {"__init__"}
    assert files - set(re.findall(r"``(\w+)``", first_page(home))) == set()


@pytest.mark.parametrize("home", CATALOGUES)
def test_the_first_page_of_a_catalogue_says_what_a_file_in_it_is(home):
    assert re.search(r"\b(file|files)\b", first_page(home).replace("\n", " "))
