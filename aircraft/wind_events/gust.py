"""A single gust that swells and fades as one minus cosine: at a time, or at a place."""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import cached_property
from typing import Annotated, Any

FASTEST = 100.0  # m/s


@dataclass(frozen=True)
class Gust:
    """A discrete gust of amplitude U: U/2 (1 - cos(pi s/H)) over 2H of flight [CS 25.341(a)].

    At a time it lasts ``lasts`` wherever the aircraft is. At a place it is round, ``length`` wide and upright: a flight
    through its middle meets the same shape from any side, beside it a weaker and shorter one. The specification's
    gradient distance H, 9 to 107 m, is half of ``length``, and half of ``lasts`` times the airspeed.
    """

    up: Annotated[float, "m/s"] = 0.0
    speed: Annotated[float, "m/s"] = 0.0  # of the horizontal part
    from_: Annotated[float, "rad"] = 0.0  # where that blows from
    at: Annotated[float | None, "s"] = None
    lasts: Annotated[float | None, "s"] = None
    past_threshold: Annotated[float | None, "m"] = None
    right: Annotated[float, "m"] = 0.0  # of the centreline
    length: Annotated[float | None, "m"] = None
    runway: Annotated[Any, "given"] = None  # where the threshold lies; needed by a gust at a place

    def __post_init__(self) -> None:
        if not 0.0 <= self.speed <= FASTEST or not abs(self.up) <= FASTEST:
            raise ValueError(
                f"speed of a gust must lie within 0 and {FASTEST:.0f} m/s, and up within as much either way"
            )
        for name in ("at", "lasts", "past_threshold", "right", "length"):
            value = getattr(self, name)
            if value is not None and not math.isfinite(value):
                raise ValueError(f"{name} of a gust must be a finite number")
        in_time = self.at is not None and self.lasts is not None
        in_space = self.past_threshold is not None and self.length is not None
        half_said = (self.at is None) != (self.lasts is None) or (self.past_threshold is None) != (self.length is None)
        if in_time == in_space or half_said:
            raise ValueError(
                "a gust comes at a time (at, lasts) or at a place (past_threshold, length): say one of them"
            )
        if self.at is not None and self.at < 0.0:
            raise ValueError("at must not be negative: a flight begins at 0 s")
        if not (self.lasts or self.length or 0.0) > 0.0:
            raise ValueError("lasts and length of a gust must be above 0")

    @cached_property
    def _amplitude(self) -> tuple[float, float, float]:
        return -self.speed * math.cos(self.from_), -self.speed * math.sin(self.from_), self.up

    @cached_property
    def _centre(self) -> tuple[float, float]:
        north, east = self.runway.to_local(self.past_threshold, self.right)
        return float(north), float(east)

    def share(self, time: float, north: float, east: float) -> float:
        """0..1 of the amplitude at a time, s, and a place, m."""
        if self.at is not None and self.lasts is not None:
            return one_minus_cosine((time - self.at) / self.lasts)
        assert self.length is not None
        middle_north, middle_east = self._centre
        return one_minus_cosine(0.5 + math.hypot(north - middle_north, east - middle_east) / self.length)

    def velocity(
        self, time: float, position: tuple[float, float, float], airspeed: float
    ) -> tuple[float, float, float]:
        """(north, east, up), m/s."""
        share = self.share(time, position[0], position[1])
        if share == 0.0:
            return 0.0, 0.0, 0.0
        north, east, up = self._amplitude
        return share * north, share * east, share * up


def one_minus_cosine(share: float) -> float:
    """Half of one minus the cosine, once around: 0 at 0, 1 at 1/2, 0 at 1 and outside."""
    return 0.5 - 0.5 * math.cos(2.0 * math.pi * share) if 0.0 < share < 1.0 else 0.0
