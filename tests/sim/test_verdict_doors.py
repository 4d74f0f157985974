"""One file, one verdict: the run, the study and the flight that is flown again agree with what is known of each flight.

Forty files through five doors, pytest and workers among them: tests/acceptance/test_verdict.py.
"""

from __future__ import annotations

import json
import re

import numpy as np
import pytest

import sim
from sim.experiment import prepared_from
from sim.reporting.text.broken_checks import broken, run_again
from sim.scenario.toml_writer import dumps
from sim.studies import study as studies
from sim.studies.job import with_values
from sim.studies.plan import designed_cells, plan
from tests.capture import CAPTURE
from tests.sim.known_faults import FLIGHTS, TABLES, files

CONTRASTED = {
    **TABLES,
    "trackers": {"plain": {"kind": "kalman"}, "other": {"kind": "saturated_control"}},
    "contrasts": [{"of": "plain", "against": "other"}],
    "checks": [{"metric": "contrasts.plain/other.overall.position_m.low", "min": 0.01}],
}


@pytest.mark.soak
def test_a_fault_of_any_flight_fails_and_names_it(tmp_path, inline, monkeypatch):
    monkeypatch.setattr("sim.studies.page.page", lambda *given: "")  # drawn elsewhere
    for file in files(1, 3):
        place = tmp_path / f"{file.name}.toml"
        place.write_text(file.text)
        result = sim.run(place)
        (check,) = result.metrics["checks"]
        more = {} if "[study]" in file.text else {"study.samples": 1}
        theirs = studies.study(place, tmp_path / file.name, inline(), more)
        assert theirs["checks"] == [check]
        assert check["passed"] is (file.faulty is None)
        assert (check["flights"], check["within"]) == (3, 3 - (file.faulty is not None))
        if file.faulty is None:
            assert result.broken == []
            continue
        assert check["flight"] == file.faulty > 0
        assert f"2 of 3 flights keep it; {file.check['metric']} = {check['value']:.4g}" in result.broken[0]
        assert f"flight {file.faulty}, seed {result.scenario.seed}" in result.broken[0]
        again = sim.run(place, flight=file.faulty)
        assert again.metrics["checks"][0]["value"] == check["value"]
        assert again.metrics["checks"][0]["passed"] is False
        assert sim.run(place, flight=0).metrics["checks"][0]["passed"] is True  # as a run once said of all


def test_workers_give_the_same_figures():
    with pytest.raises(sim.ScenarioError, match="workers must be at least 1, not 0"):
        sim.run({"name": "s", **TABLES}, workers=0)
    tables = {"name": "s", "flights": 2, **CONTRASTED, "until_s": 10.0}
    here, there = (sim.run(tables, workers=workers) for workers in (1, 2))
    assert json.dumps(here.metrics, sort_keys=True) == json.dumps(there.metrics, sort_keys=True)
    assert here.metrics["contrasts"][0]["overall"]["position_m"]["n"] == 2


def test_a_contrast_is_the_same_in_a_run_in_a_study_and_of_one_flight(tmp_path, inline, monkeypatch):
    monkeypatch.setattr("sim.studies.page.page", lambda *given: "")
    tables = {"name": "s", "flights": 2, **CONTRASTED, "until_s": 12.0}
    metrics = sim.run(tables).metrics
    theirs = studies.study({**tables, "study": {"samples": 1}}, tmp_path / "o", inline())
    (row,) = theirs["rows"]
    assert row["contrasts"] == json.loads(json.dumps(metrics["contrasts"]))
    assert theirs["checks"] == json.loads(json.dumps(metrics["checks"]))
    kept = [record["metrics"]["contrasts"]["plain/other"] for record in metrics["each_flight"]]
    lows = [one["overall"]["position_m"]["low"] for one in kept]
    (check,) = metrics["checks"]
    assert (check["value"], check["flight"]) == (min(lows), lows.index(min(lows)))
    assert sim.run(tables, flight=1).metrics["contrasts"] == [kept[1]]
    assert row["contrasts.plain/other.overall.position_m.low"]["n"] == 2


def test_the_page_begins_with_the_worst_flight_and_the_command_flies_it_again(tmp_path, command):
    tables = {**CAPTURE, "name": "s", "flights": 2, "until_s": 5.0, "wind": {"turbulence": "moderate"}}
    peaks = [max(-sim.fly(sim.prepare(sim.read(tables)), k).state.velocity_up) for k in range(2)]
    second, worst = sorted(peaks)
    number = peaks.index(worst)
    check = {"metric": "sink_mps", "max": float(second + worst) / 2}
    (tmp_path / "two.toml").write_text(dumps({**tables, "checks": [check]}))
    done = command("run", "two.toml", "-o", "o")
    assert done.returncode == 1
    again = f"shortfinal run o/scenario.toml --flight {number}"
    assert done.stdout.splitlines()[-2].endswith(again)
    page = (tmp_path / "o/report.html").read_text()
    assert f"This is the worst, flight {number}; also drawn:" in page
    assert re.findall(r'<p id="flight-(\d)">', page) == [str(1 - number)]
    assert len(page) < 3_000_000
    one = sim.run(tmp_path / "o/scenario.toml", flight=number).metrics["flight"]
    whole = json.loads((tmp_path / "o/metrics.json").read_text())
    assert one == {**whole["each_flight"][number]["metrics"], "navigated": None}
    assert whole["flight"] == {**whole["each_flight"][0]["metrics"], "navigated": None}
    with np.load(tmp_path / "o/flight.npz") as arrays:  # of flight 0
        assert max(-arrays["velocity_up_mps"]) == peaks[0]


