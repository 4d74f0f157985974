"""Trackers and the conformance alert on arrivals that look like recorded ones, under a radar with Mode C.

Both generators of tests/tuning, on a seed that nothing was tuned on; ``heading`` was never seen in tuning at all.
``recorded`` are flights of the study a320_arrivals, written as ADS-B recordings and read in again. The trackers are
told the law that is designed for the A320 at 25 deg, which none of these aircraft flies; their values are the choice of
docs/arrival-densities.md, searched on even seeds of the generator ``law``.
"""

from __future__ import annotations

import tempfile
from functools import cache
from pathlib import Path

import numpy as np
import pytest

import sim
from sim.scenario.toml_writer import dumps
from sim.studies import study as studies
from sim.studies.recordings import write_recordings
from sim.workers.executors import LocalExecutor
from tests.tuning import arrival_trackers
from tests.tuning.arrival_conformance import Conformance, conformance
from tests.tuning.arrival_densities import CHOSEN, SEARCHES
from tests.tuning.arrival_trackers import (
    LAW_FREE,
    PARTS,
    RADARS,
    Scene,
    Score,
    ratio,
    raw,
    recorded_scene,
    rmse,
    scene,
    score,
    wrong_routes,
)

pytestmark = pytest.mark.acceptance
SEED, FLIGHTS, DRAWS = 2029, 200, 4
EXTENDED, BEFORE = "intent_imm vectored", "intent_imm"
WAITING, AT_ONCE = "saturated_control engaged", "saturated_control"
FREE = "imm 25 deg"  # with its own choice of densities
TRACKERS = arrival_trackers.TRACKERS | {
    name: search.factory(point) for name, search, point in zip((EXTENDED, FREE, WAITING), SEARCHES, CHOSEN, strict=True)
}
STUDY = "a320_arrivals"
KINDS = (*RADARS, "recorded")


@cache
def seen(kind: str) -> Scene:
    if kind in RADARS:
        return scene(kind, SEED, FLIGHTS, DRAWS)
    with tempfile.TemporaryDirectory() as place:
        return recorded_scene(*recordings(Path(place)), SEED, DRAWS)


def recordings(place: Path) -> tuple[Path, Path]:
    """Files of the arrivals of a study and of their runway; its seed is not the one it was made with."""
    tables = sim.read(STUDY, {"seed": SEED, "study.samples": FLIGHTS}).tables
    source = place / "arrivals.toml"
    source.write_text(dumps({**tables, "sensors": {"adsb": {"kind": "adsb"}}}), encoding="utf-8")
    studies.study(str(source), place / "flown", LocalExecutor(2))
    return write_recordings(place / "flown", place / "tracks.csv", workers=2).files


@cache
def found(kind: str, name: str, wrong: str = "") -> Score:
    route = wrong_routes(seen(kind).route.legs[0].course)[wrong] if wrong else None
    with np.errstate(over="ignore", invalid="ignore"):  # a track is left alone behind the end of its record
        return score(seen(kind), TRACKERS[name], route=route, look_ahead=not wrong)


@cache
def law_free(kind: str) -> str:
    """The best of those that know no law, by its errors in the captures."""
    return min(("imm", LAW_FREE, FREE), key=lambda name: rmse(found(kind, name), "capture"))


def told(one):
    return f"{one.value:.3f} ({one.low:.3f} to {one.high:.3f})"


@pytest.mark.parametrize("kind", KINDS)
def test_nothing_is_lost_and_doubts_are_right(row, kind):
    own = found(kind, EXTENDED)
    anees = {part: float(np.nanmean(own.anees[number])) for number, part in enumerate(PARTS)}
    lost = int(own.lost.any(axis=1).sum())
    met = lost == 0 and all(0.8 <= value <= 1.6 for value in anees.values())
    told_anees = ", ".join(f"{value:.2f}" for value in anees.values())
    errors = ", ".join(f"{rmse(raw(seen(kind)), part):.0f} and {rmse(own, part):.0f}" for part in PARTS)
    row(
        f"look-alikes, {kind}: {EXTENDED}, flights lost; ANEES in {', '.join(PARTS)}",
        "none of them; .8 to 1.6 each",
        f"{lost} of {len(own.lost)}; {told_anees}; RMSE {errors} m, raw first",
        met,
    )
    assert met


