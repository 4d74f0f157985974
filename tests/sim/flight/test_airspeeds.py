"""Equivalent airspeeds carry the margins; each airspeed of a file has an indicated twin."""

import math

import pytest

from sim.errors import ScenarioError
from sim.experiment import run
from sim.flight.preparation import prepare
from sim.metrics.flight import flight_metrics
from sim.scenario.editors.json_schema import schema
from sim.scenario.reading import read
from sim.studies.plan import plan

LA_PAZ = {
    "name": "lapaz",
    "draws": 1,
    "runway": {"heading_deg": 80, "elevation_m": 4061},
    "aircraft": {"model": "an26", "mass_kg": 20000},
    "start": {"phase": "base"},
    "route": {"downwind_speed_mps": 72, "turn_speed_mps": 69, "approach_speed_mps": 58},
}
DENSITY = (1.0 - 0.0065 * 4458.0 / 288.15) ** 4.2559  # over that of sea level, 400 m above 4061 m, geopotential


def test_true_speeds_of_sea_level_are_refused_high_up_with_the_remedy():
    with pytest.raises(ScenarioError, match="indicated_turn_speed_mps") as told:
        prepare(read(LA_PAZ))
    assert "\n" not in str(told.value)
    raised = (1.3 * 41.3 + 2.5) / math.sqrt(DENSITY)
    assert f"approach {raised:.1f} m/s true" in str(told.value)
    assert f"turn {69.0 * math.sqrt(DENSITY):.1f}, approach {1.3 * 41.3 + 2.5:.1f} m/s" in str(told.value)


def test_a_slow_approach_is_raised_in_equivalent_airspeed_and_the_run_says_so():
    tables = {**LA_PAZ, "route": {"downwind_speed_mps": 88, "turn_speed_mps": 85, "approach_speed_mps": 58}}
    tables["route"] |= {"downwind_abeam_m": 11000, "base_distance_m": 18000}
    tables["aircraft"] = {"model": "an26", "mass_kg": 17000}
    prepared = prepare(read(tables))
    wanted = (1.3 * 41.3 * math.sqrt(0.85) + 2.5) / math.sqrt(DENSITY)
    assert prepared.autopilot.landing.approach_speed == pytest.approx(wanted, rel=1e-4)
    assert any(f"raised from 58.0 to {wanted:.1f} m/s true" in remark for remark in prepared.warnings)


def test_an_indicated_speed_is_the_true_one_where_it_is_flown():
    share = math.sqrt(DENSITY)
    charts = {"indicated_downwind_speed_kt": 140, "indicated_turn_speed_kmh": 250, "indicated_approach_speed_mps": 58}
    scenario = read({**LA_PAZ, "route": charts, "start": {"phase": "base", "indicated_speed_kt": 135}})
    knot = 1852.0 / 3600.0
    assert scenario.route.downwind_speed * share == pytest.approx(140 * knot, rel=1e-5)
    assert scenario.route.turn_speed * share == pytest.approx(250 / 3.6, rel=1e-5)
    assert scenario.route.approach_speed * share == pytest.approx(58.0, rel=1e-5)
    assert scenario.start.speed * share == pytest.approx(135 * knot, rel=1e-5)
    assert read(scenario.tables).route == scenario.route  # the resolved file keeps the user's own spelling
    assert scenario.tables["route"]["indicated_turn_speed_kmh"] == 250
    leg = {"from_m": [0, 0], "to_m": [9000, 0], "indicated_speed_kt": 140, "height_m": 400}
    legs = read({**LA_PAZ, "route": {"kind": "legs", "legs": [leg]}, "start": {"indicated_speed_mps": 70}})
    assert legs.route.legs[0].speed * share == pytest.approx(140 * knot, rel=1e-5)
    assert legs.start.speed * share == pytest.approx(70.0, rel=1e-5)
    # on the glide path under the leg the air is denser
    final = {"phase": "final", "distance_m": 3000, "indicated_speed_mps": 60}
    assert read({**LA_PAZ, "start": final}).start.speed < 60.0 / share


def test_a_twin_replaces_its_other_on_the_command_line_and_on_an_axis():
    changed = read(LA_PAZ, {"route.indicated_approach_speed_mps": 60})
    assert "approach_speed_mps" not in changed.tables["route"]
    assert changed.route.approach_speed == pytest.approx(60.0 / math.sqrt(DENSITY), rel=1e-5)
    assert read(changed.tables, {"route.approach_speed_mps": 60}).route.approach_speed == 60.0
    table = {"axes": {"route.indicated_turn_speed_mps": [70, 72]}}
    indicated = {f"indicated_{key}": value for key, value in LA_PAZ["route"].items()}
    study = plan(read({**LA_PAZ, "route": indicated, "study": table}))
    assert [cell["route.indicated_turn_speed_mps"] for cell in study.cells] == [70, 72]


