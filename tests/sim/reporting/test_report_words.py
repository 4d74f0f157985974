"""What the report says in words and numbers, judged by arithmetic and by reading."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from sim.flight.record import Event
from sim.reporting.figures.thinning import peaks, runs
from sim.reporting.text.labels import column, decimals, duration, number, split
from sim.reporting.text.outcome_sentence import what_happened
from sim.reporting.text.references import sources
from sim.reporting.text.rows import check_row, event_rows, scalar_rows, spread_rows
from sim.reporting.text.tracker_tables import tracker_tables
from sim.scenario.tables import Check

HELD, BROKEN, OPEN = ({"name": "x", "passed": passed, "flights": 1} for passed in (True, False, None))


def ended(make_flight, outcome, reason="", across=0.0):
    """A short flight that ended in a given way, beside its leg."""
    flight = make_flight(np.arange(3.0), ["final"] * 3, east=np.full(3, across))
    return flight.__class__(**{**flight.__dict__, "outcome": outcome, "reason": reason})


def touched(past, across, sink):
    return {"duration_s": 561.2, "touchdown": {"past_threshold_m": past, "cross_track_m": across, "sink_mps": sink}}


def test_a_landing_is_told_with_its_place_and_sink(make_flight):
    flight = ended(make_flight, "landed", "landed somewhere")
    told = what_happened(flight, touched(412.4, -0.31, 0.624), [HELD] * 9)
    assert told == (
        "After 9 min 21 s the aircraft landed 412 m past the threshold, 0.3 m left of the centreline, "
        "sinking at 0.62 m/s; all 9 checks held."
    )


@pytest.mark.parametrize(
    ("outcome", "reason", "across", "said"),
    [
        ("orbit", "turned 541 deg within leg 2", 0.0, "(turned 541 deg within leg 2)"),
        ("completed", "flown until 240 s", 1.26, "with the aircraft 1.3 m right of its leg"),
        ("completed", "flown until 240 s", 0.0, "with the aircraft on its leg"),
        ("time_limit", "still flying after 1800 s", -20.0, "20.0 m left of its leg"),
        (
            "diverged",
            "no longer finite at 1.00 s; last state AircraftState(time=1)",
            0.0,
            "(no longer finite at 1.00 s)",
        ),
        ("envelope", "bank 80 deg, load factor 4.0", 0.0, "(bank 80 deg, load factor 4.0)"),
        ("go_around", "at 400 s", np.nan, "climbed away;"),
        ("something new", "", np.nan, "'something new'"),
    ],
)
def test_every_other_end_is_told_with_its_reason(make_flight, outcome, reason, across, said):
    told = what_happened(ended(make_flight, outcome, reason, across), {"duration_s": 41.0, "touchdown": None}, [])
    assert said in told
    assert told.startswith("After 41 s ")
    assert told.endswith(".")
    assert ". " not in told  # one sentence
    assert "AircraftState" not in told
    assert "nan" not in told


def test_contact_beside_the_runway_is_no_landing(make_flight):
    told = what_happened(ended(make_flight, "ground"), touched(-120.0, 35.0, 4.0), [BROKEN])
    assert "land: it touched down 120 m before the threshold, 35.0 m right of the centreline, sinking at 4.00" in told
    why = "touched down 934 m past the threshold, beyond the box of 823 m"
    assert f"did not land: it {why}; 1 of 1" in what_happened(
        ended(make_flight, "ground", why), touched(934.0, 0.0, 0.6), [BROKEN]
    )


@pytest.mark.parametrize(
    ("checks", "said"),
    [
        ([], "the scenario has no checks."),
        ([OPEN], "no check could be judged."),
        ([HELD], "its one check held."),
        ([HELD, HELD, OPEN], "both checks held."),
        ([HELD, BROKEN, OPEN], "1 of 2 checks failed."),
    ],
)
def test_the_verdict_counts_what_was_judged(make_flight, checks, said):
    assert what_happened(ended(make_flight, "completed"), {"duration_s": 1.0}, checks).endswith(said)


@pytest.mark.parametrize(
    ("name", "words", "unit"),
    [
        ("cross_track_rms_final_m", "cross-track RMS final", "m"),
        ("k2_deg_per_mps", "k2", "deg/(m/s)"),
        ("touchdown.past_threshold_m", "touchdown: past the threshold", "m"),
        ("bank_rate_max_degps", "bank rate max", "deg/s"),
        ("landed", "landed", ""),
    ],
)
def test_names_become_words_and_units(name, words, unit):
    assert split(name) == (words, unit)


@pytest.mark.parametrize(
    ("value", "shown"),
    [(None, "–"), (float("nan"), "–"), (-1.234, "−1.23"), (-1e-9, "0.000"), (1234.5, "1234"), (7, "7"), (True, "yes")],
)
def test_numbers_have_the_digits_that_they_deserve(value, shown):
    assert number(value) == shown


@given(st.lists(st.floats(-1e5, 1e5), min_size=1, max_size=8))
def test_the_digits_of_a_column_stand_below_each_other(values):
    places = {len(text.partition(".")[2]) for text in column(values)}
    assert places == {decimals(*values)}


@pytest.mark.parametrize(
    ("seconds", "told"), [(0.067, "0.07 s"), (41.4, "41 s"), (59.7, "1 min 0 s"), (561.2, "9 min 21 s")]
)
def test_spans_of_time(seconds, told):
    assert duration(seconds) == told


@given(st.lists(st.floats(-1e6, 1e6) | st.just(float("nan")), min_size=1, max_size=400), st.integers(1, 40))
def test_thinning_keeps_both_ends_and_every_peak(values, bins):
    values = np.array(values)
    chosen = peaks(values, bins)
    assert chosen[0] == 0
    assert chosen[-1] == len(values) - 1
    assert np.all(np.diff(chosen) > 0)
    assert len(chosen) <= 2 * bins + 2
    if np.isfinite(values).any():
        assert np.nanmax(values[chosen]) == np.nanmax(values)
        assert np.nanmin(values[chosen]) == np.nanmin(values)


def test_a_long_gap_stays_a_gap():
    values = np.ones(10_000)
    values[3000:6000] = np.nan
    chosen = peaks(values, 100)
    assert np.isnan(values[chosen]).sum() >= 25


@given(st.lists(st.integers(0, 2), max_size=40))
def test_runs_are_the_record_again(values):
    assert [v for first, last in runs(values) for v in values[first:last]] == values
    assert all(values[a[0]] != values[b[0]] for a, b in zip(runs(values), runs(values)[1:], strict=False))


def result(**changes):
    return {
        "name": "bank_deg", "metric": "bank_deg", "during": "all", "statistic": "max", "for_s": 0.0, "limit": 16.1,
        "value": 15.03, "unit": "deg", "margin": 1.07, "time_s": 12.34, "passed": True, "source": "table",
        "flight": 0, "flights": 1, "within": 1, "not_flown": 0, "share": 1.0, "share_low": None, "confidence": None,
    } | changes  # fmt: skip


def test_a_check_is_told_in_its_own_words_and_units():
    row = check_row(Check("bank_deg", max=16.1), result())
    shown = [row[key] for key in ("name", "when", "how", "limit", "value", "margin", "unit", "time")]
    assert shown == ["bank", "whole flight", "at any time", "≤ 16.10", "15.03", "1.07", "deg", "12.3"]


def test_a_hair_over_the_limit_does_not_look_like_the_limit():
    row = check_row(Check("bank_deg", max=16.1), result(value=16.1004, margin=-0.0004, passed=False))
    assert (row["value"], row["limit"], row["margin"]) == ("16.1004", "≤ 16.1000", "−0.0004")


def test_lower_limits_ranges_and_lasting_means_are_told():
    assert (
        check_row(Check("landed", min=1.0), result(metric="landed", limit=1.0, value=1.0, margin=0.0))["limit"]
        == "≥ 1.00"
    )
    assert check_row(Check("bank_deg", min=-5.0, max=16.1), result())["limit"] == "−5.00 … 16.10"
    told = check_row(Check("bank_deg", max=1.0), result(statistic="mean_5_s", for_s=3.0, during=["final", "glide"]))
    assert (told["how"], told["when"]) == ("mean over 5 s, for 3 s", "final, glide")


def test_a_check_that_was_not_flown_shows_dashes():
    row = check_row(Check("bank_deg", max=16.1), result(value=None, margin=None, time_s=None, passed=None, source=""))
    assert [row[key] for key in ("value", "margin", "time", "source")] == ["–"] * 4


def test_events_tell_the_state_of_their_instant(make_flight):
    flight = make_flight(
        np.arange(3.0), ["final", "glide", "glide"], height=[400.0, 399.0, 398.0], bank=np.radians([0, 5, 9])
    )
    flight = flight.__class__(**{**flight.__dict__, "events": (Event(1.0, "go_around", "why"),)})
    assert event_rows(flight) == [("1.0", "go around", "399.0", "70.0", "5.0", "why")]


def test_figures_stand_under_their_labels_and_texts_are_left_to_the_page():
    figures = {"outcome": "landed", "landed": 1.0, "bank_max_deg": 15.0, "settling_s": None}
    rows = scalar_rows({**figures, "touchdown": {"sink_mps": 0.5}})
    assert {("greatest bank", "15.00", "deg"), ("settled after", "–", ""), ("sink at touchdown", "0.50", "m/s")} < {
        *rows
    }
    assert not [row for row in rows if "landed" in row]
    assert not [name for name, *_ in scalar_rows({**figures, "touchdown": None}) if "touchdown" in name]


def test_the_spread_is_shown_for_several_flights_only():
    band = {"p5": 1.0, "p50": 2.0, "p95": 3.0}
    assert spread_rows({"outcomes": {"landed": 1}, "touchdown.sink_mps": band}) == []
    assert spread_rows({"outcomes": {"landed": 19, "go_around": 1}, "landed": band, "touchdown.sink_mps": band}) == [
        ("sink at touchdown", "m/s", "1.00", "2.00", "3.00")
    ]


def test_sources_come_from_the_docstrings_of_what_ran():
    from autopilot.modes.lateral_navigation import LateralNavigation
    from autopilot.modes.radio_beacon import RadioBeacon

    equations, papers, errata = sources([LateralNavigation])
    assert equations[0].tag == "Vasylyev 2003, eq. (4)"
    assert equations[0].where == "autopilot.modes.lateral_navigation.LateralNavigation"
    assert len(papers) == 1
    assert papers[0].startswith("V. M. Vasylyev")
    assert errata == []
    equations, _, errata = sources([RadioBeacon])
    assert equations[0].tag == "Vasylyev 2003, eq. (5)"
    assert any("eps = -atan2(z, D)" in erratum for erratum in errata)


def summary(rmse, **more):
    figure = {"rmse": rmse, "low": rmse - 1, "high": rmse + 1, "raw": 100.0, "gain": 100.0 / rmse}
    figure |= {"gain_low": 99.0 / rmse, "gain_high": 101.0 / rmse}
    return {"kind": "kalman", "law_from": None, "overall": {"position_m": figure}, "by_phase": {}} | more


def test_trackers_stand_side_by_side_with_interval_gain_and_phases():
    phase = {"final": {"position_m": {"rmse": 145.1}}}
    tables = tracker_tables(
        {"one": summary(80.0, by_phase=phase, anees=1.02, lost_fraction=0.0123, lost_time_s=14.3), "two": summary(8.0)}
    )
    position, consistency = tables
    assert position.header == ["tracker", "law from", "RMSE", "interval", "raw", "gain", "of the gain", "final"]
    assert position.rows[0] == ["one", "–", "80.00", "79.00 … 81.00", "100.0", "1.25 ×", "1.24 … 1.26", "145.1"]
    assert position.rows[1] == ["two", "–", "8.00", "7.00 … 9.00", "100.0", "12.50 ×", "12.38 … 12.62", "–"]
    assert consistency.rows[0] == ["one", "kalman", "1.02", "–", "–", "1.2", "14"]
    assert consistency.rows[1][2:] == ["–"] * 5


def test_a_tracker_that_saw_nothing_is_still_listed():
    silent = {"kind": "kalman", "law_from": None, "overall": {}, "by_phase": {}}
    (consistency,) = tracker_tables({"silent": silent})
    assert consistency.rows == [["silent", "kalman", *["–"] * 5]]


def test_the_look_ahead_has_a_column_for_each_span():
    ahead = {"20_s": {"position_m": {"rmse": 31.0}}, "60_s": {"position_m": {"rmse": 131.0}}}
    *_, table = tracker_tables({"one": summary(80.0, look_ahead=ahead), "two": summary(8.0)})
    assert table.header == ["tracker", "20 s ahead", "60 s ahead"]
    assert table.rows == [["one", "31.00", "131.0"]]  # what nobody foretold is no row of dashes


def test_the_consistency_of_a_lost_tracker_has_no_decimals():
    (*_, consistency) = tracker_tables(
        {"lost": summary(8.0, anees=105679.29, anees_low=102791.64, anees_high=108566.9)}
    )
    assert consistency.rows[0][2:4] == ["105679", "102792 … 108567"]
