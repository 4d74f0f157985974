"""A single gust that swells and fades as one minus cosine: at a time, or at a place."""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import cached_property
from typing import Annotated, Any, ClassVar

from aircraft.ranges import ABOVE_ZERO, SINCE_BEGIN
from aircraft.wind_event import Outline, circle
from aircraft.wind_events._occasion import (
    SPEED,
    UP,
    amplitude,
    check,
    one_minus_cosine,
    phrase,
    place_in_words,
    scaled,
)


@dataclass(frozen=True)
class Gust:
    """A discrete gust of amplitude U: U/2 (1 - cos(pi s/H)) over 2H of flight [CS 25.341(a)].

    At a time it lasts ``lasts`` wherever the aircraft is. At a place it is round, ``length`` wide and upright: a flight
    through its middle meets the same shape from any side, beside it a weaker and shorter one. The specification's
    gradient distance H, 9 to 107 m, is half of ``length``, and half of ``lasts`` times the airspeed.
    """

    up: Annotated[float, "m/s", UP] = 0.0
    speed: Annotated[float, "m/s", SPEED] = 0.0  # of the horizontal part
    from_: Annotated[float, "rad"] = 0.0  # where that blows from
    at: Annotated[float | None, "s", SINCE_BEGIN] = None
    lasts: Annotated[float | None, "s", ABOVE_ZERO] = None
    past_threshold: Annotated[float | None, "m"] = None
    right: Annotated[float, "m"] = 0.0  # of the centreline
    length: Annotated[float | None, "m", ABOVE_ZERO] = None
    runway: Annotated[Any, "given"] = None  # where the threshold lies; needed by a gust at a place
    example: ClassVar[dict[str, Any]] = {"up_mps": 6.0, "at_s": 20.0, "lasts_s": 4.0}

    def __post_init__(self) -> None:
        check(self, "a gust")
        if not math.isfinite(self.right):
            raise ValueError("right of a gust must be a finite number")

    @cached_property
    def _amplitude(self) -> tuple[float, float, float]:
        return amplitude(self.speed, self.from_, self.up)

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
        return scaled(self.share(time, position[0], position[1]), self._amplitude)

    def words(self) -> str:
        """A gust at a place has a length."""
        if self.length is None or self.past_threshold is None:
            return phrase(self)
        where = place_in_words(self.past_threshold, self.right)
        return phrase(self, f", {self.length:.0f} m long, {where}")

    def outline(self) -> Outline:
        """The edge of a gust at a place."""
        return () if self.length is None else circle(*self._centre, self.length / 2)

    def standing(self) -> None:
        """A gust is passed before it costs energy."""
        return None
