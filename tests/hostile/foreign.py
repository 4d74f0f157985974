"""Aircraft of others as they lie on disk: small models made from the An-26, one for each way in which folders vary.

Each has its layout, what is to be said of it as it lies, and what repairs hold at zero.
"""

from __future__ import annotations

import os
from collections.abc import Callable, Iterable, Mapping
from pathlib import Path
from typing import NamedTuple

from aircraft.model_files import stock_root
from tests.hostile.models import FLIES, GOOD, control, own

ENGINE = '<electric_engine name="none"><power unit="WATTS">0.0001</power></electric_engine>'
THRUSTER = '<direct name="none"/>'
POWERED = (
    own(
        '<propulsion><engine file="ENGINE"><location unit="M"><x>0</x><y>0</y><z>0</z></location>'
        '<orient unit="DEG"><roll>0</roll><pitch>0</pitch><yaw>0</yaw></orient>'
        '<thruster file="THRUSTER"><location unit="M"><x>0</x><y>0</y><z>0</z></location>'
        '<orient unit="DEG"><roll>0</roll><pitch>0</pitch><yaw>0</yaw></orient></thruster></engine></propulsion>'
    )
    .replace("ENGINE", "my_engine")
    .replace("THRUSTER", "my_thruster")
)
STOCK_POWERED = POWERED.replace("my_engine", "electric_1mw").replace("my_thruster", "direct")
SYSTEM = '<system name="mine"><property value="1">mine/one</property></system>'
WITH_SYSTEM = own('<system file="my_system"/>')
ENGINES = {"my_engine.xml": ENGINE, "my_thruster.xml": THRUSTER}


class Foreign(NamedTuple):
    """An aircraft in a folder of its own below a place of tests."""

    named: str  # what a scenario names, below the place
    files: Mapping[str, str]  # below the place
    said: str = FLIES  # as it lies: a regular expression, or FLIES
    held: tuple[str, ...] | None = None  # what repairs hold at zero; None = repairs do not make it fly
    links: Mapping[str, str] = {}
    then: Callable[[Path], None] | None = None  # what else is done to the place

    def write(self, place: Path) -> Path:
        """Lay it down; returns what a scenario names."""
        for name, text in self.files.items():
            (place / name).parent.mkdir(parents=True, exist_ok=True)
            (place / name).write_text(text, encoding="utf-8")
        for name, to in self.links.items():
            (place / name).parent.mkdir(parents=True, exist_ok=True)
            (place / name).symlink_to(to)
        if self.then is not None:
            self.then(place)
        return place / self.named


def within(folder: str, files: Mapping[str, str]) -> dict[str, str]:
    """Files in a folder."""
    return {f"{folder}/{name}": text for name, text in files.items()}


def alone(text: str) -> dict[str, str]:
    """The one file of a model in the folder ``plane``."""
    return {"plane/plane.xml": text}


def rooted(text: str) -> dict[str, str]:
    """The same in the usual root."""
    return {"root/aircraft/plane/plane.xml": text}


def lacking(text: str, *names: str) -> Foreign:
    """A model that reads properties of another simulator: all are named, and repairs hold them."""
    return Foreign("plane", alone(text), ".*".join(("nothing here sets", *names, "aircraft.repairs = true")), names)


def switched(test: str) -> str:
    """The An-26 with a switch."""
    return control(f'<switch name="mine/s"><default value="0"/><test logic="AND" value="1">{test}</test></switch>')


def gain(name: str, more: str = "") -> str:
    """A component that reads a property."""
    return f'<pure_gain name="mine/g{len(name)}"><input>{name}</input><gain>1</gain>{more}</pure_gain>'


def piped(place: Path) -> None:
    """Put a pipe, on which a reader waits for ever, where the engine is sought."""
    (place / "root/engine").mkdir()
    os.mkfifo(place / "root/engine/my_engine.xml")


