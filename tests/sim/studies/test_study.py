"""Studies judged by arithmetic, by the single run, and by what a user may get wrong."""

from __future__ import annotations

import json

import numpy as np
import pytest
from scipy import stats

from sim.errors import OutputError, ScenarioError
from sim.experiment import run
from sim.flight.preparation import prepare
from sim.metrics.ensemble.spread import quantile_ranks
from sim.scenario.axes import Listed, Sampled, axis, cells, samples
from sim.scenario.reading import read
from sim.studies import study as studies
from tests.capture import CAPTURE

LINE = {**CAPTURE, "name": "line", "until_s": 2.0, "flights": 2, "wind": {"turbulence": "light"}}


class Inline:
    """The three calls without any process, in reversed order, since no order is promised."""

    def __init__(self):
        self.jobs = []

    def submit(self, number, function, *arguments):
        self.jobs.append((number, function, arguments))

    def finished(self):
        while self.jobs:
            number, function, arguments = self.jobs.pop()
            yield number, function(*arguments)

    def close(self):
        self.jobs.clear()


def line(axes, samples=1, **more):
    return {**LINE, **more, "study": {"axes": axes, "samples": samples}}


def fly(folder, tables, **given):
    return studies.study(tables, folder, Inline(), **given)


# ---- axes


def test_cells_are_every_combination():
    axes = [axis("a.b", [1, 2]), axis("c.d", ["x", "y", "z"]), axis("e.f", {"uniform": [0, 1]})]
    found = cells(axes)
    assert len(found) == 6
    assert found[1] == {"a.b": 1, "c.d": "y"}


def test_a_grid_has_its_ends_and_equal_steps():
    grid = axis("a.b", {"grid": [-3, 5, 5]})
    assert grid == Listed("a.b", (-3.0, -1.0, 1.0, 3.0, 5.0))


@pytest.mark.parametrize(
    ("kind", "distribution"),
    [("uniform", stats.uniform(4, 6)), ("normal", stats.norm(4, 10)), ("latin_hypercube", stats.uniform(4, 6))],
)
def test_samples_follow_their_distribution(kind, distribution):
    drawn = [row["a.b"] for row in samples([axis("a.b", {kind: [4, 10]})], 2000, 7)]
    assert stats.kstest(drawn, distribution.cdf).pvalue > 1e-4  # one false alarm in 10 000 seeds


@pytest.mark.parametrize("kind", ["latin_hypercube", "sobol"])
def test_stratified_samples_have_one_in_each_of_n_strata(kind):
    axes = [axis("a.b", {kind: [0, 64]}), axis("c.d", {kind: [0, 64]})]
    drawn = samples(axes, 64, 3)
    for address in ("a.b", "c.d"):
        assert sorted(int(row[address]) for row in drawn) == list(range(64))


def test_another_axis_leaves_the_draws_of_the_first_alone():
    first = axis("a.b", {"normal": [0, 1]})
    alone = [row["a.b"] for row in samples([first], 5, 1)]
    assert alone == [row["a.b"] for row in samples([axis("c.d", {"normal": [0, 1]}), first], 5, 1)]
    assert alone != [row["a.b"] for row in samples([first], 5, 2)]


def test_two_sampled_axes_are_not_the_same_numbers():
    drawn = samples([axis("a.b", {"uniform": [0, 1]}), axis("c.d", {"uniform": [0, 1]})], 500, 1)
    pairs = np.array([list(row.values()) for row in drawn])
    assert abs(np.corrcoef(pairs.T)[0, 1]) < 4 / np.sqrt(500)  # four standard errors


@pytest.mark.parametrize(
    ("axes", "samples", "said"),
    [
        ({}, 1, "axes are empty"),
        ({"wind.speed_mps": []}, 1, "the list is empty"),
        ({"wind.speed_mps": 4}, 1, "write a list of values"),
        ({"wind.speed_mps": {"normal": [5, -1]}}, 9, "sigma must not be negative, not -1"),
        ({"wind.speed_mps": {"uniform": [5, 5]}}, 9, "low end below its high end"),
        ({"wind.speed_mps": {"uniform": [5, float("nan")]}}, 9, "2 finite numbers"),
        ({"wind.speed_mps": {"grid": [0, 5, 0]}}, 1, "a grid has 1 to"),
        ({"wind.speed_mps": {"unifrom": [0, 5]}}, 9, "did you mean 'uniform'?"),
        ({"wind.speed_mps": {"sobol": [0, 5]}}, 9, "power of two: 8 or 16"),
        ({"wind.speed_mps": [0, 5]}, 9, "no axis is one"),
        ({"seed": [1, 2]}, 1, "belongs to the whole study"),
    ],
)
def test_a_bad_axis_is_one_sentence(axes, samples, said):
    with pytest.raises(ScenarioError) as caught:
        read(line(axes, samples))
    assert said in str(caught.value)
    assert len(str(caught.value).splitlines()) == 1


