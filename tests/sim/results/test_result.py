"""A result shows itself, draws its figures, gives its tables, and comes back from its folder as it was."""

from __future__ import annotations

import dataclasses
import importlib.util
import json
import shutil

import numpy as np
import pytest

import sim
from sim.files import plain
from sim.metrics.conformance import MISMATCHED
from sim.reporting.columns import table_of
from sim.reporting.notebook import leader
from sim.reporting.run_files import flight_arrays
from sim.reporting.text.best_tracker import best_tracker
from sim.reporting.text.labels import words
from sim.reporting.tracker_figures.error_curves import shown_trackers
from tests.capture import capture_tables

RADAR = {"kind": "surveillance_radar", "period_s": 2.0, "position_m": [-3000, 2000, 10]}
KINDS = ("kalman", "imm", "saturated_control")


@pytest.fixture(scope="module")
def flown():
    """An aircraft that captures a line under one radar, with three trackers, of which two are contrasted."""
    return sim.run(
        {
            **capture_tables(name="short", until_s=40.0, draws=6),
            "aircraft": {"model": "point_mass"},
            "sensors": {"radar": RADAR},
            "trackers": {kind: {"kind": kind} for kind in KINDS},
            "contrasts": [{"of": "kalman", "against": "saturated_control"}],
            "checks": [{"name": "tight", "metric": "bank_deg", "max": 1, "source": "no airline"}],
        }
    )


@pytest.fixture(scope="module")
def folder(flown, tmp_path_factory):
    return flown.save(str(tmp_path_factory.mktemp("saved") / "deep" / "run"))


def equal(one, other):
    """Whether two values of any of the data types are the same to the last bit."""
    if dataclasses.is_dataclass(one):
        names = [field.name for field in dataclasses.fields(one)]
        return all(equal(getattr(one, name), getattr(other, name)) for name in names)
    if isinstance(one, tuple):
        return len(one) == len(other) and all(map(equal, one, other))
    if isinstance(one, np.ndarray):
        return one.dtype == other.dtype and np.array_equal(one, other, equal_nan=one.dtype.kind == "f")
    return one == other


# ---- what it shows -------------------------------------------------------------------------------------------------


def test_a_result_shows_itself_in_a_few_lines(flown):
    text = repr(flown)
    assert len(text.splitlines()) <= 5
    assert max(map(len, text.splitlines())) < 120
    for said in ("short", "seed 1", "the best of 3 trackers", "checks: 0 of 1 passed; failed: tight"):
        assert said in text


def test_the_best_tracker_of_the_short_text_is_that_of_the_report(flown):
    name = leader(flown.metrics)[0]
    shown = shown_trackers(flown.scenario, flown.tracks)
    sentence = best_tracker(flown.flight, flown.metrics["trackers"], shown)
    assert f"{words(name)} was best" in sentence


def test_a_tracker_that_is_told_another_law_or_loses_the_track_is_not_the_best():
    def one(rmse, law=None, lost=0.0):
        return {"law_from": law, "lost_fraction": lost, "overall": {"position_m": {"rmse": rmse}}}

    told = {"wrong": one(1.0, MISMATCHED), "lost": one(2.0, lost=0.5), "good": one(30.0), "none": {"overall": {}}}
    assert leader({"trackers": told}) == ("good", "position_m", 30.0)
    assert leader({"trackers": {}}) is None


def test_no_data_type_fills_the_screen(flown):
    for one in (flown.flight, flown.prepared, *flown.tracks.values(), *flown.records.values()):
        assert len(repr(one)) < 400, type(one)
    assert len(repr(flown.tracks["imm"].track)) < 200
    assert len(repr(flown.tracks["imm"].measurements)) < 200


def test_a_notebook_shows_the_first_screen_and_the_story(flown):
    page = flown._repr_html_()
    assert "<svg" in page
    assert "Kalman against saturated control" in page
    assert all(sentence.split("'")[0] in page for sentence in flown.contrasted)
    assert "<script" not in page


def test_a_name_cannot_bring_markup_into_a_notebook():
    tables = {**capture_tables(name="plain", until_s=2.0), "aircraft": {"model": "point_mass"}}
    result = sim.run(tables)
    evil = dataclasses.replace(result, metrics={**result.metrics, "warnings": ["<script>"]})
    assert "<script" not in evil._repr_html_()


# ---- figures -------------------------------------------------------------------------------------------------------


def test_every_figure_of_the_report_has_a_name_and_is_drawn_by_it(flown, tmp_path):
    page = sim.report(flown, tmp_path / "out").read_text()
    names = sim.figures(flown)
    for title in names.values():
        assert title.replace("'", "&#39;") in page, title
    assert page.count("<figure") == len(names)
    figure = flown.plot("plan")
    (lines, *_) = [axes.lines for axes in figure.axes]
    assert any(len(line.get_xdata()) > 100 for line in lines)
    assert [*names][:2] == ["contrast", "plan"]


def test_a_figure_that_there_is_not_is_answered_with_those_that_are(flown):
    with pytest.raises(ValueError, match=r"no figure 'pln'; this result has contrast, plan, "):
        flown.plot("pln")


# ---- tables --------------------------------------------------------------------------------------------------------


def test_tables_have_the_columns_of_the_files(flown):
    pandas = pytest.importorskip("pandas")
    table = flown.to_dataframe("flight")
    assert isinstance(table, pandas.DataFrame)
    assert [*table] == [*table_of(flight_arrays(flown.flight.whole))]
    np.testing.assert_array_equal(table["bank_rad"], flown.flight.whole.state.bank)
    looks = flown.to_dataframe("measurements")
    assert set(looks["sensor"]) == {"radar"}
    assert len(looks) == len(flown.records["radar"].time) * 6
    assert set(flown.to_dataframe("trackers")["tracker"]) == set(KINDS)


