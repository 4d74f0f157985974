"""A column of rising air, as over a hot field: all that a kind of wind event needs to say.

As ``updraught.py`` in ``aircraft/wind_events``, or as ``--plugin updraught.py``, a scenario may say

    [wind]
    events.field = { kind = "updraught", up_mps = 5, past_threshold_m = -3000, at_s = 10, lasts_s = 60 }
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from typing import Annotated, Any

from aircraft.wind_event import Outline, circle


@dataclass(frozen=True)
class Updraught:
    """The air rises by ``up (1 - (r / radius)^2)`` within a radius, at all heights."""

    up: Annotated[float, "m/s"] = 3.0  # in the middle
    past_threshold: Annotated[float, "m"] = -3000.0  # of the middle
    right: Annotated[float, "m"] = 0.0  # of the centreline
    radius: Annotated[float, "m"] = 800.0
    at: Annotated[float | None, "s"] = None  # when it begins; absent = it is always there
    lasts: Annotated[float, "s"] = 60.0
    runway: Annotated[Any, "given"] = None  # where the threshold lies: filled by the simulation

    def __post_init__(self) -> None:
        if not (self.radius > 0.0 and self.lasts > 0.0):
            raise ValueError("radius and lasts of an updraught must be above 0")

    def velocity(
        self, time: float, position: tuple[float, float, float], airspeed: float
    ) -> tuple[float, float, float]:
        """(north, east, up), m/s."""
        if self.at is not None and not 0.0 <= time - self.at <= self.lasts:
            return 0.0, 0.0, 0.0
        north, east = self.runway.to_local(self.past_threshold, self.right)
        from_middle = math.hypot(position[0] - north, position[1] - east)
        return 0.0, 0.0, self.up * max(1.0 - (from_middle / self.radius) ** 2, 0.0)

    def words(self) -> str:
        """For explain and the report, which say "updraught of" before it."""
        when = "" if self.at is None else f", from {self.at:.0f} s for {self.lasts:.3g} s"
        return f"{self.up:.1f} m/s, {self.radius:.0f} m in radius{when}"

    def outline(self) -> Outline:
        """For the plan view."""
        return circle(*self.runway.to_local(self.past_threshold, self.right), self.radius)

    def standing(self) -> Updraught:
        """For what is weighed against the power of the aircraft, and drawn from beside."""
        return replace(self, at=None)


SHORTFINAL = {"wind_events": {"updraught": Updraught}}  # what this file brings, where it stays outside