@pytest.mark.parametrize(
    ("axes", "said"),
    [
        ({"wind.sped_mps": [0, 5]}, "did you mean 'speed_mps'?"),
        ({"wnd.speed_mps": [0, 5]}, "did you mean 'wind'?"),
        ({"wind.speed": [0, 5]}, "it needs its unit: speed_mps"),
        ({"wind.speed_mps": [0, -5]}, "speed_mps: must be at least 0 (got -5)"),
        ({"route.legs.4.speed_mps": [50]}, "has entries 0 to 0"),
        ({"wind.speed_mps": {"grid": [0, 1, 10_000]}, "wind.from_deg": {"grid": [0, 1, 100]}}, "more than the budget"),
    ],
)
def test_an_axis_that_no_scenario_has_is_refused_before_anything_is_written(tmp_path, axes, said):
    with pytest.raises(ScenarioError, match=None) as caught:
        fly(tmp_path / "o", line(axes))
    assert said in str(caught.value)
    assert not (tmp_path / "o").exists()


# ---- statistics


def test_intervals_of_quantiles_cover_as_often_as_they_say():
    """Of 2000 samples of 60 uniform numbers the interval must hold the quantile in at least 95 %, less 3 errors."""
    drawn = np.sort(np.random.default_rng(1).random((2000, 60)), axis=1)
    for quantile in (0.5, 0.9):
        low, high = quantile_ranks(60, quantile)
        covered = np.mean((drawn[:, low - 1] <= quantile) & (quantile <= drawn[:, high - 1]))
        assert 0.95 - 3 * np.sqrt(0.95 * 0.05 / 2000) <= covered < 0.99


def test_few_flights_have_no_bound_for_the_tail():
    assert quantile_ranks(20, 0.95) == (17, None)
    assert quantile_ranks(1, 0.5) == (None, None)


# ---- a study


def test_a_cell_of_a_study_is_the_run_with_its_values(tmp_path):
    axes = {"autopilot.bank_limit_deg": [10, 20], "wind.speed_mps": [0.0, 8.0]}
    fly(tmp_path, line(axes))
    records = [json.loads(text) for text in (tmp_path / "flights.jsonl").read_text().splitlines()]
    assert len(records) == 8
    tables = {key: value for key, value in LINE.items() if key != "study"}
    for record in (records[1], records[-1]):
        several = run(tables, overrides=record["values"])
        alone = run(tables, overrides=record["values"], flight=record["flight"])
        assert record["flight"] == 1  # the second of two
        assert several.metrics["each_flight"][1]["metrics"] == record["metrics"]
        assert {**alone.metrics["flight"]} == {**record["metrics"], "navigated": None}


def test_rows_say_what_flew(tmp_path):
    metrics = fly(tmp_path, line({"wind.speed_mps": [0.0, 8.0], "start.cross_track_m": {"uniform": [100, 500]}}, 3))
    assert metrics["flights"] == 12
    assert [row["wind.speed_mps"] for row in metrics["rows"]] == [0.0, 8.0]
    for row in metrics["rows"]:
        assert row["outcomes"] == {"completed": 6}
        assert row["bank_max_deg"]["n"] == 6
        assert row["bank_max_deg"]["p5"] <= row["bank_max_deg"]["p50"] <= row["bank_max_deg"]["p95"]
        assert 100 <= row["start.cross_track_m"]["p50"] <= 500
    one, two = metrics["rows"]
    assert one["start.cross_track_m"] == two["start.cross_track_m"]  # cells are compared on the same samples
    assert json.loads((tmp_path / "metrics.json").read_text()) == json.loads(json.dumps(metrics))


