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
    old = total_mass(model)
    others = sum(weight for weight, _, _ in _others(model))
    if not others < mass < 1e6:
        raise ModelError(f"mass must lie between {others:.0f} kg (fuel and fixed loads) and 1e6 kg, not {mass} kg")
    _set_value(empty, mass - others, KILOGRAM, "LBS")
    for name in INERTIAS:
        element = balance.find(name)
        if element is not None:
            element.text = repr(float(element.text) * mass / old)


def apply_centre_of_gravity(model: Model, position: float) -> None:
    """Put the whole aircraft's centre of gravity at ``position``, m aft in the model's structural frame."""
    balance = _mass_balance(model)
    location = balance.find("location[@name='CG']")
    x = location.find("x")
    unit = METRE[location.get("unit", "IN").upper()]
    empty = _value(balance.find("emptywt"), KILOGRAM, "LBS")
    moment = sum(weight * aft for weight, aft, _ in _others(model))
    x.text = repr((total_mass(model) * position - moment) / empty / unit)


def total_mass(model: Model) -> float:
    """Mass with fuel and fixed loads, kg."""
    return _value(_mass_balance(model).find("emptywt"), KILOGRAM, "LBS") + sum(mass for mass, _, _ in _others(model))


def centre_of_gravity(model: Model) -> tuple[float, float]:
    """(m aft, m up) in the structural frame, with fuel and fixed loads."""
    balance = _mass_balance(model)
    empty = _value(balance.find("emptywt"), KILOGRAM, "LBS")
    parts = [(empty, *_place(balance.find("location[@name='CG']"))), *_others(model)]
    total = sum(mass for mass, _, _ in parts)
    return sum(mass * x for mass, x, _ in parts) / total, sum(mass * z for mass, _, z in parts) / total


def _mass_balance(model: Model) -> ElementTree.Element:
    balance = model.root.find("mass_balance")
    if balance is None or balance.find("emptywt") is None or balance.find("location[@name='CG']") is None:
        raise ModelError(f"'{model.name}' has no complete <mass_balance>")
    return balance


def _others(model: Model) -> Iterator[tuple[float, float, float]]:
    """(kg, m aft, m up) of the fixed loads and of the fuel."""
    loads = [(load, "weight") for load in model.root.findall("mass_balance/pointmass")]
    tanks = [(tank, "contents") for tank in model.root.findall("propulsion/tank")]
    for owner, amount in loads + tanks:
        weight = owner.find(amount)
        place = owner.find("location")
        if weight is not None and place is not None:
            yield (_value(weight, KILOGRAM, "LBS"), *_place(place))


def _place(location: ElementTree.Element) -> tuple[float, float]:
    """(m aft, m up)."""
    unit = METRE[location.get("unit", "IN").upper()]
    return float(location.findtext("x", "0")) * unit, float(location.findtext("z", "0")) * unit


def _value(element: ElementTree.Element, units: Mapping[str, float], default: str) -> float:
    return float(element.text) * units[element.get("unit", default).upper()]


def _set_value(element: ElementTree.Element, value: float, units: Mapping[str, float], default: str) -> None:
    element.text = repr(value / units[element.get("unit", default).upper()])
