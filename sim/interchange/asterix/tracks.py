"""System tracks (CAT062) and reports of ADS-B (CAT021): the estimates of a file as columns, or as recorded flights."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from sim.interchange.asterix.blocks import AsterixError
from sim.interchange.asterix.reading import Feed, feed_of, first_of, without_midnights

ADSB, SYSTEM = 21, 62
# category -> what of an estimate is where: the first of these fields that it has
FIELDS: dict[int, dict[str, tuple[str, ...]]] = {
    SYSTEM: {
        "sac": ("010.sac",), "sic": ("010.sic",), "time": ("070.time",), "number": ("040.number",),
        "address": ("380.adr.address",), "code": ("060.code",), "letters": ("245.letters",),
        "latitude": ("105.latitude",), "longitude": ("105.longitude",), "x": ("100.x",), "y": ("100.y",),
        "velocity_x": ("185.x",), "velocity_y": ("185.y",), "vertical_rate": ("220.rate",),
        "pressure_altitude": ("136.level",), "height": ("130.height",),
        "x_sigma": ("500.apc.x",), "y_sigma": ("500.apc.y",), "xy_root": ("500.cov.xy",),
        "velocity_x_sigma": ("500.atv.x",), "velocity_y_sigma": ("500.atv.y",),
    },
    ADSB: {
        "sac": ("010.sac",), "sic": ("010.sic",), "time": ("071.time", "073.time", "077.time"),
        "number": ("161.number",), "address": ("080.address",), "code": ("070.code",), "letters": ("170.letters",),
        "latitude": ("131.latitude", "130.latitude"), "longitude": ("131.longitude", "130.longitude"),
        "ground_speed": ("160.speed",), "course": ("160.course",), "vertical_rate": ("155.rate", "157.rate"),
        "pressure_altitude": ("145.level",), "height": ("140.height",),
    },
}  # fmt: skip


NAMES = dict.fromkeys(name for fields in FIELDS.values() for name in fields)
CORRELATED = 0.999  # rounding may bring a covariance beyond the sigmas it belongs to: as far as this is read
SPACE, NINE = 0x20, 0x39  # letters in six bits: 1 to 26 are A to Z, digits as in ASCII
UNDATED = "it has times of day and no date: its first day is taken for 1970-01-01"


class TrackColumns(NamedTuple):
    """n estimates of all tracks of a file, in its order; SI, NaN = not said."""

    time: np.ndarray  # (n,) s of the day, UTC; it goes on beyond midnight
    sac: np.ndarray  # (n,) of the system that made it
    sic: np.ndarray  # (n,)
    number: np.ndarray  # (n,) of the track
    address: np.ndarray  # (n,) of the aircraft, 24 bits
    code: np.ndarray  # (n,) Mode 3/A
    latitude: np.ndarray  # (n,) rad, WGS 84
    longitude: np.ndarray  # (n,) rad
    x: np.ndarray  # (n,) m, + to the east of the system's own reference point
    y: np.ndarray  # (n,) m, + to its north
    velocity_x: np.ndarray  # (n,) m/s, + to the east
    velocity_y: np.ndarray  # (n,) m/s, + to the north
    pressure_altitude: np.ndarray  # (n,) m above 1013.25 hPa
    position_cov: np.ndarray  # (n, 2, 2) m2, of x and y; without I062/500 COV they are taken for uncorrelated
    velocity_sigma: np.ndarray  # (n, 2) m/s, of velocity_x and velocity_y
    remarks: tuple[str, ...]  # what was left out


def read_estimates(content: bytes) -> TrackColumns:
    """The estimates of a file of ASTERIX, raw or a capture: CAT062, and CAT021 where it has none.

    Raises ``AsterixError`` in one sentence for what cannot be read.
    """
    values, remarks = _values(content)
    correlated = np.where(np.isnan(values["xy_root"]), 0.0, np.sign(values["xy_root"]) * values["xy_root"] ** 2)
    bound = CORRELATED * values["x_sigma"] * values["y_sigma"]
    correlated = np.clip(correlated, -bound, bound)
    cov = np.array([[values["x_sigma"] ** 2, correlated], [correlated, values["y_sigma"] ** 2]])
    cov = np.where(np.isnan(values["x_sigma"] + values["y_sigma"]), np.nan, cov)
    sigma = np.stack((values["velocity_x_sigma"], values["velocity_y_sigma"]), axis=-1)
    course = values["course"]
    east, north = values["ground_speed"] * np.sin(course), values["ground_speed"] * np.cos(course)
    values["velocity_x"] = np.where(np.isnan(values["velocity_x"]), east, values["velocity_x"])
    values["velocity_y"] = np.where(np.isnan(values["velocity_y"]), north, values["velocity_y"])
    own = {name: values[name] for name in TrackColumns._fields if name in values}
    return TrackColumns(**own, position_cov=np.moveaxis(cov, -1, 0), velocity_sigma=sigma, remarks=remarks)


def read_flights(content: bytes) -> tuple[dict[str, list[str]], dict[str, np.ndarray], tuple[str, ...]]:
    """The estimates of a file as a table of recorded flights: texts, columns (n,) in SI or of places of texts, remarks.

    An aircraft is known by its address, else by its track number and, of several systems, theirs. Times count from
    1970-01-01, for want of a date. Raises ``AsterixError`` also where no estimate has a latitude and a longitude.
    """
    values, remarks = _values(content)
    if not np.isfinite(values["latitude"] + values["longitude"]).any():
        raise AsterixError("has no latitude and longitude in its tracks (I062/105, I021/131 or 130)")
    system = 256.0 * values["sac"] + values["sic"]
    several = len(np.unique(system[np.isfinite(system)])) > 1
    names: dict[str, dict[str, int]] = {"aircraft": {}, "callsign": {}}
    codes: dict[str, list[int]] = {"aircraft": [], "callsign": []}
    for address, number, sac, sic, letters in zip(
        *(values[name].tolist() for name in ("address", "number", "sac", "sic", "letters")), strict=True
    ):
        track = "" if number != number else f"track_{number:.0f}"
        track = f"{sac:.0f}_{sic:.0f}_{track}" if several and track else track
        for column, text in (
            ("aircraft", track if address != address else f"{int(address):06x}"),
            ("callsign", "" if letters != letters else identification(int(letters))),
        ):
            known = names[column]
            codes[column].append(known.setdefault(text, len(known)) if text else -1)
    course = np.where(
        np.isnan(values["course"]), np.arctan2(values["velocity_x"], values["velocity_y"]), values["course"]
    )
    speed = np.hypot(values["velocity_x"], values["velocity_y"])
    table = {
        name: values[name] for name in ("time", "latitude", "longitude", "pressure_altitude", "height", "vertical_rate")
    }
    table |= {
        "ground_speed": np.where(np.isnan(values["ground_speed"]), speed, values["ground_speed"]),
        "course": course,
    }
    table |= {name: np.array(code) for name, code in codes.items()}
    return {name: [*known] for name, known in names.items()}, table, (*remarks, UNDATED)


def _values(content: bytes) -> tuple[dict[str, np.ndarray], tuple[str, ...]]:
    """All estimates of a file with a time, and what was left out."""
    feed: Feed = feed_of(content, FIELDS)
    number = next(one for one in FIELDS if one in feed.categories)
    records = feed.records(number)
    values = {name: first_of(records, FIELDS[number].get(name, ())) for name in NAMES}
    timed = np.isfinite(values["time"])
    remarks = feed.remarks
    if not timed.all():
        remarks = (*remarks, f"{int(np.sum(~timed))} records without a time of day are left out")
    if not timed.any():
        raise AsterixError("has no track with a time of day")
    values = {name: column[timed] for name, column in values.items()}
    return {**values, "time": without_midnights(values["time"])}, remarks


def identification(word: int) -> str:
    """The text of eight letters of six bits, without spaces around it; what is no letter is left out."""
    letters = [word >> shift & 0x3F for shift in range(42, -1, -6)]
    return "".join(
        chr(one if one >= SPACE else one + 0x40) for one in letters if 0 < one <= 26 or SPACE <= one <= NINE
    ).strip()


def letters_of(text: str) -> int:
    """A text of capital letters and digits, at most eight, as eight letters of six bits."""
    word = 0
    for letter in text.ljust(8):
        word = word << 6 | ord(letter) & 0x3F
    return word