def test_a_sample_flies_with_the_gains_of_its_cell(tmp_path):
    """A designer knows the bank limit that he chose, and does not know the one that was drawn."""
    bank = "autopilot.bank_limit_deg"
    seen = []

    def gains(tables):
        planned = studies.plan(read(tables))
        return [cell["designed"]["cross_track_limit"] for cell in studies.designed_cells(planned)]

    seen = gains(line({bank: [10, 20]}))
    assert seen[0] != seen[1]
    assert len(gains(line({bank: {"uniform": [10, 20]}}, 4))) == 1
    carried = prepare(read({k: v for k, v in line({bank: [10]}).items() if k != "study"})).gains.to_table()
    assert gains({**line({bank: [10, 20]}), "designed": carried}) == seen  # a design for 15 deg, carried by a file
    frozen = {key: value for key, value in carried.items() if key != "inputs"}
    assert len(set(gains({**line({bank: [10, 20]}), "designed": frozen}))) == 1


def test_a_sample_that_cannot_fly_is_one_flight_lost(tmp_path):
    metrics = fly(tmp_path, line({"start.height_m": {"normal": [1.0, 20.0]}}, 8, flights=1))
    drawn = samples([Sampled("start.height_m", "normal", (1.0, 20.0))], 8, 1)
    below = sum(row["start.height_m"] <= 0 for row in drawn)
    assert 0 < below < 8
    assert metrics["outcomes"]["refused"] == below
    told = [json.loads(text) for text in (tmp_path / "flights.jsonl").read_text().splitlines()]
    assert all(
        "starts above the ground" in r["metrics"]["reason"] for r in told if r["metrics"]["outcome"] == "refused"
    )


def test_a_cell_that_cannot_be_designed_is_refused_and_the_others_fly(tmp_path):
    """A bank limit that leaves no room for the turns of a short leg is a result of the map."""
    legs = [
        {"from_m": [0, 0], "to_m": [9000, 0], "speed_mps": 72, "height_m": 600},
        {"from_m": [9000, 0], "to_m": [9000, 9000], "speed_mps": 72, "height_m": 600},
    ]
    short = {"route": {"kind": "legs", "legs": legs}, "start": {"leg": 0}}
    metrics = fly(tmp_path / "o", line({"autopilot.bank_limit_deg": [2.0, 15.0]}, **short))
    assert [row["outcomes"] for row in metrics["rows"]] == [{"refused": 2}, {"completed": 2}]
    (why,) = metrics["refusals"]
    assert "at 2 deg of bank its turns need" in why
    with pytest.raises(ScenarioError, match=r"with autopilot.bank_limit_deg = 2.0: .*its turns need"):
        fly(tmp_path / "none", line({"autopilot.bank_limit_deg": [2.0]}, **short))


def test_trackers_join_the_rows(tmp_path):
    radar = {"radar": {"kind": "surveillance_radar", "position_sigma_m": 100.0}}
    kalman = {"plain": {"kind": "kalman"}}
    tables = line({"sensors.radar.position_sigma_m": [50.0, 200.0]}, sensors=radar, trackers=kalman, draws=20)
    rows = fly(tmp_path, {**tables, "until_s": 20.0, "flights": 1})["rows"]
    name = "trackers.plain.overall.position_m.raw"
    assert rows[1][name]["p50"] == pytest.approx(4 * rows[0][name]["p50"])  # the same draws, four times as large


# ---- folders


