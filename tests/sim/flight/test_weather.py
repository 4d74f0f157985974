"""The [wind] table from its one-line keys to the air that is met: judged by the fields themselves and by arithmetic."""

from __future__ import annotations

import dataclasses
import math
import re
import shutil
import sys
import tomllib
from pathlib import Path

import numpy as np
import pytest

from aircraft import wind_events
from aircraft.airframe import load
from aircraft.errors import TrimError
from aircraft.trim import trim
from aircraft.turbulence import Turbulence
from aircraft.wind import SteadyWind, Together
from sim.errors import ScenarioError
from sim.experiment import fly
from sim.flight.preparation import prepare
from sim.flight.weather import air, words
from sim.metrics import windshear
from sim.scenario import catalogue
from sim.scenario.editors.json_schema import schema
from sim.scenario.reading import read
from sim.scenario.tables import Runway

LINE = {
    "name": "line",
    "route": {"kind": "legs", "legs": [{"from_m": [0, 0], "to_m": [9000, 0], "speed_mps": 72, "height_m": 300}]},
}
BURST = {"kind": "microburst", "peak_mps": 12.0, "past_threshold_m": 2500.0, "right_m": 300.0}
GUST = {"kind": "gust", "up_mps": 6.0, "at_s": 20.0, "lasts_s": 4.0}


def windy(**table):
    return read({**LINE, "wind": table})


def wind(**table):
    return windy(**table).wind


def faults(**table):
    with pytest.raises(ScenarioError) as caught:
        wind(**table)
    return str(caught.value)


# ---- reading -----------------------------------------------------------------------------------------------------


def test_each_weather_is_one_line():
    assert wind(shear="logarithmic", speed_mps=8.0).at(300.0)[0] < -8.0
    assert wind(events={"b": BURST}).events["b"].peak == 12.0
    assert wind(events={"g": {**GUST, "at_s": 20}}).events["g"].at == 20.0
    assert wind(turbulence="severe").intensity == pytest.approx(45 * 1852 / 3600)


def test_a_wind_along_and_across_the_runway_is_the_same_wind_by_its_components():
    """On runway 08: 10 m/s from ahead and 10 from the right are 14.1 m/s from 125 deg."""
    runway = {"heading_deg": 80}
    both = {"headwind_mps": 10.0, "crosswind_mps": 10.0}
    found = read({**LINE, "runway": runway, "wind": both})
    asked = read({**LINE, "runway": runway, "wind": {"from_deg": 125.0, "speed_mps": 10.0 * math.sqrt(2.0)}})
    assert found.wind.steady == pytest.approx(asked.wind.steady, abs=1e-12)
    assert found.wind.strength == pytest.approx(asked.wind.strength)
    assert words(found) == words(asked)
    assert read(found.tables) == found
    tail = read({**LINE, "runway": runway, "wind": {"headwind_kt": -10}}).wind
    assert math.degrees(math.atan2(tail.steady[1], tail.steady[0])) == pytest.approx(80.0)  # it blows along the landing


def test_turbulence_by_wind_has_the_mean_wind_at_20_ft():
    """8 m/s at 10 m: ln(20 / 0.15) / ln(32.8 / 0.15) of it, in feet, by the logarithmic profile."""
    found = wind(headwind_mps=8.0, shear="logarithmic", turbulence="by_wind")
    assert found.intensity == pytest.approx(8.0 * math.log(20 / 0.15) / math.log(10 / 0.3048 / 0.15))
    assert wind(speed_mps=3.0, turbulence="by_wind").intensity == pytest.approx(3.0)
    assert wind(turbulence="by_wind").intensity == 0.0


def test_the_resolved_file_says_everything_and_reads_back_as_the_same_weather():
    table = {"speed_kt": 10, "shear": "power", "exponent": 0.2, "events": {"b": BURST, "g": GUST}}
    scenario = read({**LINE, "wind": table})
    assert scenario.tables["wind"]["events"]["b"]["radius_m"] == 1550.0
    assert read(scenario.tables) == scenario


