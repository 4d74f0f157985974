"""What a report costs beside the trackers that it is about, and beside the same drawings through matplotlib."""

from __future__ import annotations

import io
import tempfile
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

from sim.experiment import report, run
from sim.reporting.drawing import svg
from sim.reporting.drawing.matplotlib_backend import figure
from sim.reporting.figures.flight import charts

ROUNDS = 3


def seconds(call: Callable[[], Any]) -> float:
    """CPU s, the least of some rounds; what the first imports is not in it."""
    found = []
    for _ in range(ROUNDS):
        began = time.process_time()
        call()
        found.append(time.process_time() - began)
    return min(found)


def through_matplotlib(drawings: list[Any]) -> None:
    """The same drawings as files of SVG."""
    for one in drawings:
        figure(one).savefig(io.BytesIO(), format="svg")


def main() -> list[tuple[str, str, str]]:
    """Rows: what, measured, asked."""
    began = time.process_time()
    result = run("an26_pattern")
    run_in = time.process_time() - began
    with tempfile.TemporaryDirectory() as place:
        reported_in = seconds(lambda: report(result, Path(place)))
        size = (Path(place) / "report.html").stat().st_size
    drawings = [chart.figure for chart in charts(result.flight, result.scenario, result.prepared.law)]
    ours = seconds(lambda: [svg.written(one, "") for one in drawings])
    theirs = seconds(lambda: through_matplotlib(drawings))
    return [
        ("report of an26_pattern, all files", f"{reported_in:.2f} CPU s", ""),
        ("over flying, observing and tracking it", f"{reported_in / run_in:.3f}", "<= 0.10"),
        ("size of the page", f"{size / 1e6:.2f} MB", "<= 1"),
        ("figures of the flight through matplotlib over our writer", f"{theirs / ours:.0f}", ">= 10"),
    ]
