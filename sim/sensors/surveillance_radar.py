"""Terminal surveillance radar: slant range and azimuth once per antenna turn."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Annotated, Any, NamedTuple

import numpy as np

from aircraft.state import AircraftState
from sim.interpolation import position_at
from sim.randomness import Rows, Streams


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
    runway: Annotated[Any, "given"] = None

    def __post_init__(self) -> None:
        if self.period < 1 / 120:
            raise ValueError("period must be at least 1/120 s: the flight is not known in finer steps")
        for name in ("range_sigma", "azimuth_sigma", "position_sigma"):
            sigma = getattr(self, name)
            if sigma is not None and sigma <= 0:
                raise ValueError(f"{name} must be above 0")

    @property
    def channels(self) -> tuple[str, ...]:
        """What is measured, in the order of z."""
        return ("range", "azimuth") if self.position_sigma is None else ("north", "east")

    @property
    def location(self) -> tuple[float, float, float]:
        """(north, east, height) of the antenna, m."""
        north, east = self.runway.to_local(self.position[0], self.position[1])
        return north, east, self.position[2]

    @property
    def zero_azimuth(self) -> float:
        """Course of zero azimuth, rad clockwise from north."""
        return self.runway.heading + self.course

    def covariance(self) -> np.ndarray:
        """R of one scan, shape (2, 2)."""
        if self.position_sigma is not None:
            return np.diag((self.position_sigma**2, self.position_sigma**2))
        return np.diag((self.range_sigma**2, self.azimuth_sigma**2))

    def truth(self, position: Any) -> np.ndarray:
        """Noise-free channels for (north, east, height), shape (3, ...) -> (2, ...)."""
        if self.position_sigma is not None:
            return np.asarray(position)[:2]
        north, east, up = (p - o for p, o in zip(position, self.location, strict=True))
        slant = np.sqrt(north**2 + east**2 + up**2)
        azimuth = np.arctan2(east, north) - self.zero_azimuth
        return np.stack((slant, np.arctan2(np.sin(azimuth), np.cos(azimuth))))

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
