"""What an aircraft without a data file says of itself: the slowest level flight at each flap setting, by trims."""

from __future__ import annotations

import dataclasses
import functools
import math
from pathlib import Path

from aircraft.airframe import Airframe, load
from aircraft.data import AircraftData, FlapSetting, data
from aircraft.errors import FlightError, TrimError
from aircraft.model_files import folder
from aircraft.state import STANDARD_GRAVITY
from aircraft.trim import Trim, trim

SHARES = (0.0, 0.5, 1.0)  # of full flaps, where a model has flaps
HEIGHT = 300.0  # m
DENSITY = 1.225  # kg/m3, of the first guess only
LIFT_COEFFICIENT = 0.7  # of the first guess
GUESSES = (1.0, 1.2, 0.85, 1.45, 1.75, 0.7, 2.1)  # of the speed at that lift coefficient
STEP = 0.88  # from one speed to the next slower one
PRECISION = 0.01  # of the slowest speed


def complete(model: str | Path) -> AircraftData:
    """The data of an aircraft, its flap settings by trims where no file states them; raises ``ModelError``."""
    known = data(model)
    return known if known.flap_settings else dataclasses.replace(known, flap_settings=flap_settings(model))


def flap_settings(model: str | Path) -> tuple[FlapSetting, ...]:
    """Slowest level flight, gear down, without flaps, at half and at full flaps; empty when there is none.

    The slowest trim stands for the stall: whichever of wing, elevator and power gives out first. Placards are not
    known of such an aircraft.
    """
    path = folder(model) / f"{folder(model).resolve().name}.xml"
    return _measured(model, path.stat().st_mtime_ns)


@functools.cache
def _measured(model: str | Path, changed: int) -> tuple[FlapSetting, ...]:
    airframe = load(model)
    settings = []
    for share in SHARES if airframe.full_flaps > 0.0 else SHARES[:1]:
        flaps = share * airframe.full_flaps
        found = slowest(airframe, flaps)
        if found is not None:
            settings.append(FlapSetting(flaps, math.inf, found.initial.airspeed))
    return tuple(settings)


def slowest(airframe: Airframe, flaps: float) -> Trim | None:
    """The slowest level flight with gear down that can be trimmed, to a per cent; None when none can be."""
    pressure = airframe.mass * STANDARD_GRAVITY / (airframe.wing_area * LIFT_COEFFICIENT)
    found = None
    for factor in GUESSES:
        found = _level(airframe, factor * math.sqrt(2.0 * pressure / DENSITY), flaps, None)
        if found is not None:
            break
    if found is None:
        return None
    low = 0.0
    while found.initial.airspeed - low > PRECISION * found.initial.airspeed:
        high = found.initial.airspeed
        speed = STEP * high if low < STEP * high else 0.5 * (low + high)
        slower = _level(airframe, speed, flaps, found)
        low, found = (speed, found) if slower is None else (low, slower)
    return found


def _level(airframe: Airframe, speed: float, flaps: float, near: Trim | None) -> Trim | None:
    try:
        return trim(airframe, speed, 0.0, HEIGHT, flaps, 1.0, near=near)
    except (TrimError, FlightError):
        return None
