"""A run of 20 s with sensors and trackers of all sorts, for tests of what a run leaves for other programs."""

from __future__ import annotations

from typing import Any

from tests.capture import capture_tables

RADAR = {"kind": "surveillance_radar", "period_s": 2.0, "position_m": [-3000, 2000, 10], "course_deg": 30.0}
TABLES: dict[str, Any] = {
    **capture_tables(name="short", until_s=20.0, draws=3),
    "runway": {"latitude_deg": 52.0, "longitude_deg": 10.0, "heading_deg": 80.0, "elevation_m": 120.0},
    "aircraft": {"model": "point_mass"},
    "sensors": {
        "radar": {**RADAR, "height": "mode_c"},
        "cluttered": {"kind": "precision_radar", "sector_deg": 360.0, "clutter": 2.0, "detection": 0.8},
        "approach": {"kind": "precision_radar", "sector_deg": 360.0},
        "needle": {"kind": "localiser"},
    },
    "trackers": {
        "kalman": {"kind": "kalman", "sensors": ["radar"]},
        "imm": {"kind": "imm", "sensors": ["radar"]},
        "angle": {"kind": "elevation", "sensors": ["approach"]},
    },
}