NOT_THERE = "the files 'my_(engine|thruster).xml', 'my_(engine|thruster).xml', which do not exist: looked in"
ROOT = "root/aircraft/plane"
FOREIGN = {
    # where files lie
    "usual root": Foreign(ROOT, rooted(POWERED) | within("root/engine", ENGINES), held=()),
    "root with engines": Foreign(ROOT, rooted(POWERED) | within("root/engines", ENGINES), held=()),
    "root with systems": Foreign(ROOT, rooted(WITH_SYSTEM) | {"root/systems/my_system.xml": SYSTEM}, held=()),
    "engines inside": Foreign("plane", alone(POWERED) | within("plane/Engines", ENGINES), held=()),
    "engine inside": Foreign("plane", alone(POWERED) | within("plane/Engine", ENGINES), held=()),
    "engines of JSBSim": Foreign("plane", alone(STOCK_POWERED), held=()),
    "parent of another name": Foreign(
        "root/planes/plane",
        {"root/planes/plane/plane.xml": POWERED} | within("root/engine", ENGINES),
        f"{NOT_THERE}.*not beside it, as 'planes' is not called 'aircraft'",
    ),
    "no engines anywhere": Foreign(ROOT, rooted(POWERED), f"{NOT_THERE}.* in 'engine' and 'engines' of its root"),
    "folder of engines is a link": Foreign(
        ROOT,
        rooted(POWERED) | within("elsewhere", ENGINES),
        "is a link, which a model may not use",
        links={"root/engine": "../elsewhere"},
    ),
    "engine is a link": Foreign(
        ROOT,
        rooted(POWERED) | {"root/engine/my_thruster.xml": THRUSTER, "elsewhere.xml": ENGINE},
        "is a link, which a model may not use",
        links={"root/engine/my_engine.xml": "../../elsewhere.xml"},
    ),
    "engine is a pipe": Foreign(ROOT, rooted(POWERED), NOT_THERE, then=piped),
    "system above the root": Foreign(
        ROOT,
        rooted(own('<system file="../my_system"/>')) | {"root/my_system.xml": SYSTEM},
        "leaves the folder of the model",
    ),
    # names
    "file of another name": Foreign("plane/an-26b.xml", {"plane/an-26b.xml": GOOD}, held=()),
    "folder without a file of its name": Foreign(
        "plane",
        {"plane/b.xml": GOOD, "plane/a.xml": GOOD, "plane/engine.xml": ENGINE},
        "there is no 'plane.xml', but '.*/a.xml', '.*/b.xml': name one",
    ),
    "several in one folder": Foreign("plane/b.xml", {"plane/plane.xml": "<broken", "plane/b.xml": GOOD}, held=()),
    "no aircraft in the folder": Foreign("plane", {"plane/engine.xml": ENGINE}, "the folder must hold 'plane.xml'"),
    "name of a stock aircraft": Foreign("c172x", {"c172x/c172x.xml": GOOD}, held=()),
    "name of our own aircraft": Foreign("an26", {"an26/an26.xml": GOOD}, held=()),
    "file beside data": Foreign("plane/b.xml", {"plane/b.xml": GOOD, "plane/b.toml": "title = 3"}, "b.toml.*text"),
    # properties of another simulator
    "read by a function": lacking(
        control(
            '<fcs_function name="mine/f"><function><sum><property>/sim/a</property><property>/sim/b</property></sum>'
            "</function></fcs_function>"
        ),
        "/sim/a",
        "/sim/b",
    ),
    "on or off": lacking(
        own(
            f'<system name="mine"><channel name="one" execute="/sim/on">{gain("velocities/vt-fps")}</channel>'
            f'<channel name="two" execute="/sim/on-too">{gain("aero/beta-rad")}</channel></system>'
        ),
        "/sim/on",
        "/sim/on-too",
    ),
    "read by a switch": lacking(switched("/sim/a == 1\n/sim/b gt /sim/c"), "/sim/a", "/sim/b", "/sim/c"),
    "read in a branch": lacking(
        control(
            '<fcs_function name="mine/f"><function><ifthen><gt><property>/sim/a</property><value>1</value></gt>'
            "<property>/sim/b</property><value>0</value></ifthen></function></fcs_function>"
        ),
        "/sim/a",
        "/sim/b",
    ),
    "read with a sign": lacking(control(gain("-/sim/a")), "/sim/a"),
    "read by a limit": lacking(
        control(gain("velocities/vt-fps", "<clipto><min>/sim/low</min><max>1</max></clipto>")), "/sim/low"
    ),
    "read by the aerodynamics": lacking(
        GOOD.replace(
            "</aerodynamics>",
            '<function name="aero/mine"><product><property>/sim/damage</property><value>0</value></product></function>'
            "</aerodynamics>",
        ),
        "/sim/damage",
    ),
    "read by a table": lacking(
        control(
            '<fcs_function name="mine/f"><function><table><independentVar>/sim/a</independentVar>'
            "<tableData>0 1\n1 2\n</tableData></table></function></fcs_function>"
        ),
        "/sim/a",
    ),
    "never written, of its own": lacking(control(gain("mine/never")), "mine/never"),
    "read, and broken besides": Foreign(
        "plane",
        alone(control(f'{gain("/sim/a")}<angle name="mine/angle"/>')),
        "cannot load",
    ),
    # what JSBSim itself refuses or dies of
    "aborts": Foreign(
        "plane",
        alone(control('<actuator name="a"><input>velocities/vt-fps</input><delay type="time">-5</delay></actuator>')),
        r"aborts the simulation \(SIGABRT: .*(alloc|length|vector)",
    ),
    "root in capitals": Foreign(
        "plane", alone((stock_root() / "aircraft/blank/blank.xml").read_text()), "its root is <FDM_CONFIG>"
    ),
}


def lay(place: Path, names: Iterable[str]) -> dict[str, Path]:
    """Some of them, each below a folder of its own; what a scenario names of each."""
    return {name: FOREIGN[name].write(place / name.replace(" ", "_").replace(",", "")) for name in names}
