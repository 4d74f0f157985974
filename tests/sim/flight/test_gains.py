"""Gains that travel in [designed]: used for what they were designed for, designed anew for anything else, or frozen."""

from __future__ import annotations

import tomllib

import pytest

from sim.errors import ScenarioError
from sim.experiment import read
from sim.flight.preparation import prepare
from sim.flight.preparing import loops
from sim.scenario.toml_writer import dumps

BASE = {"aircraft.centre_of_gravity_mac": 0.24, "aircraft.factors.drag": 1.0, "aircraft.mass_kg": 20000.0}


@pytest.fixture(scope="module")
def carried():
    """The tables of a run's own scenario.toml, through its text."""
    prepared = prepare(read("an26_pattern", BASE))
    return tomllib.loads(dumps({**prepared.scenario.tables, "designed": prepared.gains.to_table()}))


def designs(monkeypatch, tables, changes):
    """(whether a design was made, the preparation)."""
    made = []
    real = loops.designed
    monkeypatch.setattr(loops, "designed", lambda **told: made.append(told) or real(**told))
    prepared = prepare(read(tables, changes))
    return bool(made), prepared


@pytest.mark.parametrize(
    ("address", "value", "input_"),
    [
        ("autopilot.bank_limit_deg", 20.0, "bank_limit"),
        ("autopilot.estimate_lag_s", 1.0, "estimate_lag"),
        ("aircraft.mass_kg", 18000.0, "choice.mass"),
        ("aircraft.centre_of_gravity_mac", 0.2, "choice.centre_of_gravity_mac"),
        ("aircraft.factors.drag", 1.1, "choice.factors.drag"),
        ("aircraft.factors.lift_slope", 0.95, "choice.factors.lift_slope"),
        ("runway.elevation_m", 500.0, "choice.runway.elevation"),
        ("route.height_m", 500.0, "height"),
        ("route.downwind_speed_mps", 74.0, "speed"),
        ("route.turn_speed_mps", 70.0, "configurations.1.fastest"),
        ("route.approach_speed_mps", 60.0, "configurations.0.slowest"),
    ],
)
def test_each_input_of_the_design_brings_a_new_one_and_a_remark(monkeypatch, carried, address, value, input_):
    anew, prepared = designs(monkeypatch, carried, {address: value})
    assert anew
    assert prepared.warnings[0].startswith("the gains of [designed] were made for other inputs (")
    assert input_ in prepared.warnings[0]


def test_gains_designed_anew_are_those_without_the_table(carried):
    changes = {"autopilot.bank_limit_deg": 20.0, "autopilot.estimate_lag_s": 1.0}
    plain = prepare(read({k: v for k, v in carried.items() if k != "designed"}, changes))
    assert prepare(read(carried, changes)).gains.to_table() == plain.gains.to_table()
    assert not plain.warnings


@pytest.mark.parametrize(
    ("address", "value"),
    [
        ("seed", 7),
        ("wind.speed_mps", 5.0),
        ("start.cross_track_m", 50.0),
        ("runway.heading_deg", 10.0),
        ("autopilot.frequency_share", 0.1),
        ("sensors", {}),
        ("trackers", {}),
    ],
)
def test_what_is_no_input_of_the_design_keeps_its_gains(monkeypatch, carried, address, value):
    anew, prepared = designs(monkeypatch, carried, {"trackers": {}, address: value})
    assert not anew
    assert prepared.gains.to_table() == carried["designed"]
    assert not prepared.warnings


def test_another_aircraft_or_a_changed_model_is_designed_anew(monkeypatch, carried):
    monkeypatch.setattr(loops, "digest", lambda model: "another content")
    anew, prepared = designs(monkeypatch, carried, {})
    assert anew
    assert "choice.model" in prepared.warnings[0]


def test_a_table_without_inputs_is_frozen(monkeypatch, carried):
    frozen = {key: value for key, value in carried["designed"].items() if key != "inputs"}
    anew, prepared = designs(monkeypatch, {**carried, "designed": frozen}, {"autopilot.bank_limit_deg": 20.0})
    assert not anew
    assert prepared.gains.to_table() == frozen


def test_point_mass_has_inputs_of_its_own(carried):
    line = {"kind": "legs", "legs": [{"from_m": [0, 0], "to_m": [9000, 0], "speed_mps": 72.0, "height_m": 400}]}
    tables = {"name": "line", "aircraft": {"model": "point_mass"}, "start": {"leg": 0}, "route": line}
    first = prepare(read(tables))
    table = {**tables, "designed": first.gains.to_table()}
    assert prepare(read(table)).gains == first.gains
    other = prepare(read(table, {"autopilot.bank_limit_deg": 20.0}))
    assert "(bank_limit)" in other.warnings[0]
    changed = prepare(read({**table, "aircraft": {"model": "an26"}}))
    assert "choice.model" in changed.warnings[0]


def test_inputs_that_are_no_table_are_a_sentence(carried):
    with pytest.raises(ScenarioError, match=r"\[designed\] inputs must be a table; take \[designed\] out"):
        prepare(read({**carried, "designed": {**carried["designed"], "inputs": 3}}))
