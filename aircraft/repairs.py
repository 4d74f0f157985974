"""What stock models need to fly without the simulator that they were written for; each repair says what it did.

The rules are general and never name an aircraft. Models of a user are touched only where the user asks for it; else
their faults are told.
"""

from __future__ import annotations

import re
import xml.etree.ElementTree as ElementTree
from collections.abc import Callable
from pathlib import Path, PurePosixPath

from aircraft.model_files import Model, folder, stock_root
from aircraft.properties import STEERING

MISSING = re.compile(r"property (\S+) does not exist|On/Off property, (\S+) specified")
PART = r"[A-Za-z_][\w.-]*(?:\[\d+\])?"
PROPERTY = re.compile(rf"(?<![\w./])/?{PART}(?:/{PART})+(?![\w/])")  # as it stands in a text
LEVERS = "/controls/engines/"
SYSTEM = "shortfinal repairs"  # of the properties that are held
PROSE = ("description", "documentation", "author", "email", "note", "limitation", "reference", "license")
LONGEST_LIST = 300  # characters of names in a sentence
MOST_MISSING = 100  # properties of another simulator that a model may read
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


def define_missing(model: Model, said: str) -> bool:
    """Hold at zero a property that JSBSim says is missing: another simulator owns it; False when it said otherwise."""
    found = MISSING.search(said)
    known = _defined(model)
    if found is None or len(known) >= MOST_MISSING:
        return False
    name = found.group(1) or found.group(2)
    if name in known:
        return False
    _hold(model, name)
    return True


def define_unread(model: Model, exists: Callable[[str], bool]) -> bool:
    """Hold at zero what the model would read in some branch only and what is of another simulator by its name.

    JSBSim's own properties are named from its aircraft on; those that begin with a slash are of the program around it.
    Power levers are left out: the airframe moves those that exist. Returns whether there were any.
    """
    names = [name for name in sorted(mentioned(model)) if name.startswith("/") and not name.startswith(LEVERS)]
    unread = [name for name in names if not exists(name)][:MOST_MISSING]
    for name in unread:
        _hold(model, name)
    return bool(unread)


def _hold(model: Model, name: str) -> None:
    section = model.root.find(f"system[@name='{SYSTEM}']")
    if section is None:
        section = ElementTree.Element("system", name=SYSTEM)
        model.root.insert(0, section)  # systems are loaded in their order, before all else that reads properties
    ElementTree.SubElement(section, "property", value="0").text = name


def defined(model: Model) -> str | None:
    """A sentence about the properties that were held at zero."""
    names = _defined(model)
    return f"nothing sets {', '.join(names)}: held at 0" if names else None


def asked_for(model: Model) -> str | None:
    """A sentence about the properties that would have to be held at zero, and what can be done."""
    names = _defined(model)
    if not names:
        return None
    shown = names[: max(1, sum(1 for n in range(len(names)) if len(", ".join(names[: n + 1])) <= LONGEST_LIST))]
    more = f" and {len(names) - len(shown)} more" if len(shown) < len(names) else ""
    return (
        f"'{model.name}' cannot be used: nothing here sets {', '.join(shown)}{more}, which it reads and another "
        "simulator may set: aircraft.repairs = true holds them at 0, or declare them in the model"
    )


def mentioned(model: Model) -> set[str]:
    """Everything in a model that reads like the name of a property."""
    return {
        name
        for tree in (model.root, *model.files.values())
        for element in tree.iter()
        if element.tag not in PROSE
        for text in (element.text, *element.attrib.values())
        for name in PROPERTY.findall(text or "")
    }


def _defined(model: Model) -> list[str]:
    return [element.text or "" for element in model.root.iterfind(f"system[@name='{SYSTEM}']/property")]
