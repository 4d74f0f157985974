"""Names and scales, in figures, of the deviations that a law uses."""

from __future__ import annotations

import math
from typing import NamedTuple


class Component(NamedTuple):
    """One field of ``PathDeviation`` on a page."""

    label: str  # of an axis
    short: str  # of a row
    scale: float = 1.0  # from SI to what is shown

    @property
    def unit(self) -> str:
        """As shown."""
        return self.label.rpartition(", ")[2]


DEGREES = math.degrees(1.0)
COMPONENTS = {
    "cross_track": Component("cross-track, m (+ right)", "offset"),
    "cross_track_rate": Component("cross-track rate, m/s", "rate"),
    "distance_to_go": Component("distance to go, m", "distance"),
    "bearing_error": Component("bearing error, deg", "bearing", DEGREES),
    "track_error": Component("track error, deg", "track", DEGREES),
    "heading_error": Component("heading error, deg", "heading", DEGREES),
}
