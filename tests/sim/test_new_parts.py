"""A new file in the folder of its family is a kind: it flies, tracks, and stands in explain, report and schema.

The files are those of ``tests/parts``, which the documentation quotes; the folder is a temporary one that stands beside
the real one, so that nothing else knows their names.
"""

from __future__ import annotations

import importlib
import re
import shutil
import sys
from contextlib import contextmanager
from pathlib import Path

import numpy as np
import pytest

import sim
from aircraft.wind_event import broken_promises as broken_by_event
from sim.cli.explain import explain
from sim.cli.exporting.spreadsheet import export_spreadsheet
from sim.cli.listing import kind_lines
from sim.errors import ScenarioError
from sim.estimation.setup import check
from sim.estimation.trial import maker
from sim.experiment import report, run_to_folder
from sim.flight.preparation import prepare
from sim.observation.sensor import broken_promises as broken_by_sensor
from sim.reporting.drawing.marks import Area, Words
from sim.scenario import catalogue
from sim.scenario.editors.json_schema import schema
from sim.scenario.parameters import construct
from sim.scenario.reading import read
from sim.scenario.tables import Runway
from tests.sim.drawn import drawings, marks
from tracking.contract import broken_promises as broken_by_tracker

PARTS = Path(__file__).resolve().parent.parent / "parts"
LINE = {
    "name": "line",
    "draws": 4,
    "until_s": 40,
    "aircraft": {"model": "point_mass"},
    "start": {"leg": 0, "cross_track_m": 100},
    "route": {"kind": "legs", "legs": [{"from_m": [-4000, 0], "to_m": [9000, 0], "speed_mps": 80, "height_m": 600}]},
    "sensors": {"radar": {"kind": "surveillance_radar", "period_s": 2}},
}
FIELD = {"kind": "updraught", "up_mps": 5, "past_threshold_m": -2500, "at_s": 5, "lasts_s": 30}
EVENT = {"wind": {"events": {"field": FIELD}}}
TRACKERS = {"simple": {"kind": "alpha_beta", "period_s": 2}, "plain": {"kind": "kalman"}}


@contextmanager
def dropped(folder: Path, family: str, kind: str, text: str):
    """A file in the folder of a family."""
    package = importlib.import_module(catalogue.FOLDERS[family][0])
    (folder / f"{kind}.py").write_text(text)
    package.__path__.append(str(folder))
    importlib.invalidate_caches()
    try:
        yield
    finally:
        package.__path__.remove(str(folder))
        sys.modules.pop(f"{package.__name__}.{kind}", None)
        importlib.invalidate_caches()


@pytest.fixture(scope="module")
def both(tmp_path_factory):
    """Both new parts in their folders, and the run of a scenario that names them, with its report."""
    folders = tmp_path_factory.mktemp("events"), tmp_path_factory.mktemp("trackers")
    event, tracker = ((PARTS / f"{kind}.py").read_text() for kind in ("updraught", "alpha_beta"))
    with (
        dropped(folders[0], "wind_events", "updraught", event),
        dropped(folders[1], "trackers", "alpha_beta", tracker),
    ):
        result = sim.run({**LINE, **EVENT, "trackers": TRACKERS})
        folder = tmp_path_factory.mktemp("out")
        report(result, folder)
        yield result, (folder / "report.html").read_text()
    for place in folders:
        shutil.rmtree(place)


def test_new_parts_keep_their_contracts(both):
    event, tracker = catalogue.load("wind_events", "updraught"), catalogue.load("trackers", "alpha_beta")
    assert broken_by_event(event, lambda: construct(event, {}, runway=Runway())) == []
    assert broken_by_tracker(tracker, maker(tracker)) == []


def test_new_parts_are_documentation():
    for kind in ("updraught", "alpha_beta"):
        assert len((PARTS / f"{kind}.py").read_text().splitlines()) <= 60


def test_a_new_wind_event_is_flown(both):
    flight = both[0].flight
    inside = (flight.time > 5.1) & (flight.time < 34.9) & (np.hypot(flight.state.north + 2500, flight.state.east) < 800)
    assert inside.sum() > 300
    assert flight.wind[2, ~inside] == pytest.approx(0.0, abs=0.1)  # wind is recorded a step later
    middle = np.argmin(np.abs(flight.state.north + 2500))
    assert flight.wind[2, middle] == pytest.approx(5.0, abs=0.2)  # 90 m beside the middle of 800 m: 1 % less


