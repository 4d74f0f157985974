"""A thousand landings as distributions: what they cost, how often limits are exceeded, and whether intervals cover."""

from __future__ import annotations

import json
import resource
import time

import numpy as np
import pytest
from scipy.stats import norm

from sim.metrics.ensemble.exceedance import answer, interval
from sim.studies import study as studies
from sim.workers.executors import LocalExecutor

pytestmark = pytest.mark.acceptance
NAME, FLIGHTS = "an26_dispersion", 1000
ASKED_S = 15 * 60.0  # on two cores


def spent() -> float:
    """CPU time of all workers that ended, s."""
    used = resource.getrusage(resource.RUSAGE_CHILDREN)
    return used.ru_utime + used.ru_stime


def test_a_thousand_landings(row, tmp_path):
    began, before = time.perf_counter(), spent()
    metrics = studies.study(NAME, tmp_path / "o", LocalExecutor(2))
    wall, cpu = time.perf_counter() - began, spent() - before
    records = [json.loads(line) for line in (tmp_path / "o/flights.jsonl").read_text().splitlines()]
    told = f"{wall / 60:.1f} min, {cpu / 60:.1f} CPU min ({cpu / len(records):.2f} s a flight)"
    met = len(records) == FLIGHTS and wall <= ASKED_S
    row(f"{NAME}: 1,000 flights begun on final, 2 workers", "<= 15 min", told, met)
    row(f"{NAME}: flights beyond any limit", "reported", answer(metrics), True)
    for one in metrics["exceedances"]:
        low, high = 100 * one["low"], 100 * one["high"]
        found = f"{one['beyond']} of {one['flights']}: {low:.2g} to {high:.2g} %; below {100 * one['below']:.2g} %"
        row(f"{NAME}: beyond '{one['name']}', 95 % interval; one-sided bound", "reported", found, True)
    for figure in ("past_threshold_m", "cross_track_m", "sink_mps", "pitch_deg", "bank_deg"):
        values = [record["metrics"]["touchdown"][figure] for record in records if record["metrics"].get("touchdown")]
        shown = ", ".join(f"{value:.2f}" for value in np.percentile(values, [0, 1, 50, 99, 100]))
        row(f"{NAME}: touchdown {figure}: least, 1, 50, 99 %, greatest", "reported", shown, True)
    assert met


@pytest.mark.parametrize("true", [0.001, 0.01, 0.05])
def test_intervals_cover_a_known_exceedance(row, true):
    """20,000 repeats of 1,000 normal figures: three standard deviations of a share of 95 % are 0.46 points."""
    generator, repeats, flights = np.random.default_rng(16), 20_000, 1000
    limit = norm.isf(true)
    beyond = np.array([(generator.standard_normal(flights) > limit).sum() for _ in range(repeats)])
    low, high = interval(beyond, flights)
    _, bound = interval(beyond, flights, 0.9)
    two, one = 100 * ((low <= true) & (true <= high)).mean(), 100 * (true <= bound).mean()
    met = min(two, one) >= 95 - 0.46
    told = f"{two:.1f} % two-sided, {one:.1f} % one-sided"
    row(f"95 % intervals of an exceedance that is exactly {true:g}, 20,000 x 1,000 flights", ">= 95 %", told, met)
    assert met
