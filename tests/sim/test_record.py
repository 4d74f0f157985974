"""A scenario with [record]: run, run again, studied; what cannot stand beside it; what nobody recorded."""

from __future__ import annotations

import json
import math
from pathlib import Path

import numpy as np
import pytest

import sim
from sim.errors import ScenarioError
from sim.experiment import evaluate, run_to_folder
from sim.files import plain
from sim.studies.plan import designed_cells, plan
from tests import recordings

RADAR = {"kind": "surveillance_radar", "height": "mode_c", "period_s": 20.0}


@pytest.fixture(scope="module")
def files(tmp_path_factory):
    """Two flights of which the second reads 100 m too low, and the runway."""
    folder = tmp_path_factory.mktemp("recorded")
    table = recordings.rows("FIRST", step=2.0) + recordings.rows("SECOND", step=2.0, pressure=-100.0)
    (folder / "tracks.csv").write_text(recordings.text(table))
    (folder / "runway.toml").write_text(recordings.RUNWAY_FILE)
    return folder


def tables(files, flight="FIRST", **more):
    record = {"file": str(files / "tracks.csv"), "runway": str(files / "runway.toml")}
    record |= {} if flight is None else {"flight": flight}
    return {"name": "recorded", "draws": 1, "record": record, **more}


@pytest.fixture(scope="module")
def folder(files, tmp_path_factory):
    """A run of it."""
    checks = [{"metric": "bank_deg", "max": 30.0}, {"metric": "airspeed_mps", "min": 1.0}]
    checks += [
        {"metric": "touchdown.sink_mps", "max": 3.0},
        {"metric": "cross_track_m", "max": 100.0, "during": "glide"},
    ]
    trackers = {"kalman": {"kind": "kalman"}, "intent_imm": {"kind": "intent_imm"}}
    whole = tables(files, sensors={"radar": RADAR}, trackers=trackers, checks=checks)
    out, _ = run_to_folder(whole, {}, tmp_path_factory.mktemp("out") / "run")
    return out


def test_trackers_follow_it_and_figures_that_nobody_knows_are_null(folder):
    metrics = json.loads((folder / "metrics.json").read_text())
    figures = metrics["flight"]
    assert figures["outcome"] == "landed"
    turning = math.degrees(math.atan(75.0**2 / (9.80665 * 2500.0)))
    assert turning < figures["bank_max_deg"] < turning + 2.0  # a bank that jumps is smoothed, and swings a little
    assert figures["overshoot_m"] < 1.0
    absent = ("time_saturated_s", "bank_rate_max_degps", "final_over_stall", "touchdown", "rollout", "navigated")
    assert [figures[name] for name in absent] == [None] * len(absent)
    for one in metrics["trackers"].values():
        assert one["overall"]["position_m"]["rmse"] < one["overall"]["position_m"]["raw"] * 1.5
        assert {"vectors", "capture", "established", "glide"} <= {*one["by_phase"]}
    assert metrics["trackers"]["intent_imm"]["conformance"]["false_alarm_fraction"] is None
    assert [check["passed"] for check in metrics["checks"]] == [True, None, None, True]
    told = [sentence for sentence in metrics["warnings"] if "not judged" in sentence]
    assert len(told) == 2
    assert "'airspeed_mps'" in told[0]


def test_the_page_says_nothing_of_an_aircraft_that_flies_here(folder):
    page = (folder / "report.html").read_text()
    assert "recorded flight FIRST" in page
    assert "2026-03-01 12:00:00 UTC" in page
    for word in ("point mass", "no steady wind", "Speed and configuration", "at the bank limit"):
        assert word not in page.partition("<h2")[0]
    assert ">NaN<" not in page


def test_run_again_it_is_the_same_and_another_content_is_refused(folder, files, tmp_path):
    text = (folder / "scenario.toml").read_text()
    assert f'file   = "{files / "tracks.csv"}"' in text
    assert "[aircraft]" not in text
    assert "[designed" not in text
    again = sim.run(str(folder / "scenario.toml"))
    assert json.loads(json.dumps(plain(again.metrics))) == json.loads((folder / "metrics.json").read_text())
    other = tmp_path / "other.csv"
    other.write_text((files / "tracks.csv").read_text() + "\n")
    with pytest.raises(ScenarioError, match="its content is another"):
        sim.read(str(folder / "scenario.toml"), {"record.file": str(other)})


def test_a_study_varies_the_flight_and_designs_nothing(files):
    axes = {"axes": {"record.flight": ["FIRST", "SECOND"]}}
    cells = designed_cells(plan(sim.read(tables(files, sensors={"radar": RADAR}, study=axes))))
    assert [cell["record"]["flight"] for cell in cells] == ["FIRST", "SECOND"]
    assert not any(cell.get("designed") for cell in cells)


@pytest.mark.parametrize(
    ("more", "told"),
    [
        ({"aircraft": {"model": "an26"}}, r"\[aircraft\] stands beside \[record\]"),
        ({"start": {"leg": 0}}, r"\[start\] stands beside"),
        ({"wind": {"speed_mps": 5}}, r"\[wind\] stands beside"),
        ({"until_s": 100.0}, r"\[until_s\] stands beside"),
        ({"departures": [{"at_s": 5.0, "flies": "beacon"}]}, r"\[departures\] stands beside"),
        ({"autopilot": {"navigation": "kalman"}}, r"\[autopilot\] navigation says how an aircraft is flown"),
        ({"route": {"kind": "pattern"}}, r'told to trackers as kind = "legs"'),
        ({"flights": 3}, "a recording is one flight"),
        ({"study": {"samples": 4}}, "a recording is one flight"),
        ({"runway": {"heading_deg": 10}}, r"there is a table \[runway\] already"),
    ],
)
def test_what_only_a_flown_flight_has_cannot_stand_beside_it(files, more, told):
    trackers = {"kalman": {"kind": "kalman"}}
    with pytest.raises(ScenarioError, match=told) as caught:
        sim.read(tables(files, sensors={"radar": RADAR}, trackers=trackers) | {"draws": 1} | more)
    assert "\n" not in str(caught.value)


