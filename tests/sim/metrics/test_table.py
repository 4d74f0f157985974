"""The contract of a metric over the whole table, and one row more that everything follows."""

from __future__ import annotations

import csv
import dataclasses
import importlib.util
import json
import math
import re
from pathlib import Path

import numpy as np
import pytest

import sim
from aircraft.units import SUFFIXES
from autopilot.route import Leg, Route
from sim.cli.exporting.spreadsheet import export_spreadsheet
from sim.flight.outcomes import STOPPED
from sim.metrics import signals, table
from sim.metrics.checks import unknown_names, with_names
from sim.metrics.ensemble.spread import summary
from sim.metrics.figures import Context, Navigation
from sim.metrics.flight import figure, flight_metrics, navigated_figures
from sim.reporting.text.header import first_screen
from sim.reporting.text.rows import check_name, check_row, scalar_rows, spread_rows
from sim.scenario.editors.json_schema import schema
from sim.scenario.tables import Check, Runway
from sim.studies import study as studies
from tests.sim.one_flight import judged

EXAMPLE = Path(__file__).resolve().parents[2] / "parts" / "metric_row.py"
CONTEXT = Context(Runway(), math.radians(15.0), Navigation(12.0, 1.5, 4.0, 90.0), stall_speed=50.0)
PATTERN = {
    "name": "final",
    "draws": 1,
    "aircraft": {"model": "point_mass"},
    "start": {"phase": "final", "distance_m": 9000.0, "cross_track_m": 30.0},
}


def approach(make_flight):
    """Down to the ground with a swinging bank, so that every row has something to say."""
    time = np.arange(0.0, 130.0, 1 / 30)
    north = -7000.0 + 58.0 * time
    phase = np.where(north < 250.0, "glide", np.where(north < 400.0, "flare", "ground"))
    height = np.maximum((Runway().aiming_point - north) * math.tan(Runway().glide_path), 0.0)
    between = (-4000.0, 0.0)
    legs = Leg((-50000.0, 0.0), between, 70.0, 400.0), Leg(between, (300.0, 0.0), 70.0, 400.0)
    flight = make_flight(
        time,
        phase.tolist(),
        route=Route(legs),
        north=north,
        east=20.0 * np.exp(-time / 20.0) * np.cos(time / 3.0),
        height=height,
        bank=math.radians(3.0) * np.sin(time / 2.0),
        main_wheels=(north >= 400.0).astype(float),
        specific_force_down=np.full(len(time), -9.8),
    )
    rolling = np.arange(0.0, 20.0, 1 / 30)
    rollout = make_flight(
        time[-1] + 1 / 30 + rolling,
        ["ground"] * len(rolling),
        north=north[-1] + 58.0 * rolling * (1.0 - rolling / 40.0),
        east=np.cos(rolling),
        velocity_north=58.0 * (1.0 - rolling / 20.0),
    )
    rollout = dataclasses.replace(rollout, outcome=STOPPED)
    return dataclasses.replace(flight, leg=(north > between[0]).astype(int), rollout=rollout)


@pytest.mark.parametrize("row", table.METRICS, ids=lambda row: row.name)
def test_a_row_keeps_its_contract(row, make_flight):
    assert re.fullmatch(r"([a-z]+\.)?[a-z][a-z0-9_]*", row.name)
    assert row.unit == "" or (row.unit in SUFFIXES and row.name.endswith(f"_{row.unit}"))
    assert row.label
    assert "_" not in row.label
    assert 0 <= row.digits <= 6
    found = row.of(approach(make_flight), CONTEXT)
    assert found is not None
    assert math.isfinite(found)
    for phase in ("final", "glide", "flare", "ground", "go_around"):  # the shortest flights that there are
        short = row.of(make_flight(np.array([0.0]), [phase]), Context(Runway(), 0.2))
        assert short is None or not math.isinf(short)


@pytest.mark.parametrize("row", signals.SIGNALS, ids=lambda row: row.name)
def test_a_signal_keeps_its_contract(row, make_flight):
    assert row.name.endswith(f"_{row.unit}")
    assert row.label
    assert "_" not in row.label
    flight = approach(make_flight)
    values = row.of(flight, Runway())
    assert values.shape == flight.time.shape
    assert np.isfinite(values).any()
    assert unknown_names({"checks": [{"metric": row.name}]}) == []
    (result,) = judged((Check(row.name, max=1e9),), flight, Runway(), {})
    assert (result["unit"], result["passed"], check_name(result)) == (row.unit, True, row.label)