def test_an_event_can_be_varied_by_its_address():
    scenario = read({**LINE, "wind": {"events": {"b": BURST}}}, {"wind.events.b.peak_kt": 20.0})
    assert scenario.wind.events["b"].peak == pytest.approx(20 * 1852 / 3600)


@pytest.mark.parametrize(
    ("table", "said"),
    [
        ({"events": {"b": {**BURST, "kind": "microbust"}}}, "[wind.events.b] kind: no kind 'microbust'; did you mean"),
        ({"events": {"b": {"peak_mps": 3.0}}}, "[wind.events.b] kind: is missing"),
        (
            {"events": {"b": {**BURST, "peek_mps": 3.0}}},
            "[wind.events.b] peek_mps: no such key; did you mean 'peak_mps'",
        ),
        ({"events": {"b": {**BURST, "radius": 3.0}}}, "radius: no such key; it needs its unit: radius_m"),
        ({"events": {"b": {**BURST, "peak_mps": -3.0}}}, "[wind.events.b] peak_mps: must be at least 0"),
        ({"events": {"b": {**BURST, "past_threshold_m": math.nan}}}, "past_threshold_m: must be a finite number"),
        ({"events": {"b": {"kind": "microburst", "peak_mps": 3.0}}}, "'past_threshold_m' is missing"),
        ({"events": {"b": {**GUST, "length_m": 50.0}}}, "[wind.events.b] a gust comes at a time"),
        ({"events": {"b": 3}}, "[wind.events] b: must be a table with a 'kind'"),
        ({"events": {"b c": GUST}}, "a name starts with a letter"),
        ({"events": 3}, "[wind] events: must be a table"),
        ({"event": {}}, "[wind] event: no such key; did you mean 'events'"),
        ({"shear": "logaritmic"}, "'none', 'logarithmic' or 'power'"),
        ({"exponent": 0.2}, 'exponent belongs to shear = "power"'),
        ({"shear": "power", "roughness_m": 0.1}, 'roughness belongs to shear = "logarithmic"'),
        ({"reference_height_m": 10.0}, "reference_height belongs to a shear"),
        ({"shear": "power", "reference_height_m": 0.1}, "reference_height_m: must be at least 0.9144"),
        ({"shear": "logarithmic", "roughness_m": 9.0}, "roughness_m: must be at most 0.4572"),
        ({"shear": "power", "exponent": math.nan}, "must be a finite number"),
    ],
)
def test_each_fault_is_one_clear_sentence(table, said):
    told = faults(**table)
    assert said in told
    assert len(told.splitlines()) == 1


def test_the_weather_that_a_new_scenario_suggests_is_good_weather():
    text = catalogue.bundled("an26_pattern").read_text()
    block = text[text.index("# [wind]") :].partition("\n\n")[0]
    table = tomllib.loads("\n".join(line.removeprefix("# ") for line in block.splitlines()))
    suggested = read({**LINE, **table}).wind
    assert {type(event).__name__.lower() for event in suggested.events.values()} == {
        kind.replace("_", "") for kind in catalogue.kinds("wind_events")
    }


def test_schema_and_listing_know_the_kinds():
    from sim.cli.listing import kind_lines

    text = str(schema())
    assert all(key in text for key in ("peak_mps", "lasts_s", "roughness_m", "reference_height_ft"))
    listed = "\n".join(kind_lines())
    assert "[wind.events.NAME] kind" in listed
    assert all(kind in listed for kind in catalogue.kinds("wind_events"))


def test_words_say_what_there_is():
    assert words(windy()) == ["no steady wind"]
    said = words(windy(from_deg=110, speed_mps=8, shear="power", turbulence="light", events={"b": BURST, "g": GUST}))
    assert said == [
        "wind from 110 deg at 8.0 m/s 10 m up, power shear",
        "light turbulence, 7.7 m/s at 20 ft",
        "b: microburst of 12.0 m/s, 1550 m in radius, 2500 m past the threshold, 300 m right of the centreline",
        "g: gust of 6.0 m/s up, from 20 s for 4 s",
    ]
    side = {"kind": "gust", "speed_mps": 5.0, "from_deg": 350, "past_threshold_m": -900.0, "length_m": 200.0}
    _, told = words(windy(events={"g": side}))
    assert told == "g: gust of 5.0 m/s from 350 deg, 200 m long, 900 m before the threshold"
    _, told = words(windy(events={"s": {**side, "kind": "wind_shift"}}))
    assert told == "s: wind shift of 5.0 m/s from 350 deg, over 200 m from 900 m before the threshold"


