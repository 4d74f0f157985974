"""Trackers of vectored airliners on look-alikes of recorded arrivals, on seeds and a generator never searched on.

The values of the trackers are the choice of docs/arrival-densities.md, searched on even seeds of the generator ``law``.
"""

from __future__ import annotations

from functools import cache

import numpy as np
import pytest

from tests.tuning import arrival_conformance, arrival_trackers
from tests.tuning.arrival_densities import CHOSEN, COURSES, SEARCHES
from tests.tuning.arrival_trackers import LAW_FREE, PARTS, TRACKERS, ratio, wrong_routes

pytestmark = pytest.mark.acceptance
FLIGHTS, DRAWS = 100, 2
SEED = {"law": 7, "heading": 5}
VECTORED, _, WAITING = (search.factory(point) for search, point in zip(SEARCHES, CHOSEN, strict=True))
each = pytest.mark.parametrize("kind", SEED)


@cache
def scene(kind):
    return arrival_trackers.scene(kind, SEED[kind], FLIGHTS, DRAWS)


def score(*given, **more):
    """A track is left alone behind the end of its record: what becomes of it there is not judged."""
    with np.errstate(over="ignore", invalid="ignore"):
        return arrival_trackers.score(*given, **more)


@cache
def law_free(kind):
    return score(scene(kind), TRACKERS[LAW_FREE])


@each
def test_tracked_better_than_without_a_law(row, kind):
    reference, own = law_free(kind), score(scene(kind), VECTORED)
    head = f"look-alikes {kind}, intent_imm vectored"
    row(f"{head}: lost draws", "none", f"{100 * own.lost.mean():.1f} %", not own.lost.any())
    for part, anees in zip(PARTS, np.nanmean(own.anees, axis=1), strict=True):
        row(f"{head}: ANEES, {part}", "0.8 to 1.6", f"{anees:.2f}", 0.8 <= anees <= 1.6)
    capture = ratio(reference, own, "capture")
    row(
        f"{head}: capture, RMSE of the best law-free IMM over its own",
        ">= 1.12 at the lower end",
        f"{capture.value:.3f} ({capture.low:.3f} to {capture.high:.3f})",
        capture.low >= 1.12,
    )
    for part in ("vectors", None):
        found = ratio(reference, own, part)
        row(
            f"{head}: the same, {part or 'overall'}",
            ">= 0.97",
            f"{found.value:.3f} ({found.low:.3f} to {found.high:.3f})",
            found.value >= 0.97,
        )
        assert found.value >= 0.9
    ahead, without = np.median(own.ahead), np.median(reference.ahead)
    row(
        f"{head}: 60 s ahead in the turn, median, over that of the law-free IMM",
        "<= 1/3",
        f"{ahead:.0f} m of {without:.0f} m: {ahead / without:.2f}",
        ahead <= without / 3.0,
    )
    assert capture.low >= 1.05
    assert ahead <= 0.4 * without


@each
def test_told_a_wrong_line(row, kind):
    for what, route in wrong_routes(COURSES[kind]).items():
        own = score(scene(kind), VECTORED, route=route, look_ahead=False)
        parts = (f"{part} {1 / ratio(law_free(kind), own, part).value:.3f}" for part in PARTS)
        overall = 1.0 / ratio(law_free(kind), own, None).value
        row(
            f"look-alikes {kind}, intent_imm vectored, told a line {what}: RMSE over that of the law-free IMM",
            "<= 1.05",
            f"{overall:.3f}; {', '.join(parts)}",
            overall <= 1.05,
        )
        assert overall <= 1.1


@each
def test_a_law_that_is_waited_for(row, kind):
    own, at_once = (score(scene(kind), one, look_ahead=False) for one in (WAITING, TRACKERS["saturated_control"]))
    told = ("/".join(f"{arrival_trackers.rmse(one, part):.0f}" for part in PARTS) for one in (own, at_once))
    row(
        f'look-alikes {kind}, saturated_control with begins = "engaged": RMSE in vectors/capture/established, m',
        "shown beside one that begins at once",
        f"{next(told)} beside {next(told)}; lost {own.lost.mean():.1%} beside {at_once.lost.mean():.1%}",
        True,
    )
    assert arrival_trackers.rmse(own, "capture") < 0.5 * arrival_trackers.rmse(at_once, "capture")


@each
def test_conformance(row, kind):
    new, today = (
        arrival_conformance.conformance(kind, SEED[kind], 60, DRAWS, one) for one in (VECTORED, TRACKERS["intent_imm"])
    )
    head = f"look-alikes {kind}, conformance of intent_imm vectored"
    windows, arrivals = new.windows[-1], new.arrivals[-1]
    row(f"{head}: established windows of 200 s with an alarm", "<= 5 %", f"{100 * windows:.1f} %", windows <= 0.05)
    row(f"{head}: whole arrivals with an alarm", "<= 15 %", f"{100 * arrivals:.1f} %", arrivals <= 0.15)
    for departure, delays in new.delays.items():
        late, before = delays[new.asked], today.delays[departure][-1]
        row(
            f"{head}, {departure}: median delay at one alarm in 1000 looks or fewer",
            f"<= {before:.0f} s, that of the one that is not vectored at {today.false[-1]:.2f} in 1000",
            f"{late:.0f} s at {new.false[new.asked]:.2f} in 1000",
            late <= before,
        )
    assert windows <= 0.05
    assert arrivals <= 0.2
