"""The least that flies: an aircraft beside a straight leg, which it captures. A test says only what it changes."""

from __future__ import annotations

import json
import tomllib


def capture(*tables: str, to_m: float = 20000, cross_track_m: float = 300, **keys: str | float) -> str:
    """The text of its file: ``keys`` such as name and until_s, the leg and the start, then further ``tables``."""
    head = "".join(f"{key} = {json.dumps(value)}\n" for key, value in keys.items())
    line = LEG.format(to_m=to_m, cross_track_m=cross_track_m)
    return head + line + "".join(f"{table.strip()}\n" for table in tables)


LEG = """[route]
kind = "legs"
[[route.legs]]
from_m = [0, 0]
to_m = [{to_m}, 0]
speed_mps = 72
height_m = 600
[start]
leg = 0
cross_track_m = {cross_track_m}
"""

CAPTURE = tomllib.loads(capture(name="capture"))  # as tables


def capture_tables(**keys: str | float) -> dict[str, object]:
    """The same as tables, with ``keys`` such as name and until_s."""
    return {**CAPTURE, **keys}
