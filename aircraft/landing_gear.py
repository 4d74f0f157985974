"""The main wheels of a model, read from its ground contacts."""

from __future__ import annotations

import math
from typing import NamedTuple

from aircraft.loading import centre_of_gravity, place
from aircraft.model_files import Model

FULLY_TURNED = 80.0  # deg; a wheel that turns farther casters and steers nothing
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


def steering(model: Model) -> tuple[float, float]:
    """(wheelbase in m, travel in rad) of the wheel that is steered and lies farthest from the main wheels; 0 for none.

    The wheelbase is negative where the steered wheel is behind them, the travel where it turns against its command.
    """
    mains = main_wheels(model)
    found = (0.0, 0.0)
    for contact in model.root.findall("ground_reactions/contact") if mains else ():
        location, travel = contact.find("location"), contact.find("max_steer")
        if contact.get("type") != "BOGEY" or location is None or travel is None:
            continue
        ahead = sum(wheel.x for wheel in mains) / len(mains) - place(location)[0]
        limit = float(travel.text or 0.0)
        if 0.0 < abs(limit) <= FULLY_TURNED and abs(ahead) > abs(found[0]):
            found = ahead, math.radians(limit)
    return found


def height_of_wheels(model: Model) -> float:
    """Centre of gravity above the lowest main wheel, m; 0 without any."""
    wheels = main_wheels(model)
    return centre_of_gravity(model)[1] - min(wheel.z for wheel in wheels) if wheels else 0.0
