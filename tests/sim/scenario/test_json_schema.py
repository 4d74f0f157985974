"""The JSON Schema: whatever we fly is valid, and of what we refuse all that a schema can say. Judge: jsonschema."""

from __future__ import annotations

import tomllib

import pytest
from jsonschema import Draft202012Validator

from sim.cli.commands.options import overrides_of
from sim.errors import ScenarioError
from sim.metrics.checks import with_names
from sim.scenario import catalogue
from sim.scenario.editors.json_schema import schema
from sim.scenario.reading import override
from tests.hostile.command_lines import VALUES
from tests.hostile.scenario_base import CAPTURE
from tests.hostile.scenarios import SCENARIOS
from tests.sim.scenario import test_scenario_errors

SCHEMA = with_names(schema())
VALIDATOR = Draft202012Validator(SCHEMA)

BEYOND_A_SCHEMA = {  # what of the hostile files and values no schema can refuse, and why
    "the text itself, of which a schema sees the tables alone": ("too_large",),
    "one key by another": (
        "legs_that_do_not_join", "route.legs.0.to_m=[0,0]", "start.phase=base", "checks=[{metric='bank_deg',max=1,min=",
        "checks=[{metric='bank_deg',max=1,share=0.9}", "checks=[{metric='bank_deg',max=1,confidence=0.9}",
        "checks=[{metric='bank_deg',max=1,probability_max=1e-9",
        "study={axes={'wind.speed_mps'={uniform=[0,1]}},samples",
    ),
    "names that the file itself gives": (
        "autopilot.navigation=nobody", "trackers.steady.sensors=['x']", "trackers.steady.handover=steady",
        "sensors={}", "checks=[{metric='trackers.nobody", "start.leg=7", "trackers.steady.law.k1=3",
    ),
    "files, and aircraft that are there or not": (
        "aircraft_that_leaves", "aircraft.model=", "aircraft={model='an26'", "aircraft.factors.zzz",
        "aircraft.centre_of_gravity_mac=7",
    ),
    "what a design needs, and whether it flies": (
        "design_of_nonsense", "designed={}", "autopilot.law.k1_deg_per_m=1e3",
    ),
    "numbers that JSON does not have": (
        "wind.speed_mps=nan", "aircraft.mass_kg=nan", "study={axes={'wind.speed_mps'=[nan]}}",
    ),
    "1.0, which is a whole number to a schema": ("seed=1.0",),
    "categories of Unicode, which its patterns cannot name": (
        'checks=[{metric="bank_deg",max=1,name="a\\u001b', 'checks=[{metric="bank_deg",max=1,source="a\\nbank',
    ),
}  # fmt: skip


def beyond(case: str) -> bool:
    told = any(case.startswith(start) for starts in BEYOND_A_SCHEMA.values() for start in starts)
    return told and case != "aircraft.model=3"  # a number is no name


def tables_of(text: str | bytes) -> dict[str, object] | None:
    """The tables of a file; None where it is no TOML, of which no schema knows."""
    try:
        return tomllib.loads(text if isinstance(text, str) else text.decode())
    except (ValueError, RecursionError):
        return None


def with_value(value: str) -> dict[str, object] | None:
    """The shortest scenario with a value of ``--set``; None where that is no value at all."""
    tables = tomllib.loads(CAPTURE)
    try:
        for address, given in overrides_of([value]).items():
            tables = override(tables, address, given)
    except ScenarioError:
        return None
    return tables


def test_it_is_a_schema():
    Draft202012Validator.check_schema(SCHEMA)


@pytest.mark.parametrize("name", [*catalogue.scenarios(), *catalogue.studies()])
def test_every_bundled_file_is_valid(name):
    tables = tomllib.loads(catalogue.bundled(name).read_text(encoding="utf-8"))
    assert [f"{fault.json_path}: {fault.message}" for fault in VALIDATOR.iter_errors(tables)] == []


@pytest.mark.parametrize("every", [4, pytest.param(1, marks=pytest.mark.soak)])
def test_what_is_refused_is_refused_by_the_schema_where_a_schema_can(every):
    slow = () if every == 1 else ("deep_key",)  # tomllib takes seconds for it
    cases = {name: tables_of(text) for name, (text, _) in [*SCENARIOS.items()][::every] if name not in slow}
    cases |= {value: with_value(value) for value, _ in VALUES[::every]}
    known = {case: tables for case, tables in cases.items() if tables is not None}
    passed = [case for case, tables in known.items() if VALIDATOR.is_valid(tables)]
    assert [case for case in passed if not beyond(case)] == []
    assert [case for case in known if beyond(case) and case not in passed] == []
    assert len(known) - len(passed) > 100 // every


def test_the_faults_that_have_a_sentence_are_faults_of_the_schema():
    """But for relations between keys, and a name of the file itself."""
    relations = ("not both", "no tracker 'radar'", "needs 'max' or 'min'")
    cases = test_scenario_errors.test_each_fault_is_one_clear_sentence.pytestmark[0].args[1]
    for table, content, said in cases:
        tables = {**test_scenario_errors.GOOD, table: content}
        assert VALIDATOR.is_valid(tables) == said.endswith(relations), (table, content)


@pytest.mark.parametrize(
    ("change", "said"),
    [
        ({"trackers": {"a": {"kind": "immm"}}}, "'immm' is not one of ['autonomous_models', "),
        ({"sensors": {"a": {"kind": "radar"}}}, "'radar' is not one of ['adsb', "),
        ({"wind": {"events": {"a": {"kind": "gusts"}}}}, "'gusts' is not one of ['gust', 'microburst', 'wind_shift']"),
        ({"autopilot": {"kind": "lnav"}}, "'lnav' is not one of ['lateral_navigation', 'radio_beacon']"),
        ({"route": {"kind": "leg"}}, "'leg' is not one of ['legs', 'pattern', 'vectored']"),
        ({"wind": {"speed_kt": 400}}, "400 is greater than the maximum of 194.384449244"),
        ({"start": {"height_ft": 0}}, "0 is less than or equal to the minimum of 0"),
        ({"study": {"axes": {"wind.speed_mps": {"gird": [0, 1, 2]}}}}, "('gird' was unexpected)"),
    ],
)
def test_one_slip_is_one_fault_that_says_what_there_is(change, said):
    (fault,) = VALIDATOR.iter_errors({"name": "mine", **change})
    assert said in fault.message


@pytest.mark.parametrize("law", [{}, {"k1_deg_per_m": 0.05, "cross_track_limit_m": 500.0}])
def test_a_table_without_a_kind_is_of_the_kind_that_files_mean(law):
    assert VALIDATOR.is_valid({"autopilot": {"bank_limit_deg": 20, "law": law}, "route": {"side": "left"}})
    assert not VALIDATOR.is_valid({"autopilot": {"law": {"k3": 1.0}}})


def test_the_schema_has_no_kind_that_the_catalogue_has_not():
    for family, place in (("sensors", "sensors"), ("trackers", "trackers")):
        told = SCHEMA["properties"][place]["additionalProperties"]["properties"]["kind"]["enum"]
        assert told == catalogue.kinds(family)
