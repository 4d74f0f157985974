"""docs/architecture.md and docs/choosing-a-tracker.md beside the code that they speak of."""

from __future__ import annotations

import re
import typing
from pathlib import Path

import pytest

from sim.scenario import catalogue
from sim.scenario.parameters import GIVEN

ROOT = Path(__file__).resolve().parents[2]
ARCHITECTURE = (ROOT / "docs" / "architecture.md").read_text(encoding="utf-8")
CHOOSING = (ROOT / "docs" / "choosing-a-tracker.md").read_text(encoding="utf-8")
KIND = re.compile(r"^\| `(\w+)` \| ([^|]+) \|", re.MULTILINE)
LAW, DOWNLINK = "law, route", "downlink"


def section(page: str, title: str) -> str:
    """The text under a heading of the second level."""
    return page.partition(f"\n## {title}\n")[2].partition("\n## ")[0]


def given(kind: str) -> set[str]:
    """Names of the fields of a tracker that the simulation fills."""
    hints = typing.get_type_hints(catalogue.load("trackers", kind), include_extras=True)
    return {name for name, hint in hints.items() if GIVEN in getattr(hint, "__metadata__", ())}


def test_every_room_of_sim_is_on_the_page_and_no_other():
    named = set(re.findall(r"`(\w+(?:\.py|/))`", section(ARCHITECTURE, "The rooms of sim").partition("\nWhy")[0]))
    rooms = {f"{path.name}/" for path in (ROOT / "sim").iterdir() if (path / "__init__.py").is_file()}
    files = {path.name for path in (ROOT / "sim").glob("*.py")} - {"__init__.py"}
    assert named == rooms | files


def test_every_tracker_has_its_row():
    assert sorted(kind for kind, _ in KIND.findall(section(CHOOSING, "All kinds"))) == catalogue.kinds("trackers")


@pytest.mark.parametrize(("kind", "needs"), KIND.findall(section(CHOOSING, "All kinds")))
def test_a_tracker_needs_what_its_row_says(kind, needs):
    wanted = given(kind)
    assert (LAW in needs) == ({"law", "route"} <= wanted) == bool({"law", "route"} & wanted)
    assert ("plots" in needs) == ("measurement" in wanted)
    assert (DOWNLINK in needs or "elevation" in needs) == ("measured" in wanted)


def test_every_tracker_has_its_cost():
    table = section(CHOOSING, "Questions").partition("What may it cost")[2]
    kinds = " ".join(line.split("|")[1] for line in table.splitlines() if line.startswith("| `"))
    assert sorted(re.findall(r"`(\w+)`", kinds)) == catalogue.kinds("trackers")
