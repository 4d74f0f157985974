"""What an aircraft without a data file says of itself: the slowest level flight at each flap setting, by trims."""

from __future__ import annotations

import dataclasses
import functools
import math
from collections.abc import Callable
from pathlib import Path

from aircraft.airframe import Airframe, load
from aircraft.data import AircraftData, FlapSetting, data
from aircraft.errors import FlightError, TrimError
from aircraft.model_files import main_file
from aircraft.state import STANDARD_GRAVITY
from aircraft.stock import stock_row
from aircraft.trim import Trim, trim

SHARES = (0.0, 0.5, 1.0)  # of full flaps, where a model has flaps
HEIGHT = 300.0  # m
DENSITY = 1.225  # kg/m3, of the first guess only
LIFT_COEFFICIENT = 0.7  # of the first guess
UNKNOWN_WING = 60.0  # m/s, the first guess where a model states no wing area
GUESSES = (1.0, 1.25, 0.8, 1.6, 2.0)  # of the speed at that lift coefficient
STEP = 0.88  # from one speed to the next slower one
PRECISION = 0.01  # of the slowest speed


def complete(
    model: str | Path, repaired: bool = False, measure: Callable[..., tuple[FlapSetting, ...]] | None = None
) -> AircraftData:
    """The data of an aircraft with its flap settings, which no file states of most; raises ``ModelError``.

    Those of a stock aircraft are in a table, measured under the version of JSBSim that is noted there; where that is
    not the version at hand, and for the folder of a user, they are measured on the spot: by ``flap_settings``, or by
    ``measure``, which takes the same arguments and may know them from before.
    """
    known = data(model)
    if known.flap_settings:
        return known
    rows = stock_row(model).get("flap_settings", [])
    settings = tuple(FlapSetting(math.radians(row["flaps_deg"]), math.inf, row["slowest_mps"]) for row in rows)
    return dataclasses.replace(known, flap_settings=settings or (measure or flap_settings)(model, repaired))


def why_not(airframe: Airframe) -> str:
    """Why an aircraft has no level flight: what the trim at the likeliest speed says."""
    try:
        trim(airframe, _guess(airframe), 0.0, HEIGHT, 0.0, 1.0)
    except (TrimError, FlightError) as error:
        return str(error)
    return "it has no level flight"


def flap_settings(model: str | Path, repaired: bool = False) -> tuple[FlapSetting, ...]:
    """Slowest level flight, gear down, without flaps, at half and at full flaps, equivalent airspeeds; or empty.

    The slowest trim stands for the stall: whichever of wing, elevator and power gives out first. Placards are not
    known of such an aircraft.
    """
    return _measured(model, main_file(model).stat().st_mtime_ns, repaired)


@functools.cache
def _measured(model: str | Path, changed: int, repaired: bool) -> tuple[FlapSetting, ...]:
    airframe = load(model, repaired=repaired)
    share_there = airframe.air.equivalent_share(HEIGHT)
    settings = []
    for share in SHARES if airframe.full_flaps > 0.0 else SHARES[:1]:
        flaps = share * airframe.full_flaps
        found = slowest(airframe, flaps)
        if found is not None:
            settings.append(FlapSetting(flaps, math.inf, found.initial.airspeed * share_there))
        elif not settings:
            break  # what does not fly clean does not fly
    return tuple(settings)


def slowest(airframe: Airframe, flaps: float) -> Trim | None:
    """The slowest level flight with gear down that can be trimmed, to a per cent; None when none can be."""
    found = None
    for factor in GUESSES:
        found = _level(airframe, factor * _guess(airframe), flaps, None)
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


def _guess(airframe: Airframe) -> float:
    """Airspeed, m/s, of level flight at an ordinary lift coefficient."""
    if not airframe.wing_area > 0.0:
        return UNKNOWN_WING
    pressure = airframe.mass * STANDARD_GRAVITY / (airframe.wing_area * LIFT_COEFFICIENT)
    return math.sqrt(2.0 * pressure / DENSITY)


def _level(airframe: Airframe, speed: float, flaps: float, near: Trim | None) -> Trim | None:
    try:
        return trim(airframe, speed, 0.0, HEIGHT, flaps, 1.0, near=near)
    except (TrimError, FlightError):
        return None
