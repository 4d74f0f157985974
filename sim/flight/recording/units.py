"""Columns of one track that contradict each other: one of them stands in another unit than was taken."""

from __future__ import annotations

import math

import numpy as np

from sim.interchange.track_record import TrackRecord

FOOT, KNOT = 0.3048, 1852.0 / 3600.0
RATIOS = {"m for ft": 1.0 / FOOT, "ft for m": FOOT, "m/s for kt": 1.0 / KNOT, "kt for m/s": KNOT}
NEAR = 0.06  # of a ratio: units lie farther apart, QNH and wind bring less
MOVING, CLIMBING = 30.0, 300.0  # m/s, m: less says nothing
WAY = 10  # rows over which a speed is taken from places: few of them are stale, none matters by its jitter
EARTH = 6371e3  # m


def contradictions(track: TrackRecord) -> list[str]:
    """Sentences about a speed that does not fit the places, which is not used.

    Raises ``ValueError`` for an altitude that does not fit the vertical rate or the geometric altitude by a ratio of
    units: it would be used.
    """
    climbed, asked = _climb(track)
    if climbed > CLIMBING and asked > CLIMBING:
        _refuse("its altitude", climbed / asked, "its vertical rate")
    if track.pressure_altitude is not None and track.height is not None:
        both = (track.height > CLIMBING) & (track.pressure_altitude > CLIMBING)
        if both.any():
            ratio = float(np.median(track.pressure_altitude[both] / track.height[both]))
            _refuse("its pressure altitude", ratio, "its geometric altitude")
    if track.ground_speed is None or len(track.time) < 2:
        return []
    rows = min(WAY, len(track.time) - 1)
    north = EARTH * (track.latitude[rows:] - track.latitude[:-rows])
    east = EARTH * (track.longitude[rows:] - track.longitude[:-rows]) * np.cos(track.latitude[rows:])
    with np.errstate(divide="ignore", invalid="ignore"):
        flown = np.hypot(north, east) / (track.time[rows:] - track.time[:-rows])
        both = (flown > MOVING) & np.isfinite(flown + track.ground_speed[rows:])
    if not both.any():
        return []
    ratio = float(np.median(track.ground_speed[rows:][both]) / np.median(flown[both]))
    unit = _unit(ratio)
    return [f"its ground speed is {ratio:.2f} of that of its places, as with {unit}; it is not used"] if unit else []


def _climb(track: TrackRecord) -> tuple[float, float]:
    """(m, m) up and down by the altitude, and by the vertical rate, over rows in which both are known."""
    altitude = track.pressure_altitude if track.pressure_altitude is not None else track.height
    if altitude is None or track.vertical_rate is None or len(track.time) < 2:
        return math.nan, math.nan
    rate = 0.5 * (track.vertical_rate[1:] + track.vertical_rate[:-1])
    change, by_rate = np.diff(altitude), rate * np.diff(track.time)
    both = np.isfinite(change + by_rate) & (np.abs(rate) > 2.0) & (np.diff(track.time) < 30.0)
    return float(np.sum(np.sign(rate[both]) * change[both])), float(np.sum(np.abs(by_rate[both])))


def _unit(ratio: float) -> str:
    """What was taken for what; empty where the ratio is none of units."""
    return next((unit for unit, one in RATIOS.items() if abs(ratio * one - 1.0) < NEAR), "")


def _refuse(what: str, ratio: float, against: str) -> None:
    unit = _unit(ratio)
    if unit:
        raise ValueError(f"{what} is {ratio:.2f} of {against}, as with {unit}; tell the units in [record.columns]")