def test_a_log_that_was_cut_ends_with_the_same_bytes(tmp_path):
    tables = line({"wind.speed_mps": [0.0, 8.0]}, until_s=1.0)
    fly(tmp_path / "whole", tables)
    whole = {name: (tmp_path / "whole" / name).read_bytes() for name in ("flights.jsonl", "metrics.json")}
    for cut in (0, 10, len(whole["flights.jsonl"]) // 2, len(whole["flights.jsonl"]) - 1):
        folder = tmp_path / str(cut)
        fly(folder, tables)
        (folder / "metrics.json").unlink()
        (folder / "flights.jsonl").write_bytes(whole["flights.jsonl"][:cut])
        studies.resume(folder, Inline())
        assert {name: (folder / name).read_bytes() for name in whole} == whole


def test_what_is_finished_is_not_flown_again(tmp_path):
    tables = line({"wind.speed_mps": [0.0, 8.0]}, until_s=1.0)
    fly(tmp_path, tables)

    class Refuses(Inline):
        def submit(self, number, function, *arguments):
            raise AssertionError("flown again")

    studies.study(tables, tmp_path, Refuses())


def test_another_study_is_not_mixed_in(tmp_path):
    tables = line({"wind.speed_mps": [0.0]}, until_s=1.0)
    fly(tmp_path, tables)
    before = (tmp_path / "metrics.json").read_bytes()
    with pytest.raises(OutputError, match="a study with seed 1, not 2"):
        fly(tmp_path, {**tables, "seed": 2})
    with pytest.raises(OutputError, match="a study of another scenario"):
        fly(tmp_path, line({"wind.speed_mps": [1.0]}, until_s=1.0))
    assert (tmp_path / "metrics.json").read_bytes() == before
    assert fly(tmp_path, {**tables, "seed": 2}, anew=True)["seed"] == 2


def test_another_version_goes_on_only_when_told(tmp_path):
    fly(tmp_path, line({"wind.speed_mps": [0.0]}, until_s=1.0))
    file = tmp_path / "cache/identity.json"
    file.write_text(file.read_text().replace('"shortfinal": "', '"shortfinal": "0.0.'))
    with pytest.raises(OutputError, match=r"a study begun with shortfinal 0\.0\."):
        studies.resume(tmp_path, Inline())
    assert studies.resume(tmp_path, Inline(), anyway=True)["flights"] == 2


@pytest.mark.parametrize("found", ["null", "7", "[]", '{"versions": []}', "{", ""])
def test_a_broken_identity_is_no_identity(tmp_path, found):
    fly(tmp_path, line({"wind.speed_mps": [0.0]}, until_s=1.0))
    (tmp_path / "cache/identity.json").write_text(found)
    with pytest.raises(OutputError, match=r"is no study folder: its cache/identity\.json is damaged"):
        studies.resume(tmp_path, Inline())


def test_a_folder_without_a_study_is_left_alone(tmp_path):
    with pytest.raises(OutputError, match="is no study folder"):
        studies.resume(tmp_path, Inline())
    (tmp_path / "thesis.txt").write_text("years of work")
    with pytest.raises(OutputError, match="did not write"):
        fly(tmp_path, line({"wind.speed_mps": [0.0]}))
    assert [file.name for file in tmp_path.iterdir()] == ["thesis.txt"]


def test_two_at_a_time_are_refused(tmp_path):
    tables = line({"wind.speed_mps": [0.0]}, until_s=1.0)

    class Meanwhile(Inline):
        def finished(self):
            with pytest.raises(OutputError, match="another process is working"):
                studies.resume(tmp_path, Inline())
            yield from super().finished()

    studies.study(tables, tmp_path, Meanwhile())


# ---- the command


@pytest.mark.parametrize(
    ("sets", "said"),
    [
        ((), "has no [study]; say what is to be varied"),
        (('study.axes={ "wind.sped_mps" = [1] }',), "did you mean 'speed_mps'?"),
        (('study.axes={ "wind.speed_mps" = [] }',), "the list is empty"),
        (
            ("study.samples=58", 'checks=[{ metric = "overshoot_m", max = 1, share = 0.95, confidence = 0.95 }]'),
            "needs at least 59 flights, there are 58: none broken of 58 says only below 5 %",
        ),
        (
            ('study.axes={ "wind.speed_mps" = [1] }', 'study.checks=[{ metric = "overshoot_m", max = 1 }]'),
            "[study] checks: no such key; write each under [[checks]], with its share and confidence",
        ),
    ],
)
def test_bad_studies_are_one_sentence_and_exit_two(command, tmp_path, sets, said):
    words = [word for item in sets for word in ("--set", item)]
    done = command("study", "route_capture_point_mass", *words, "-o", tmp_path / "o")
    assert done.returncode == 2, done.stdout + done.stderr
    assert said in done.stderr
    assert len(done.stderr.splitlines()) == 1
    assert not (tmp_path / "o").exists()


def test_validate_looks_at_the_axes_too(command):
    base = ("validate", "route_capture_point_mass", "--set")
    assert command(*base, 'study.axes={ "wind.speed_mps" = [1] }').returncode == 0
    assert "did you mean 'speed_mps'?" in command(*base, 'study.axes={ "wind.sped_mps" = [1] }').stderr


def test_resume_without_a_folder_is_exit_two(command, tmp_path):
    done = command("resume", tmp_path / "nowhere")
    assert done.returncode == 2
    assert "is no study folder" in done.stderr
