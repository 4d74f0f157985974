"""The claims of the papers, each measured and judged by one rule; a paper is one file that lists its claims."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from importlib import import_module
from pathlib import Path
from typing import Any

from sim.errors import ScenarioError, did_you_mean

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
    return tuple(import_module(f"sim.claims.{paper}").CLAIMS)


def plots_of(paper: str, seed: int = SEED) -> tuple[Any, ...]:
    """The figures of one paper, from our own runs."""
    figures = import_module(f"sim.claims.figures.{paper}").FIGURES
    return tuple(plot for figure in figures.values() for plot in figure(seed))


def measured(
    papers: Iterable[str] = (), seed: int = SEED, quick: bool = False, progress: Any = None, folder: Path | None = None
) -> Iterator[Any]:
    """Rows of the ledger, one after the other; ``progress`` wraps the work as `sim.progress.bar` does.

    Rows are kept in ``folder`` until the pages are written there: an interrupted ledger goes on where it was stopped.
    """
    from sim.claims import kept
    from sim.claims.ledger import Row, measure

    mark = "" if folder is None else kept.stamp(seed, quick)
    found = {} if folder is None else kept.load(folder, mark)
    work = [(paper, claim) for paper in chosen(papers) for claim in claims_of(paper)]
    shown = work if progress is None else progress(work, len(work), "claims")
    for paper, claim in shown:
        if (paper, claim.name) in found:
            yield Row(paper, claim, seed, found[paper, claim.name])
            continue
        row = measure(paper, claim, seed, quick)
        if folder is not None:
            kept.keep(folder, mark, row)
        yield row