# ---- the air that is built ---------------------------------------------------------------------------------------


def test_plain_weather_is_built_as_plainly_as_ever():
    """A steady wind stays the one object that the airframe sets once for several steps."""
    noise = np.random.default_rng(1)
    assert isinstance(air(wind(speed_mps=5.0), Runway(), noise), SteadyWind)
    assert isinstance(air(wind(speed_mps=5.0, turbulence="light"), Runway(), noise), Turbulence)
    assert isinstance(air(wind(speed_mps=5.0, turbulence="light"), Runway()), SteadyWind)
    assert isinstance(air(wind(speed_mps=5.0, shear="power"), Runway(), noise), Together)


def test_turbulence_is_the_same_with_and_without_events():
    place, table = (100.0, 200.0, 90.0), {"speed_mps": 6.0, "from_deg": 200.0, "turbulence": "moderate"}
    plain = air(wind(**table), Runway(), np.random.default_rng(4))
    eventful = air(wind(**table, events={"b": BURST}), Runway(), np.random.default_rng(4))
    burst = wind(events={"b": BURST}).events["b"]
    for step in range(0, 600, 7):
        alone, both = (np.array(one.velocity(step / 120.0, place, 72.0)) for one in (plain, eventful))
        assert both == pytest.approx(alone + burst.velocity(0.0, place, 72.0), abs=1e-12)


def test_turns_are_planned_for_the_wind_where_they_are_flown():
    pattern = {"name": "p", "wind": {"speed_mps": 5.0, "from_deg": 270.0, "shear": "power"}}
    east = prepare(read(pattern)).route.wind[1]
    assert east == pytest.approx(5.0 * (304.8 / 10.0) ** (1.0 / 7.0))  # 400 m is above the end of the profile


# ---- the air that is met -----------------------------------------------------------------------------------------


@pytest.mark.parametrize("model", ["point_mass", "an26"])
def test_what_the_record_shows_is_the_field_where_the_aircraft_was(model):
    """Wind enters every vehicle: ground velocity less air velocity is the field at the place and time of the step."""
    start = {"leg": 0, "distance_m": 8000}
    events = {"b": BURST, "g": GUST}
    scenario = read(
        {**LINE, "aircraft": {"model": model}, "start": start, "until_s": 40, "wind": {"speed_mps": 4, "shear": "power",
         "events": events}}
    )  # fmt: skip
    flight = fly(prepare(scenario))
    s, field = flight.state, air(scenario.wind, scenario.runway)
    places = zip(flight.time, s.north, s.east, s.height, strict=True)
    known = np.array([field.velocity(t, (n, e, h), 72.0) for t, n, e, h in places]).T
    assert np.ptp(known, axis=1).min() > 0.4  # there is something to be met in every direction
    # each record has the air of the step that led to it: of its beginning, or for JSBSim in time up to 3/120 s later,
    # in which the gust grows by 6 m/s * pi / 4 s * 0.025 s = 0.12 m/s
    assert flight.wind[:2, 1:] == pytest.approx(known[:2, :-1], abs=1e-6)
    assert flight.wind[2, 1:] == pytest.approx(known[2, :-1], abs=0.12)


def test_who_flies_a_point_mass_is_told_what_it_does_not_feel():
    calm = prepare(read({**LINE, "aircraft": {"model": "point_mass"}}))
    assert not calm.warnings
    told = prepare(read({**LINE, "aircraft": {"model": "point_mass"}, "wind": {"events": {"b": BURST}}})).warnings
    assert "keeps its airspeed" in told[0]


# ---- energy ------------------------------------------------------------------------------------------------------


