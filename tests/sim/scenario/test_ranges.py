"""No key takes a number that overflows what is computed with it: every numeric key of every kind refuses such sizes."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest
from pydantic import ValidationError

from aircraft.ranges import Range, shown
from aircraft.units import MAGNITUDES, SUFFIXES
from sim.errors import ScenarioError
from sim.estimation.setup import check
from sim.experiment import read
from sim.flight.preparation import prepare
from sim.scenario import catalogue, tables
from sim.scenario.arrivals.navigation import NavigationErrors
from sim.scenario.arrivals.vectored import SpeedTable, VectoredTable, VectorTable
from sim.scenario.parameters import JSON_LIMITS, model_of, parameters
from tests.capture import CAPTURE

TABLES = [getattr(tables, name) for name in ("Runway", "AirTable", "Start", "PatternTable", "AutopilotTable", "Check")]
TABLES += [VectoredTable, VectorTable, SpeedTable, NavigationErrors]
KINDS = [
    catalogue.load(family, kind)
    for family in ("sensors", "trackers", "modes", "wind_events")
    for kind in catalogue.kinds(family)
]


def test_every_unit_has_its_range():
    assert {unit for unit, _ in SUFFIXES.values()} == set(MAGNITUDES)


@pytest.mark.parametrize("cls", [*TABLES, *KINDS], ids=lambda cls: cls.__name__)
def test_numbers_beyond_every_size_are_refused(cls):
    model, tried = model_of(cls, partial=True), 0
    numbers = (float, float | None, int, int | None)
    for parameter in parameters(cls):
        for key in parameter.keys if parameter.kind in numbers else ():
            whole = parameter.kind in (int, int | None)
            for value in (10**400, -(10**12)) if whole else (1e200, -1e200, 1e-200):
                with pytest.raises(ValidationError) as refused:
                    model.model_validate({key: value})
                assert any(fault["loc"][:1] == (key,) for fault in refused.value.errors())
                tried += 1
    assert tried or not [parameter for parameter in parameters(cls) if parameter.kind in numbers]


@pytest.mark.parametrize("cls", [*TABLES, *KINDS], ids=lambda cls: cls.__name__)
def test_defaults_can_be_written_into_a_file(cls):
    """As the resolved scenario does."""
    for parameter in parameters(cls):
        if isinstance(parameter.default, int | float) and not isinstance(parameter.default, bool):
            key, factor = next(iter(parameter.keys.items()))
            value = parameter.default / factor if parameter.kind in (float, float | None) else parameter.default
            assert not faults_of_key(model_of(cls, partial=True), key, value)


def faults_of_key(model, key, value):
    try:
        model.model_validate({key: value})
    except ValidationError as refused:
        return [fault for fault in refused.errors() if fault["loc"][:1] == (key,)]
    return []


@pytest.mark.parametrize(
    ("changes", "said"),
    [
        ({"sensors.radar.position_sigma_m": 1e-200}, "[sensors.radar] position_sigma_m: must be 0 or at least 1e-06"),
        ({"sensors.radar.position_sigma_ft": 1e200}, "[sensors.radar] position_sigma_ft: must be at most 3.28e+07"),
        (
            {"checks": [{"metric": "bank_deg", "max": 1, "for_s": 1e308}]},
            "[[checks]] entry 0 for_s: must be at most 1e+09",
        ),
        (
            {"checks": [{"metric": "bank_deg", "max": 1, "during": []}]},
            "an empty 'during': name a phase, or leave it out",
        ),
        ({"trackers.it.sub_step_s": 1e-4}, "[trackers.it] sub_step must be at least 0.01 s"),
    ],
)
def test_the_sentence_names_key_and_limit_in_the_unit_of_the_file(changes, said):
    sensors = {"radar": {"kind": "surveillance_radar", "period_s": 2}}
    base = {**CAPTURE, "sensors": sensors, "trackers": {"it": {"kind": "saturated_control"}}}
    with pytest.raises(ScenarioError) as refused:
        check(prepare(read(base, changes)))
    assert said in str(refused.value)


@pytest.mark.parametrize("cls", [*TABLES, *KINDS], ids=lambda cls: cls.__name__)
def test_a_range_is_kept_by_what_reads_told_by_what_documents_and_required_by_the_schema(cls):
    """Of every spelling of every parameter with a range: one note on its field says all."""
    model = model_of(cls, partial=True)
    written = model.model_json_schema()["properties"]
    for parameter in parameters(cls):
        numeric = parameter.kind in (float, float | None, int, int | None) or parameter.kind is Any
        for key, factor in parameter.keys.items() if parameter.range is not None and numeric else ():
            schema = next(one for one in (written[key], *written[key].get("anyOf", ())) if one.get("type"))
            assert parameter.range.words(factor) in written[key]["description"]
            for name, told, limit in parameter.range.limits(factor):
                assert schema[JSON_LIMITS[name]] == limit
                beyond = limit + (1 if name in ("below", "most") else -1) * (1 + abs(limit) / 1000)
                whole = round if parameter.kind in (int, int | None) else float
                (fault,) = faults_of_key(model, key, whole(beyond))
                assert f"must be {told} {shown(limit)}" in fault["msg"]
                assert bool(faults_of_key(model, key, whole(limit))) == (name in ("above", "below"))


def test_a_range_has_its_reason_and_every_number_of_an_array_keeps_it():
    assert Range(above=0.0, why="a flight starts above the ground").fault(-3) == (
        "must be above 0: a flight starts above the ground"
    )
    assert Range(least=0.0, most=1.0).fault(np.array([0.0, 1.0])) is None
    assert Range(least=0.0, most=1.0).fault(np.array([0.0, 1.1])) == "must be at most 1"
    assert Range(below=2.0).fault(math.nan) == "must be below 2"
    assert Range(most=100.0).fault(194.38444924406, 1852 / 3600) is None  # 100 m/s, as its unit rounds
    assert (shown(1e6), shown(0.01)) == ("1000000", "0.01")
