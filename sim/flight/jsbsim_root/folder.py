"""A JSBSim root with one aircraft that flies one scenario, written whole or not at all."""

from __future__ import annotations

import os
import shutil
import xml.etree.ElementTree as ElementTree
from pathlib import Path, PurePosixPath
from typing import Any, NamedTuple

from aircraft.executive import PLANET
from sim.errors import OutputError, ScenarioError
from sim.files import claim, only_writer, refuse_foreign, unstopped
from sim.flight.jsbsim_root.crew import Crew
from sim.flight.jsbsim_root.script import START, Start, initial, script
from sim.flight.jsbsim_root.system import NAME, System
from sim.flight.outcomes import LONGEST_FLIGHT
from sim.flight.preparation import MODEL_TIME_LIMIT, Prepared
from sim.flight.vehicles import JsbsimVehicle
from sim.flight.weather import air
from sim.interchange.jsbsim_system.components import Element
from sim.interchange.jsbsim_system.terms import Refused
from sim.workers.isolation import run_isolated

KIND = "jsbsim"  # of a folder
SCRIPT = PurePosixPath("scripts/flight.xml")
WAIT = 60.0  # s, for another process that writes the same folder


class Root(NamedTuple):
    """What a JSBSim root holds: the text of each file by its path."""

    files: dict[PurePosixPath, str]
    components: int
    rate: float  # Hz


def jsbsim_root(prepared: Prepared) -> Root:
    """The files of a root in which JSBSim alone flies what ``sim.fly`` flies.

    Raises ``ScenarioError`` with one sentence for what cannot be said in JSBSim.
    """
    _refuse(prepared)
    return run_isolated(prepared.scenario, MODEL_TIME_LIMIT, _root, prepared)


def write_jsbsim_root(prepared: Prepared, folder: Path) -> Root:
    """Write such a root into ``folder``: new, empty, or written for the same; raises ``OutputError`` otherwise."""
    refuse_foreign(folder, KIND)
    root = jsbsim_root(prepared)
    claim(folder, KIND)
    staging = folder / ".partial"
    try:
        with only_writer(folder, WAIT):
            try:
                shutil.rmtree(staging, ignore_errors=True)
                for path, text in root.files.items():
                    file = staging / path
                    file.parent.mkdir(parents=True, exist_ok=True)
                    file.write_text(text, encoding="utf-8")
                with unstopped():
                    for place in sorted(staging.iterdir()):
                        shutil.rmtree(folder / place.name, ignore_errors=True)
                        os.replace(place, folder / place.name)
            finally:
                shutil.rmtree(staging, ignore_errors=True)
    except OSError as error:
        raise OutputError(f"{folder}: cannot be written: {error.strerror}") from None
    return root


def _refuse(prepared: Prepared) -> None:
    """Raise ``ScenarioError`` for what is not flown by an autopilot alone in air that can be foretold."""
    scenario = prepared.scenario
    if prepared.recording is not None:
        why = "a recorded flight has no autopilot that could fly it"
    elif not isinstance(prepared.vehicle, JsbsimVehicle):
        why = "the point mass is no aircraft of JSBSim: name one as aircraft.model"
    elif scenario.autopilot.navigation != "truth":
        why = f"it is navigated by the tracker '{scenario.autopilot.navigation}', which runs in Python only"
    elif scenario.navigation_errors is not None:
        why = "the errors of its navigation are drawn in Python: leave them out"
    elif scenario.wind.intensity > 0.0:
        why = "its turbulence is drawn in Python: set wind.turbulence to 'none'"
    else:
        return
    raise ScenarioError(f"{scenario.name}: cannot be flown by JSBSim alone: {why}")


def _root(prepared: Prepared) -> Root:
    scenario, begins = prepared.scenario, prepared.initial
    wind = air(scenario.wind, scenario.runway)
    assert isinstance(prepared.vehicle, JsbsimVehicle)
    body = prepared.vehicle.begin(begins, wind)
    airframe, state = body.airframe, body.state
    source, wiring, still = airframe.source, airframe.wiring, airframe.air
    assert source is not None
    crew = Crew(prepared.controller, body.inner_loops)
    try:
        system = System(wiring, airframe.rate, scenario.runway).element(crew, crew.begin(state, begins.leg), wind)
    except Refused as refused:
        raise ScenarioError(f"{scenario.name}: cannot be flown by JSBSim alone: {refused}") from None
    start = Start(
        state,
        None if still.is_standard else (still.temperature_shift, still.sea_level_pressure),
        (*wind.velocity(0.0, (begins.north, begins.east, begins.height), begins.airspeed)[:2], 0.0),
        scenario.runway.elevation,
    )
    end = LONGEST_FLIGHT if scenario.until is None else min(scenario.until, LONGEST_FLIGHT)
    run = script(scenario.name, source.name, start, wiring, airframe.has, airframe.rate, end)
    home = PurePosixPath("aircraft", source.name)
    files = {
        home / source.name: _with_system(source.root),
        home / START: initial(start),
        PurePosixPath("systems", NAME): system,
        SCRIPT.with_suffix(""): run,
        **source.files,
    }
    return Root(
        {path.with_name(f"{path.name}.xml"): _text(tree) for path, tree in files.items()},
        sum(1 for _ in system.iter("fcs_function")),
        airframe.rate,
    )


def _with_system(model: Element) -> Element:
    """The model on our earth, its system before its own ones, which would move the controls too."""
    ours: list[Any] = [ElementTree.fromstring(PLANET), Element("system", {"file": NAME})]
    held = [place for place, section in enumerate(model) if section.tag == "system" and "file" not in section.attrib]
    place = held[0] + 1 if held else 0
    model[place:place] = ours
    return model


def _text(tree: Element) -> str:
    ElementTree.indent(tree)
    return ElementTree.tostring(tree, encoding="unicode", xml_declaration=True) + "\n"