def test_a_new_wind_event_is_said_in_its_own_words(both):
    said = "field: updraught of 5.0 m/s, 800 m in radius, from 5 s for 30 s"
    assert said in explain(both[0].scenario)
    assert said in both[1]
    assert "gust" not in explain(both[0].scenario).splitlines()[0]


def test_a_new_wind_event_is_drawn_where_it_is(both):
    from sim.reporting.figures.plan_view import plan_view
    from sim.reporting.figures.weather import weather_charts

    result = both[0]
    (panel,) = plan_view(result.flight, result.scenario.runway, (0.0, 0.0), result.scenario.wind.events).panels
    (area,) = marks(panel, Area)
    (corners,) = area.rings
    assert np.hypot(corners[:, 0] + 2.5, corners[:, 1]) == pytest.approx(np.full(len(corners), 0.8))
    assert "field" in [words.text for words in marks(panel, Words)]
    titles = [title for title, _, _ in weather_charts(result.flight, result.scenario)]
    assert titles == ["Wind met", "Updraught field"]


def test_a_new_wind_event_is_weighed_against_the_power(both):
    """Of an event that rises everywhere on the glide path the F-factor is what it lifts over the airspeed."""
    from sim.metrics.windshear import worst_on_the_glide_path

    cls = catalogue.load("wind_events", "updraught")
    wide = construct(cls, {"up_mps": -7.0, "radius_m": 1e9, "at_s": 5.0}, runway=Runway()).standing()
    assert worst_on_the_glide_path(wide, Runway(), 70.0, 300.0) == pytest.approx(0.1)


def test_a_new_tracker_is_judged_like_any_other(both):
    trackers = both[0].metrics["trackers"]
    simple, plain = (trackers[name]["overall"]["position_m"] for name in ("simple", "plain"))
    assert trackers["simple"]["kind"] == "alpha_beta"
    assert 0.0 < simple["rmse"] < simple["raw"]  # a filter with gains this low is better than its plots
    assert set(trackers["simple"]) == set(trackers["plain"])
    assert set(simple) == set(plain)
    assert re.search(r"<t[dh][^>]*>\s*simple", both[1])


def test_new_parts_stand_in_the_schema_and_in_the_list_of_kinds(both):
    for text in (str(schema()), "\n".join(kind_lines())):
        assert "updraught" in text
        assert "alpha_beta" in text


def test_an_unknown_kind_is_refused_once_its_file_is_gone():
    with pytest.raises(ScenarioError, match="no kind 'vortex'"):
        read({**LINE, "wind": {"events": {"field": {"kind": "vortex"}}}})


WRONG_EVENTS = {
    "words raises ZeroDivisionError": ('        when = ""', '        1 / 0\n        when = ""'),
    "outline raises ZeroDivisionError": ("        return circle(", "        1 / 0\n        return circle("),
    "standing raises ZeroDivisionError": ("        return replace(", "        1 / 0\n        return replace("),
    "velocity raises ZeroDivisionError": ("        from_middle =", "        1 / 0\n        from_middle ="),
    "velocity gives": ("        return 0.0, 0.0, self.up", "        return 0.0, self.up"),
    "must define exactly one dataclass with 'velocity'": ("    def velocity(", "    def blow("),
}


@pytest.mark.parametrize("said", WRONG_EVENTS)
def test_a_scenario_with_a_wrong_wind_event_gets_one_sentence_with_the_member(tmp_path, said):
    text = (PARTS / "updraught.py").read_text()
    assert WRONG_EVENTS[said][0] in text
    kind = f"updraught_{abs(hash(said))}"
    wrong = text.replace(*WRONG_EVENTS[said])
    with dropped(tmp_path, "wind_events", kind, wrong), pytest.raises(ScenarioError) as caught:
        read({**LINE, "wind": {"events": {"field": {**FIELD, "kind": kind}}}})
    assert said in str(caught.value)
    assert len(str(caught.value).splitlines()) == 1


