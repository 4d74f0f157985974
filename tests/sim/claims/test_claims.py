"""The ledger of claims: its rule on made intervals, its completeness, its rows, its command."""

from __future__ import annotations

import csv
import json
import math
import os
import tomllib
from dataclasses import replace
from importlib import import_module
from pathlib import Path

import numpy as np
import pytest
from typer.testing import CliRunner

from sim import claims
from sim.claims.curves import csv_files
from sim.claims.ledger import DRAWS, FLIGHTS, MOST_FLIGHTS, MOST_RUNS, Claim, Reading, Row, exactly, flown_too, measure
from sim.claims.page import chart, page
from sim.claims.plots import Curve, Plot
from sim.claims.table import summary, table
from sim.claims.verdict import above, at_most, between, borderline, number, verdict, zero
from sim.cli.commands import app, main
from tests.sim.drawn import drawings
from tracking.intervals import Interval

LISTED = tomllib.loads((Path(__file__).resolve().parents[2] / "papers.toml").read_text())


@pytest.mark.parametrize(
    ("values", "printed", "expected"),
    [
        ([1.4], between("1.3", "1.5"), "reproduced"),
        ([1.3, 1.5], between("1.3", "1.5"), "reproduced"),
        ([1.4, 2.0], between("1.3", "1.5"), "qualified"),
        ([2.0, 3.0], between("1.3", "1.5", good=1), "exceeded"),
        ([2.0, 3.0], between("1.3", "1.5", good=-1), "refuted"),
        ([2.0, 3.0], between("1.3", "1.5"), "refuted"),
        ([1.0], between("1.3", "1.5", good=1), "refuted"),
        ([1.0, 2.0], number("1.4"), "not reproducible"),
        ([1.7, 2.0], number("1.4"), "refuted"),
        ([1.0, 1.1], number("1.4"), "refuted"),
        ([1.0, 1.4, 2.0], number("1.4"), "qualified"),
        ([math.inf], number("1.4", good=1), "exceeded"),
        ([1.0, 2.0], between("1.3", "1.5", good=1), "not reproducible"),
        ([1.1, 2.0], above(1.0), "reproduced"),
        ([1.1, 0.9], above(1.0), "qualified"),
        ([0.9, 1.0], above(1.0), "refuted"),
        ([50.0], at_most(50), "reproduced"),
        ([], between("1.3", "1.5"), "not testable here"),
        ([1.0], None, "not testable here"),
        ([math.nan], above(1.0), "not testable here"),
    ],
)
def test_the_rule(values, printed, expected):
    assert verdict(values, printed) == expected


@pytest.mark.parametrize(
    ("text", "inside", "outside"),
    [
        ("82", (81.5, 82.2, 82.99), (81.4, 83.0)),
        ("0.0122", (0.01215, 0.01229), (0.0121, 0.0123)),
        ("3.6e-8", (3.55e-8, 3.69e-8), (3.5e-8, 3.7e-8)),
        ("0.95", (0.945, 0.959), (0.944, 0.96)),
    ],
)
def test_a_single_number_is_all_that_rounds_or_truncates_to_it(text, inside, outside):
    printed = number(text)
    assert [printed.side(value) for value in inside] == [0] * len(inside)
    assert 0 not in [printed.side(value) for value in outside]


@pytest.mark.parametrize("unit", [1.0, 100.0, 1e-9])
def test_a_printed_zero_is_judged_alike_in_every_unit(unit):
    printed = zero(unit)
    assert [printed.side(share * unit) for share in (-0.02, -0.009, 0.0, 0.009, 0.02)] == [-1, 0, 0, 0, 1]


@pytest.mark.parametrize("text", ["0", "0.00", "0e3"])
def test_a_zero_is_no_number_that_rounds(text):
    with pytest.raises(ValueError, match="scale"):
        number(text)


@pytest.mark.parametrize(
    ("intervals", "hangs"),
    [
        ([(1.1, 0.9, 1.3)], True),
        ([(1.2, 1.1, 1.3)], False),
        ([(0.9, 0.8, 1.1), (2.0, 1.9, 2.1)], True),
        ([(2.0, 1.9, 2.1), (0.5, 0.4, 0.6)], False),
        ([(3.0, math.nan, math.nan)], False),
        ([], False),
    ],
)
def test_a_verdict_that_hangs_on_where_in_its_interval_a_value_lies_says_so(intervals, hangs):
    assert borderline(intervals, above(1.0)) is hangs


