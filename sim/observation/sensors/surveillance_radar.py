"""Terminal surveillance radar: slant range and azimuth once per antenna turn."""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from typing import Annotated, ClassVar

import numpy as np

from aircraft.state import AircraftState
from sim.flight.interpolation import state_at
from sim.observation.antenna import (
    Sampling,
    antenna_of,
    at_least_a_step,
    looks_until,
    no_outline,
    place,
    polar,
    positive,
    zero_azimuth_of,
)
from sim.observation.sensor import Look
from sim.randomness import Streams
from sim.scenario.tables import Runway


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

    gives_place: ClassVar[bool] = True  # one scan is a place
    clutter: ClassVar[float] = 0.0  # it knows its target
    antenna = property(antenna_of)
    zero_azimuth = property(zero_azimuth_of)
    outline = no_outline  # it sees all round, as far as there is something to see

    def __post_init__(self) -> None:
        at_least_a_step(self.period)
        positive(self, "range_sigma", "azimuth_sigma", "position_sigma")

    @property
    def channels(self) -> tuple[str, ...]:
        """What is measured, in the order of z."""
        return ("range", "azimuth") if self.position_sigma is None else ("north", "east")

    def covariance(self) -> np.ndarray:
        """R of one scan, shape (2, 2)."""
        if self.position_sigma is not None:
            return np.diag((self.position_sigma**2, self.position_sigma**2))
        return np.diag((self.range_sigma**2, self.azimuth_sigma**2))

    def truth(self, state: AircraftState) -> np.ndarray:
        """Noise-free channels, shape (2, ...)."""
        if self.position_sigma is not None:
            return np.stack((state.north, state.east))
        slant, azimuth, _ = polar(place(state), self.antenna, self.zero_azimuth)
        return np.stack((slant, azimuth))

    def begin(self, time: float, streams: Streams) -> Sampling:
        """Ready for the first look, one period after ``time``."""
        return Sampling(time + self.period, streams.normal("noise", 2))

    def step(self, state: Sampling, before: AircraftState, after: AircraftState) -> tuple[Sampling, list[Look]]:
        """Looks that fall between two records."""
        R = self.covariance()
        sigma = np.sqrt(np.diag(R))[:, None]

        def scan(epoch: float) -> Look:
            exact = self.truth(state_at(before, after, epoch))
            return Look(epoch, epoch, exact[:, None] + sigma * state.noise.row(), R)

        return looks_until(state, self.period, after.time, scan)