WRONG_TRACKERS = {
    "has no 'estimate'": ("    def estimate(self", "    def estimated(self"),
    "has no 'begin'": ("    def begin(self", "    def begun(self"),
    "has no 'channels'": ("    channels = ", "    names = "),
    "must define exactly one dataclass with 'step'": ("    def step(self", "    def stepped(self"),
    "begin raises ZeroDivisionError": ("        return prior", "        return 1 / 0"),
    "step raises ZeroDivisionError": ("        if z is None:", "        1 / 0\n        if z is None:"),
    "step gives Gaussian": ("+ noise), innovation", "+ noise)"),
    "estimate gives ndarray": ("        return state\n\n\nSHORT", "        return state.mean\n\n\nSHORT"),
    "channels raises ZeroDivisionError": (
        '    channels = ("north", "north_rate", "east", "east_rate")',
        "    channels = property(lambda self: 1 / 0)",
    ),
}


@pytest.mark.parametrize("said", WRONG_TRACKERS)
def test_a_scenario_with_a_wrong_tracker_gets_one_sentence_with_the_member(tmp_path, said):
    text = (PARTS / "alpha_beta.py").read_text()
    assert WRONG_TRACKERS[said][0] in text
    kind = f"alpha_beta_{abs(hash(said))}"
    wrong = text.replace(*WRONG_TRACKERS[said])
    with dropped(tmp_path, "trackers", kind, wrong), pytest.raises(ScenarioError) as caught:
        sim.run({**LINE, "until_s": 10, "draws": 2, "trackers": {"simple": {"kind": kind}}})
    assert said in str(caught.value)
    assert len(str(caught.value).splitlines()) == 1


def test_a_wrong_tracker_that_flies_the_aircraft_gets_one_sentence_too(tmp_path):
    text = (
        (PARTS / "alpha_beta.py").read_text().replace("        if z is None:", "        1 / 0\n        if z is None:")
    )
    with dropped(tmp_path, "trackers", "alpha_gamma", text):
        tables = {**LINE, "until_s": 10, "draws": 1, "trackers": {"simple": {"kind": "alpha_gamma"}}}
        with pytest.raises(
            ScenarioError, match=r"navigation: its tracker.s step raises ZeroDivisionError: division by zero"
        ):
            sim.run({**tables, "autopilot": {"navigation": "simple"}})


# ---- a new sensor ------------------------------------------------------------------------------------------------

DOPPLER = (PARTS / "doppler_radar.py").read_text()
WATCHED = {**LINE["sensors"], "doppler": {"kind": "doppler_radar"}}
BESIDE = {
    "both": {"kind": "kalman"},  # all sensors: place by the radar, and the range of the new one
    "alone": {"kind": "kalman", "sensors": ["radar"]},
}


@pytest.fixture(scope="module")
def watched(tmp_path_factory):
    """The new sensor in its folder, and the run of a scenario that names it, with its files."""
    with dropped(tmp_path_factory.mktemp("sensors"), "sensors", "doppler_radar", DOPPLER):
        folder = tmp_path_factory.mktemp("run")
        yield run_to_folder({**LINE, "sensors": WATCHED, "trackers": BESIDE}, {}, folder)[1], folder


def test_a_new_sensor_keeps_its_contract_and_is_documentation(watched):
    cls = catalogue.load("sensors", "doppler_radar")
    assert broken_by_sensor(cls, lambda: construct(cls, {}, runway=Runway())) == []
    assert len(DOPPLER.splitlines()) <= 60


def test_a_new_sensor_measures_along_the_flight(watched):
    """North along a line 100 m beside its antenna: range and range rate by Pythagoras."""
    record, state = watched[0].records["doppler"], watched[0].flight.state
    away = [np.interp(record.time, state.time, one) for one in (state.north, state.east, state.height)]
    north, east, up = (one - own for one, own in zip(away, (300.0, 200.0, 3.0), strict=True))
    slant = np.sqrt(north**2 + east**2 + up**2)
    along = (
        np.interp(record.time, state.time, state.velocity_north),
        np.interp(record.time, state.time, state.velocity_east),
    )
    rate = (north * along[0] + east * along[1]) / slant  # it flies level
    assert record.channels == ("range", "range_rate")
    for row, (exact, sigma) in enumerate(((slant, 30.0), (rate, 0.5))):
        assert np.std(record.z[:, row] - exact[:, None]) == pytest.approx(sigma, rel=0.15)  # 316 numbers: sd 4 %


