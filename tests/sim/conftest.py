"""Flights made by formula, so that checks and metrics are judged by arithmetic; the command without a process."""

from __future__ import annotations

import sys
from typing import NamedTuple

import numpy as np
import pytest

from aircraft.state import AircraftState, Command
from autopilot.route import Leg, Route
from sim.flight.record import Event, Flight

PHASES = ("final", "glide", "flare", "ground", "go_around")


def made(time, phase, route=None, gate_height=None, **signals):
    """A flight northwards along a line, every other signal zero unless given; command signals carry ``command_``."""
    k = len(time)
    columns = {name: np.zeros(k) for name in AircraftState._fields}
    columns |= {"time": np.asarray(time, float), "velocity_north": np.full(k, 70.0), "airspeed": np.full(k, 70.0)}
    columns["equivalent_airspeed"] = columns["airspeed"]
    columns |= {name: np.asarray(value, float) for name, value in signals.items() if not name.startswith("command_")}
    commands = {name: np.zeros(k) for name in Command._fields} | {"airspeed": np.full(k, 70.0)}
    commands |= {name[8:]: np.asarray(value, float) for name, value in signals.items() if name.startswith("command_")}
    route = route or Route((Leg((-50000.0, 0.0), (300.0, 0.0), 70.0, 400.0),))
    index = np.array([PHASES.index(name) for name in phase])
    events = (Event(0.0, phase[0]),)
    state, command = AircraftState(**columns), Command(**commands)
    return Flight(route, state, command, np.zeros(k, int), index, PHASES, events, "completed", "", gate_height)


@pytest.fixture
def make_flight():
    return made


class Inline:
    """The three calls of an executor in this process."""

    def __init__(self):
        self.jobs = []

    def submit(self, number, function, *arguments):
        self.jobs.append((number, function, arguments))

    def finished(self):
        return ((number, function(*arguments)) for number, function, arguments in self.jobs)

    def close(self):
        self.jobs.clear()


@pytest.fixture(scope="session")
def inline():
    return Inline


@pytest.fixture(scope="session")
def short_flown():
    """The run of tests/short_run.py."""
    import sim
    from tests.short_run import TABLES

    return sim.run(TABLES)


@pytest.fixture(scope="session")
def short_folder(short_flown, tmp_path_factory):
    """Its folder, which is only read."""
    return short_flown.save(tmp_path_factory.mktemp("short") / "run")


class Done(NamedTuple):
    """What a command that has ended leaves at the prompt."""

    returncode: int
    stdout: str
    stderr: str


@pytest.fixture
def command(monkeypatch, capsys, tmp_path):
    """The command without the cost of a new process; an exception that escapes fails the test."""
    from sim.cli.commands import main

    def call(*arguments):
        monkeypatch.chdir(tmp_path)
        monkeypatch.setattr(sys, "argv", ["shortfinal", *map(str, arguments)])
        with pytest.raises(SystemExit) as end:
            main()
        out, err = capsys.readouterr()
        return Done(end.value.code or 0, out, err)

    return call