def test_figures_of_trackers_are_over_all_flights():
    result = sim.run({"name": "s", "flights": FLIGHTS, **TABLES})
    each = [record["metrics"]["trackers"]["plain"]["overall"]["position_m"] for record in result.metrics["each_flight"]]
    pooled = result.metrics["trackers"]["plain"]["overall"]["position_m"]
    assert pooled["rmse"] == pytest.approx(np.sqrt(np.mean([one["rmse"] ** 2 for one in each])))
    assert pooled["raw"] == pytest.approx(np.sqrt(np.mean([one["raw"] ** 2 for one in each])))
    assert pooled["low"] < pooled["rmse"] < pooled["high"]
    spread = result.metrics["flights_summary"]["trackers.plain.overall.position_m.rmse"]
    assert (spread["n"], spread["p50"]) == (FLIGHTS, pytest.approx(np.median([one["rmse"] for one in each])))
    assert result.metrics["flight"]["bank_max_deg"] == result.metrics["each_flight"][0]["metrics"]["bank_max_deg"]


def test_one_flight_has_no_table_of_flights_and_no_spread():
    metrics = sim.run({"name": "s", **TABLES}).metrics
    assert "each_flight" not in metrics
    assert set(metrics["flights_summary"]["bank_max_deg"]) == {"p5", "p50", "p95"}
    assert not [name for name in metrics["flights_summary"] if name.startswith("trackers.")]


LISTED = "autopilot.roll_rate_limit_degps"
DRAWN = {
    **CAPTURE,
    "name": "drawn",
    "until_s": 20.0,
    "start": {"leg": 0, "cross_track_m": 1500.0},  # from where the limit of the cross-track decides, which is a gain
    "flights": 2,
    "wind": {"turbulence": "light"},
    "checks": [{"metric": "bank_deg", "max": 1.0}],
    "study": {
        "samples": 3,
        "axes": {
            LISTED: [4, 6],
            "wind.speed_mps": {"uniform": [0, 9]},
            "autopilot.bank_limit_deg": {"normal": [15, 2]},
        },
    },
}


def test_a_row_of_a_study_is_flown_again_with_its_drawn_values_and_the_gains_of_its_cell(tmp_path, inline):
    metrics = studies.study(DRAWN, tmp_path, inline())
    records = [json.loads(line) for line in (tmp_path / "flights.jsonl").read_text().splitlines()]
    planned = plan(sim.read(DRAWN))
    tables = designed_cells(planned)
    for record in (records[1], records[-2]):
        chosen = {LISTED: record["values"][LISTED]}
        again = sim.run(tmp_path / "scenario.toml", overrides=chosen, flight=record["flight"])
        drawn = planned.samples[record["sample"]]
        flown = sim.fly(prepared_from(json.dumps(with_values(tables[record["cell"]], drawn)), ()), record["flight"])
        for ours, theirs in zip(again.flight.state, flown.state, strict=True):
            assert ours.tobytes() == theirs.tobytes()
        assert {**again.metrics["flight"]} == {**record["metrics"], "navigated": None}
    (check,) = metrics["checks"]
    said = broken(check, metrics, run_again("f"))
    chosen = check["at"][LISTED]
    assert said.endswith(f": shortfinal run f --set {LISTED}={chosen} --flight {check['flight']}")


@pytest.mark.parametrize(
    ("flight", "more", "said"),
    [
        (6, {}, "drawn: flight: there are flights 0 to 5, not 6"),
        (-1, {}, "drawn: flight: there are flights 0 to 5, not -1"),
        (2, {"study": None}, "drawn: flight: there are flights 0 to 1, not 2"),
    ],
)
def test_a_flight_that_there_is_not(flight, more, said):
    with pytest.raises(sim.ScenarioError) as caught:
        sim.run({**DRAWN, **more}, flight=flight)
    assert str(caught.value) == said


def test_a_run_of_a_study_says_that_it_is_not_the_study():
    result = sim.run(DRAWN)
    assert result.metrics["flights"] == 2
    assert any("not about its [study]" in warning for warning in result.metrics["warnings"])
    shares = [{"metric": "bank_deg", "max": 90.0, "share": 0.5, "confidence": 0.9}]
    with pytest.raises(sim.ScenarioError, match=r"needs at least 4 flights, there are 2.*; 'study' flies its"):
        sim.run({**DRAWN, "checks": shares})
    assert sim.run({**DRAWN, "checks": shares}, flight=5).metrics["checks"][0]["share_low"] is None


def test_a_flight_that_cannot_be_flown_fails_every_check(monkeypatch):
    fly = sim.experiment.fly

    def some(prepared, number=0):
        if number in (0, 3):
            raise sim.ScenarioError("s: no luck")
        return fly(prepared, number)

    monkeypatch.setattr("sim.experiment.fly", some)
    tables = {"name": "s", "flights": 5, **TABLES, "checks": [{"metric": "bank_deg", "max": 90.0}]}
    result = sim.run(tables)
    assert result.metrics["flights_summary"]["outcomes"] == {"crashed": 2, "completed": 3}
    (check,) = result.metrics["checks"]
    assert (check["passed"], check["within"], check["outcome"]) == (False, 3, "crashed")
    assert result.number == 1
    assert "3 of 5 flights keep it; the flight crashed, limit 90 deg" in result.broken[0]
    with pytest.raises(sim.ScenarioError, match="no luck"):
        sim.run(tables, flights=1)
