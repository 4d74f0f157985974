"""A microburst: a column of sinking air that spreads over the ground, in closed form and free of divergence."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Annotated, Any, ClassVar

from aircraft.ranges import ABOVE_ZERO, SINCE_BEGIN, Range, check_ranges
from aircraft.wind_event import Outline, circle
from aircraft.wind_events._occasion import SPEED, one_minus_cosine, place_in_words, time_in_words

GROWTH = -0.15  # c1: how the outflow dies away with height, over the height of its peak
FRICTION = -3.214924  # c2: how it comes up from the ground; c1 exp(c1) = c2 exp(c2) puts the peak where it is said
PEAK = math.exp(GROWTH) - math.exp(FRICTION)  # of the vertical shape, at the height of the peak outflow
FARTHEST = 3.0  # radii, beyond which the wind is below 1e-7 of its peak


@dataclass(frozen=True)
class Microburst:
    """Axisymmetric stagnation flow with a boundary layer [Vicroy 1991, NASA TM-104053].

    Outflow u = (scale/2) r E(r) P(z) with P = exp(c1 z/zp) - exp(c2 z/zp), E = exp((1 - (r/rp)^4 / 2) / 2): it peaks at
    the radius rp and the height zp. Continuity, (1/r) d(r u)/dr + dw/dz = 0, then gives the vertical wind
    w = -scale (1 - (r/rp)^4 / 2) E(r) (integral of P from the ground to z): down inside, weakly up in a ring outside.

    Defaults are medians of microbursts measured by radar (Wilson and others, 1984): 3.1 km between the peaks on either
    side, 75 m above the ground; the median peak was 11 m/s. High above the peak the model has too much wind.
    """

    peak: Annotated[float, "m/s", SPEED]  # greatest outflow
    past_threshold: Annotated[float, "m"]  # of its centre
    right: Annotated[float, "m"] = 0.0  # of the centreline
    radius: Annotated[float, "m", Range(least=100.0, most=10_000.0)] = 1550.0  # of the greatest outflow
    height: Annotated[float, "m", Range(least=10.0, most=1000.0)] = 75.0  # of the greatest outflow
    at: Annotated[float | None, "s", SINCE_BEGIN] = None  # absent = there all the time
    lasts: Annotated[float | None, "s", ABOVE_ZERO] = None  # it swells and fades as one minus cosine
    runway: Annotated[Any, "given"] = None  # where the threshold lies
    example: ClassVar[dict[str, Any]] = {"peak_mps": 11.0, "past_threshold_m": -2500.0}

    def __post_init__(self) -> None:
        check_ranges(self)
        if not (math.isfinite(self.past_threshold) and math.isfinite(self.right)):
            raise ValueError("past_threshold and right of a microburst must be finite numbers")
        if (self.at is None) != (self.lasts is None):
            raise ValueError("a microburst that comes and goes needs both at and lasts; absent, it is always there")

    @cached_property
    def centre(self) -> tuple[float, float]:
        """(north, east), m from the threshold."""
        north, east = self.runway.to_local(self.past_threshold, self.right)
        return float(north), float(east)

    def outflow(self, radius: float, height: float) -> tuple[float, float]:
        """(radial outflow over the radius, 1/s; vertical wind, m/s) at full strength [Vicroy 1991]."""
        fourth = (radius / self.radius) ** 4
        if fourth > FARTHEST**4:
            return 0.0, 0.0
        scale = 2.0 * self.peak / (self.radius * PEAK * math.exp(0.25))
        spread = math.exp(0.5 - 0.25 * fourth)
        up = max(height, 0.0) / self.height
        growth, friction = math.exp(GROWTH * up), math.exp(FRICTION * up)
        rising = self.height * ((growth - 1.0) / GROWTH - (friction - 1.0) / FRICTION)
        return 0.5 * scale * spread * (growth - friction), -scale * (1.0 - 0.5 * fourth) * spread * rising

    def strength(self, time: float) -> float:
        """0..1 at a time, s."""
        if self.at is None or self.lasts is None:
            return 1.0
        return one_minus_cosine((time - self.at) / self.lasts)

    def velocity(
        self, time: float, position: tuple[float, float, float], airspeed: float
    ) -> tuple[float, float, float]:
        """(north, east, up), m/s."""
        strength = self.strength(time)
        if strength == 0.0:
            return 0.0, 0.0, 0.0
        middle_north, middle_east = self.centre
        north, east = position[0] - middle_north, position[1] - middle_east
        out, up = self.outflow(math.hypot(north, east), position[2])
        return strength * out * north, strength * out * east, strength * up

    def words(self) -> str:
        """How strong, how large, where and when."""
        where, when = place_in_words(self.past_threshold, self.right), time_in_words(self.at, self.lasts)
        return f"{self.peak:.1f} m/s, {self.radius:.0f} m in radius, {where}{when}"

    def outline(self) -> Outline:
        """Where the outflow is greatest."""
        return circle(*self.centre, self.radius)

    def standing(self) -> Microburst:
        """At its greatest strength."""
        return replace(self, at=None, lasts=None)