def test_names_and_labels_are_unique():
    for column in ("name", "label"):
        values = [getattr(row, column) for row in (*table.METRICS, *signals.SIGNALS)]
        assert sorted(values) == sorted(set(values))


@pytest.mark.parametrize("row", table.METRICS, ids=lambda row: row.name)
def test_a_row_stands_in_metrics_and_is_accepted_by_checks_and_labelled(row, make_flight):
    flight = approach(make_flight)
    figures = flight_metrics(flight, *CONTEXT[:2], CONTEXT.stall_speed)
    figures["navigated"] = navigated_figures(flight, CONTEXT)
    assert figure(figures, row.name) == pytest.approx(float(row.of(flight, CONTEXT)))
    assert unknown_names({"checks": [{"metric": row.name}]}) == []
    (result,) = judged((Check(row.name, max=1e9),), flight, Runway(), figures)
    assert (result["unit"], result["passed"], check_name(result)) == (row.unit, True, row.label)
    if row.name != "landed" and not row.name.startswith("navigated."):  # said by the outcome, and by a table of its own
        assert row.label in [label for label, *_ in scalar_rows(figures)]
        assert row.label in [label for label, *_ in spread_rows(summary([{"metrics": figures}] * 2))]


def test_what_is_not_finite_is_absent(make_flight, monkeypatch):
    values = {"a_m": math.nan, "b_m": math.inf, "nested.c_m": -math.inf, "nested.d_m": None}
    rows = [table.Metric(name, "m", name, lambda flight, context, v=v: v, 1) for name, v in values.items()]
    monkeypatch.setattr(table, "METRICS", tuple(rows))
    found = flight_metrics(approach(make_flight), Runway(), 0.2)
    assert found == {"outcome": "completed", "reason": "", "a_m": None, "b_m": None, "nested": None}


def test_one_row_more_is_in_run_checks_study_report_and_export(monkeypatch, tmp_path, inline):
    """No file but the table knows of it: only the table is changed here."""
    spec = importlib.util.spec_from_file_location("metric_row", EXAMPLE)
    example = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(example)
    row = example.ROW
    with pytest.raises(sim.ScenarioError, match="no metric 'wings_level_s'"):
        sim.read({**PATTERN, "checks": [{"metric": row.name, "min": 1.0}]})
    monkeypatch.setattr(table, "METRICS", (*table.METRICS, row._replace(headline=True)))

    parts = with_names(schema())["$defs"]
    assert row.name in parts["Check"]["properties"]["metric"]["examples"]
    result = sim.run({**PATTERN, "checks": [{"metric": row.name, "min": 1.0}]}, flights=2)
    value = result.metrics["flight"][row.name]
    assert 1.0 < value < result.metrics["flight"]["duration_s"]
    (check,) = result.metrics["checks"]
    assert (check["value"], check["unit"], check["passed"]) == (value, "s", True)
    assert result.metrics["flights_summary"][row.name]["p50"] == pytest.approx(value)
    shown = (row.label, f"{value:.1f}", "s")
    monkeypatch.setattr("sim.reporting.text.header.MOST_FIGURES", 99)  # it is behind the first six
    assert shown in first_screen(result.scenario, result.flight, result.metrics, [])["key_figures"]
    assert shown in scalar_rows(result.metrics["flight"])
    assert check_row(result.scenario.checks[0], check)["name"] == row.label
    assert (row.label, "s") in [line[:2] for line in spread_rows(result.metrics["flights_summary"])]

    axes = {"axes": {"start.cross_track_m": [0.0, 30.0]}, "show": [row.name]}
    checks = [{"metric": row.name, "max": 1.0, "share": 0.5, "confidence": 0.5}]
    metrics = studies.study({**PATTERN, "study": axes, "checks": checks}, tmp_path / "study", inline())
    straight, aside = (one[row.name]["p50"] for one in metrics["rows"])
    assert (aside, straight > aside) == (pytest.approx(value), True)
    assert (metrics["checks"][0]["unit"], metrics["checks"][0]["passed"]) == ("s", False)
    assert f"{row.label}, s" in (tmp_path / "study" / "report.html").read_text()
    (table_of_flights,) = export_spreadsheet(tmp_path / "study").files
    with table_of_flights.open() as file:
        assert [float(line[row.name]) for line in csv.DictReader(file)] == [straight, aside]
    assert row.name in json.loads((tmp_path / "study" / "metrics.json").read_text())["rows"][0]