def test_the_table_of_errors_gives_the_figures_of_the_run(flown):
    pytest.importorskip("pandas")
    table = flown.to_dataframe("errors")
    for kind in KINDS:
        mine = table[table["tracker"] == kind]
        rmse = float(np.sqrt(np.mean(mine["position_m"] ** 2)))
        # figures count the epochs at which something was measured, which here are all
        assert rmse == pytest.approx(flown.metrics["trackers"][kind]["overall"]["position_m"]["rmse"], rel=1e-9)


def test_without_pandas_one_sentence_says_what_to_install(flown, monkeypatch):
    monkeypatch.setattr(importlib.util, "find_spec", lambda name: None)
    with pytest.raises(sim.OutputError, match=r"^to_dataframe needs pandas: pip install 'shortfinal\[pandas\]'$"):
        flown.to_dataframe("flight")


def test_a_table_that_there_is_not_is_answered(flown):
    with pytest.raises(ValueError, match="no table 'fligt'; there are flight, measurements, trackers, errors"):
        flown.to_dataframe("fligt")


# ---- its folder ----------------------------------------------------------------------------------------------------


def test_a_saved_result_is_loaded_as_it_was(flown, folder):
    again = sim.load(str(folder))
    assert equal(again.flight, flown.flight)
    assert again.metrics == json.loads(json.dumps(plain(flown.metrics)))
    assert again.number == flown.number
    assert repr(again) == repr(flown)
    assert again.scenario.tables == {**flown.scenario.tables, "designed": flown.prepared.design}
    assert {*again.records} == {"radar"}
    assert equal(again.records["radar"], flown.records["radar"])
    for name, one in flown.tracks.items():
        assert equal(again.tracks[name].track, one.track), name
    assert sim.figures(again) == sim.figures(flown)


def test_a_loaded_result_is_saved_to_the_same_bytes(folder, tmp_path):
    sim.load(folder).save(tmp_path / "b")
    for file in folder.iterdir():
        assert file.read_bytes() == (tmp_path / "b" / file.name).read_bytes(), file.name


def test_a_flight_of_several_with_its_rollout_is_loaded_as_it_was(tmp_path):
    without = {"trackers": {}, "sensors": {}, "contrasts": [], "checks": []}
    changes = {"start.phase": "final", "start.distance_m": 1500.0, "flights": 2, "wind.turbulence": "light", **without}
    flown = sim.run("an26_crosswind", overrides=changes, flight=1)
    again = sim.load(flown.save(tmp_path / "run"))
    assert again.number == 1
    assert flown.flight.rollout is not None
    assert equal(again.flight, flown.flight)


def flown_versions(folder):
    return json.loads((folder / "metrics.json").read_text())["versions"]


def spoilt(folder, tmp_path):
    place = tmp_path / "spoilt"
    shutil.copytree(folder, place)
    return place


def test_a_folder_that_is_no_whole_run_is_refused_in_one_sentence(folder, tmp_path):
    def refused(place):
        with pytest.raises(sim.OutputError) as caught:
            sim.load(place)
        assert "\n" not in str(caught.value)
        return str(caught.value)

    assert "no such folder" in refused(tmp_path / "none")
    (tmp_path / "photos").mkdir()
    assert "not a run folder" in refused(tmp_path / "photos")
    place = spoilt(folder, tmp_path)
    (place / "tracks.npz").unlink()
    (place / "metrics.json").rename(place / "kept")
    assert "half written, metrics.json and tracks.npz missing" in refused(place)
    shutil.rmtree(place)
    place = spoilt(folder, tmp_path)
    metrics = json.loads((place / "metrics.json").read_text())
    metrics["versions"]["shortfinal"] = "0.0.1"
    (place / "metrics.json").write_text(json.dumps(metrics))
    assert "written by shortfinal 0.0.1, and this is" in refused(place)
    shutil.rmtree(place)
    place = spoilt(folder, tmp_path)
    content = (place / "flight.npz").read_bytes()
    (place / "flight.npz").write_bytes(content[: len(content) // 2])
    assert "flight.npz: damaged" in refused(place)
    for content in ("[]", '{"versions": 5}', "{", json.dumps({"versions": flown_versions(folder)})):
        (place / "metrics.json").write_text(content)
        assert "metrics.json: damaged" in refused(place)
    (place / "cache").mkdir()
    assert "holds a study, not a run" in refused(place)


def test_tracks_that_are_not_those_of_the_folder_are_an_error_and_no_other_numbers(folder, tmp_path):
    place = spoilt(folder, tmp_path)
    with np.load(place / "tracks.npz") as arrays:
        kept = dict(arrays.items())
    kept["imm.mean"][0, 0, 0] += 1.0
    np.savez(place / "tracks.npz", **kept)
    again = sim.load(place)
    with pytest.raises(sim.OutputError, match=r"tracks.npz: holds another imm.mean than its scenario gives here"):
        again.tracks["kalman"]


def test_a_report_takes_a_string_and_keeps_what_is_not_its_own(flown, tmp_path):
    assert sim.report(flown, f"{tmp_path}/new/run").name == "report.html"
    (tmp_path / "mine").mkdir()
    (tmp_path / "mine" / "thesis.txt").write_text("words")
    with pytest.raises(sim.OutputError, match="holds files that shortfinal did not write"):
        flown.save(tmp_path / "mine")
