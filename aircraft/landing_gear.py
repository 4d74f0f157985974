"""What of a model can touch the ground, read from its ground contacts: the main wheels and all other parts."""

from __future__ import annotations

from typing import NamedTuple

from aircraft.loading import centre_of_gravity, place
from aircraft.model_files import Model
from aircraft.state import FUSELAGE, MAIN_WHEEL, NOSE_WHEEL, TAIL, TAIL_WHEEL, WING_TIP

HIGHER = 0.5  # m above the lowest main wheel: not a main wheel, nor a nose wheel
CENTRE = 0.01  # m from the plane of symmetry, at most: in it


class Contact(NamedTuple):
    """A point of the structure that the ground pushes against."""

    node: str  # JSBSim's property for the weight on it
    part: int  # one of ``aircraft.state.PARTS``


class Wheel(NamedTuple):
    """A wheel, extended and without load, in the model's structural frame."""

    number: int  # among the contacts
    x: float  # m aft
    y: float  # m right
    z: float  # m up


def main_wheels(model: Model) -> tuple[Wheel, ...]:
    """Wheels off the plane of symmetry; some models put wheels under wing tips and tail too, but higher up."""
    found = []
    for number, contact in enumerate(model.root.findall("ground_reactions/contact")):
        location = contact.find("location")
        if contact.get("type") != "BOGEY" or location is None:
            continue
        wheel = Wheel(number, *place(location))
        if abs(wheel.y) > CENTRE:
            found.append(wheel)
    lowest = min((wheel.z for wheel in found), default=0.0)
    return tuple(wheel for wheel in found if wheel.z < lowest + HIGHER)


def contacts(model: Model) -> tuple[Contact, ...]:
    """Every contact with the part of the aircraft that it belongs to, told by where it is.

    Without a nose wheel the aircraft stands on its tail: then the first point behind the main wheels that comes down
    when it does is the tail wheel, be it a wheel or a skid.
    """
    mains = main_wheels(model)
    numbers = {wheel.number for wheel in mains}
    places, wheels = {}, set()
    for number, contact in enumerate(model.root.findall("ground_reactions/contact")):
        location = contact.find("location")
        if location is not None:
            places[number] = Wheel(number, *place(location))
        if contact.get("type") == "BOGEY":
            wheels.add(number)
    if not mains:
        return tuple(Contact(_node(n, n in wheels), FUSELAGE) for n in places)
    aft = sum(wheel.x for wheel in mains) / len(mains)
    lowest = min(wheel.z for wheel in mains)
    outside = max(abs(wheel.y) for wheel in mains)
    in_centre = [point for point in places.values() if abs(point.y) <= CENTRE and point.number not in numbers]
    noses = {p.number for p in in_centre if p.number in wheels and p.x < aft and p.z < lowest + HIGHER}
    behind = [point for point in in_centre if point.x > aft]
    tail_wheel = min(behind, key=lambda p: (p.z - lowest) / (p.x - aft)).number if behind and not noses else None

    def part(point: Wheel) -> int:
        if point.number in numbers:
            return MAIN_WHEEL
        if point.number in noses:
            return NOSE_WHEEL
        if point.number == tail_wheel:
            return TAIL_WHEEL
        if abs(point.y) > outside:
            return WING_TIP
        return TAIL if point.x > aft and abs(point.y) <= CENTRE else FUSELAGE

    return tuple(Contact(_node(point.number, point.number in wheels), part(point)) for point in places.values())


def _node(number: int, is_wheel: bool) -> str:
    return f"{'gear' if is_wheel else 'contact'}/unit[{number}]/WOW"


def wheel_track(model: Model) -> float:
    """Distance between the outermost main wheels, m; 0 without any."""
    sides = [wheel.y for wheel in main_wheels(model)]
    return max(sides) - min(sides) if sides else 0.0


def height_of_wheels(model: Model) -> float:
    """Centre of gravity above the lowest main wheel, m; 0 without any."""
    wheels = main_wheels(model)
    return centre_of_gravity(model)[1] - min(wheel.z for wheel in wheels) if wheels else 0.0
