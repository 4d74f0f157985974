"""Two runs set against each other: noise alone changes nothing, a shift is found, and bad input is one sentence."""

import json

import numpy as np
import pytest

from sim.errors import OutputError
from sim.studies import study as studies
from sim.studies.comparing import arrangements
from sim.studies.comparing.comparison import compare
from sim.studies.comparing.judging import ERROR, judge
from tests.capture import CAPTURE
from tests.sim.studies.test_study import Inline

FLIGHTS = 8


def made(folder, seed, shift=0.0, landed=1.0, flights=FLIGHTS, **more):
    """The folder of a run whose sink is drawn, common to all runs of a seed but for a little."""
    folder.mkdir()
    (folder / ".shortfinal").write_text("written by shortfinal run\n")
    draws = np.random.default_rng(seed).normal(1.5, 0.4, flights)
    each = [
        {"flight": i, "metrics": {"outcome": "landed", "landed": landed, "touchdown": {"sink_mps": x + shift}}}
        for i, x in enumerate(draws)
    ]
    metrics = {"seed": seed, "draws": 1, "flight": each[0]["metrics"], "trackers": {}, "contrasts": {}, "versions": {}}
    (folder / "metrics.json").write_text(json.dumps({**metrics, "each_flight": each, **more}))
    return folder


def row(found, metric="touchdown.sink_mps"):
    return next(one for one in found.rows if one.metric == metric)


def test_the_same_flights_are_paired_so_that_a_small_shift_is_found(tmp_path):
    found = compare(made(tmp_path / "a", 1), made(tmp_path / "b", 1, shift=0.01))
    assert found.is_paired
    assert row(found).changed
    assert row(found).span.difference == pytest.approx(0.01)
    assert not row(found, "landed").changed


def test_of_other_seeds_the_same_shift_is_noise_and_a_great_one_is_not(tmp_path):
    a = made(tmp_path / "a", 1)
    small, great = (compare(a, made(tmp_path / name, 2, shift)) for name, shift in (("b", 0.01), ("c", 4.0)))
    assert not small.is_paired
    assert not small.changed
    assert [one.metric for one in great.changed] == ["touchdown.sink_mps"]


def test_all_landed_against_none_is_a_change(tmp_path):
    found = compare(made(tmp_path / "a", 1), made(tmp_path / "b", 1, landed=0.0))
    assert [one.metric for one in found.changed] == ["landed"]


def noise(rng, flights, metrics=12):
    """Metrics of flights, heavy-tailed and hanging together: what no table of Student's is made for."""
    common = rng.standard_t(3, (flights, 1))
    return common * rng.choice([-1, 1], metrics) + rng.standard_t(3, (flights, metrics))


def judged(a, b, paired):
    columns = {metric: (a[:, metric], b[:, metric]) for metric in range(a.shape[1])}
    return judge(columns, (len(a), len(b)), paired)


@pytest.mark.parametrize("paired", [True, False])
def test_where_nothing_has_changed_anything_is_named_as_rarely_as_it_says(paired):
    rng, flights, trials = np.random.default_rng(5), 7 if paired else 5, 600
    differs = named = 0
    for _ in range(trials):
        a = noise(rng, flights, 6)
        b = a + noise(rng, flights, 6) if paired else noise(rng, flights, 6)
        found = judged(a, b, paired)
        differs += found.probability <= ERROR
        named += any(span.changed for span in found.spans.values())
    exact = {True: 1 / 64, False: 3 / 126}[paired]  # the greatest share of the arrangements that is no more than ERROR
    spread = np.sqrt(exact * (1.0 - exact) / trials)
    assert abs(differs / trials - exact) < 4.0 * spread
    assert named <= differs


@pytest.mark.parametrize(("paired", "share"), [(True, 0.95), (False, 0.9)])
def test_one_metric_that_moves_by_some_spreads_is_named_among_others_that_do_not(paired, share):
    """By 4 spreads of the difference of a pair, by 3 of each side: half of all trials would pass by 2 and 2."""
    rng, trials = np.random.default_rng(6), 30
    right = 0
    for _ in range(trials):
        a = noise(rng, 8)
        b = a + noise(rng, 8) if paired else noise(rng, 8)
        b[:, 3] = (a[:, 3] + rng.normal(4.0, 1.0, 8)) if paired else rng.normal(6.0, 1.5, 8)
        if not paired:
            a[:, 3] = rng.normal(0.0, 1.5, 8)
        right += [key for key, span in judged(a, b, paired).spans.items() if span.changed] == [3]
    assert right >= share * trials


@pytest.mark.parametrize("flights", [3, 8])
def test_what_moves_alike_in_every_flight_is_found_however_little_it_moves(flights):
    rng = np.random.default_rng(7)
    a = np.hstack((noise(rng, flights), np.full((flights, 1), 5.0)))
    b = np.hstack((a[:, :-1] + noise(rng, flights), np.full((flights, 1), 5.001)))
    for paired in (True, False) if flights == 8 else (True,):
        found = judged(a, b, paired)
        assert [key for key, span in found.spans.items() if span.changed] == [a.shape[1] - 1]
        assert found.probability <= ERROR


