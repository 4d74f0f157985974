"""Flights to be identified: of a file of recordings, or of the folder of a run."""

from __future__ import annotations

import os
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np

from aircraft.state import AircraftState, Command
from sim.errors import OutputError, ScenarioError
from sim.experiment import read
from sim.files import DAMAGED, MARK, opened, refuse_links
from sim.flight.preparation import prepare
from sim.flight.record import Flight
from sim.reporting.run_files import state_name
from sim.studies.folder import IDENTITY

SCENARIO, RECORD = "scenario.toml", "flight.npz"


def flights_of(source: Path, runway: Path | None, plugins: Any = ()) -> Mapping[str, Flight]:
    """Flights by name; raises ``OutputError`` or ``ScenarioError`` in one sentence for what holds none."""
    if source.is_dir():
        if runway is not None:
            raise OutputError(f"{source}: is a folder, and a run has its own runway; leave out --runway")
        return {source.name: _of_run(source, plugins)}
    if runway is None:
        raise OutputError(f"{source}: say --runway FILE, the runway that the flights land on")
    from sim.flight.recording.flights import recorded

    flights: Mapping[str, Flight] = recorded(source, runway)
    return flights


def _of_run(folder: Path, plugins: Any) -> Flight:
    """The flight that a run kept, with the route of its scenario."""
    if not (folder / MARK).is_file() or (folder / IDENTITY).is_file():
        raise OutputError(f"{folder}: not a run folder; name one that 'shortfinal run' wrote, or a file of recordings")
    refuse_links(folder)
    scenario = read(str(folder / SCENARIO), plugins=plugins)
    route = prepare(scenario).route
    path = folder / RECORD
    try:
        with os.fdopen(opened(path, os.O_RDONLY), "rb") as file, np.load(file) as arrays:
            state = AircraftState(*(arrays[state_name(name)] for name in AircraftState._fields))
            leg, phase, phases = arrays["leg"], arrays["phase"], tuple(map(str, arrays["phases"]))
    except FileNotFoundError:
        raise OutputError(f"{path}: missing; run the scenario again") from None
    except DAMAGED:
        raise OutputError(f"{path}: damaged; run the scenario again") from None
    if int(np.max(leg, initial=0)) >= len(route.legs):
        raise ScenarioError(f"{folder}: its flight and its scenario are not of one run; run the scenario again")
    command = Command(*(np.full(len(leg), np.nan) for _ in Command._fields))
    return Flight(route, state, command, leg, phase, phases, (), "", "")
