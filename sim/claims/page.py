"""The ledger of claims as pages: one for each paper with its figures redrawn, and one for all."""

from __future__ import annotations

from collections import Counter
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np

from sim.claims import plots_of
from sim.claims.ledger import Row
from sim.claims.plots import Plot
from sim.claims.row_cache import FILE
from sim.claims.table import figure, interval, judged, runs, summary
from sim.files import staged, write_json
from sim.reporting.figures import style
from sim.reporting.page import rendered
from sim.reporting.text.labels import ABSENT
from sim.reporting.tracker_figures.tracking_errors import logarithmic
from sim.workers.sharing import current

HEIGHT = 2.4  # in
LOOKS: dict[str, dict[str, Any]] = {
    "line": {"linestyle": "-"},
    "dashed": {"linestyle": (0, style.DASHED)},
    "dots": {"linestyle": "none", "marker": ".", "markersize": 2.0},
    "places": {"linestyle": "none", "marker": "^", "markersize": 5.0},
    "marks": {"linestyle": "none", "marker": "o", "markersize": 4.0},
}


def write(folder: Path, rows: Sequence[Row], seed: int) -> None:
    """claims.json, claims.md, claims.html and one page for each paper, all or none."""
    papers = list(dict.fromkeys(row.paper for row in rows))
    charts = dict(zip(papers, current().in_order(charts_of, [(paper, seed) for paper in papers]), strict=True))
    with staged(folder) as place:
        write_json(place / "claims.json", [row.plain() for row in rows])
        (place / "claims.md").write_text(summary(rows) + "\n", encoding="utf-8")
        (place / "claims.html").write_text(page("Claims of the papers", rows, {}, seed), encoding="utf-8")
        for paper in papers:
            own = [row for row in rows if row.paper == paper]
            text = page(f"Claims of {paper}", own, {paper: charts[paper]}, seed)
            (place / f"{paper}.html").write_text(text, encoding="utf-8")
    (folder / FILE).unlink(missing_ok=True)


def charts_of(paper: str, seed: int) -> list[style.Chart]:
    """The figures of one paper."""
    with style.drawing():
        return [chart(plot) for plot in plots_of(paper, seed)]


def page(title: str, rows: Sequence[Row], charts: dict[str, list[style.Chart]], seed: int) -> str:
    """One self-contained HTML page."""
    counts = Counter(row.verdict for row in rows if row.verdict is not None)
    told = ", ".join(f"{count} {name}" for name, count in sorted(counts.items()))
    papers = [
        {"name": paper, "rows": [_row(row) for row in rows if row.paper == paper], "charts": charts.get(paper, [])}
        for paper in dict.fromkeys(row.paper for row in rows)
    ]
    sentence = f"{sum(counts.values())} claims: {told}." if counts else "Measured."
    return rendered("claims.html", title=title, sentence=sentence, papers=papers, seed=seed)


def _row(row: Row) -> dict[str, Any]:
    claim = row.claim
    unit = f" {claim.unit}" if claim.unit else ""
    return {
        "name": claim.name,
        "words": claim.words,
        "where": claim.where,
        "printed": ABSENT if claim.printed is None else claim.printed.text + unit,
        "paper_runs": claim.paper_runs or ABSENT,
        "truth": claim.truth,
        "geometry_by": claim.geometry_by,
        "verdict": judged(row),
        "look": (row.verdict or "measured").replace(" ", "-"),
        "note": claim.note,
        "measured": [
            {
                "reading": m.reading,
                "value": figure(m.value) + unit,
                "interval": ABSENT if m.low == m.high else interval(m),
                "runs": ABSENT if m.runs <= 1 else runs(row, m),
            }
            for m in row.measured
        ],
    }


def chart(plot: Plot) -> style.Chart:
    """A figure of a paper, drawn."""
    named = any(curve.names for curve in plot.curves)
    drawn, (axes,) = style.panels(HEIGHT * (1.6 if plot.equal or named else 1.0))
    colours = iter(style.TRACKERS)
    for curve in plot.curves:
        look: dict[str, Any] = LOOKS[curve.look]
        colour = style.GREY if curve.look in ("dots", "places") else next(colours)
        axes.plot(np.asarray(curve.x), np.asarray(curve.y), color=colour, label=curve.label, **look)
        for x, y, name in zip(curve.x, curve.y, curve.names, strict=False):
            axes.annotate(name, (x, y), (2, -4), textcoords="offset points", rotation=-50, va="top", fontsize="small")
    if named:
        axes.margins(x=0.1)  # room for the last name
    if plot.logarithmic:
        logarithmic(axes)
    if plot.equal:
        axes.set_aspect("equal", adjustable="datalim")
    axes.set_xlabel(plot.x)
    axes.set_ylabel(plot.y)
    if len(plot.curves) > 1:
        axes.legend(loc="best")
    return style.Chart(f"{plot.figure}: {plot.title}", style.data_uri(drawn), plot.caption)
