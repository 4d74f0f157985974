"""The main wheels of a model and the reach of all that can touch, read from its ground contacts."""

from __future__ import annotations

import math
from typing import NamedTuple

from aircraft.loading import centre_of_gravity, place
from aircraft.model_files import Model

HIGHER = 0.5  # m above the lowest main wheel: not a main wheel


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
        if abs(wheel.y) > 0.01:
            found.append(wheel)
    lowest = min((wheel.z for wheel in found), default=0.0)
    return tuple(wheel for wheel in found if wheel.z < lowest + HIGHER)


def wheel_track(model: Model) -> float:
    """Distance between the outermost main wheels, m; 0 without any."""
    sides = [wheel.y for wheel in main_wheels(model)]
    return max(sides) - min(sides) if sides else 0.0


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