def test_a_borderline_row_says_so_everywhere():
    claim = Claim("near", "near", "here", above(1.0), (Reading("a", lambda s, n: Interval(1.1, 0.9, 1.3, n)),))
    row = measure("made", claim, 0, quick=True)
    assert row.verdict == "reproduced"
    assert row.plain()["borderline"]
    assert "reproduced, borderline" in table([row])
    assert "reproduced, borderline" in summary([row])
    assert "reproduced, borderline" in page("Claims", [row], {}, 0)


def over_flights(asked: list[int], spread: float) -> Claim:
    """A claim whose interval narrows with the number of flights."""

    def measured(seed, count):
        asked.append(count)
        return Interval(1.1, 1.1 - spread / count, 1.1 + spread / count, count)

    claim = Claim("made", "made", "here", above(1.0), (Reading("model", lambda s, n: exactly(2.0)),))
    return flown_too(claim, (Reading("flown", measured),), "")[1]


@pytest.mark.parametrize(
    ("spread", "counts"),
    [
        (0.1, [4 * FLIGHTS]),
        (4.0, [4 * FLIGHTS, MOST_FLIGHTS]),
        (90.0, [4 * FLIGHTS, MOST_FLIGHTS]),
    ],
)
def test_flights_are_added_while_the_verdict_hangs(spread, counts):
    asked: list[int] = []
    row = measure("made", over_flights(asked, spread), 0)
    assert asked == counts
    assert row.measured[0].runs == counts[-1]
    assert row.borderline is (spread == 90.0)
    assert f"{counts[-1]} x {DRAWS}" in table([row])
    assert (row.plain()["n"], row.plain()["draws"]) == (counts[-1], DRAWS)


def test_runs_are_added_until_the_interval_is_a_tenth_of_the_range():
    asked = []

    def measured(seed, runs):
        asked.append(runs)
        return Interval(1.4, 1.4 - 1.0 / runs**0.5, 1.4 + 1.0 / runs**0.5, runs)

    claim = Claim("made", "made", "here", between("1.0", "2.0"), (Reading("only", measured),))
    row = measure("made", claim, 0)
    assert 2.0 / row.measured[0].runs ** 0.5 <= 0.1
    assert measure("made", claim, 0, quick=True).measured[0].runs == claim.first_runs
    stubborn = Claim(
        "made", "made", "here", between("1.0", "2.0"), (Reading("only", lambda s, n: Interval(1.5, 0.0, 3.0, n)),)
    )
    assert measure("made", stubborn, 0).measured[0].runs == MOST_RUNS


def test_what_is_far_from_the_range_needs_no_more_runs():
    printed = between("25", "30")
    assert printed.settled(100.0, 110.0)
    assert not printed.settled(31.0, 34.0)
    assert above(1.0).settled(2.0, 2.5)
    assert not above(1.0).settled(0.9, 1.2)


def told(claim: Claim) -> dict[str, str]:
    """What a row says of the print, in the words of the list."""
    said = {"words": claim.words, "where": claim.where}
    if claim.printed is not None:
        said |= {"printed": claim.printed.text} | ({"unit": claim.unit} if claim.unit else {})
    return said


@pytest.mark.parametrize("paper", claims.PAPERS)
def test_every_listed_claim_has_its_row_and_one_on_jsbsim(paper):
    rows = {claim.name: claim for claim in claims.claims_of(paper)}
    assert len(rows) == len(claims.claims_of(paper))
    for name, listed in LISTED[paper]["claims"].items():
        not_flown = listed.get("not_flown", LISTED[paper].get("not_flown"))
        printed = {key: value for key, value in listed.items() if key != "not_flown"}
        assert told(rows[name]) == printed
        assert rows[name].truth != "jsbsim"
        assert not rows[name].overlooked
        flown = rows.get(f"{name}_jsbsim")
        assert (flown is None) == (not_flown is not None)
        if flown is not None:
            assert told(flown) == printed
            assert flown.truth == "jsbsim"


@pytest.mark.parametrize("paper", claims.PAPERS)
def test_rows_on_jsbsim_are_over_flights(paper):
    """What JSBSim flies stands in rows of its own, whose runs are a few flights with several draws each."""
    for claim in claims.claims_of(paper):
        if claim.truth == "jsbsim":
            assert claim.draws > 1, claim.name
            assert claim.first_runs <= MOST_FLIGHTS // 4, claim.name
            assert claim.most_runs <= MOST_FLIGHTS, claim.name
        else:
            assert not any("JSBSim" in reading.name for reading in claim.readings), claim.name


@pytest.mark.parametrize("paper", claims.PAPERS)
def test_what_is_judged_is_printed(paper):
    """A judged row that the list does not know is a variant of a listed one, judged by the same print."""
    listed = LISTED[paper]["claims"]
    for claim in claims.claims_of(paper):
        if not claim.overlooked and claim.name not in listed:
            base = max((name for name in listed if claim.name.startswith(name)), key=len)
            assert told(claim).get("printed") == listed[base].get("printed")


