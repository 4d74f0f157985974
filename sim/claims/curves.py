"""The curves of each figure as comma-separated values, for whoever would draw them otherwise."""

from __future__ import annotations

import csv
import io
import itertools
import re
from collections.abc import Sequence

import numpy as np

from sim.claims.plots import Plot


def csv_files(paper: str, plots: Sequence[Plot]) -> dict[str, str]:
    """A table for each figure of a paper by its file's name, ``PAPER_FIGURE.csv``."""
    found: dict[str, str] = {}
    for plot in plots:
        name = f"{paper}_{re.sub(r'[^a-z0-9]+', '_', plot.figure.lower()).strip('_')}"
        again = sum(other == name or other.startswith(f"{name}-") for other in found)  # two drawings of one figure
        found[f"{name}-{again + 1}" if again else name] = _table(plot)
    return {f"{name}.csv": table for name, table in found.items()}


def _table(plot: Plot) -> str:
    """One row for each point: its curve, x and y under the labels of the axes, and its name where points have names."""
    text = io.StringIO()
    writer = csv.writer(text, lineterminator="\n")
    named = any(curve.names for curve in plot.curves)
    writer.writerow(["curve", plot.x, plot.y, *(["name"] if named else [])])
    for curve in plot.curves:
        points = itertools.zip_longest(np.ravel(curve.x).tolist(), np.ravel(curve.y).tolist(), fillvalue="")
        for (x, y), name in zip(points, itertools.chain(curve.names, itertools.repeat("")), strict=False):
            writer.writerow([curve.label, x, y, *([name] if named else [])])
    return text.getvalue()