def test_many_small_moves_are_seen_together_where_none_is_named():
    rng, trials = np.random.default_rng(8), 40
    together = alone = 0
    for _ in range(trials):
        a = rng.normal(0.0, 1.0, (8, 30))
        found = judged(a, a + rng.normal(0.7, 1.0, (8, 30)), True)
        together += found.probability <= ERROR
        alone += any(span.changed for span in found.spans.values())
    assert together >= 0.9 * trials
    assert alone < together


def test_a_metric_of_two_flights_is_not_judged_and_hides_no_other():
    rng = np.random.default_rng(9)
    a = noise(rng, 8)
    b = a + noise(rng, 8) + 20.0 * (np.arange(12) == 4)
    a[2:, 0] = b[2:, 0] = np.nan
    b[:2, 0] = a[:2, 0] + 1.0  # alike in both: for half of the arrangements there is nothing more certain
    found = judged(a, b, True)
    assert not found.spans[0].known
    assert [key for key, span in found.spans.items() if span.changed] == [4]


def test_arrangements_begin_with_the_one_at_hand_and_are_all_different():
    for sides, size in (
        (arrangements.of_pairs(5), 16),
        (arrangements.of_sides(4, 4), 35),
        (arrangements.of_sides(3, 4), 35),
        (arrangements.of_sides(30, 20), arrangements.MOST),
        (arrangements.of_pairs(40), arrangements.MOST),
    ):
        assert len({tuple(row) for row in sides}) == len(sides) == size
        assert np.all(np.diff(sides[0]) >= 0)
        assert np.all(sides.sum(axis=1) == sides[0].sum())


def test_a_tolerance_judges_the_difference_of_the_means(tmp_path):
    a, b = made(tmp_path / "a", 1), made(tmp_path / "b", 1, shift=0.3)
    file = tmp_path / "tolerance.toml"
    for limit, beyond in ((0.29, True), (0.31, False)):
        file.write_text(f"[touchdown]\nsink_mps = {limit}\n")
        assert bool(compare(a, b, file).beyond) == beyond


def test_one_flight_each_has_differences_but_no_intervals(tmp_path):
    found = compare(made(tmp_path / "a", 1, flights=1), made(tmp_path / "b", 1, 0.5, flights=1))
    assert not found.changed
    assert row(found).span.difference == pytest.approx(0.5)
    assert "no interval" in " ".join(found.remarks)


@pytest.mark.parametrize(
    ("tolerance", "words"),
    [
        ({"touchdown.sink_kts": 1}, "no such metric; did you mean 'touchdown.sink_mps'"),
        ({"overshoot_m": 1}, "neither side has"),
        ({"touchdown.sink_mps": -1}, "at least 0"),
        ({"touchdown": {"sink_mps": "much"}}, "must be a number"),
        ({}, "names no metric"),
    ],
)
def test_a_bad_tolerance_is_one_sentence(tmp_path, tolerance, words):
    a, b = made(tmp_path / "a", 1), made(tmp_path / "b", 2)
    with pytest.raises(OutputError, match=words) as told:
        compare(a, b, tolerance)
    assert "\n" not in str(told.value)


def test_what_cannot_be_compared_is_one_sentence(tmp_path):
    a = made(tmp_path / "a", 1)
    (tmp_path / "empty").mkdir()
    old = made(tmp_path / "old", 1, each_flight=[{"number": 1}])
    broken = made(tmp_path / "broken", 1)
    (broken / "metrics.json").write_text("{")
    half = made(tmp_path / "half", 1)
    (half / "metrics.json").unlink()
    for other, words in (
        (tmp_path / "empty", "not a run folder"),
        (tmp_path / "none", "no such folder"),
        (old, "not that of this version"),
        (broken, "damaged"),
        (half, "half written, metrics.json missing; run the scenario again"),
    ):
        with pytest.raises(OutputError, match=words) as told:
            compare(a, other)
        assert "\n" not in str(told.value)


def test_studies_are_compared_cell_by_cell_and_not_with_others(tmp_path):
    """By the cross-track limit, which acts in the cell that begins beyond it and not in the one that begins on it."""
    for name, limit, offsets in (("a", 300, [0, 600]), ("b", 350, [0, 600]), ("c", 300, [0, 200])):
        autopilot, axes = {"law": {"cross_track_limit_m": limit}}, {"axes": {"start.cross_track_m": offsets}}
        wind = {"from_deg": 90, "turbulence": "light"}
        tables = {**CAPTURE, "name": "line", "until_s": 12.0, "flights": 8, "autopilot": autopilot, "wind": wind}
        studies.study({**tables, "study": axes}, tmp_path / name, Inline())
    found = compare(tmp_path / "a", tmp_path / "b")
    assert found.is_paired
    assert found.differs
    assert {one.cell for one in found.changed} == {1}
    assert not compare(tmp_path / "a", tmp_path / "a").differs
    for other, words in (("c", "over different axes"), ("run", "is a study and .* is a run: compare two of a kind")):
        folder = tmp_path / other if other == "c" else made(tmp_path / other, 1)
        with pytest.raises(OutputError, match=words) as told:
            compare(tmp_path / "a", folder)
        assert "\n" not in str(told.value)


def test_another_version_is_told(tmp_path):
    a, b = (made(tmp_path / name, 1, versions={"jsbsim": version}) for name, version in (("a", "1"), ("b", "2")))
    assert compare(a, b).remarks == ("the versions differ: jsbsim 1 and 2",)
