"""What of a model can touch the ground, read from its ground contacts: the parts, and how far they reach."""

from __future__ import annotations

import math
from typing import NamedTuple
from xml.etree.ElementTree import Element

from aircraft.loading import centre_of_gravity, place, quantity
from aircraft.model_files import Model
from aircraft.state import FUSELAGE, MAIN_WHEEL, NOSE_WHEEL, TAIL, TAIL_WHEEL, WING_TIP

ANGLE = {"DEG": math.pi / 180.0, "RAD": 1.0}  # rad
FULLY_TURNED = math.radians(80.0)  # a wheel that turns farther casters and steers nothing
HIGHER = 0.5  # m above the lowest main wheel: not a main wheel, nor a nose wheel
CENTRE = 0.01  # m from the plane of symmetry, at most: in it


class Wheel(NamedTuple):
    """A wheel, extended and without load, in the model's structural frame."""

    number: int  # among the contacts
    x: float  # m aft
    y: float  # m right
    z: float  # m up


class Contact(NamedTuple):
    """A point of the structure that the ground pushes against."""

    node: str  # JSBSim's property for the weight on it
    part: int  # one of ``aircraft.state.PARTS``
    point: Wheel


def main_wheels(model: Model) -> tuple[Wheel, ...]:
    """Wheels off the plane of symmetry; some models put wheels under wing tips and tail too, but higher up."""
    found = []
    for number, contact in enumerate(_elements(model)):
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
    wheels = {number for number, contact in enumerate(_elements(model)) if contact.get("type") == "BOGEY"}
    points = {
        number: Wheel(number, *place(location))
        for number, contact in enumerate(_elements(model))
        if (location := contact.find("location")) is not None
    }
    parts = dict.fromkeys(points, FUSELAGE)
    mains = main_wheels(model)
    if mains:
        aft, lowest = _axle(mains)
        outside = max(abs(wheel.y) for wheel in mains)
        parts |= {n: WING_TIP for n, point in points.items() if abs(point.y) > outside}
        centre = [point for point in points.values() if abs(point.y) <= CENTRE]
        behind = [point for point in centre if point.x > aft]
        noses = [p for p in centre if p.number in wheels and p.x < aft and p.z < lowest + HIGHER]
        parts |= {point.number: TAIL for point in behind} | {point.number: NOSE_WHEEL for point in noses}
        if behind and not noses:
            parts[min(behind, key=lambda point: (point.z - lowest) / (point.x - aft)).number] = TAIL_WHEEL
        parts |= {wheel.number: MAIN_WHEEL for wheel in mains}
    return tuple(
        Contact(f"{'gear' if number in wheels else 'contact'}/unit[{number}]/WOW", parts[number], point)
        for number, point in points.items()
    )


def touchdown_pitch(model: Model) -> tuple[float, float]:
    """Pitch, rad, at which the nose wheel, and at which tail or tail wheel, touch level ground with the main wheels.

    Without such a contact it is -90 or 90 deg.
    """
    mains = main_wheels(model)
    lowest, highest = -math.pi / 2.0, math.pi / 2.0
    for contact in contacts(model) if mains else ():
        aft, down = _axle(mains)
        pitch = math.atan2(contact.point.z - down, contact.point.x - aft)
        if contact.part == NOSE_WHEEL:
            lowest = max(lowest, math.remainder(pitch, math.pi))
        elif contact.part in (TAIL, TAIL_WHEEL):
            highest = min(highest, pitch)
    return lowest, highest


def touchdown_bank(model: Model) -> float:
    """Bank, rad, at which a wing tip, or what else is outside the main wheels, touches level ground with one of these.

    At level pitch; without such a contact it is 90 deg.
    """
    highest = math.pi / 2.0
    mains = main_wheels(model)
    for contact in contacts(model) if mains else ():
        if contact.part == WING_TIP:
            _, _, y, z = contact.point
            wheel = max(mains, key=lambda wheel: wheel.y * y)  # the outermost on its side
            highest = min(highest, math.atan2(z - wheel.z, abs(y) - abs(wheel.y)))
    return highest


def _axle(mains: tuple[Wheel, ...]) -> tuple[float, float]:
    """(x, z) m of the main wheels, in the middle and of the lowest."""
    return sum(wheel.x for wheel in mains) / len(mains), min(wheel.z for wheel in mains)


def _elements(model: Model) -> list[Element]:
    return model.root.findall("ground_reactions/contact")


def wheel_track(model: Model) -> float:
    """Distance between the outermost main wheels, m; 0 without any."""
    sides = [wheel.y for wheel in main_wheels(model)]
    return max(sides) - min(sides) if sides else 0.0


def steering(model: Model) -> tuple[float, float]:
    """(wheelbase in m, travel in rad) of the wheel that is steered and lies farthest from the main wheels; 0 for none.

    The wheelbase is negative where the steered wheel is behind them, the travel where it turns against its command.
    """
    mains = main_wheels(model)
    found = (0.0, 0.0)
    for contact in _elements(model) if mains else ():
        location, travel = contact.find("location"), contact.find("max_steer")
        if contact.get("type") != "BOGEY" or location is None or travel is None:
            continue
        ahead = _axle(mains)[0] - place(location)[0]
        limit = quantity(travel, ANGLE, "DEG")
        if 0.0 < abs(limit) <= FULLY_TURNED and abs(ahead) > abs(found[0]):
            found = ahead, limit
    return found


def height_of_wheels(model: Model) -> float:
    """Centre of gravity above the lowest main wheel, m; 0 without any."""
    wheels = main_wheels(model)
    return centre_of_gravity(model)[1] - min(wheel.z for wheel in wheels) if wheels else 0.0


def reach(model: Model) -> float:
    """How far, m, any contact is from the centre of gravity: higher up nothing can touch, whatever the attitude."""
    aft, up = centre_of_gravity(model)
    locations = [contact.find("location") for contact in model.root.findall("ground_reactions/contact")]
    places = [place(location) for location in locations if location is not None]
    return max((math.dist((x, y, z), (aft, 0.0, up)) for x, y, z in places), default=0.0)
