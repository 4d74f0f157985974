"""One file in the folder of modes is a mode everywhere: flown, tracked, explained, drawn; no other file knows it."""

from __future__ import annotations

import dataclasses
import shutil
import sys
from pathlib import Path

import numpy as np
import pytest

import autopilot.modes
from autopilot.mode import TRIAL, broken_promises
from autopilot.modes.lateral_navigation import LateralNavigation
from sim.cli.contract import examine
from sim.cli.explain import explain
from sim.cli.listing import kind_lines
from sim.errors import ScenarioError
from sim.estimation.setup import build, check
from sim.experiment import fly, report, run
from sim.flight.preparation import prepare
from sim.scenario import catalogue
from sim.scenario.plugins import Catalogue
from sim.scenario.reading import read
from sim.workers.sharing import helper

PART = Path(__file__).parent.parent / "parts" / "wings_level.py"
RADAR = {"radar": {"kind": "surveillance_radar", "position_m": [3000, 4000, 10]}}


@pytest.fixture
def folder(tmp_path, monkeypatch):
    """A further folder of modes, empty."""
    monkeypatch.setattr(autopilot.modes, "__path__", [*autopilot.modes.__path__, str(tmp_path)])
    yield tmp_path
    for file in tmp_path.glob("*.py"):
        sys.modules.pop(f"autopilot.modes.{file.stem}", None)
        if hasattr(autopilot.modes, file.stem):
            delattr(autopilot.modes, file.stem)


@pytest.fixture
def wings_level(folder):
    shutil.copy(PART, folder)


LEAST = """
from dataclasses import dataclass
from typing import Annotated, Any


@dataclass(frozen=True)
class WingsLevel:
    k1: Annotated[Any, "rad/m"]
    k2: Annotated[Any, "rad/(m/s)"]
    bank_limit: Annotated[Any, "rad"]
    cross_track_limit: Annotated[Any, "m"]
    cross_track_rate_limit: Annotated[Any, "m/s"]

    def __call__(self, deviation: Any) -> Any:
        return 0.0 * deviation.cross_track
"""


@pytest.fixture
def least(folder):
    """A mode that says no more than it must."""
    (folder / "wings_level.py").write_text(LEAST)


def scenario(**tables):
    return read(
        {
            "name": "mode",
            "until_s": 60,
            "draws": 2,
            "aircraft": {"model": "point_mass"},
            "start": {"leg": 0, "cross_track_m": 2000},
            "route": {
                "kind": "legs",
                "legs": [{"from_m": [0, 0], "to_m": [30000, 0], "speed_mps": 80, "height_m": 600}],
            },
            "autopilot": {"kind": "wings_level"},
            **tables,
        }
    )


@pytest.mark.usefixtures("wings_level")
def test_it_is_flown_tracked_and_reported(tmp_path):
    trackers = {"told": {"kind": "saturated_control"}}
    result = run(scenario(sensors=RADAR, trackers=trackers))
    flight = result.flight
    assert not flight.command.bank.any()
    assert not flight.state.bank.any()
    np.testing.assert_allclose(flight.deviation.cross_track, 2000.0, atol=1e-6)
    told = result.metrics["trackers"]["told"]
    assert told["lost_fraction"] == 0.0  # it knows that the aircraft does not turn, 2 km beside its leg
    assert told["overall"]["position_m"]["gain_low"] > 1.0
    out = tmp_path / "out"
    out.mkdir()
    report(result, out)
    page = (out / "report.html").read_text()
    assert "wings_level" in page
    assert "Phase portrait of the law" in page


@pytest.mark.usefixtures("wings_level")
def test_it_is_listed_and_explained():
    assert any(line.split()[:1] == ["wings_level"] for line in kind_lines())
    assert "bank = 0, whatever the deviation; turns are planned at 15.0 deg" in explain(scenario())


@pytest.mark.usefixtures("wings_level")
def test_it_keeps_the_contract():
    assert broken_promises(catalogue.load("modes", "wings_level")) == []


@pytest.mark.usefixtures("wings_level")
def test_a_tracker_of_intercepts_refuses_a_law_that_has_none():
    prepared = prepare(scenario(sensors=RADAR, trackers={"intents": {"kind": "intent_imm"}}))
    with pytest.raises(ScenarioError, match=r"^\[trackers.intents\] the wings-level law names no limit") as caught:
        check(prepared)
    assert "\n" not in str(caught.value)


@pytest.mark.usefixtures("wings_level")
def test_a_crew_can_switch_to_it():
    switched = scenario(autopilot={}, departures=[{"at_s": 10, "flies": "wings_level"}], until_s=20)
    flight = fly(prepare(switched))
    assert abs(flight.command.bank[flight.time < 10.0]).max() > 0.1
    assert not flight.command.bank[flight.time > 14.0].any()
    assert "the wings level law flies" in explain(switched)


def intents_of(prepared):
    return build(prepared, "intents", prepared.scenario.trackers["intents"])[0].intents


def test_a_mode_that_is_not_standard_changes_no_other_scenario(folder):
    """Only a mode that says that every crew has it is weighed beside the laws of the others."""
    tables = {"autopilot": {}, "sensors": RADAR, "trackers": {"intents": {"kind": "intent_imm"}}}
    before = intents_of(prepare(scenario(**tables)))
    assert set(before) == {"route law", "beacon law", "manual"}
    shutil.copy(PART, folder)
    assert intents_of(prepare(scenario(**tables))) == before
    text = PART.read_text().replace("standard: ClassVar[bool] = False", "standard: ClassVar[bool] = True")
    (folder / "always_level.py").write_text(text)
    assert set(intents_of(prepare(scenario(**tables)))) == {*before, "wings-level law"}