@pytest.mark.parametrize("paper", claims.PAPERS)
def test_every_listed_figure_is_drawn(paper):
    assert sorted(import_module(f"sim.claims.papers.{paper}.figures").FIGURES) == sorted(LISTED[paper]["figures"])


@pytest.mark.parametrize(
    ("paper", "figure"),
    [("kychak2011", "fig. 3"), ("kychak2011", "fig. 5"), ("volovyk2018", "fig. 2"), ("vasylyev2003", "fig. 3")],
)
def test_a_figure_is_numbers_under_its_own_name(paper, figure):
    (plot,) = import_module(f"sim.claims.papers.{paper}.figures").FIGURES[figure](1)
    assert plot.figure == figure
    for curve in plot.curves:
        assert np.shape(curve.x) == np.shape(curve.y)
        assert np.isfinite(curve.x).all()
        assert np.isfinite(curve.y).all()


def made(value: float = 2.0) -> Row:
    claim = Claim(
        "gain", "a gain", "fig. 1", between("1.3", "1.5", good=1), (Reading("a", lambda s, n: exactly(value)),)
    )
    return measure("made", claim, 3)


def test_a_row_has_the_fields_that_others_read():
    row = made().plain()
    wanted = "paper claim where printed measured unit low high n seed truth readings_tried geometry_by verdict note"
    assert set(wanted.split()) <= set(row)
    assert (row["printed"], row["measured"], row["verdict"], row["seed"]) == ("1.3 to 1.5", 2.0, "exceeded", 3)


def test_what_no_paper_says_is_measured_and_not_judged():
    claim = Claim("own", "ours", "not said", None, (Reading("a", lambda s, n: exactly(2.0)),), overlooked=True)
    row = measure("made", claim, 0)
    assert row.plain()["verdict"] is None
    assert "measured" in table([row])
    assert "ours" not in summary([row])


def test_the_summary_sets_a_flown_claim_beside_its_own():
    flown = made(2.5)
    flown = flown._replace(claim=replace(flown.claim, name="gain_jsbsim", truth="jsbsim"))
    *_, line = summary([made(1.4), flown]).splitlines()
    assert line == "| made | a gain | 1.3 to 1.5 | 1.4 | reproduced | 2.5: exceeded |"
    wide = flown._replace(measured=(flown.measured[0]._replace(low=2.0, high=3.0),))
    *_, line = summary([made(1.4), wide]).splitlines()
    assert line == "| made | a gain | 1.3 to 1.5 | 1.4 | reproduced | 2.5 (2 to 3): exceeded |"


def test_the_table_is_aligned_and_says_all():
    lines = table([made(), made(1.0)]).splitlines()
    assert len({line.index("made") for line in lines[1:]}) == 1
    assert "exceeded" in lines[1]
    assert "refuted" in lines[2]


def test_the_page_shows_rows_and_figures():
    plot = Plot(
        "fig. 1", "Made", "Made up.", "x", "y", (Curve("a", [0, 1], [1, 2]), Curve("b", [0, 1], [2, 1], "dots"))
    )
    drawn = chart(plot)
    text = page("Claims of made", [made()], {"made": [drawn]}, 3)
    assert "1 claims: 1 exceeded." in text
    assert "fig. 1: Made" in text
    assert len(drawings(text)) == 1
    assert [mark.label for mark in drawn.figure.legend[0]] == ["a", "b"]


def test_known_counts_are_reproduced():
    """Exact counts: no seed, no runs."""
    rows = {
        claim.name: measure("volovyk2018", claim, 0, quick=True)
        for claim in claims.claims_of("volovyk2018")
        if claim.name in ("multiplications_saved", "additions_saved", "initial_values_rate")
    }
    assert {name: row.verdict for name, row in rows.items()} == {
        "multiplications_saved": "reproduced",
        "additions_saved": "reproduced",
        "initial_values_rate": "qualified",
    }
    assert rows["multiplications_saved"].measured[0].value == pytest.approx(100 * (1 - 8 / 45))


@pytest.mark.soak
def test_the_verdict_on_the_printed_gain_does_not_depend_on_the_seed():
    """25-30 is far from both definitions, 107 and 10.3, whatever is drawn."""
    listed = {claim.name: claim for claim in claims.claims_of("kychak2011")}
    for seed in (1, 2, 3):
        row = measure("kychak2011", listed["accuracy_gain"], seed, quick=True)
        assert row.verdict == "not reproducible"
        assert measure("kychak2011", listed["steady_state"], seed, quick=True).verdict == "qualified"
        assert row.measured[0].value == pytest.approx(107.0, rel=0.12)  # 200 runs: 3 % and heavy tails


