"""Sources of a run: its equations, papers and errata, read from the docstrings of the code that ran."""

from __future__ import annotations

import inspect
import re
from collections.abc import Iterable
from typing import Any, NamedTuple

from aircraft.data import data
from aircraft.point_mass import PointMass
from aircraft.turbulence import Turbulence
from aircraft.turbulence_intensity import intensity, sigma_aloft
from sim.reporting.text.labels import words

TAG = re.compile(r"\[([A-Z][^\[\]\n]*?\d[^\[\]\n]*)\]")
ERRATUM = re.compile(r"^Erratum: *(.+?)(?=\n\s*\n|\nErratum:|\Z)", re.MULTILINE | re.DOTALL)

PAPERS = {
    "Vasylyev 2003": (
        "V. M. Vasylyev: Raising the adequacy and accuracy of tracking of controlled flight trajectories of aircraft. "
        "National Aviation University, Kyiv, 2003 (in Ukrainian)."
    ),
    "Kychak 2011": (
        "V. M. Kychak, Yu. M. Volovyk, A. Yu. Volovyk, M. A. Shutylo: Optimal filtration of angular measurements of "
        "different accuracy in a centimetre-range landing system. Vinnytsia National Technical University, 2011 "
        "(in Ukrainian)."
    ),
    "Volovyk 2018": (
        "A. Yu. Volovyk, D. V. Havrilov, V. S. Mozgovoj: Development of trajectory supervision model for landing "
        "aviation system. Herald of Khmelnytskyi National University, no. 6, 2018 (in Ukrainian)."
    ),
    "Volovyk 2022": (
        "A. Volovyk: Adaptive estimation of the motion parameters of an aircraft that keeps a prescribed landing "
        "trajectory. Vinnytsia National Technical University, 2022 (in Ukrainian)."
    ),
    "Vicroy 1991": (
        "D. D. Vicroy: A simple, analytical, axisymmetric microburst model for downdraft estimation. NASA TM-104053, "
        "1991."
    ),
    "Glistin": (
        "V. N. Glistin, Yu. N. Panasyuk: Use of dynamic data of an aircraft in the angular channel of information and "
        "measuring systems. Tambov State Technical University (in Russian)."
    ),
}

FLIGHT_DYNAMICS = (
    "J. S. Berndt: JSBSim: an open source flight dynamics model in C++. AIAA 2004-4923, 2004. "
    "JSBSim integrates the equations of motion of this flight."
)


def what_ran(scenario: Any, law: Any) -> list[Any]:
    """Everything of a run whose docstring may name a source."""
    things: list[Any] = [law, scenario.route]
    is_flown = scenario.record is None
    if is_flown and not scenario.law:
        things.append(law.designed)
    if is_flown and scenario.aircraft.model == "point_mass":
        things.append(PointMass)
    if scenario.wind.intensity > 0:
        things += [Turbulence, intensity, sigma_aloft]
    if scenario.wind.profile is not None:
        things.append(scenario.wind.profile)
    things += scenario.wind.events.values()
    trackers = dict.fromkeys(tracker.cls for tracker in scenario.trackers.values())
    return [*things, *scenario.sensors.values(), *trackers]


def aircraft_sources(model: str) -> list[tuple[str, str]]:
    """(what, where it is from) of the data of an aircraft; empty for the point mass."""
    return [] if model == "point_mass" else [(words(name), source) for name, source in data(model).sources]


class Source(NamedTuple):
    """One equation that ran."""

    tag: str
    what: str
    where: str  # module and name


def sources(things: Iterable[Any]) -> tuple[list[Source], list[str], list[str]]:
    """(equations, papers in full, errata) of classes, instances and functions, each once, in the order given."""
    equations: list[Source] = []
    papers: dict[str, None] = {}
    errata: dict[str, None] = {}
    for thing in things:
        for owner, text in _documented(thing if inspect.isclass(thing) or inspect.isroutine(thing) else type(thing)):
            for tag in TAG.findall(text):
                entry = Source(tag, _first_line(text), f"{owner.__module__}.{owner.__qualname__}")
                if entry not in equations:
                    equations.append(entry)
                papers |= {full: None for short, full in PAPERS.items() if short in tag}
            errata |= {" ".join(found.split()): None for found in ERRATUM.findall(text)}
    return equations, list(papers), list(errata)


def _documented(thing: Any) -> list[tuple[Any, str]]:
    """A class or function and its public members with their docstrings."""
    members = [
        member for name, member in vars(thing).items() if inspect.isfunction(member) and not name.startswith("_")
    ] if inspect.isclass(thing) else []  # fmt: skip
    return [(owner, inspect.getdoc(owner) or "") for owner in (thing, *members)]


def _first_line(text: str) -> str:
    """What the docstring says it computes, without the tag."""
    first = " ".join(text.split("\n\n")[0].split())
    return TAG.sub("", first).replace("``", "").replace(" .", ".").strip().rstrip(":")
