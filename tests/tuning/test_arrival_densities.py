"""What is chosen for airliners is what the page says."""

from __future__ import annotations

import pytest

from tests.tuning.arrival_densities import CHOSEN, PAGE, SEARCHES


@pytest.mark.parametrize(
    ("search", "point"), list(zip(SEARCHES, CHOSEN, strict=True)), ids=lambda one: getattr(one, "name", "")
)
def test_the_choice_is_the_one_of_the_page(search, point):
    section = PAGE.read_text(encoding="utf-8").split(f"\n## {search.name}\n")[1].split("\n## ")[0]
    rows = [[cell.strip() for cell in line.strip("|").split("|")] for line in section.splitlines() if line[:2] == "| "]
    assert tuple(float(row[0]) for row in rows if row[-1] == "chosen") == point
    values = [float(row[0]) for row in rows if not row[0].startswith("`")]
    assert values == [value for values in search.grid.values() for value in values]
