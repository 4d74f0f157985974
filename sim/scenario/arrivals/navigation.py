"""What is wrong with the navigation that an autopilot flies on, where it is no tracker of the scenario."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Annotated, Literal

from aircraft.ranges import Range, check_ranges, within
from sim.scenario.tables import FARTHEST

BEND = Range(least=0.0, most=math.radians(2.0))


@dataclass(frozen=True)
class NavigationErrors:
    """Errors of the localiser, of the glide path and of the wind that the aircraft has worked out.

    Bends are deviations of a beam that stay where they are: a first-order Gauss-Markov process over the distance to the
    antenna. The aircraft smooths the localiser by what it knows of its own ``motion`` across the final (a complementary
    filter of second order, critically damped): "air", its heading, its airspeed and a wind that it corrects as it goes,
    and that lags behind the true one; or "inertial", its velocity over the ground with a drift that it corrects. So it
    believes a cross-track and a rate that are both a little wrong. Without the table the autopilot knows its motion.

    Nothing errs by default. Annex 10 lets twice the deviation of a localiser's bends be 5 microampere of category III
    at the runway (0.07 deg, with 150 microampere at 2.15 deg) and 30 of any category beyond 4 NM [ICAO annex 10 volume
    I, 3.1.3.4, from memory]; how long bends are is not laid down.
    """

    localiser_bend: Annotated[float, "rad", BEND] = 0.0  # standard deviation
    # of the course line, + to the right of an approach
    localiser_bias: Annotated[float, "rad", within(math.radians(5.0))] = 0.0
    glide_path_bend: Annotated[float, "rad", BEND] = 0.0  # standard deviation
    bend_length: Annotated[float, "m", Range(least=1.0, most=FARTHEST)] = 1000.0  # of correlation
    smoothing: Annotated[float, "s", Range(least=0.5, most=600.0)] = 10.0  # time constant of the complementary filter
    # standard deviation of what is wrong with wind, or drift, across at first
    wind: Annotated[float, "m/s", Range(least=0.0, most=50.0)] = 0.0
    motion: Literal["air", "inertial"] = "air"
    # of the antenna, past the threshold
    localiser_past: Annotated[float, "m", Range(least=0.0, most=20_000.0)] = 2800.0

    def __post_init__(self) -> None:
        check_ranges(self)
