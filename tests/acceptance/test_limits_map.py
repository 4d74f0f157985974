"""What the map of limits must show: theory's border beside the flown one, its time, the same bytes however flown."""

from __future__ import annotations

import json
import os
import time
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from sim.studies import study as studies
from sim.workers.executors import LocalExecutor

pytestmark = pytest.mark.acceptance
STUDY = "limits_map"
AXES = ("autopilot.law.cross_track_limit_m", "autopilot.bank_limit_deg", "start.cross_track_m")
RATIO = "contrasts.linear_feedback/saturated_control.overall.cross_track_m.ratio"
WRITTEN = ("metrics.json", "report.html", "flights.jsonl")


def flown(folder: Path, workers: int) -> float:
    """Fly the study, or what is missing of it; seconds."""
    began = time.monotonic()
    call = studies.resume if folder.exists() else lambda place, *more, **how: studies.study(STUDY, place, *more, **how)
    call(folder, LocalExecutor(workers), workers=workers)
    return time.monotonic() - began


def over_the_axes(metrics: dict[str, Any], get: Any) -> np.ndarray:
    """Something of each cell, over the values of `AXES`."""
    values = [metrics["axes"][address]["values"] for address in AXES]
    found = np.full([len(one) for one in values], np.nan)
    for number, row in enumerate(metrics["rows"]):
        found[tuple(one.index(row[address]) for one, address in zip(values, AXES, strict=True))] = get(number, row)
    return found


def near(cell: tuple[int, ...], inside: np.ndarray) -> bool:
    """Whether theory has its border within one cell: a neighbour on the other side."""
    limit, bank, offset = cell
    around = inside[limit, max(bank - 1, 0) : bank + 2, max(offset - 1, 0) : offset + 2]
    return bool((around != inside[cell]).any())


def test_the_map_of_limits(row, tmp_path):
    folder = tmp_path / STUDY
    took = flown(folder, 2)
    metrics = json.loads((folder / "metrics.json").read_text())
    whole = {name: (folder / name).read_bytes() for name in WRITTEN}
    figures = [one["contrasts"][0]["overall"]["cross_track_m"] for one in metrics["rows"]]
    ratio, low, high = (
        over_the_axes(metrics, lambda number, _, name=name: figures[number][name] or np.nan)
        for name in ("ratio", "low", "high")
    )
    inside = over_the_axes(metrics, lambda number, _: metrics["predicted"][RATIO][number]) < 1.0
    decided = (low > 1.0) | (high < 1.0)
    same = (ratio < 1.0) == inside
    right = sum(same[cell] or near(cell, inside) for cell in zip(*np.nonzero(decided), strict=True))
    strict, count = int((same & decided).sum()), int(decided.sum())
    with_interval = int((np.isfinite(low) & np.isfinite(high)).sum())
    met = right >= 0.9 * count and count >= 0.8 * ratio.size
    row(
        "limits_map: cells that are not hatched on theory's side of ratio 1, or within one cell of it",
        ">= 90 %", f"{100 * right / count:.1f} % of {count} ({strict} strictly on it; {ratio.size} cells)", met,
    )  # fmt: skip
    row("limits_map: cells with an interval", "each", f"{with_interval} of {ratio.size}", with_interval == ratio.size)
    busy = f"load {os.getloadavg()[0]:.1f} on {os.cpu_count()} cores"
    row("limits_map on two cores", "<= 15 min", f"{took / 60:.1f} min ({busy})", took <= 900.0)

    log = folder / "flights.jsonl"
    lines = log.read_bytes().splitlines(keepends=True)
    log.write_bytes(b"".join(lines[::3]) + lines[1][:50])  # as a crash leaves it
    flown(folder, 1)
    equal = [name for name in WRITTEN if (folder / name).read_bytes() == whole[name]]
    row(
        "limits_map, two thirds of it flown again by one worker after a crash",
        "the same bytes", f"of {', '.join(equal)}", equal == [*WRITTEN],
    )  # fmt: skip
    assert met
    assert with_interval == ratio.size
    assert equal == [*WRITTEN]
    assert took <= 900.0