@pytest.mark.parametrize("missing", ["heading_deg", "latitude_deg", "longitude_deg"])
def test_a_runway_says_where_it_is_and_its_course(files, tmp_path, missing):
    lines = [line for line in recordings.RUNWAY_FILE.splitlines() if not line.startswith(missing)]
    (tmp_path / "runway.toml").write_text("\n".join(lines))
    whole = tables(files)
    whole["record"]["runway"] = str(tmp_path / "runway.toml")
    with pytest.raises(ScenarioError, match=missing):
        sim.read(whole)
    with pytest.raises(ScenarioError, match=missing):
        sim.recorded(files / "tracks.csv", tmp_path / "runway.toml")


def test_a_flight_is_named_where_there_are_several(files):
    with pytest.raises(ScenarioError, match="has 2 flights, say which: FIRST, SECOND"):
        sim.prepare(sim.read(tables(files, None)))
    with pytest.raises(ScenarioError, match=r"no flight 'FIRTS'.*did you mean 'FIRST'"):
        sim.prepare(sim.read(tables(files, "FIRTS")))


def test_where_nobody_is_named_a_radar_with_mode_c_watches(files):
    scenario = sim.read(tables(files))
    assert scenario.sensors["radar"].channels == ("range", "azimuth", "height")
    assert [*scenario.trackers] == ["kalman", "imm", "intent_imm"]
    assert sim.read(tables(files, sensors={}, trackers={})).trackers == {}


def test_a_sensor_of_what_nobody_recorded_is_refused(files):
    downlink = tables(files, sensors={"downlink": {"kind": "downlink"}}, trackers={})
    prepared = sim.prepare(sim.read(downlink))
    with pytest.raises(ScenarioError, match=r"\[sensors.downlink\] measures load_factor_forward.*does not know"):
        evaluate(prepared, sim.fly(prepared))


def test_trackers_are_told_the_fitted_law_or_that_of_the_file_and_a_final_without_speeds(files):
    from sim.estimation.setup import charted_route

    prepared = sim.prepare(sim.read(tables(files)))
    assert math.degrees(prepared.law.bank_limit) == pytest.approx(25.0)
    assert math.degrees(prepared.law.k1) == pytest.approx(0.055)
    assert charted_route(prepared).chart is None
    (leg,) = prepared.route.legs
    assert math.degrees(leg.course) == pytest.approx(80.0)
    legs = [{"from_m": [-9000, 0], "to_m": [0, 0], "speed_mps": 70, "height_m": 500}]
    told = {"route": {"kind": "legs", "legs": legs}, "autopilot": {"bank_limit_deg": 20, "law": {"k1_deg_per_m": 0.1}}}
    other = sim.prepare(sim.read(tables(files) | told))
    assert math.degrees(other.law.k1) == pytest.approx(0.1)
    assert math.degrees(other.law.k2) == pytest.approx(0.88)
    assert charted_route(other).chart == ()
    assert other.recording.route == other.route


def test_flights_of_a_file_are_smoothed_when_they_are_asked_for(files):
    flights = sim.recorded(files / "tracks.csv", files / "runway.toml")
    assert list(flights) == ["FIRST", "SECOND"]
    assert flights["FIRST"] is flights["FIRST"]
    with pytest.raises(KeyError):
        flights["THIRD"]
    apart = flights["FIRST"].state.height[:3000] - flights["SECOND"].state.height[:3000]
    np.testing.assert_allclose(apart, 100.0, atol=5.0)


def test_the_example_of_the_page_is_the_formula():
    page = Path(__file__).resolve().parents[2] / "docs" / "recordings"
    assert (page / "made_up.csv").read_text() == recordings.text(recordings.rows(step=4.0)).replace("\r\n", "\n")
    assert (page / "runway.toml").read_text().endswith(recordings.RUNWAY_FILE)
    flight = sim.recorded(page / "made_up.csv", page / "runway.toml")["MADE1_001"]
    assert flight.outcome == "landed"


def test_the_command_runs_one_flight(files, command, monkeypatch):
    done = command("record", files / "tracks.csv", "--runway", files / "runway.toml")
    assert done.returncode == 2
    assert "has 2 flights, say which: FIRST, SECOND" in done.stderr
    asked = []

    def run_to_folder(*arguments, **how):
        asked.append(arguments)
        raise ScenarioError("enough")

    monkeypatch.setattr("sim.experiment.run_to_folder", run_to_folder)
    more = ("--flight", "FIRST", "-o", "there", "--set", "draws=3")
    command("record", files / "tracks.csv", "--runway", files / "runway.toml", *more)
    ((whole, overrides, out),) = asked
    prepared = sim.prepare(sim.read(whole, overrides))
    assert (prepared.scenario.name, prepared.scenario.draws, out.name) == ("FIRST", 3, "there")
    assert [one.kind for one in prepared.scenario.trackers.values()] == ["kalman", "imm", "intent_imm"]
    assert prepared.recording.outcome == "landed"
