"""Wind that grows with height: what the tower measures, times a profile of the layer near the ground."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Annotated, NamedTuple

from aircraft.ranges import Range, check_ranges
from aircraft.wind import SteadyWind

LOWEST, HIGHEST = 3.0 * 0.3048, 1000.0 * 0.3048  # m above the ground, between which the profiles hold
ROUGHNESS = Range(above=0.0, most=0.5 * LOWEST)
EXPONENT = Range(above=0.0, most=1.0)


@dataclass(frozen=True)
class LogarithmicProfile:
    """Speed proportional to ln(height / roughness), 3 to 1000 ft, constant beyond [MIL-F-8785C, wind shear model].

    The mean profile of a neutral surface layer. The default roughness is the specification's 0.15 ft for take-off,
    approach and landing.
    """

    roughness: Annotated[float, "m", ROUGHNESS] = 0.15 * 0.3048

    def __post_init__(self) -> None:
        check_ranges(self)

    def share(self, height: float, reference: float) -> float:
        """Speed at ``height`` over that at ``reference``, both m above the ground."""
        return math.log(_within(height) / self.roughness) / math.log(reference / self.roughness)


@dataclass(frozen=True)
class PowerProfile:
    """Speed proportional to height to a power, between the heights of the logarithmic profile, constant beyond.

    One seventh is the classical exponent of neutral air over open country; stable air has up to about a half.
    """

    exponent: Annotated[float, EXPONENT] = 1.0 / 7.0

    def __post_init__(self) -> None:
        check_ranges(self)

    def share(self, height: float, reference: float) -> float:
        """Speed at ``height`` over that at ``reference``, both m above the ground."""
        return float((_within(height) / reference) ** self.exponent)


PROFILES = {"logarithmic": LogarithmicProfile, "power": PowerProfile}


class ShearedWind(NamedTuple):
    """A horizontal wind of one direction whose speed follows a profile."""

    at_reference: SteadyWind
    reference: float  # m above the ground, where ``at_reference`` is measured
    profile: LogarithmicProfile | PowerProfile

    def velocity(
        self, time: float, position: tuple[float, float, float], airspeed: float
    ) -> tuple[float, float, float]:
        """(north, east, up), m/s."""
        share = self.profile.share(position[2], self.reference)
        north, east, up = self.at_reference
        return share * north, share * east, up


def _within(height: float) -> float:
    return min(max(height, LOWEST), HIGHEST)
