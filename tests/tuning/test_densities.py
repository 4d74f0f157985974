"""The defaults of the kinds are what the search on docs/densities.md chose, and the page is what the code gives."""

from __future__ import annotations

import pytest

from sim.scenario.catalogue import load
from tests.tuning.densities import CASE, PAGE, SAME, SEARCHES, cell, figures


def table(head):
    """Rows of the section of that name, by their first cell."""
    section = PAGE.read_text(encoding="utf-8").split(f"\n## {head}\n")[1].split("\n## ")[0]
    rows = [[cell.strip() for cell in line.strip("|").split("|")] for line in section.splitlines() if line[:2] == "| "]
    return {first: rest for first, *rest in rows}


def densities_of(text):
    return tuple(float(value) for value in text.split(","))


@pytest.mark.parametrize("search", SEARCHES, ids=lambda search: search.name)
def test_the_default_is_the_choice_of_the_search(search):
    best = densities_of(table("Chosen")[search.name][1])
    assert set(zip(search.grid, best, strict=True)) <= {(k, v) for k, values in search.grid.items() for v in values}
    if not search.printed:
        assert search.defaults() == best


@pytest.mark.parametrize(("kind", "as_"), SAME.items())
def test_a_filter_by_other_hands_has_the_same_default(kind, as_):
    fields = [load("trackers", one).__dataclass_fields__["acceleration_density"].default for one in (kind, as_)]
    assert fields[0] == fields[1]


def test_no_choice_lies_at_the_edge_of_its_grid():
    """There the least criterion could lie outside."""
    for search in SEARCHES:
        best = densities_of(table("Chosen")[search.name][1])
        for value, values in zip(best, search.grid.values(), strict=True):
            assert values[0] < value < values[-1], search.name


def test_a_cell_of_the_page_is_what_the_code_gives():
    """The cheapest: one filter in one short flight, over all seeds."""
    search = next(search for search in SEARCHES if search.name == "kalman")
    case = CASE["capture from 500 m"]
    (found,) = figures(search, case, [densities_of(table("Chosen")["kalman"][1])])
    column = list(CASE).index(case.name)
    assert table("Flight by flight")["kalman"][column] == cell(found)
