"""What a run would take of the machine is refused before it flies, with what is free beside what is needed."""

from __future__ import annotations

from collections import namedtuple

import pytest

from sim.errors import ScenarioError
from sim.scenario import budget
from sim.scenario.reading import read

Usage = namedtuple("Usage", "free")


def of_draws(draws: int):
    return read("an26_pattern", {"draws": draws})


def test_five_thousand_draws_fit_where_what_they_take_is_free(monkeypatch):
    """About twice the 1.4 GB of memory and 4 GB of files that were measured: a radar sees its sector only."""
    monkeypatch.setattr(budget, "available_memory", lambda: 3_000_000_000)
    monkeypatch.setattr(budget.shutil, "disk_usage", lambda folder: Usage(8_000_000_000))
    budget.refuse_too_much(of_draws(5000))


def test_memory_of_many_draws_is_refused(monkeypatch):
    monkeypatch.setattr(budget, "available_memory", lambda: 1_000_000_000)
    with pytest.raises(ScenarioError, match=r"5000 need about [23]\.\d GB of memory and 1\.0 GB are free"):
        budget.refuse_too_much(of_draws(5000))


def test_room_for_files_is_asked_for_where_draws_go_in_parts(monkeypatch):
    monkeypatch.setattr(budget.shutil, "disk_usage", lambda folder: Usage(1000))
    with pytest.raises(ScenarioError, match=r"513 need about .* GB in .* and 0\.0 GB are free; .* TMPDIR"):
        budget.refuse_too_much(of_draws(513))
    budget.refuse_too_much(of_draws(512))
