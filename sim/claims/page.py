"""The ledger of claims as pages: one for each paper with its figures redrawn, and one for all."""

from __future__ import annotations

from collections import Counter
from collections.abc import Sequence
from pathlib import Path
from typing import Any

from sim.claims import plots_of
from sim.claims.curves import csv_files
from sim.claims.ledger import Row
from sim.claims.plots import Plot
from sim.claims.row_cache import FILE
from sim.claims.table import figure, interval, judged, runs, summary
from sim.files import staged, write_json
from sim.reporting.drawing.figure import Drawing, Panel
from sim.reporting.drawing.marks import numbers
from sim.reporting.figures import style
from sim.reporting.page import picture, rendered
from sim.reporting.text.labels import ABSENT
from sim.reporting.tracker_figures.tracking_errors import logarithmic
from sim.workers.sharing import current

HEIGHT = 2.4  # in
ROOM = 0.05  # of the width, at either side of points with names
DOTS: dict[str, dict[str, Any]] = {
    "dots": {"size": 2.0},
    "places": {"marker": "^", "size": 5.0},
    "marks": {"marker": "o", "size": 4.0},
}


def write(folder: Path, rows: Sequence[Row], seed: int) -> None:
    """claims.json, claims.md, claims.html, one page for each paper and a table for each figure, all or none."""
    papers = list(dict.fromkeys(row.paper for row in rows))
    drawn = dict(zip(papers, current().in_order(charts_of, [(paper, seed) for paper in papers]), strict=True))
    charts = {paper: [one for one, _ in pairs] for paper, pairs in drawn.items()}
    with staged(folder) as place:
        write_json(place / "claims.json", [row.plain() for row in rows])
        (place / "claims.md").write_text(summary(rows) + "\n", encoding="utf-8")
        (place / "claims.html").write_text(page("Claims of the papers", rows, {}, seed), encoding="utf-8")
        for paper in papers:
            own = [row for row in rows if row.paper == paper]
            text = page(f"Claims of {paper}", own, {paper: charts[paper]}, seed)
            (place / f"{paper}.html").write_text(text, encoding="utf-8")
            for name, table in csv_files(paper, [curves for _, curves in drawn[paper]]).items():
                (place / name).write_text(table, encoding="utf-8")
    (folder / FILE).unlink(missing_ok=True)


def charts_of(paper: str, seed: int) -> list[tuple[style.Chart, Plot]]:
    """The figures of one paper, drawn and as numbers."""
    return [(chart(plot), plot) for plot in plots_of(paper, seed)]


def page(title: str, rows: Sequence[Row], charts: dict[str, list[style.Chart]], seed: int) -> str:
    """One self-contained HTML page."""
    counts = Counter(row.verdict for row in rows if row.verdict is not None)
    told = ", ".join(f"{count} {name}" for name, count in sorted(counts.items()))
    papers = [
        {
            "name": paper,
            "rows": [_row(row) for row in rows if row.paper == paper],
            "charts": [*map(picture, charts.get(paper, ()))],
        }
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
        x, y = numbers(curve.x), numbers(curve.y)
        colour = style.GREY if curve.look in ("dots", "places") else next(colours)
        if curve.look in DOTS:
            axes.points(x, y, colour=colour, label=curve.label, **DOTS[curve.look])
        else:
            dashes = style.DASHES[0] if curve.look == "dashed" else style.SOLID
            axes.line(x, y, colour=colour, dashes=dashes, label=curve.label)
        for right, up, name in zip(x, y, curve.names, strict=False):
            axes.words(name, right, up, right=2.0, up=-4.0, turn=50.0, above=0.5, anchor="start", size=6.7, free=True)
    axes.x.label, axes.y.label = plot.x, plot.y
    if named:  # room for the last name
        left, right = drawn.limits(axes.x)
        axes.x.limits = left - ROOM * (right - left), right + ROOM * (right - left)
    if plot.logarithmic:
        logarithmic(axes)
    if plot.equal:
        _equal(drawn, axes)
    if len(plot.curves) > 1:
        drawn.legend = [axes.labelled]
    return style.Chart(f"{plot.figure}: {plot.title}", drawn, plot.caption)


def _equal(drawn: Drawing, axes: Panel) -> None:
    """One scale on both axes; what is drawn lies in the middle."""
    (left, right), (low, high) = drawn.limits(axes.x), drawn.limits(axes.y)
    scale = max((right - left) / axes.box.width, (high - low) / axes.box.height) / 2
    across, up = (left + right) / 2, (low + high) / 2
    axes.x.limits = across - scale * axes.box.width, across + scale * axes.box.width
    axes.y.limits = up - scale * axes.box.height, up + scale * axes.box.height