@pytest.mark.parametrize(
    ("change", "told"),
    [
        (
            {"route": {"turn_speed_mps": 69, "indicated_turn_speed_kt": 130}},
            "'turn_speed_mps' is the true airspeed and 'indicated_turn_speed_kt' the indicated one of one speed",
        ),
        ({"route": {"indicated_turn_speed": 69}}, "it needs its unit: indicated_turn_speed_mps"),
        ({"air": {"temperature_c": -120}}, r"\[air\] temperature_c: must be at least -90: nothing colder"),
        ({"air": {"qnh_hpa": 29.92}}, r"\[air\] qnh_hpa: must be at least 850: .* \(got 29.92\)"),
    ],
)
def test_bad_speeds_and_air_are_one_sentence_each(change, told):
    with pytest.raises(ScenarioError, match=told) as found:
        read({**LA_PAZ, **change})
    assert "\n" not in str(found.value)


def test_the_schema_knows_the_twins():
    tables = schema()["$defs"]
    key = tables["PatternTable"]["properties"]["indicated_approach_speed_kt"]
    assert "indicated airspeed" in key["description"]
    assert "temperature_c" in tables["AirTable"]["properties"]


def test_broken_margins_and_placards_are_remarks():
    slow = prepare(read("an26_pattern", {"aircraft.mass_kg": 24000, "route.turn_speed_mps": 63}))
    assert any("the turn to final at" in remark and "below 1.4" in remark for remark in slow.warnings)
    fast = prepare(read("an26_pattern", {"route.turn_speed_mps": 72}))
    assert any("above 69.4 m/s, the limit of flaps at 38 deg" in remark for remark in fast.warnings)
    assert not prepare(read("an26_pattern")).warnings


@pytest.fixture(scope="module")
def hot_and_high():
    """The An-26 at 2500 m, 25 C above the standard, with the speeds of a chart."""
    route = {f"indicated_{key}": value for key, value in LA_PAZ["route"].items()}
    tables = LA_PAZ | {"runway": {"heading_deg": 80, "elevation_m": 2500}, "air": {"temperature_c": 23.75}}
    return run({**tables, "start": {"phase": "final", "distance_m": 11500}, "route": route})


def test_hot_and_high_it_lands_with_the_margin_of_sea_level(hot_and_high):
    flight, prepared = hot_and_high.flight, hot_and_high.prepared
    figures = flight_metrics(flight, prepared.scenario.runway, prepared.law.bank_limit, prepared.stall_speed)
    assert flight.outcome == "landed"
    assert figures["final_over_stall"] > 1.3
    glide, height = flight.during("glide"), flight.state.height
    # the true speed is kept, so that 58 m/s where final begins, at 400 m, are 1.2 % more 270 m lower down
    before_it_slows_down = glide & (height > 110.0) & (height < 150.0)
    assert flight.state.equivalent_airspeed[before_it_slows_down].mean() == pytest.approx(1.012 * 58.0, abs=0.3)
    on_final = glide & (height < 60.0)
    # sea level over here: the standard pressure of 2500 m in air that is 25 K warmer
    density = (1.0 - 0.0065 * 2500.0 / 288.15) ** 5.2559 * 288.15 / (271.9 + 25.0)
    ratio = flight.state.airspeed[on_final] / flight.state.equivalent_airspeed[on_final]
    assert ratio.mean() == pytest.approx(density**-0.5, rel=0.002)  # 30 m above the runway: .0015


def test_a_run_says_in_which_air_it_flew_and_what_it_was_slow_for(hot_and_high):
    from sim.reporting.text.warnings import warnings

    flight = hot_and_high.flight
    assert not warnings(flight, hot_and_high.metrics["flight"], {}, {}, {})
    (told,) = warnings(flight, {"final_over_stall": 1.146}, {}, {}, {})
    assert "1.15 of the stall speed" in told
    assert hot_and_high.metrics["flight"]["touchdown"]["over_stall"] == pytest.approx(
        hot_and_high.metrics["flight"]["touchdown"]["equivalent_airspeed_mps"] / 41.3
    )


def test_the_air_of_a_file_is_in_si():
    scenario = read({**LA_PAZ, "air": {"temperature_c": -5, "qnh_hpa": 1030}})
    assert scenario.air.temperature == pytest.approx(268.15)
    assert scenario.air.qnh == 103000.0
