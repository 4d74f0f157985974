"""A wind that sets in and stays: a front that passes at a time, or a line on the approach behind which it blows."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import Annotated, Any, ClassVar

from aircraft.ranges import ABOVE_ZERO, SINCE_BEGIN
from aircraft.wind_event import Outline
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
class WindShift:
    """A further wind V that grows as V/2 (1 - cos(pi x/d)) and then stays [MIL-F-8785C, 3.7.2.3].

    At a time it grows for ``lasts``, everywhere. At a place it grows from a line across the runway's direction over
    ``length`` of the way to the runway, and blows from there on.
    """

    speed: Annotated[float, "m/s", SPEED] = 0.0  # of the horizontal part
    from_: Annotated[float, "rad"] = 0.0  # where that blows from
    up: Annotated[float, "m/s", UP] = 0.0
    at: Annotated[float | None, "s", SINCE_BEGIN] = None
    lasts: Annotated[float | None, "s", ABOVE_ZERO] = None
    past_threshold: Annotated[float | None, "m"] = None
    length: Annotated[float | None, "m", ABOVE_ZERO] = None
    runway: Annotated[Any, "given"] = None  # where the threshold lies; needed by a shift at a place
    example: ClassVar[dict[str, Any]] = {"speed_mps": 5.0, "from_deg": 200.0, "at_s": 20.0, "lasts_s": 4.0}

    def __post_init__(self) -> None:
        check(self, "a wind shift")

    @cached_property
    def _amplitude(self) -> tuple[float, float, float]:
        return amplitude(self.speed, self.from_, self.up)

    @cached_property
    def _along(self) -> tuple[float, float]:
        north, east = self.runway.to_local(1.0, 0.0)
        return float(north), float(east)

    def share(self, time: float, north: float, east: float) -> float:
        """0..1 of the amplitude at a time, s, and a place, m."""
        if self.at is not None and self.lasts is not None:
            grown = (time - self.at) / self.lasts
        else:
            assert self.past_threshold is not None
            assert self.length is not None
            along_north, along_east = self._along
            grown = (north * along_north + east * along_east - self.past_threshold) / self.length
        return 1.0 if grown >= 1.0 else one_minus_cosine(0.5 * grown)

    def velocity(
        self, time: float, position: tuple[float, float, float], airspeed: float
    ) -> tuple[float, float, float]:
        """(north, east, up), m/s."""
        return scaled(self.share(time, position[0], position[1]), self._amplitude)

    def words(self) -> str:
        """A shift at a place grows over a length."""
        if self.length is None or self.past_threshold is None:
            return phrase(self)
        return phrase(self, f", over {self.length:.0f} m from {place_in_words(self.past_threshold)}")

    def outline(self) -> Outline:
        """None: it blows on everything behind its line."""
        return ()

    def standing(self) -> WindShift | None:
        """A shift at a place."""
        return None if self.length is None else self