def test_an_unknown_paper_is_refused_with_the_nearest(capsys, monkeypatch):
    monkeypatch.setattr("sys.argv", ["shortfinal", "claims", "kychak"])
    with pytest.raises(SystemExit) as stopped:
        main()
    assert stopped.value.code == 2
    assert "did you mean 'kychak2011'?" in capsys.readouterr().err


def test_a_folder_that_cannot_be_written_is_refused_before_anything_is_measured(tmp_path, capsys, monkeypatch):
    (tmp_path / "theirs.txt").write_text("kept")
    monkeypatch.setattr("sys.argv", ["shortfinal", "claims", "-o", str(tmp_path)])
    monkeypatch.setattr(claims, "measured", lambda *given: pytest.fail("measured"))
    with pytest.raises(SystemExit) as stopped:
        main()
    assert stopped.value.code == 2
    assert "choose another folder" in capsys.readouterr().err
    assert os.listdir(tmp_path) == ["theirs.txt"]


def test_the_command_writes_json_and_pages_and_exits_0_whatever_the_verdicts(tmp_path, monkeypatch):
    monkeypatch.setattr(claims, "measured", lambda *given: [made(1.0)])
    monkeypatch.setattr("sim.claims.page.plots_of", lambda paper, seed: ())
    done = CliRunner().invoke(app, ["claims", "glistin", "--json", "-o", str(tmp_path / "out")])
    assert done.exit_code == 0
    (row,) = json.loads(done.stdout)
    assert row["verdict"] == "refuted"
    written = {path.name for path in (tmp_path / "out").iterdir()}
    assert {"claims.json", "claims.md", "claims.html", "made.html"} <= written
    assert json.loads((tmp_path / "out" / "claims.json").read_text()) == [row]


def some_claim(name: str, asked: list[str]) -> Claim:
    def measured(seed, runs):
        asked.append(name)
        return exactly(float(len(name)))

    return Claim(name, "made", "here", above(1.0), (Reading("only", measured),))


def test_an_interrupted_command_goes_on_where_it_was_stopped(tmp_path, monkeypatch):
    asked: list[str] = []
    first, second = (some_claim(name, asked) for name in ("one", "three"))
    monkeypatch.setattr("sim.claims.page.plots_of", lambda paper, seed: ())
    monkeypatch.setattr("sys.argv", ["shortfinal", "claims", "glistin", "-o", str(tmp_path / "out")])

    def stopped(seed, runs):
        raise KeyboardInterrupt

    torn = Claim("three", "made", "here", above(1.0), (Reading("only", stopped),))
    monkeypatch.setattr(claims, "claims_of", lambda paper: (first, torn))
    with pytest.raises(SystemExit) as ended:
        main()
    assert ended.value.code == 130
    assert sorted(path.name for path in (tmp_path / "out").iterdir()) == [".shortfinal", "rows.jsonl"]
    with (tmp_path / "out" / "rows.jsonl").open("a") as file:
        file.write('{"stamp": "to')  # what a kill tears
    monkeypatch.setattr(claims, "claims_of", lambda paper: (first, second))
    with pytest.raises(SystemExit) as ended:
        main()
    assert not ended.value.code
    assert asked == ["one", "three"]
    rows = json.loads((tmp_path / "out" / "claims.json").read_text())
    assert [row["measured"] for row in rows] == [3.0, 5.0]
    assert not (tmp_path / "out" / "rows.jsonl").exists()


def test_rows_of_another_seed_or_program_are_measured_again(tmp_path, monkeypatch):
    asked: list[str] = []
    monkeypatch.setattr(claims, "claims_of", lambda paper: (some_claim("one", asked),))
    for seed in (1, 1, 2):
        list(claims.measured(["glistin"], seed, True, None, tmp_path))
    assert asked == ["one", "one"]
    monkeypatch.setattr("sim.claims.row_cache.program", lambda: "another")
    list(claims.measured(["glistin"], 1, True, None, tmp_path))
    assert asked == ["one", "one", "one"]


def test_a_figure_leaves_its_curves_as_a_table():
    plot = Plot(
        "Fig. 2", "t", "c", "time, s", "error, m", (Curve("a, b", [0.0, 1.0], [2.0, 0.1]), Curve("c", [3], [4]))
    )
    found = csv_files("made", [plot, plot])
    assert sorted(found) == ["made_fig_2-2.csv", "made_fig_2.csv"]
    rows = list(csv.reader(found["made_fig_2.csv"].splitlines()))
    assert rows == [["curve", "time, s", "error, m"], ["a, b", "0.0", "2.0"], ["a, b", "1.0", "0.1"], ["c", "3", "4"]]
