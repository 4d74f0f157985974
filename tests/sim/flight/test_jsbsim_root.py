"""A scenario flown by JSBSim alone: in lock step with the Python it was translated from, and as ``fly`` flies it."""

from __future__ import annotations

import dataclasses
import xml.etree.ElementTree as ElementTree

import numpy as np
import pytest

import sim.flight.jsbsim_root.folder as roots
from aircraft import properties
from sim.cli.exporting.others import export_jsbsim
from sim.errors import OutputError, ScenarioError
from sim.experiment import fly, read
from sim.flight.jsbsim_root.folder import SCRIPT, write_jsbsim_root
from sim.flight.preparation import prepare
from tests.jsbsim_alone import Alone, departures

FINAL = {"start.phase": "final", "start.distance_m": 1400, "seed": 1}  # 65 m above the ground, 20 s from it


@pytest.fixture(scope="module")
def final():
    return prepare(read("an26_pattern", FINAL))


def test_lock_step_down_to_the_ground(final, tmp_path):
    """The same controls to 1e-12 for the same motion, through the glide path, the gate, the flare and the touchdown."""
    write_jsbsim_root(final, tmp_path / "root")
    alone = Alone(final, tmp_path / "root")
    apart, phases = [], set()
    for orders in alone.steps():
        apart.append(alone.apart(orders))
        phases.add(alone.phase)
    assert len(apart) > 200
    assert {"glide", "flare"} <= phases
    assert max(apart) <= 1e-12


def test_lock_step_sees_another_law(final, tmp_path):
    """A gain that is one in a million off is no lock step."""
    law = final.law
    other = dataclasses.replace(final.autopilot, law=dataclasses.replace(law, k1=law.k1 * 1.000001))
    begins = final.initial._replace(east=final.initial.east + 20.0)
    final = dataclasses.replace(final, initial=begins)
    write_jsbsim_root(final, tmp_path / "root")
    alone = Alone(dataclasses.replace(final, autopilot=other), tmp_path / "root")
    assert max(alone.apart(orders) for orders, _ in zip(alone.steps(), range(60), strict=False)) > 1e-9


@pytest.mark.parametrize(
    ("name", "changes"),
    [
        ("route_capture", {"until_s": 12, "start.cross_track_m": 400}),
        (
            "an26_pattern",
            {"until_s": 12, **FINAL, "wind.from_deg": 200, "wind.speed_mps": 6, "runway.elevation_m": 600},
        ),
        (
            "an26_pattern",
            {
                **{"until_s": 12, **FINAL, "wind.from_deg": 70, "wind.speed_mps": 5, "wind.shear": "logarithmic"},
                "wind.events.bump": {"kind": "gust", "up_mps": 5, "at_s": 3, "lasts_s": 3},
                "wind.events.burst": {"kind": "microburst", "peak_mps": 6, "past_threshold_m": -800},
                "air.temperature_c": 30,
            },
        ),
    ],
)
def test_jsbsim_alone_flies_as_fly_does(name, changes, tmp_path):
    """In calm air, in wind above a high runway, and in air that is worked out in the system too."""
    prepared = prepare(read(name, changes))
    write_jsbsim_root(prepared, tmp_path / "root")
    flight = fly(prepared, 0)
    assert flight.time[-1] == pytest.approx(12.0)
    assert np.ptp(flight.command.bank) + np.ptp(flight.command.height) > 0.1  # it is no cruise
    place, bank = departures(Alone(prepared, tmp_path / "root"), flight)
    assert place < 1e-6  # m: roundings
    assert bank < 1e-8  # rad


def test_it_ends_where_it_has_landed_and_says_where(final, tmp_path):
    write_jsbsim_root(final, tmp_path / "root")
    alone = Alone(final, tmp_path / "root")
    for _ in alone.frames():
        pass
    flight = fly(final, 0)
    past, right = final.scenario.runway.from_local(flight.state.north[-1], flight.state.east[-1])
    assert flight.outcome == "landed"
    assert alone["shortfinal/touchdown/past-threshold-m"] == pytest.approx(past, abs=2.0)  # a record at 55 m/s
    assert alone["shortfinal/touchdown/right-of-centreline-m"] == pytest.approx(right, abs=0.1)
    assert 0.2 < alone["shortfinal/touchdown/sink-mps"] < 1.0
    assert alone["simulation/sim-time-sec"] == pytest.approx(flight.time[-1], abs=0.05)


