"""Borders of theory against flights on both sides of them, and the bundled studies as they are shipped."""

from __future__ import annotations

import json

import numpy as np
import pytest

from sim.errors import ScenarioError
from sim.scenario import catalogue
from sim.scenario.reading import read
from sim.studies import study
from sim.studies.theory import border

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


def test_flights_on_both_sides_of_the_border_end_as_theory_says(tmp_path):
    """15 % off the border, which leaves a bank of 15 % of 8 degrees: enough to see within the flight."""

    class Inline:
        jobs = ()

        def submit(self, number, function, *arguments):
            self.jobs = (*self.jobs, (number, function, arguments))

        def finished(self):
            for number, function, arguments in self.jobs:
                yield number, function(*arguments)

        def close(self):
            pass

    line = border("orbit", read("orbit_map", POINT_MASS), np.array([0.0, 20.0]))
    limits = [float(round(factor * value)) for value in line for factor in (0.85, 1.15)]
    axes = {"axes": {WIND: [0.0, 20.0], LIMIT: limits}, "theory": "orbit"}
    metrics = study.study("orbit_map", tmp_path, Inline(), {**POINT_MASS, "study": axes, "until_s": 330.0})
    ended = {(row[WIND], row[LIMIT]): set(row["outcomes"]) for row in metrics["rows"]}
    for wind, value in zip((0.0, 20.0), line, strict=True):
        for limit in limits:
            assert ended[wind, limit] == {"orbit" if limit > value else "completed"}
    assert json.loads((tmp_path / "metrics.json").read_text())["rows"] == json.loads(json.dumps(metrics["rows"]))


def test_a_theory_of_legs_is_refused_for_a_pattern_before_anything_is_flown():
    axes = {"axes": {WIND: [0.0, 5.0], LIMIT: [300.0, 600.0]}, "theory": "orbit"}
    on_a_pattern = {"name": "p", "aircraft": {"model": "point_mass"}, "route": {"kind": "pattern"}, "study": axes}
    with pytest.raises(ScenarioError, match='theory "orbit" needs a route of legs') as caught:
        study.plan(read(on_a_pattern))
    assert "\n" not in str(caught.value)


def test_a_theory_about_other_axes_is_refused():
    with pytest.raises(ScenarioError, match='theory "orbit" is about the axes'):
        study.plan(read("orbit_map", {**POINT_MASS, "study": {"axes": {LIMIT: [300.0]}, "theory": "orbit"}}))
