"""The folder is the catalogue: a kind is a file's name, its class the dataclass that the file defines.

This is what is bundled; `sim.scenario.plugins` adds what is brought from outside.
"""

from __future__ import annotations

import dataclasses
import functools
import importlib
import os
import pkgutil
import sys
from importlib import resources
from types import ModuleType
from typing import Any

from sim.errors import ScenarioError
from sim.scenario.parameters import cached

FOLDERS = {
    "sensors": ("sim.observation.sensors", "step"),
    "trackers": ("tracking.trackers", "step"),
    "modes": ("autopilot.modes", "__call__"),
    "truths": ("sim.flight.truths", "fly"),
    "wind_events": ("aircraft.wind_events", "velocity"),
}
ELSEWHERE = {  # (family, kind) whose file is in no folder of its family, because that may not read files -> its module
    ("trackers", "recorded"): ("sim.estimation.recorded.kind", "estimates"),
}
RETIRED = {  # (family, kind) that files of before may name -> what to write now
    ("trackers", "route_control"): 'kind = "saturated_control", and for its old form covariance = "jacobian"',
    ("trackers", "law_ekf"): 'kind = "saturated_control" and covariance = "jacobian"',
}
CONTRACTS = {  # family -> the module with its MEMBERS, its DEFAULTS, and what tries a class on them
    "sensors": "sim.observation.sensor",
    "trackers": "tracking.contract",
    "modes": "autopilot.mode",
    "wind_events": "aircraft.wind_event",
}


def kinds(family: str) -> list[str]:
    """Names of all kinds of a family, without importing any of them."""
    package, _ = FOLDERS[family]
    places = tuple((sys.modules.get(package) or importlib.import_module(package)).__path__)
    there = _kinds_in(places, tuple(os.stat(place).st_mtime_ns for place in places))
    return sorted([*there, *(kind for own, kind in ELSEWHERE if own == family)])


def has(family: str, kind: str) -> bool:
    """Whether a family has a kind; one that is in use already needs no look at its folder."""
    package, _ = FOLDERS[family]
    return (f"{package}.{kind}" in sys.modules and not kind.startswith("_")) or kind in kinds(family)


@functools.lru_cache(maxsize=64)
def _kinds_in(places: tuple[str, ...], changed: tuple[int, ...]) -> tuple[str, ...]:
    """Names of the modules in folders, looked up again when one of them has changed."""
    return tuple(sorted(found.name for found in pkgutil.iter_modules(places) if not found.name.startswith("_")))


def load(family: str, kind: str) -> type[Any]:
    """The class of a kind: the one dataclass of its file that has the family's method.

    Raises ``KeyError`` for a kind that has no file, ``ScenarioError`` for a file that defines none.
    """
    package, method = FOLDERS[family]
    name, method = ELSEWHERE.get((family, kind), (f"{package}.{kind}", method))
    try:
        module = sys.modules.get(name)
        if module is None:
            if kind not in kinds(family):
                raise KeyError(kind)
            module = importlib.import_module(name)
    except SyntaxError as error:
        raise ScenarioError(f"{name}: cannot be imported: {error.msg} (line {error.lineno})") from None
    return _class_in(module, family, method)


@cached
def _class_in(module: ModuleType, family: str, method: str) -> type[Any]:
    found = [
        thing
        for thing in vars(module).values()
        if isinstance(thing, type)
        and dataclasses.is_dataclass(thing)
        and thing.__module__ == module.__name__
        and hasattr(thing, method)
    ]
    if len(found) != 1:
        mend = "" if found else "; write @dataclass(frozen=True) above its class"
        counted = f"exactly one dataclass with '{method}', found {len(found)}{mend}"
        raise ScenarioError(f"{module.__name__} must define {counted}")
    return completed(family, found[0]) if family in CONTRACTS else found[0]


@cached
def completed(family: str, cls: type[Any]) -> type[Any]:
    """The class with the members of its family that it may leave out, each as the contract's ``DEFAULTS`` have it."""
    own = {*own_members(cls), *getattr(cls, "__dataclass_fields__", ())}
    for name, member in importlib.import_module(CONTRACTS[family]).DEFAULTS.items():
        if name not in own:
            setattr(cls, name, member)
    return cls


def own_members(cls: type[Any]) -> set[str]:
    """Names of what a class brings itself, and not with every other class."""
    return {name for base in cls.__mro__[:-1] for name, member in vars(base).items() if member is not None}


def scenarios() -> list[str]:
    """Names of the bundled scenarios."""
    return _tables("sim.scenario.bundled")


def studies() -> list[str]:
    """Names of the bundled studies."""
    return _tables("sim.scenario.bundled.studies")


def bundled(name: str) -> Any:
    """The file of a bundled scenario or study; None where there is none of this name."""
    for package, names in (("sim.scenario.bundled", scenarios()), ("sim.scenario.bundled.studies", studies())):
        if name in names:
            return resources.files(package) / f"{name}.toml"
    return None


def _tables(package: str) -> list[str]:
    files = (file.name for file in resources.files(package).iterdir())
    return sorted(name[:-5] for name in files if name.endswith(".toml"))