@pytest.mark.parametrize("kind", KINDS)
def test_it_is_better_than_the_best_that_knows_no_law(row, kind):
    reference, own = found(kind, law_free(kind)), found(kind, EXTENDED)
    capture, vectors, overall = (ratio(reference, own, part) for part in ("capture", "vectors", None))
    met = capture.low >= 1.12 and min(vectors.value, overall.value) >= 0.97
    row(
        f"look-alikes, {kind}: RMSE of the best without a law over {EXTENDED}: capture, vectors, overall",
        ">= 1.12 (lower end), >= .97, >= .97",
        f"{law_free(kind)}: {'; '.join(map(told, (capture, vectors, overall)))}",
        met,
    )
    assert met


@pytest.mark.parametrize("kind", KINDS)
def test_a_line_told_wrong_costs_little(row, kind):
    reference = found(kind, law_free(kind))
    errors = {
        wrong: [1.0 / ratio(reference, found(kind, EXTENDED, wrong), part).value for part in (*PARTS, None)]
        for wrong in wrong_routes(0.0)
    }
    met, parts = max(map(max, errors.values())) <= 1.05, ", ".join((*PARTS, "all"))
    row(
        f"look-alikes, {kind}: RMSE of {EXTENDED}, told a wrong line, over the best without a law; {parts}",
        "<= 1.05 each",
        "; ".join(f"{wrong}: {', '.join(f'{value:.3f}' for value in own)}" for wrong, own in errors.items()),
        met,
    )
    assert met


@pytest.mark.parametrize("kind", KINDS)
def test_it_looks_ahead(row, kind):
    reference, own = (float(np.median(found(kind, name).ahead)) for name in (law_free(kind), EXTENDED))
    row(
        f"look-alikes, {kind}: 60 s ahead in the turn, median error of {EXTENDED} and of the best without a law, m",
        "<= 1/3 of it",
        f"{own:.0f} and {reference:.0f} ({law_free(kind)}): {own / reference:.3f} of it",
        own <= reference / 3.0,
    )
    assert own <= reference / 3.0


@pytest.mark.parametrize("kind", KINDS)
def test_a_law_that_is_waited_for(row, kind):
    own, at_once = found(kind, WAITING), found(kind, AT_ONCE)
    told = ("/".join(f"{rmse(one, part):.0f}" for part in PARTS) for one in (own, at_once))
    row(
        f'look-alikes, {kind}: saturated_control with begins = "engaged", RMSE in {", ".join(PARTS)}, m',
        "shown beside one that begins at once",
        f"{next(told)} beside {next(told)}; lost {own.lost.mean():.1%} beside {at_once.lost.mean():.1%}",
        True,
    )
    assert rmse(own, "capture") < 0.5 * rmse(at_once, "capture")


@cache
def alert(kind: str, name: str) -> Conformance:
    return conformance(kind, SEED, FLIGHTS, DRAWS, TRACKERS[name])


@pytest.mark.parametrize("kind", RADARS)
def test_the_alert_is_rarely_false(row, kind):
    own = alert(kind, EXTENDED)
    windows, arrivals = 100.0 * own.windows[-1], 100.0 * own.arrivals[-1]
    met = windows <= 5.0 and arrivals <= 15.0
    row(
        f"conformance on look-alikes, {kind}: alarms in established windows of 200 s, and on whole arrivals, %",
        "<= 5, <= 15",
        f"{windows:.1f}, {arrivals:.1f}; {own.false[-1]:.2f} in 1000 looks of the windows",
        met,
    )
    assert met


@pytest.mark.parametrize("kind", RADARS)
def test_the_alert_is_as_quick_as_before_at_its_own_worse_rate(row, kind):
    own, before = alert(kind, EXTENDED), alert(kind, BEFORE)
    delays = {name: (float(own.delays[name][own.asked]), float(before.delays[name][-1])) for name in own.delays}
    met = own.false[own.asked] <= 1.0 and all(now <= then for now, then in delays.values())
    row(
        f"conformance on look-alikes, {kind}: median delay at one false alarm in 1000 looks, and before, s",
        "no longer",
        "; ".join(f"{name}: {now:.0f} and {then:.0f}" for name, (now, then) in delays.items())
        + f"; at {own.false[own.asked]:.2f} and {before.false[-1]:.2f} false alarms in 1000 looks",
        met,
    )
    assert met