def test_f_factor_of_growing_tailwind_and_of_sinking_air(make_flight):
    time = np.arange(0.0, 30.0, 1 / 30)
    growing = make_flight(time, ["final"] * len(time), velocity_north=70.0 + 0.98 * time)
    assert windshear.f_factor(growing) == pytest.approx(np.full(len(time), 0.98 / 9.80665))
    sinking = make_flight(time, ["final"] * len(time), velocity_up=np.full(len(time), -7.0))
    assert windshear.f_factor(sinking) == pytest.approx(np.full(len(time), 0.1))
    side = make_flight(time, ["final"] * len(time), velocity_east=0.5 * time)
    assert windshear.f_factor(side) == pytest.approx(np.zeros(len(time)), abs=1e-12)


def test_averages_are_over_the_last_kilometre():
    distance = np.arange(0.0, 4000.0, 10.0)
    mean = windshear.averaged(np.where(distance > 2000.0, 1.0, 0.0), distance)
    assert np.isnan(mean[:100]).all()
    assert mean[[100, 200]] == pytest.approx([0.0, 0.0])
    assert mean[[250, 399]] == pytest.approx([0.5, 1.0], abs=0.01)  # one step of 10 m in 1000


def test_steepest_climb_is_what_full_power_accelerates_in_level_flight():
    prepared = prepare(read("an26_pattern", {"trackers": {}, "sensors": {}}))
    climb, landing = windshear.steepest_climb(prepared), prepared.autopilot.landing
    airframe = load("an26", 20000.0)

    def accelerated(share):
        rate = share * 9.80665 * climb
        return trim(airframe, landing.approach_speed, 0.0, 100.0, landing.flaps, 1.0, rate).controls.throttle

    # 3 %: a climb of 7 deg needs 0.7 % less lift than level flight, and the thrust lies a little across the path
    assert 0.9 < accelerated(0.97) <= 1.0
    with pytest.raises(TrimError, match="full power"):
        accelerated(1.03)


@pytest.fixture(scope="module")
def encounter():
    scenario = read("an26_windshear")
    return scenario, fly(prepare(scenario))


def test_the_glide_path_foretells_the_energy_that_a_flight_loses(encounter):
    scenario, flight = encounter
    landing = prepare(scenario).autopilot.landing
    foretold = windshear.worst_on_the_glide_path(
        scenario.wind.events["burst"], scenario.runway, landing.approach_speed, 300.0
    )
    met = np.nanmax(np.where(flight.during("glide"), windshear.averaged_f_factor(flight), np.nan))
    # the flight is up to 8 m/s faster or slower than the schedule and feels the ground speed of the wind itself
    assert met == pytest.approx(foretold, rel=0.15)


def test_the_gate_sends_it_around(encounter):
    _, flight = encounter
    assert flight.outcome == "go_around"
    names = [event.name for event in flight.events]
    assert names.index("go_around") > names.index("glide")


def test_explain_weighs_a_microburst_against_the_power_that_there_is(encounter):
    (told,) = windshear.outlook(prepare(encounter[0]))
    taken, held = (float(number) for number in re.findall(r"0\.\d{3}", told))
    # 20 m/s is below the 21.6 m/s of the study's energy line at this place, in the same proportion
    assert 0.8 < taken / held < 1.0
    assert windshear.outlook(prepare(read("an26_gust"))) == []


def test_weather_is_drawn_and_plain_air_is_not(encounter):
    from sim.reporting.figures.weather import weather_charts

    scenario, flight = encounter
    titles = [title for title, _, _ in weather_charts(flight, scenario)]
    assert titles == ["Wind met", "Microburst burst"]
    plain = dataclasses.replace(scenario, wind=wind(speed_mps=9.0))
    assert not list(weather_charts(flight, plain))
    rough = dataclasses.replace(scenario, wind=wind(speed_mps=9.0, shear="power", turbulence="light"))
    titles = [title for title, _, _ in weather_charts(flight, rough)]
    assert titles == ["Wind met", "Wind and turbulence over height"]  # level flight was too short for a spectrum


