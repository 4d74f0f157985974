"""Mass, centre of gravity and factors of a flight, written into the model before it is loaded."""

from __future__ import annotations

import xml.etree.ElementTree as ElementTree
from collections.abc import Iterator, Mapping

from aircraft.errors import ModelError
from aircraft.model_files import Model

KILOGRAM = {"KG": 1.0, "LBS": 0.45359237, "SLUG": 14.593902937206365}
METRE = {"M": 1.0, "FT": 0.3048, "IN": 0.0254}
INERTIAS = ("ixx", "iyy", "izz", "ixy", "ixz", "iyz")


def apply_factors(model: Model, factors: Mapping[str, float]) -> None:
    """Scale groups of coefficients: ``lift_slope`` is the property ``factors/lift-slope`` of the model."""
    nodes = {
        element.text.strip().removeprefix("factors/").replace("-", "_"): element
        for element in model.root.iter("property")
        if "value" in element.attrib and (element.text or "").strip().startswith("factors/")
    }
    for name, value in factors.items():
        if name not in nodes:
            known = ", ".join(nodes) or "none"
            raise ModelError(f"'{model.name}' has no factor '{name}': known are {known}")
        if not 0.0 <= value < 100.0:
            raise ModelError(f"factor '{name}' must lie between 0 and 100, not {value}")
        nodes[name].set("value", repr(float(value)))


def apply_mass(model: Model, mass: float) -> None:
    """Set the total mass, kg, by the empty weight; inertia scales with the mass (same radii of gyration)."""
    balance = _mass_balance(model)
    empty = balance.find("emptywt")
    old = _value(empty, KILOGRAM, "LBS")
    others = sum(weight for weight, _ in _other_masses(model))
    if not others < mass < 1e6:
        raise ModelError(f"mass must lie between {others:.0f} kg (fuel and fixed loads) and 1e6 kg, not {mass} kg")
    _set_value(empty, mass - others, KILOGRAM, "LBS")
    for name in INERTIAS:
        element = balance.find(name)
        if element is not None:
            element.text = repr(float(element.text) * mass / (old + others))


def apply_centre_of_gravity(model: Model, position: float) -> None:
    """Put the whole aircraft's centre of gravity at ``position``, m aft in the model's structural frame."""
    balance = _mass_balance(model)
    location = balance.find("location[@name='CG']")
    x = location.find("x")
    unit = METRE[location.get("unit", "IN").upper()]
    empty = _value(balance.find("emptywt"), KILOGRAM, "LBS")
    others = list(_other_masses(model))
    total = empty + sum(weight for weight, _ in others)
    x.text = repr((total * position - sum(weight * place for weight, place in others)) / empty / unit)


def _mass_balance(model: Model) -> ElementTree.Element:
    balance = model.root.find("mass_balance")
    if balance is None or balance.find("emptywt") is None or balance.find("location[@name='CG']") is None:
        raise ModelError(f"'{model.name}' has no complete <mass_balance>")
    return balance


def _other_masses(model: Model) -> Iterator[tuple[float, float]]:
    """(kg, m aft) of the fixed loads and of the fuel."""
    loads = [(load, "weight") for load in model.root.findall("mass_balance/pointmass")]
    tanks = [(tank, "contents") for tank in model.root.findall("propulsion/tank")]
    for owner, amount in loads + tanks:
        weight = owner.find(amount)
        place = owner.find("location")
        if weight is not None and place is not None:
            yield _value(weight, KILOGRAM, "LBS"), float(place.find("x").text) * METRE[place.get("unit", "IN").upper()]


def _value(element: ElementTree.Element, units: Mapping[str, float], default: str) -> float:
    return float(element.text) * units[element.get("unit", default).upper()]


def _set_value(element: ElementTree.Element, value: float, units: Mapping[str, float], default: str) -> None:
    element.text = repr(value / units[element.get("unit", default).upper()])
