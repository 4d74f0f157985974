"""What stock models need to fly without the simulator that they were written for; each repair says what it did.

The rules are general and never name an aircraft. Models of a user are not touched: their faults are told instead.
"""

from __future__ import annotations

import re
import xml.etree.ElementTree as ElementTree
from pathlib import Path, PurePosixPath

from aircraft.model_files import Model, folder, stock_root
from aircraft.properties import STEERING

MISSING = re.compile(r"property (\S+) does not exist")
MOST_MISSING = 40  # properties of another simulator that a model may read
DIRECT = PurePosixPath("engine/direct")


def is_stock(model: str | Path) -> bool:
    """Whether a model is one of JSBSim's own."""
    return folder(model).resolve().is_relative_to(stock_root().resolve())


def drive_directly(model: Model) -> str | None:
    """Let turbines act directly where they drive a propeller: it would take their pounds of thrust for power."""
    changed = False
    for engine in model.root.iter("engine"):
        thruster = engine.find("thruster")
        if thruster is not None and _kind(model, engine) == "turbine_engine" and _kind(model, thruster) == "propeller":
            thruster.set("file", DIRECT.name)
            model.files[DIRECT] = ElementTree.Element("direct", name="Direct")
            changed = True
    return "its turbines act directly: their propellers took the pounds of thrust for power" if changed else None


def free_steering(model: Model) -> str | None:
    """Let the pilot steer where something of the model, such as an autopilot that is off, sets the steering itself."""
    changed = False
    for tree in (model.root, *model.files.values()):
        for component in tree.iter():
            for output in component.findall("output"):
                if (output.text or "").strip() == STEERING.name:
                    component.remove(output)
                    changed = True
    return "its own systems do not set the nose wheel: the pilot steers it" if changed else None


def has_propellers(model: Model) -> bool:
    """Whether any engine turns a propeller."""
    return any(_kind(model, thruster) == "propeller" for thruster in model.root.iter("thruster"))


def _kind(model: Model, part: ElementTree.Element) -> str:
    """Tag of the file behind an <engine> or <thruster>."""
    tree = model.files.get(PurePosixPath("engine") / part.get("file", ""))
    return "" if tree is None else tree.tag


def define_missing(model: Model, said: str) -> str | None:
    """Hold at zero a property that JSBSim says is missing: another simulator owns it; None when it said otherwise."""
    found = MISSING.search(said)
    if found is None or len(_defined(model)) >= MOST_MISSING:
        return None
    name = found.group(1)
    if name in _defined(model):
        return None
    ElementTree.SubElement(_section(model), "property", value="0", repaired="yes").text = name
    return name


def defined(model: Model) -> str | None:
    """A sentence about the properties that were held at zero."""
    names = _defined(model)
    return f"nothing sets {', '.join(names)}: held at 0" if names else None


def _section(model: Model) -> ElementTree.Element:
    """Where interface properties are declared before anything reads them."""
    for section in model.root.findall("flight_control"):
        return section
    return ElementTree.SubElement(model.root, "flight_control", name="repairs")


def _defined(model: Model) -> list[str]:
    return [element.text or "" for element in _section(model).iter("property") if element.get("repaired")]
