"""Terminal surveillance radar: slant range and azimuth once per antenna turn."""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from typing import Annotated, Any, NamedTuple

import numpy as np

from aircraft.state import AircraftState
from sim.flight.interpolation import position_at
from sim.observation.antenna import at_least_a_step, location, polar, positive
from sim.randomness import Rows, Streams
from sim.scenario.tables import Runway


class Scan(NamedTuple):
    """What the radar carries from step to step."""

    epoch: float  # s, next look at the target
    noise: Rows


@dataclass(frozen=True)
class SurveillanceRadar:
    """Slant range and azimuth, or position with the same accuracy along both axes where the papers assume that."""

    period: Annotated[float, "s"] = 4.0
    range_sigma: Annotated[float, "m"] = 60.0
    azimuth_sigma: Annotated[float, "rad"] = math.radians(0.15)
    position_sigma: Annotated[float | None, "m"] = None
    position: Annotated[tuple[float, float, float], "m"] = (0.0, 2000.0, 10.0)  # past threshold, right, up
    course: Annotated[float, "rad"] = 0.0  # of zero azimuth, relative to the runway
    runway: Annotated[Runway, "given"] = field(default_factory=Runway)

    def __post_init__(self) -> None:
        at_least_a_step(self.period)
        positive(self, "range_sigma", "azimuth_sigma", "position_sigma")

    @property
    def channels(self) -> tuple[str, ...]:
        """What is measured, in the order of z."""
        return ("range", "azimuth") if self.position_sigma is None else ("north", "east")

    @property
    def antenna(self) -> tuple[float, float, float]:
        """(north, east, height) of the antenna, m."""
        return location(self.runway, self.position)

    @property
    def zero_azimuth(self) -> float:
        """Course of zero azimuth, rad clockwise from north."""
        return float(self.runway.heading + self.course)

    def covariance(self) -> np.ndarray:
        """R of one scan, shape (2, 2)."""
        if self.position_sigma is not None:
            return np.diag((self.position_sigma**2, self.position_sigma**2))
        return np.diag((self.range_sigma**2, self.azimuth_sigma**2))

    def truth(self, position: Any) -> np.ndarray:
        """Noise-free channels for (north, east, height), shape (3, ...) -> (2, ...)."""
        if self.position_sigma is not None:
            return np.asarray(position)[:2]
        slant, azimuth, _ = polar(position, self.antenna, self.zero_azimuth)
        return np.stack((slant, azimuth))

    def begin(self, time: float, streams: Streams) -> Scan:
        """Ready for the first look, one period after ``time``."""
        return Scan(time + self.period, streams.normal("noise", 2))

    def step(
        self, scan: Scan, before: AircraftState, after: AircraftState
    ) -> tuple[Scan, list[tuple[float, float, np.ndarray, np.ndarray]]]:
        """Looks that fall between two records: (epoch, arrival, z (2, draws), R (2, 2)) each."""
        looks = []
        epoch = scan.epoch
        while epoch <= after.time:
            R = self.covariance()
            z = self.truth(position_at(before, after, epoch))[:, None] + np.sqrt(np.diag(R))[:, None] * scan.noise.row()
            looks.append((epoch, epoch, z, R))
            epoch += self.period
        return Scan(epoch, scan.noise), looks
