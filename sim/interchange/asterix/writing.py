"""What leaves as ASTERIX, from plain arrays: target reports, service messages, reports of ADS-B, system tracks.

Draws of noise are told apart as aircraft are: each has an address and a Mode 3/A code of its own (`address_of`,
`code_of`), and its number as track number.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import NamedTuple

import numpy as np

from sim.interchange.asterix.blocks import Blocks, packed
from sim.interchange.asterix.categories.cat021 import CAT021
from sim.interchange.asterix.categories.cat034 import CAT034, NORTH_MARKER
from sim.interchange.asterix.categories.cat048 import CAT048
from sim.interchange.asterix.categories.cat062 import CAT062
from sim.interchange.asterix.categories.units import TICK
from sim.interchange.asterix.category import Category
from sim.interchange.asterix.encoding import encode
from sim.interchange.asterix.tracks import letters_of
from sim.interchange.clocks import DAY

SAC = 0  # of no state
ADDRESS = 0xF00000  # of draw 0; no state has addresses from here on
CODE = 0o1001  # of draw 0
MOST_DRAWS = 0o7000 - CODE  # codes from 7000 octal on are said of emergencies and of traffic without a code
PRIMARY, ROLL_CALL = 1, 5  # what a plot was made of
SLOWEST = 512.0  # s, a turn that I034/041 does not hold
VERSION, LINK = 2, 2  # of CAT021: ED-102A, and 1090 MHz extended squitter
ALTITUDE_STEP_UNKNOWN = 2


class Estimates(NamedTuple):
    """n estimates of tracks, SI; x to the east and y to the north of the reference point."""

    stamps: np.ndarray  # (n,) s since 1970, each true at its stamp
    draw: np.ndarray  # (n,)
    latitude: np.ndarray  # (n,) rad
    longitude: np.ndarray
    position: np.ndarray  # (2, n) m, x and y
    velocity: np.ndarray  # (2, n) m/s
    position_cov: np.ndarray  # (2, 2, n) m2
    velocity_sigma: np.ndarray  # (2, n) m/s
    first: np.ndarray  # (n,) whether it is the first of its track
    last: np.ndarray


def address_of(draw: np.ndarray) -> np.ndarray:
    """The address of the aircraft of a draw."""
    return ADDRESS + np.asarray(draw, float)


def code_of(draw: np.ndarray) -> np.ndarray:
    """The Mode 3/A code of a draw."""
    return CODE + np.asarray(draw, float)


def time_of_day(stamps: np.ndarray) -> np.ndarray:
    """s of the day of stamps since 1970, in whole ticks of 1/128 s: what rounds up to midnight is 0 of the next day."""
    return np.rint(stamps / TICK) % (DAY / TICK) * TICK


def target_reports(
    sic: int,
    stamps: np.ndarray,
    draw: np.ndarray,
    columns: Mapping[str, np.ndarray],
    *,
    sent: np.ndarray,
    cooperative: bool,
    numbered: bool,
) -> Blocks:
    """CAT048.

    Parameters
    ----------
    stamps, sent : (n,) s since 1970, when a plot was true and when it left
    draw : (n,) of each plot
    columns : (n,) ``range``, ``azimuth`` from true north; where they are measured ``level`` m above 1013.25 hPa and
        ``height`` m above the sea
    cooperative : whether the aircraft answered, so that it is known; else a plot is one of a primary radar
    numbered : whether the number of the draw stands as track number
    """
    found = _report(sic, stamps, "140.time")
    found |= {"020.typ": _all(stamps, ROLL_CALL if cooperative else PRIMARY), "020.sim": _all(stamps, 1)}
    found |= {"040.rho": columns["range"], "040.theta": columns["azimuth"]}
    if cooperative:
        found |= {"070.code": code_of(draw), "220.address": address_of(draw)}
    if numbered:
        found["161.number"] = np.asarray(draw, float)
    for name, field in (("level", "090.level"), ("height", "110.height")):
        if name in columns:
            found[field] = columns[name]
    return _packed(CAT048, found, sent)


def north_markers(sic: int, stamps: np.ndarray, period: float, antenna: tuple[float, float, float]) -> Blocks:
    """CAT034: a turn of an antenna begins; ``antenna`` is (latitude rad, longitude rad, height m above the sea)."""
    found = _report(sic, stamps, "030.time")
    found |= {
        "000.message": _all(stamps, NORTH_MARKER),
        "041.period": _all(stamps, period if period < SLOWEST else np.nan),
    }
    for name, value in zip(("latitude", "longitude", "height"), antenna, strict=True):
        found[f"120.{name}"] = _all(stamps, value)
    return _packed(CAT034, found, stamps)


def position_reports(
    sic: int, stamps: np.ndarray, draw: np.ndarray, columns: Mapping[str, np.ndarray], *, numbered: bool
) -> Blocks:
    """CAT021.

    Parameters
    ----------
    stamps : (n,) s since 1970, when a report was received
    draw : (n,) of each report
    columns : (n,) ``latitude``, ``longitude``, ``level``, ``ground_speed``, ``course``, ``vertical_rate``,
        ``position_category`` (NACp), ``velocity_category`` (NACv); those of the motion may be absent
    numbered : whether the number of the draw stands as track number
    """
    found = _report(sic, stamps, "073.time")
    found |= {
        "040.arc": _all(stamps, ALTITUDE_STEP_UNKNOWN),
        "040.sim": _all(stamps, 1),
        "080.address": address_of(draw),
    }
    found |= {"210.vn": _all(stamps, VERSION), "210.ltt": _all(stamps, LINK)}
    found["170.letters"] = np.array([letters_of(f"SIM{one:04d}") for one in draw.tolist()], float)
    if numbered:
        found["161.number"] = np.asarray(draw, float)
    for name, field in REPORTED.items():
        if name in columns:
            found[field] = columns[name]
    return _packed(CAT021, found, stamps)


REPORTED = {
    "latitude": "131.latitude",
    "longitude": "131.longitude",
    "level": "145.level",
    "ground_speed": "160.speed",
    "course": "160.course",
    "vertical_rate": "155.rate",
    "velocity_category": "090.velocity",
    "position_category": "090.position",
}


def system_tracks(sic: int, estimates: Estimates) -> Blocks:
    """CAT062. What an accuracy cannot hold is the largest that it can."""
    found = _report(sic, estimates.stamps, "070.time")
    found |= {"105.latitude": estimates.latitude, "105.longitude": estimates.longitude}
    found |= {"060.code": code_of(estimates.draw), "380.adr.address": address_of(estimates.draw)}
    found |= {"040.number": np.asarray(estimates.draw, float), "080.mon": _all(estimates.stamps, 1)}
    found |= {"080.sim": _all(estimates.stamps, 1), "080.tsb": 1.0 * estimates.first, "080.tse": 1.0 * estimates.last}
    covariance = estimates.position_cov[0, 1]
    found["500.cov.xy"] = np.clip(np.sign(covariance) * np.sqrt(np.abs(covariance)), -16000.0, 16000.0)
    for row, axis in enumerate("xy"):
        found[f"100.{axis}"], found[f"185.{axis}"] = estimates.position[row], estimates.velocity[row]
        found[f"500.apc.{axis}"] = np.minimum(np.sqrt(estimates.position_cov[row, row]), 32767.0)
        found[f"500.atv.{axis}"] = np.minimum(estimates.velocity_sigma[row], 63.75)
    return _packed(CAT062, found, estimates.stamps)


def _report(sic: int, stamps: np.ndarray, time: str) -> dict[str, np.ndarray]:
    """Who reports, and when it was true."""
    return {"010.sac": _all(stamps, SAC), "010.sic": _all(stamps, sic), time: time_of_day(stamps)}


def _all(stamps: np.ndarray, value: float) -> np.ndarray:
    return np.full(len(stamps), float(value))


def _packed(category: Category, found: dict[str, np.ndarray], sent: np.ndarray) -> Blocks:
    encoded = encode(category, found)
    return packed(category.number, encoded.lengths, encoded.octets, sent)
