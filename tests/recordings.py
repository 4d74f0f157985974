"""A made-up recording: an aircraft intercepts a final at 30 degrees and lands, by a formula, in traffic's columns."""

from __future__ import annotations

import csv
import io
import math
from datetime import UTC, datetime
from typing import Any

import numpy as np

from aircraft.runway import Runway

RUNWAY = Runway(math.radians(48.0), math.radians(11.0), 300.0, math.radians(80.0))
RUNWAY_FILE = """[runway]
latitude_deg = 48.0
longitude_deg = 11.0
elevation_m = 300.0
heading_deg = 80.0
glide_path_deg = 3.0
aiming_point_m = 300.0
"""
SPEED, ANGLE, RADIUS, HEIGHT = 75.0, math.radians(30.0), 2500.0, 900.0  # m/s, rad, m, m
STRAIGHT, FINAL, ROLL = 12_000.0, 20_000.0, 1200.0  # m before the turn, after it to the aiming point, on the runway
BEGUN = datetime(2026, 3, 1, 12, 0, 0, tzinfo=UTC).timestamp()
FOOT, KNOT = 0.3048, 1852.0 / 3600.0
COLUMNS = (
    *("timestamp", "icao24", "callsign", "flight_id", "latitude", "longitude", "altitude", "geoaltitude"),
    *("groundspeed", "track", "vertical_rate"),
)


def motion(time: Any) -> tuple[Any, Any, Any, Any, Any]:
    """(past threshold, right of the centreline, height, course off the runway's, bank) at times (k,) s, in SI."""
    flown = SPEED * np.asarray(time, float)
    turned = np.clip((flown - STRAIGHT) / RADIUS, 0.0, ANGLE)  # of the arc
    final = flown - STRAIGHT - RADIUS * ANGLE  # past its end
    begins = 300.0 - FINAL
    past = begins - RADIUS * np.sin(ANGLE - turned) + np.maximum(final, 0.0)
    right = RADIUS * (1.0 - np.cos(ANGLE - turned))
    ahead = np.maximum(STRAIGHT - flown, 0.0)
    past, right = past - ahead * math.cos(ANGLE), right + ahead * math.sin(ANGLE)
    height = np.clip((300.0 - past) * math.tan(math.radians(3.0)), 0.0, HEIGHT)
    off = turned - ANGLE  # it comes from the right
    bank = np.where((turned > 0.0) & (turned < ANGLE), math.atan(SPEED**2 / (9.80665 * RADIUS)), 0.0)
    return past, right, height, off, bank


LENGTH = (STRAIGHT + RADIUS * ANGLE + FINAL + ROLL) / SPEED  # s


def rows(name: str = "MADE1_001", step: float = 1.0, pressure: float = 0.0) -> list[dict[str, Any]]:
    """The recording, a row every ``step`` seconds; ``pressure`` (m) is added to the pressure altitude."""
    time = np.arange(0.0, LENGTH, step)
    past, right, height, off, _ = motion(time)
    c, s = math.cos(RUNWAY.heading), math.sin(RUNWAY.heading)
    latitude, longitude = RUNWAY.geodetic(past * c - right * s, past * s + right * c, height)
    climb = np.gradient(height, time)
    return [
        {
            "timestamp": stamp(t),
            "icao24": "3c0000",
            "callsign": "MADE1",
            "flight_id": name,
            "latitude": f"{math.degrees(latitude[i]):.8f}",
            "longitude": f"{math.degrees(longitude[i]):.8f}",
            "altitude": f"{round((height[i] + RUNWAY.elevation + pressure) / FOOT / 25) * 25}",
            "geoaltitude": f"{(height[i] + RUNWAY.elevation) / FOOT:.0f}",
            "groundspeed": f"{SPEED / KNOT:.1f}",
            "track": f"{math.degrees(RUNWAY.heading + off[i]) % 360:.2f}",
            "vertical_rate": f"{climb[i] / FOOT * 60:.0f}",
        }
        for i, t in enumerate(time)
    ]


def stamp(time: float) -> str:
    """ISO 8601 of seconds since the recording began."""
    return datetime.fromtimestamp(BEGUN + float(time), UTC).isoformat(sep=" ")


def text(table: list[dict[str, Any]], columns: Any = None, separator: str = ",") -> str:
    """As comma-separated values."""
    columns = list(table[0]) if columns is None and table else list(columns or COLUMNS)
    out = io.StringIO()
    writer = csv.DictWriter(out, columns, delimiter=separator, extrasaction="ignore", restval="")
    writer.writeheader()
    writer.writerows(table)
    return out.getvalue()
