"""Mass, centre of gravity and factors of a flight, written into the model before it is loaded."""

from __future__ import annotations

import math
import xml.etree.ElementTree as ElementTree
from collections.abc import Iterator, Mapping

from aircraft.errors import ModelError
from aircraft.model_files import Model

KILOGRAM = {"KG": 1.0, "LBS": 0.45359237, "SLUG": 14.593902937206365}
METRE = {"M": 1.0, "FT": 0.3048, "IN": 0.0254}
INERTIAS = ("ixx", "iyy", "izz", "ixy", "ixz", "iyz")


def apply_factors(model: Model, factors: Mapping[str, float]) -> None:
    """Scale groups of coefficients: ``lift_slope`` is the property ``factors/lift-slope`` of the model."""
    nodes = {}
    for element in model.root.iter("property"):
        name = (element.text or "").strip()
        if "value" in element.attrib and name.startswith("factors/"):
            nodes[name.removeprefix("factors/").replace("-", "_")] = element
    for name, value in factors.items():
        if name not in nodes:
            raise ModelError(f"'{model.name}' has no factor '{name}': known are {', '.join(nodes) or 'none'}")
        if not 0.0 <= value < 100.0:
            raise ModelError(f"factor '{name}' must lie between 0 and 100, not {value}")
        nodes[name].set("value", repr(float(value)))


def apply_mass(model: Model, mass: float) -> None:
    """Set the total mass, kg, by the empty weight; inertia scales with the mass (same radii of gyration)."""
    empty = _empty_weight(model)
    old = total_mass(model)
    others = sum(weight for weight, _, _ in _others(model))
    if not others < mass < 1e6:
        raise ModelError(f"mass must lie between {others:.0f} kg (fuel and fixed loads) and 1e6 kg, not {mass} kg")
    empty.text = repr((mass - others) / KILOGRAM[empty.get("unit", "LBS").upper()])
    for name in INERTIAS:
        for element in model.root.findall(f"mass_balance/{name}"):
            element.text = repr(quantity(element, {"": 1.0}, "", "") * mass / old)


def apply_centre_of_gravity(model: Model, position: float) -> None:
    """Put the whole aircraft's centre of gravity at ``position``, m aft in the model's structural frame."""
    location = _empty_location(model)
    moment = sum(weight * aft for weight, aft, _ in _others(model))
    aft = (total_mass(model) * position - moment) / quantity(_empty_weight(model), KILOGRAM, "LBS")
    for x in location.findall("x"):
        x.text = repr(aft / METRE[location.get("unit", "IN").upper()])


def total_mass(model: Model) -> float:
    """Mass with fuel and fixed loads, kg."""
    mass = quantity(_empty_weight(model), KILOGRAM, "LBS") + sum(mass for mass, _, _ in _others(model))
    if not mass > 0.0:
        raise ModelError(f"the mass of '{model.name}' with fuel and loads must be above 0, not {mass:g} kg")
    return mass


def centre_of_gravity(model: Model) -> tuple[float, float]:
    """(m aft, m up) in the structural frame, with fuel and fixed loads."""
    aft, _, up = place(_empty_location(model))
    parts = [(quantity(_empty_weight(model), KILOGRAM, "LBS"), aft, up), *_others(model)]
    total = total_mass(model)
    return sum(mass * x for mass, x, _ in parts) / total, sum(mass * z for mass, _, z in parts) / total


def place(location: ElementTree.Element) -> tuple[float, float, float]:
    """(m aft, m right, m up) of a <location>."""
    unit = location.get("unit", "IN")
    found = [quantity(axis, METRE, unit, unit) for name in "xyz" for axis in location.findall(name)[:1]]
    if len(found) != 3:
        raise ModelError("a <location> must have x, y and z")
    return found[0], found[1], found[2]


def quantity(element: ElementTree.Element, units: Mapping[str, float], default: str, unit: str | None = None) -> float:
    """Number of an element in SI, its unit from the element unless given; raises ``ModelError``."""
    unit = (element.get("unit", default) if unit is None else unit).upper()
    try:
        value = float(element.text or "") * units[unit]
        if not math.isfinite(value):
            raise ValueError
        return value
    except (ValueError, KeyError):
        known = f" in {', '.join(units)}" if "" not in units else ""
        raise ModelError(f"<{element.tag}> must be a number{known}, not '{element.text}' {unit}".rstrip()) from None


def _empty_weight(model: Model) -> ElementTree.Element:
    return _required(model, "emptywt")


def _empty_location(model: Model) -> ElementTree.Element:
    return _required(model, "location")  # named CG or not: the only one directly in the section


def _required(model: Model, path: str) -> ElementTree.Element:
    found = model.root.find(f"mass_balance/{path}")
    if found is None:
        raise ModelError(f"'{model.name}' has no complete <mass_balance>")
    return found


def _others(model: Model) -> Iterator[tuple[float, float, float]]:
    """(kg, m aft, m up) of the fixed loads and of the fuel."""
    loads = [(load, "weight") for load in model.root.findall("mass_balance/pointmass")]
    tanks = [(tank, "contents") for tank in model.root.findall("propulsion/tank")]
    for owner, amount in loads + tanks:
        weight, location = owner.find(amount), owner.find("location")
        if weight is not None and location is not None:
            aft, _, up = place(location)
            yield quantity(weight, KILOGRAM, "LBS"), aft, up
