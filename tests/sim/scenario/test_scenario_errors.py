"""Every fault of a file is told at once, in the user's own keys."""

from __future__ import annotations

import contextlib
import math

import pytest
from hypothesis import given
from hypothesis import strategies as st

from sim.errors import ScenarioError
from sim.scenario import schema
from sim.scenario.reading import override, read
from tests.capture import CAPTURE

GOOD = {**CAPTURE, "start": {"leg": 0, "cross_track_m": 3000}}


def faults(**tables: object) -> str:
    with pytest.raises(ScenarioError) as caught:
        read({**GOOD, **tables})
    return str(caught.value)


@pytest.mark.parametrize("content", ["", "\n", "# a remark\n", "\ufeff"])
def test_a_file_that_says_nothing_is_refused(tmp_path, content):
    file = tmp_path / "empty.toml"
    file.write_text(content, encoding="utf-8")
    with pytest.raises(ScenarioError, match=r"empty\.toml: says nothing; 'shortfinal new FILE\.toml' writes"):
        read(file)


def test_names_that_mean_something_already_are_refused():
    radar = {"radar": {"kind": "surveillance_radar"}}
    said = faults(sensors=radar, trackers={"truth": {"kind": "kalman"}})
    assert said == "scenario: [trackers.truth]: 'truth' is the motion itself, as [autopilot] navigation has it; " + (
        "choose another name"
    )


def test_files_that_differ_in_numbers_share_their_model():
    """Making one takes a hundred times as long as reading by it."""

    def tables(number):
        radar = {"radar": {"kind": "surveillance_radar", "position_sigma_m": 50.0 + number}}
        return {**GOOD, "sensors": radar, "trackers": {"plain": {"kind": "kalman"}}, "wind": {"speed_mps": number}}

    read(tables(0))
    makers = (schema.file_model, schema._table_model, schema.wind_model, schema._tracker_model)
    before = [maker.cache_info().misses for maker in makers]
    for number in range(1, 20):
        read(tables(number))
    assert [maker.cache_info().misses for maker in makers] == before
    read({**tables(0), "trackers": {"other": {"kind": "kalman"}}})
    assert schema.file_model.cache_info().misses == before[0] + 1


def test_a_misspelt_key_gets_a_suggestion():
    assert "[start] cross_trak_m: no such key; did you mean 'cross_track_m'?" in faults(start={"cross_trak_m": 3})


def test_a_wrong_unit_is_answered_with_the_legal_spellings():
    assert "speed_kmph: no such key" in faults(wind={"speed_kmph": 3})
    assert "it needs its unit: speed_mps" in faults(wind={"speed": 3})


def test_two_spellings_of_one_value_are_refused():
    assert "'speed_mps' and 'speed_kt' are two spellings of one value" in faults(wind={"speed_mps": 3, "speed_kt": 6})


@pytest.mark.parametrize("kind", ["route_control", "law_ekf"])
def test_a_kind_of_before_is_answered_with_what_to_write_now(kind):
    radar = {"radar": {"kind": "surveillance_radar"}}
    told = faults(sensors=radar, trackers={"t": {"kind": kind, "covariance": "known_control"}})
    assert told.startswith(f"scenario: [trackers.t] kind: no kind '{kind}'; write kind = \"saturated_control\"")
    assert 'covariance = "jacobian"' in told
    assert "\n" not in told
    form = {"kind": "saturated_control", "covariance": "known_control"}
    assert "[trackers.t] covariance: must be 'paper' or 'jacobian'" in faults(sensors=radar, trackers={"t": form})


@pytest.mark.parametrize("value", [math.nan, math.inf, -math.inf])
def test_numbers_must_be_finite(value):
    assert "must be a finite number" in faults(aircraft={"mass_kg": value})


@pytest.mark.parametrize(
    ("table", "content", "said"),
    [
        ("aircraft", {"mass_kg": -20000.0}, "[aircraft] mass_kg: must be above 0 (got -20000.0)"),
        ("aircraft", {"factors": {"lift_slope": 0.0}}, "[aircraft.factors] lift_slope: must be above 0 (got 0.0)"),
        ("start", {"height_m": -5.0}, "a flight starts above the ground"),
        ("start", {"leg": 0, "phase": "base"}, "say 'phase' (pattern) or 'leg' (legs), not both"),
        ("wind", {"turbulence": "strong"}, "'none', 'light', 'moderate', 'severe' or 'by_wind'"),
        ("wind", {"turbulence": "light", "w20_kt": 20.0}, "say 'turbulence' or 'w20_kt', not both"),
        ("autopilot", {"bank_limit_deg": 90.0}, "bank_limit_deg: must be at most 60 (got 90.0)"),
        ("autopilot", {"kind": "lateral_navigatoin"}, "did you mean 'lateral_navigation'?"),
        ("autopilot", {"navigation": "radar"}, "[autopilot] navigation: no tracker 'radar'"),
        ("route", {"kind": "legs", "legs": []}, "[route] legs: must not be empty: give at least one"),
        ("sensors", {"radar": {"kind": "surveilance_radar"}}, "did you mean 'surveillance_radar'?"),
        (
            "sensors",
            {"radar": {"kind": "surveillance_radar", "period_s": 0.0}},
            "[sensors.radar] period_s: must be at least 0.00833333: the flight is not known in steps finer",
        ),
        ("sensors", {"radar": {}}, "[sensors.radar] kind: is missing"),
        ("checks", [{"metric": "bank_deg"}], "[[checks]] entry 0 the check of 'bank_deg' needs 'max' or 'min'"),
        ("seed", -1, "seed: must be at least 0 (got -1)"),
        ("seed", True, "seed: must be a whole number"),
        ("colour", "red", "colour: no such key"),
    ],
)
def test_each_fault_is_one_clear_sentence(table, content, said):
    assert said in faults(**{table: content})