def test_turbulence_is_told_from_the_rest_of_the_wind(make_flight):
    """A flight made of known gusts, a sheared wind and an event gives the gusts back, and enough of them are drawn."""
    from sim.reporting.figures.weather import spectra, turbulence_met

    scenario = read({**LINE, "wind": {"from_deg": 30, "speed_mps": 7, "shear": "power", "turbulence": "moderate",
                     "events": {"b": BURST}}})  # fmt: skip
    time = np.arange(0.0, 150.0, 1 / 30)
    north, height = 70.0 * time, np.full(len(time), 400.0)
    gusts = air(wind(turbulence="moderate"), Runway(heading=math.radians(210.0)), np.random.default_rng(5))
    field = air(scenario.wind, scenario.runway)
    places = list(zip(time.tolist(), north.tolist(), strict=True))
    random = np.array([gusts.velocity(t, (n, 0.0, 400.0), 70.0) for t, n in places]).T
    total = random + np.array([field.velocity(t, (n, 0.0, 400.0), 70.0) for t, n in places]).T
    flight = make_flight(
        time, ["final"] * len(time), north=north, height=height,
        velocity_north=70.0 + total[0], velocity_east=total[1], velocity_up=total[2],
    )  # fmt: skip
    along, right, up = met = turbulence_met(flight, scenario)
    c, s = math.cos(math.radians(210.0)), math.sin(math.radians(210.0))  # the wind blows towards 210 deg
    assert along == pytest.approx(c * random[0] + s * random[1], abs=1e-9)
    assert right == pytest.approx(c * random[1] - s * random[0], abs=1e-9)
    assert up == pytest.approx(random[2], abs=1e-9)
    assert spectra(flight, scenario, met) is not None


def test_the_report_names_what_the_weather_stands_on():
    from sim.reporting.text.references import sources, what_ran

    scenario = read("an26_windshear", {"wind.shear": "logarithmic", "wind.events.g": GUST})
    equations, papers, _ = sources(what_ran(scenario, prepare(scenario).law))
    assert {"CS 25.341(a)", "MIL-F-8785C, wind shear model"} <= {equation.tag for equation in equations}
    assert any("TM-104053" in paper for paper in papers)


def test_an_event_is_called_by_its_kind_even_where_its_file_is_a_copy(tmp_path, monkeypatch):
    folders = list(wind_events.__path__)
    shutil.copy(Path(folders[0]) / "gust.py", tmp_path / "updraught.py")
    monkeypatch.setattr(wind_events, "__path__", [*folders, str(tmp_path)])
    assert words(windy(events={"u": {"kind": "updraught", "up_mps": 5.0, "at_s": 10, "lasts_s": 5}})) == [
        "no steady wind",
        "u: updraught of 5.0 m/s up, from 10 s for 5 s",
    ]
    del sys.modules["aircraft.wind_events.updraught"]


def test_a_drawn_spectrum_has_the_variance_of_its_record():
    from sim.reporting.figures.weather import spectrum

    values = np.random.default_rng(3).standard_normal(40_000)
    frequency, density = spectrum(values)
    assert np.trapezoid(density, frequency) == pytest.approx(1.0, rel=0.03)  # 1 / sqrt(20,000) and the two end bins
    tone = np.sqrt(2.0) * np.sin(5.0 * np.arange(40_000) / 30.0)
    frequency, density = spectrum(tone)
    assert frequency[np.argmax(density)] == pytest.approx(5.0, abs=frequency[1])


def test_the_energy_line_needs_its_microburst():
    from sim.studies.theory import border

    with pytest.raises(ScenarioError, match=r"needs a landing pattern and a \[wind.events.burst\]"):
        border("energy", read({**LINE, "aircraft": {"model": "an26"}}), np.array([0.0]))


def test_the_energy_line_is_higher_for_wider_microbursts():
    from sim.studies.theory import border

    places = np.array([-3000.0, -1000.0])
    narrow, wide = (
        border("energy", read("an26_microburst", {"wind.events.burst.radius_m": radius}), places)
        for radius in (1200.0, 2400.0)
    )
    assert (narrow < wide).all()  # the same change of wind over a longer way costs less power
