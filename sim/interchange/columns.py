"""Columns of recorded tracks: what each is called, in which unit it stands, and which of ours it is."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from typing import NamedTuple

from aircraft.units import SUFFIXES
from sim.errors import did_you_mean

QUANTITIES = {  # ours -> SI unit, "" = a text
    "time": "stamp",
    "latitude": "rad",
    "longitude": "rad",
    "pressure_altitude": "m",
    "height": "m",
    "ground_speed": "m/s",
    "course": "rad",
    "vertical_rate": "m/s",
    "flight": "",
    "aircraft": "",
    "callsign": "",
}
NEEDED = ("time", "latitude", "longitude")

# names of columns -> ours with the unit, as they stand in files of the traffic library and in OpenSky's state vectors
TRAFFIC = {
    "timestamp": "time",
    "latitude": "latitude_deg",
    "longitude": "longitude_deg",
    "altitude": "pressure_altitude_ft",
    "geoaltitude": "height_ft",
    "groundspeed": "ground_speed_kt",
    "track": "course_deg",
    "vertical_rate": "vertical_rate_fpm",
    "flight_id": "flight",
    "icao24": "aircraft",
    "callsign": "callsign",
}
OPENSKY = {
    "time": "time",
    "lat": "latitude_deg",
    "lon": "longitude_deg",
    "baroaltitude": "pressure_altitude_m",
    "geoaltitude": "height_m",
    "velocity": "ground_speed_mps",
    "heading": "course_deg",
    "vertrate": "vertical_rate_mps",
    "icao24": "aircraft",
    "callsign": "callsign",
}
LAYOUTS = {"the traffic library": TRAFFIC, "OpenSky's state vectors": OPENSKY}


class Column(NamedTuple):
    """Where a quantity of ours stands in a file."""

    name: str  # of the column
    factor: float  # to SI; of a stamp and of a text 1


def recognised(names: Iterable[str], told: Mapping[str, str] | None) -> dict[str, Column]:
    """Columns of a file by the quantities that they hold: as ``told``, else those of a known layout.

    ``told`` has our names with a unit, ``height_ft``, and for each the name of a column.

    Raises ``ValueError``, in one sentence, where time or place is not among them.
    """
    present = [*names]
    if told:
        return _told(present, told)
    lowered = {name.strip().lower(): name for name in reversed(present)}
    layout = max(LAYOUTS.values(), key=lambda one: sum(name in lowered for name in one))
    found = {}
    for name, key in layout.items():
        if name in lowered:
            quantity, factor = _quantity(key)
            found[quantity] = Column(lowered[name], factor)
    lacking = [quantity for quantity in NEEDED if quantity not in found]
    if lacking:
        have = ", ".join(present[:12]) + (", ..." if len(present) > 12 else "")
        known = " or ".join(f"{', '.join(one)} ({whose})" for whose, one in LAYOUTS.items())
        raise ValueError(
            f"has no {' and no '.join(lacking)} among its columns ({have or 'none'}); known are {known}; others are "
            'told in [record.columns], such as time = "t", latitude_deg = "y"'
        )
    return found


def _told(present: list[str], told: Mapping[str, str]) -> dict[str, Column]:
    found: dict[str, Column] = {}
    for key, name in told.items():
        quantity, factor = _quantity(key)
        if quantity in found:
            raise ValueError(f"[record.columns] {key}: {quantity} is told twice; keep one")
        if name not in present:
            raise ValueError(f"[record.columns] {key}: no column '{name}'; {did_you_mean(name, present)}")
        found[quantity] = Column(name, factor)
    lacking = [quantity for quantity in NEEDED if quantity not in found]
    if lacking:
        raise ValueError(f"[record.columns] {_example(lacking[0])} is missing: it takes time, latitude and longitude")
    return found


def _quantity(key: str) -> tuple[str, float]:
    """The quantity of a key such as ``height_ft``, and the factor to SI of its unit."""
    if QUANTITIES.get(key) in ("", "stamp"):
        return key, 1.0
    for quantity, unit in QUANTITIES.items():
        suffix = key.removeprefix(f"{quantity}_")
        if suffix != key and SUFFIXES.get(suffix, ("",))[0] == unit:
            return quantity, SUFFIXES[suffix][1]
    if key in QUANTITIES:
        raise ValueError(f"[record.columns] {key}: says no unit; write {_example(key)}")
    examples = [_example(quantity) for quantity in QUANTITIES]
    raise ValueError(f"[record.columns] no quantity '{key}'; {did_you_mean(key, examples)}")


def _example(quantity: str) -> str:
    unit = {"rad": "_deg", "m": "_ft", "m/s": "_kt"}.get(QUANTITIES[quantity], "")
    return f"{quantity}{unit}"