def test_all_faults_come_at_once():
    told = faults(wind={"speed_kmph": 3}, aircraft={"mass_kg": math.nan}, seed=-1, autopilot={"kind": "x"})
    assert len(told.splitlines()) == 4


def test_a_tracker_must_name_a_sensor_that_exists():
    radar = {"radar": {"kind": "surveillance_radar"}}
    told = faults(sensors=radar, trackers={"cv": {"kind": "kalman", "sensors": ["radr"]}})
    assert "[trackers.cv] sensors: no sensor 'radr'; did you mean 'radar'?" in told
    assert "needs at least one sensor" in faults(trackers={"cv": {"kind": "kalman"}})


@pytest.mark.parametrize(
    ("content", "said"),
    [
        (b"name = 'a\n", "not TOML"),
        (b"name = 'caf\xe9'\n", "not UTF-8"),
        (b"x = " + b"[" * 20000, "not TOML"),
        (b"", "colour"),
    ],
)
def test_broken_files_are_told_by_name(tmp_path, content, said):
    file = tmp_path / "broken.toml"
    file.write_bytes(content or b"colour = 1")
    with pytest.raises(ScenarioError, match=said) as caught:
        read(file)
    assert "broken.toml" in str(caught.value)


def test_an_unknown_scenario_gets_a_suggestion():
    with pytest.raises(ScenarioError, match="did you mean 'an26_pattern'"):
        read("an26_patern")


def test_an_override_takes_the_other_spelling_out():
    tables = override({"wind": {"speed_kt": 10, "from_deg": 90}}, "wind.speed_mps", 8)
    assert tables == {"wind": {"from_deg": 90, "speed_mps": 8}}


def test_an_override_reaches_into_lists():
    scenario = read({**GOOD, "checks": [{"metric": "bank_deg", "max": 20}]}, {"checks.0.max": 25})
    assert scenario.checks[0].max == 25
    with pytest.raises(ScenarioError, match="entries 0 to 0"):
        read({**GOOD, "checks": [{"metric": "bank_deg", "max": 20}]}, {"checks.3.max": 25})


def test_units_become_si_and_radians():
    scenario = read({**GOOD, "wind": {"speed_kt": 10, "from_deg": 90}})
    assert scenario.wind.speed == pytest.approx(5.144444, abs=1e-6)  # 10 kt by the definition 1852 m / 3600 s
    assert scenario.wind.steady == pytest.approx((0, -5.144444), abs=1e-6)  # from the east, so it blows to the west


def test_the_resolved_file_reads_back_as_the_same_scenario():
    first = read(
        {**GOOD, "wind": {"speed_kt": 10, "from_deg": 200.1}, "sensors": {"r": {"kind": "surveillance_radar"}}}
    )
    assert read(first.tables) == first


def test_a_table_inside_a_table_is_read_and_checked():
    beam = {"snr_db": 5.4, "at_distance_m": 750, "floor_deg": 0.01}
    scenario = read({**GOOD, "sensors": {"mls": {"kind": "mls", "beam": beam}}})
    assert scenario.sensors["mls"].beam.floor == pytest.approx(math.radians(0.01))
    assert read(scenario.tables) == scenario
    told = faults(sensors={"mls": {"kind": "mls", "beam": {**beam, "snr": 3.0}}})
    assert "snr: no such key; it needs its unit: snr_db" in told


scalars = st.one_of(st.none(), st.booleans(), st.integers(), st.floats(), st.text(max_size=8))
values = st.recursive(
    scalars, lambda inner: st.lists(inner, max_size=3) | st.dictionaries(st.text(max_size=8), inner, max_size=3)
)


@given(
    table=st.sampled_from(
        ["runway", "aircraft", "start", "route", "autopilot", "wind", "sensors", "sensor_faults", "trackers", "checks"]
    ),
    content=values,
)
def test_any_content_is_read_or_answered_by_a_scenario_error(table, content):
    with contextlib.suppress(ScenarioError):  # anything else that escapes fails
        read({**GOOD, table: content})
