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
from sim.cli.listing import kind_lines
from sim.errors import ScenarioError
from sim.estimation.trial import maker
from sim.experiment import report
from sim.scenario import catalogue
from sim.scenario.parameters import construct
from sim.scenario.reading import read
from sim.scenario.schema import schema
from sim.scenario.tables import Runway
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
    axes = plan_view(result.flight, result.scenario.runway, (0.0, 0.0), result.scenario.wind.events).axes[0]
    (area,) = axes.patches
    corners = area.get_xy()
    assert np.hypot(corners[:, 0] + 2.5, corners[:, 1]) == pytest.approx(np.full(len(corners), 0.8))
    assert "field" in [text.get_text() for text in axes.texts]
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
    "has no 'words'": ("    def words(self)", "    def told(self)"),
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
