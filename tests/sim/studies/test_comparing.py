"""Two runs set against each other: noise alone changes nothing, a shift is found, and bad input is one sentence."""

import json

import numpy as np
import pytest

from sim.errors import OutputError
from sim.studies.comparing.comparison import compare
from sim.studies.comparing.spans import paired, unpaired

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


def test_intervals_cover_as_often_as_they_say():
    rng, level, trials = np.random.default_rng(5), 0.95, 2000
    for span in (paired, unpaired):
        flagged = sum(span(*rng.normal(0.0, 1.0, (2, FLIGHTS)), level).changed for _ in range(trials))
        # four standard errors of a share of 5 % in so many trials, and Welch's approximation
        assert abs(flagged / trials - 0.05) < 4 * np.sqrt(0.05 * 0.95 / trials) + 0.005


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
    for other, words in (
        (tmp_path / "empty", "not a run folder"),
        (tmp_path / "none", "no such folder"),
        (old, "not that of this version"),
        (broken, "damaged"),
    ):
        with pytest.raises(OutputError, match=words) as told:
            compare(a, other)
        assert "\n" not in str(told.value)


def test_a_run_and_a_study_are_not_compared(tmp_path, monkeypatch):
    from sim.studies.comparing import comparison

    a, b = made(tmp_path / "a", 1), made(tmp_path / "b", 1)
    sides = {str(a): comparison.side_of(a), str(b): comparison.side_of(b)._replace(kind="study")}
    monkeypatch.setattr(comparison, "side_of", lambda what: sides[str(what)])
    with pytest.raises(OutputError, match=r"is a run and .* is a study: compare two of a kind"):
        compare(a, b)


def test_another_version_is_told(tmp_path):
    a, b = (made(tmp_path / name, 1, versions={"jsbsim": version}) for name, version in (("a", "1"), ("b", "2")))
    assert compare(a, b).remarks == ("the versions differ: jsbsim 1 and 2",)