def test_a_new_sensor_is_explained_drawn_and_reported(watched):
    result, folder = watched
    assert re.search(r"doppler +doppler_radar +range, range_rate +0\.5", explain(result.scenario))
    page = (folder / "report.html").read_text()
    assert "What the sensors measured" in page
    drawn = drawings(page)
    assert any("doppler: range rate, m/s" in image for image in drawn)
    assert any(">doppler<" in image for image in drawn)  # its antenna on the plan


def test_what_a_sensor_covers_is_drawn_where_it_is(watched):
    from sim.reporting.figures.plan_view import plan_view

    cls = catalogue.load("sensors", "precision_radar")
    radar = construct(cls, {"position_m": [1200, 150, 3], "sector_deg": 20, "coverage_m": 9000}, runway=Runway())
    (panel,) = plan_view(watched[0].flight, Runway(), (0.0, 0.0), None, {"eye": radar}).panels
    (edge,) = [line for line in panel.lines if line.width == 0.7]
    away = np.hypot(edge.x - 1.2, edge.y - 0.15)  # km; the final course runs north
    assert away[[0, -1]] == pytest.approx(0.0)
    assert away[1:-1] == pytest.approx(9.0)
    half = np.degrees(np.arctan2(edge.y[1:-1] - 0.15, 1.2 - edge.x[1:-1]))
    assert (half.min(), half.max()) == pytest.approx((-10.0, 10.0))
    assert "eye" in [words.text for words in marks(panel, Words)]


COLUMNS = ("", "_sigma", "_truth", "_error")  # of a channel in a table


def test_a_new_sensor_is_recorded_and_exported_with_its_units(watched):
    _, folder = watched
    with np.load(folder / "measurements.npz") as arrays:
        assert arrays["doppler.units"].tolist() == ["m", "mps"]
    export_spreadsheet(folder)
    with (folder / "measurements.doppler.csv").open() as file:
        names = [f"{one}{part}_{unit}" for one, unit in (("range", "m"), ("range_rate", "mps")) for part in COLUMNS]
        assert file.readline().strip().split(",") == ["time_s", "arrival_s", "phase", "draw", *names]


def test_a_tracker_of_places_uses_the_range_of_a_new_sensor_beside_a_radar(watched):
    figures = watched[0].metrics["trackers"]
    both, alone = (figures[name]["overall"]["position_m"]["rmse"] for name in ("both", "alone"))
    assert both < 0.9 * alone  # 30 m twice a second beside 60 m every 2 s
    track = watched[0].tracks["both"].track
    assert track.white.shape[1] == 3  # two rows of a place and one range; the rate is left out


def test_a_tracker_that_cannot_use_a_new_sensor_says_so_in_one_sentence(watched):
    for sensors, said in (
        (["doppler"], "'doppler' range, range_rate: from that alone no position follows"),
        (["radar", "altimeter"], "'altimeter' measures height, which is no position"),
    ):
        tables = {**WATCHED, "altimeter": {"kind": "radio_altimeter"}}
        trackers = {"t": {"kind": "kalman", "sensors": sensors}}
        with pytest.raises(ScenarioError) as caught:
            check(prepare(read({**LINE, "sensors": tables, "trackers": trackers})))
        assert said in str(caught.value)
        assert "needs north and east" in str(caught.value) or "uses north and east" in str(caught.value)
        assert len(str(caught.value).splitlines()) == 1


WRONG_SENSORS = {
    "has no 'truth'; 'shortfinal contract' says": ("def truth(", "def exact("),
    "[sensors.doppler] step raises ZeroDivisionError: division by zero": (
        "        def look(",
        "        1 / 0\n\n        def look(",
    ),
    "[sensors.doppler] step gives z of the shape (2,), not (2, 2)": (
        "Look(epoch, epoch, z,",
        "Look(epoch, epoch, z[:, 0],",
    ),
}


@pytest.mark.parametrize("said", WRONG_SENSORS)
def test_a_wrong_sensor_gets_one_sentence(said, tmp_path):
    kind = f"wrong_sensor_{len(said)}"  # classes are remembered by their module
    with (
        dropped(tmp_path, "sensors", kind, DOPPLER.replace(*WRONG_SENSORS[said])),
        pytest.raises(ScenarioError) as caught,
    ):
        sim.run({**LINE, "until_s": 5, "draws": 2, "sensors": {"doppler": {"kind": kind}}})
    assert said in str(caught.value)
    assert len(str(caught.value).splitlines()) == 1