def test_a_law_of_any_other_name_is_designed_and_known_to_theory(folder):
    """The route law in a file of its own flies bit for bit as the bundled one, and its loop is judged by theory."""
    source = Path(sys.modules[LateralNavigation.__module__].__file__).read_text()
    (folder / "nameless.py").write_text(source.replace("LateralNavigation", "Nameless"))
    flights = [fly(prepare(scenario(autopilot={"kind": kind}))) for kind in ("lateral_navigation", "nameless")]
    np.testing.assert_array_equal(flights[0].state.bank, flights[1].state.bank)
    assert abs(flights[0].state.bank).max() > 0.1
    other = catalogue.load("modes", "nameless").designed({}, TRIAL)
    assert dataclasses.asdict(LateralNavigation.of(other)) == dataclasses.asdict(other)


@pytest.mark.parametrize(
    ("old", "new", "told"),
    [
        (
            "bank_limit: Annotated",
            "limit: Annotated",
            "kind 'wings_level' has no 'bank_limit'; 'shortfinal contract' says",
        ),
        ("def __call__", "def bank", "has no '__call__'"),
    ],
)
def test_a_file_that_is_no_whole_mode_is_told_in_one_sentence(folder, old, new, told):
    (folder / "wings_level.py").write_text(PART.read_text().replace(old, new))
    with pytest.raises(ScenarioError, match=told) as caught:
        prepare(scenario())
    assert "\n" not in str(caught.value)


def test_a_departure_to_an_unknown_law_names_those_there_are():
    departures = [{"at_s": 10, "flies": "beacno"}]
    with pytest.raises(ScenarioError, match=r"\[\[departures\]\] flies: no law 'beacno'; did you mean 'beacon'"):
        prepare(scenario(autopilot={}, departures=departures))


def test_a_law_on_the_heading_is_flown_as_the_file_says():
    law = prepare(scenario(autopilot={"kind": "radio_beacon", "law": {"course": "heading"}})).law
    assert law.limits()[1].of == "heading_error"


def test_a_word_of_a_law_has_no_factor():
    told = {"kind": "saturated_control", "law": {"course_factor": 2.0}}
    with pytest.raises(ScenarioError, match="course_factor: no such key; allowed: k3_factor"):
        check(prepare(scenario(autopilot={"kind": "radio_beacon"}, sensors=RADAR, trackers={"told": told})))


def test_a_mode_that_says_only_its_bank_flies_and_is_drawn(least, tmp_path):
    """Its parameters are those of the design under the same names; trackers run in a helper process as well."""
    trackers = {name: {"kind": "kalman", "sensors": ["radar"]} for name in ("a", "b", "c")}
    trackers["law"] = {"kind": "saturated_control", "sensors": ["radar"]}
    flown = scenario(sensors=RADAR, trackers=trackers)
    with helper(True):
        result = run(flown)
        report(result, tmp_path / "out")
    assert np.abs(result.flight.state.bank).max() == 0.0
    assert result.prepared.law.k1 == result.prepared.designed.k1
    assert "law wings level" in (tmp_path / "out/report.html").read_text()
    assert "bank_limit 0.26" in explain(flown)


def test_a_mode_that_says_only_its_bank_keeps_the_contract(least):
    assert examine("wings_level", Catalogue()) == ("modes.wings_level", [])


def test_a_law_that_fails_in_flight_is_told_in_one_sentence(folder):
    text = LEAST.replace("return 0.0 * deviation.cross_track", "return 0.0 * deviation.crosstrack")
    (folder / "wings_level.py").write_text(text)
    with pytest.raises(ScenarioError) as caught:
        run(scenario())
    told = "kind 'wings_level' (line 15) raises AttributeError: 'PathDeviation' object has no attribute 'crosstrack'"
    assert str(caught.value) == f"mode: [autopilot] {told} in flight"


def test_a_default_of_the_class_is_not_replaced_by_the_design(folder):
    (folder / "wings_level.py").write_text(
        LEAST.replace('"rad/m"]', '"rad/m"] = 0.5')
        .replace('"rad/(m/s)"]', '"rad/(m/s)"] = 0.5')
        .replace('bank_limit: Annotated[Any, "rad"]', 'bank_limit: Annotated[Any, "rad"] = 1.0')
        .replace('"m"]', '"m"] = 9.0')
        .replace('"m/s"]', '"m/s"] = 9.0')
    )
    law = prepare(scenario()).law
    assert (law.k1, law.k2, law.cross_track_limit) == (0.5, 0.5, 9.0)
    assert law.bank_limit == pytest.approx(np.radians(15.0))


def test_a_file_that_is_no_python_is_told_with_its_line(folder):
    (folder / "wings_level.py").write_text("class WingsLevel\n")
    with pytest.raises(ScenarioError, match=r"autopilot.modes.wings_level: cannot be imported: .* \(line 1\)"):
        scenario()


def test_a_bank_that_is_no_number_ends_the_flight(folder):
    """It is flown no further, and no check passes on what follows."""
    late = "return (np.nan if deviation.distance_to_go < 29_000.0 else 0.0) + 0.0 * deviation.cross_track"
    (folder / "wings_level.py").write_text(
        "import numpy as np\n" + LEAST.replace("return 0.0 * deviation.cross_track", late)
    )
    flight = fly(prepare(scenario()))
    assert (flight.outcome, flight.reason) == ("diverged", "the law commands a bank of nan rad")
    assert 12.0 < flight.time[-1] < 13.0  # 1000 m at 80 m/s
