"""Borders of theory against flights on both sides of them, and the bundled studies as they are shipped."""

from __future__ import annotations

import json

import numpy as np
import pytest

from sim.errors import ScenarioError
from sim.scenario import catalogue
from sim.scenario.reading import read
from sim.studies import study
from sim.studies.theory import THEORIES, border

POINT_MASS = {"aircraft": {"model": "point_mass"}}
WIND, LIMIT = "wind.speed_mps", "autopilot.law.cross_track_limit_m"


@pytest.mark.parametrize("name", catalogue.studies())
def test_every_bundled_study_says_what_it_shows_and_can_be_planned(name):
    text = catalogue.bundled(name).read_text()
    assert text.startswith("# ")
    assert len(text.splitlines()[0]) > 20
    scenario = read(name)
    assert scenario.name == name
    assert study.plan(scenario).flights > 20


def test_the_orbit_border_is_the_balance_of_bank_far_out():
    """1.656/0.145 s times the closing speed of 72 m/s less the wind, by hand."""
    scenario = read("orbit_map", POINT_MASS)
    assert border("orbit", scenario, np.array([0.0, 12.0])) == pytest.approx([822.3, 685.2], abs=0.1)
    near = read("orbit_map", {**POINT_MASS, "start.cross_track_m": 700.0})
    assert border("orbit", near, np.array([0.0, 12.0])) == pytest.approx([np.inf, 685.2], abs=0.1)


def test_flights_on_both_sides_of_the_border_end_as_theory_says(tmp_path, inline, monkeypatch):
    """15 % off the border, which leaves a bank of 15 % of 8 degrees: enough to see within the flight."""
    monkeypatch.setattr("sim.studies.page.page", lambda *given: "")  # drawn elsewhere
    line = border("orbit", read("orbit_map", POINT_MASS), np.array([0.0, 20.0]))
    limits = [float(round(factor * value)) for value in line for factor in (0.85, 1.15)]
    axes = {"axes": {WIND: [0.0, 20.0], LIMIT: limits}, "theory": "orbit"}
    metrics = study.study("orbit_map", tmp_path, inline(), {**POINT_MASS, "study": axes, "until_s": 330.0})
    ended = {(row[WIND], row[LIMIT]): set(row["outcomes"]) for row in metrics["rows"]}
    for wind, value in zip((0.0, 20.0), line, strict=True):
        for limit in limits:
            assert ended[wind, limit] == {"orbit" if limit > value else "completed"}
    assert json.loads((tmp_path / "metrics.json").read_text())["rows"] == json.loads(json.dumps(metrics["rows"]))


BURST = {"kind": "microburst", "past_threshold_m": -1000.0, "peak_mps": 10.0}
LINE = {"kind": "legs", "legs": [{"from_m": [0, 0], "to_m": [20000, 0], "speed_mps": 72, "height_m": 600}]}
STORM = {"wind": {"events": {"burst": BURST}}}
AXES = {
    "orbit": {WIND: [0.0, 5.0], LIMIT: [300.0, 600.0]},
    "energy": {"wind.events.burst.past_threshold_m": [-1000.0], "wind.events.burst.peak_mps": [5.0, 10.0]},
    "gain": {"autopilot.frequency_share": [0.2], "autopilot.bank_limit_deg": [15.0, 25.0]},
}


@pytest.mark.parametrize(
    ("theory", "tables", "said"),
    [
        ("orbit", {"route": {"kind": "pattern"}}, 'a route of legs, [route] kind = "legs"'),
        ("energy", {"route": LINE, **STORM}, "a landing pattern and a [wind.events.burst]"),
        ("energy", STORM, "a JSBSim aircraft, not the point mass"),
        ("gain", {"route": LINE}, "a JSBSim aircraft, not the point mass"),
    ],
)
def test_a_theory_that_does_not_apply_is_one_sentence_before_anything_flies(theory, tables, said):
    scenario = read({"name": "other", **POINT_MASS, **tables, "study": {"axes": AXES[theory], "theory": theory}})
    with pytest.raises(ScenarioError) as caught:
        study.plan(scenario)
    assert str(caught.value) == f'other: [study] theory "{theory}" needs {said}'


@pytest.mark.parametrize("theory", ["orbit", "gain"])
def test_a_theory_of_the_route_law_is_refused_to_any_other(theory):
    tables = {"name": "other", "route": LINE, "autopilot": {"kind": "radio_beacon"}}
    said = "a law of the cross-track and its rate, such as 'lateral_navigation', not 'radio_beacon'"
    assert THEORIES[theory].needs(read(tables)) == said
    assert "law" not in THEORIES[theory].needs(read({**tables, "autopilot": {}}))


def test_the_theory_of_energy_needs_its_burst():
    assert THEORIES["energy"].needs(read({"name": "calm"})) == "a landing pattern and a [wind.events.burst]"


def test_a_theory_about_other_axes_is_refused():
    with pytest.raises(ScenarioError, match='theory "orbit" is about the axes'):
        study.plan(read("orbit_map", {**POINT_MASS, "study": {"axes": {LIMIT: [300.0]}, "theory": "orbit"}}))
