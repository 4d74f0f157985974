"""Linear models against the flight of the aircraft, and against the margins that are worked out without them."""

from __future__ import annotations

import xml.etree.ElementTree as ElementTree

import control
import numpy as np
import pytest

from autopilot.route_loop import STEP, margins
from sim.cli.explain import draw_loops
from sim.errors import OutputError, ScenarioError
from sim.experiment import fly, read
from sim.flight.linear_systems.systems import linear
from sim.flight.preparation import prepare
from sim.reporting.loop_figures.bode import bode
from sim.reporting.loop_figures.step import step

SMALL = 8.0  # m beside the line, which asks for 1.2 deg of bank: inside all limits but that of the roll rate


@pytest.fixture(scope="module")
def capture():
    return prepare(read("route_capture", {"start.cross_track_m": SMALL, "until_s": 40}))


def test_closed_loop_is_how_the_aircraft_flies(capture):
    """From rest a line that lies ``SMALL`` to the left is met as the aircraft meets it that begins to the right."""
    loops, flight = linear(capture), fly(capture, 0)
    time, there = flight.time - flight.time[0], flight.deviation.cross_track
    outputs = control.step_response(loops.closed * -SMALL, STEP * np.arange(len(time))).outputs[1, 0]
    assert np.abs(there - (SMALL + outputs)).max() < 0.05 * SMALL  # the limit of the roll rate acts in the first second
    assert abs(there[-1]) < 0.1 * SMALL


def test_signals_have_names_and_units(capture):
    loops = linear(capture)
    assert loops.aircraft.input_labels == ["throttle", "elevator", "aileron", "rudder"]
    assert loops.aircraft.output_labels[:5] == [
        *("airspeed_mps", "angle_of_attack_rad", "pitch_rate_radps", "pitch_rad", "height_m")
    ]
    assert loops.closed.output_labels == ["bank_rad", "cross_track_m", "cross_track_rate_mps", "aileron_command"]
    assert loops.aircraft.isctime()
    assert loops.opened.dt == loops.closed.dt == loops.bank.dt == STEP
    assert loops.leg == capture.route.legs[0]


def test_heading_and_path_of_the_sampled_states_are_named_in_their_order(capture):
    """A step of the bank command to the right: the named states move as they are called."""
    bank = linear(capture).bank
    moved = control.step_response(bank * 0.01, STEP * np.arange(91))
    states = dict(zip(bank.state_labels, moved.states[:, 0, -1], strict=True))
    assert states["bank_rad"] == pytest.approx(0.01, rel=0.15)
    assert states["bank_reference_rad"] == pytest.approx(0.01, rel=0.01)
    assert states["heading_rad"] > 0.0
    assert states["cross_track_m"] > 0.0
    assert states["yaw_rate_radps"] == pytest.approx(9.80665 / 72.0 * states["bank_rad"], rel=0.15)


def test_margins_are_those_of_python_control(capture):
    loops = linear(capture)
    found = margins(loops.loop, loops.law)
    frequency = np.array([found.phase_crossover, found.gain_crossover])
    response = loops.opened(np.exp(1j * STEP * frequency))
    assert response[0] == pytest.approx(-1.0 / found.gain, rel=1e-6)
    assert abs(response[1]) == pytest.approx(1.0, rel=1e-6)
    gain = bode(loops.loop, loops.law).panels[0].marks[0]
    there = np.abs(loops.opened(np.exp(1j * STEP * np.asarray(gain.x[::100]))))
    assert gain.y[::100] == pytest.approx(20.0 * np.log10(there), abs=1e-6)


def test_figures_are_written_whole(capture, tmp_path):
    wanted = {"bode": tmp_path / "bode.svg", "step": tmp_path / "step.svg"}
    assert draw_loops(capture.scenario, wanted) == list(wanted.values())
    for path in wanted.values():
        assert ElementTree.fromstring(path.read_text()).tag.endswith("svg")
    ends = [panel.marks[0].y[-1] for panel in step(linear(capture).loop, linear(capture).law).panels]
    assert ends == pytest.approx([1.0, 10.0, 0.0], abs=0.03)
    with pytest.raises(OutputError, match=r"name it NAME\.svg"):
        draw_loops(capture.scenario, {"bode": tmp_path / "bode.pdf"})
    with pytest.raises(ScenarioError, match="margins need a JSBSim aircraft under a route law"):
        linear("beacon_homing")
