"""The claims of the papers, each measured and judged by one rule; a paper is one folder of `sim.claims.papers`.

``verdict`` is the rule, ``ledger`` a claim with all its readings and its row, ``plots`` a figure as numbers; ``table``,
``page`` and ``curves`` show them, ``row_cache`` lets an interrupted ledger go on. ``jsbsim_flights``,
``angle_channel`` and ``manoeuvre_variance`` are what several papers share.
"""

from __future__ import annotations

from collections.abc import Iterable
from importlib import import_module
from pathlib import Path
from typing import Any

from sim.errors import ScenarioError, did_you_mean
from sim.workers.sharing import current

PAPERS = ("vasylyev2003", "volovyk2022", "volovyk2018", "kychak2011", "glistin", "madap")
SEED = 2026


def chosen(papers: Iterable[str]) -> tuple[str, ...]:
    """The papers asked for, in order and once, or all; raises ``ScenarioError`` for an unknown one."""
    asked = tuple(dict.fromkeys(papers))
    for paper in asked:
        if paper not in PAPERS:
            raise ScenarioError(f"paper '{paper}' is not known; {did_you_mean(paper, PAPERS)}")
    return asked or PAPERS


def claims_of(paper: str) -> tuple[Any, ...]:
    """The claims of one paper."""
    return tuple(import_module(f"sim.claims.papers.{paper}.claims").CLAIMS)


def plots_of(paper: str, seed: int = SEED) -> tuple[Any, ...]:
    """The figures of one paper, from our own runs."""
    figures = import_module(f"sim.claims.papers.{paper}.figures").FIGURES
    return tuple(plot for figure in figures.values() for plot in figure(seed))


def measured(
    papers: Iterable[str] = (),
    seed: int = SEED,
    quick: bool = False,
    progress: Any = None,
    folder: Path | None = None,
) -> list[Any]:
    """Rows of the ledger; ``progress`` wraps the work as `sim.cli.terminal.bar` does.

    A second process takes a part of it. Rows are kept in ``folder`` until the pages are written there: an interrupted
    ledger goes on where it was stopped.
    """
    from sim.claims import row_cache
    from sim.claims.ledger import Row

    mark = "" if folder is None else row_cache.stamp(seed, quick)
    found = {} if folder is None else row_cache.load_rows(folder, mark)
    claims = {(paper, claim.name): claim for paper in chosen(papers) for claim in claims_of(paper)}
    missing = [name for name, claim in claims.items() if not _is_of(claim, found.get(name))]
    done: Any = current().as_done(_measure, [(*name, seed, quick) for name in missing])
    for number, values in done if progress is None else progress(done, len(missing), "claims"):
        name = missing[number]
        found[name] = values
        if folder is not None:
            row_cache.add_row(folder, mark, Row(name[0], claims[name], seed, values))
    return [Row(name[0], claim, seed, found[name]) for name, claim in claims.items()]


def _is_of(claim: Any, values: tuple[Any, ...] | None) -> bool:
    """Whether these are values of all readings of a claim; it may have none."""
    return values is not None and [one.reading for one in values] == [reading.name for reading in claim.readings]


def _measure(paper: str, name: str, seed: int, quick: bool) -> Any:
    """What was measured for one claim, by its name: a claim itself holds functions and stays where it is."""
    from sim.claims.ledger import measure

    claim = next(claim for claim in claims_of(paper) if claim.name == name)
    return measure(paper, claim, seed, quick).measured