def test_another_step_of_the_motion_ends_at_once(final, tmp_path):
    root = write_jsbsim_root(final, tmp_path / "root")
    alone = Alone(final, tmp_path / "root", rate=root.rate / 2.0)
    assert sum(1 for _ in alone.frames()) <= 1


def test_nothing_is_named_twice_and_nothing_leaves_but_the_record(final, tmp_path):
    root = write_jsbsim_root(final, tmp_path / "root")
    trees = {path: ElementTree.fromstring(text) for path, text in root.files.items()}
    files = [(path, element) for path, tree in trees.items() for element in tree if element.tag in ("output", "input")]
    assert [(path, element.get("name"), element.get("type")) for path, element in files] == [
        (SCRIPT, "an26_pattern.csv", "CSV")
    ]
    names = [one.get("name") for tree in trees.values() if tree.tag == "system" for one in tree.iter("fcs_function")]
    assert len(names) == root.components
    twice = {name for name in names if names.count(name) > 1}
    assert twice == {"shortfinal/rhythm/frames-to-wait"}  # set by a step, counted down by every frame
    assert {of.name for of in properties.SURFACES} <= set(names)


@pytest.mark.parametrize(
    ("name", "changes", "why"),
    [
        ("an26_pattern", {"wind.turbulence": "light"}, "its turbulence is drawn in Python"),
        ("route_capture_point_mass", {}, "the point mass is no aircraft of JSBSim"),
        ("an26_talkdown", {}, "navigated by the tracker 'saturated_control'"),
    ],
)
def test_what_jsbsim_cannot_fly_is_said_and_nothing_written(name, changes, why, tmp_path):
    with pytest.raises(ScenarioError, match=why):
        export_jsbsim(name, tmp_path / "root", changes, ())
    assert not list(tmp_path.iterdir())


LAW = '''
from dataclasses import dataclass

@dataclass(frozen=True)
class Searching:
    """Halves a bank until it is small."""

    bank_limit: float

    def __call__(self, deviation):
        bank = -0.001 * deviation.cross_track
        while bank > self.bank_limit:
            bank /= 2.0
        return max(bank, -self.bank_limit)

SHORTFINAL = {"modes": {"searching": Searching}}
'''


def test_a_law_that_cannot_be_translated_is_refused_with_its_line(tmp_path):
    plugin = tmp_path / "searching.py"
    plugin.write_text(LAW)
    changes = {"autopilot.kind": "searching"}
    with pytest.raises(ScenarioError, match=r"searching.py, line 12, in Searching.__call__: 'while .*' is not known"):
        export_jsbsim("route_capture", tmp_path / "root", changes, (plugin,))
    assert not (tmp_path / "root").exists()


def test_a_folder_is_ours_or_left_alone_and_never_half_written(final, tmp_path, monkeypatch):
    mine = tmp_path / "mine"
    mine.mkdir()
    (mine / "thesis.tex").write_text("years")
    with pytest.raises(OutputError, match="holds files that shortfinal did not write"):
        write_jsbsim_root(final, mine)
    assert [path.name for path in mine.iterdir()] == ["thesis.tex"]

    ours = tmp_path / "ours"
    write_jsbsim_root(final, ours)
    before = {path: path.read_bytes() for path in ours.rglob("*") if path.is_file()}
    assert len(before) == 5

    def full(*_):
        raise OSError(28, "No space left on device")

    monkeypatch.setattr(roots.os, "replace", full)
    with pytest.raises(OutputError, match="cannot be written: No space left"):
        write_jsbsim_root(final, ours)
    monkeypatch.undo()
    assert not (ours / ".partial").exists()
    write_jsbsim_root(final, ours)
    assert {path: path.read_bytes() for path in ours.rglob("*") if path.is_file()} == before
