"""Localiser: the azimuth of the aircraft seen from beyond the far end of the runway, and nothing else."""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from typing import Annotated, ClassVar

import numpy as np

from aircraft.ranges import ABOVE_ZERO, check_ranges, within
from aircraft.state import AircraftState
from sim.flight.interpolation import state_at
from sim.observation.antenna import (
    Sampling,
    antenna_of,
    looks_until,
    place,
    polar,
    sector,
)
from sim.observation.sensor import PERIOD, Look
from sim.randomness import Streams
from sim.scenario.tables import Runway


@dataclass(frozen=True)
class Localiser:
    """Azimuth from the course line of an antenna that looks up the approach, with noise and a constant error.

    The course line is the runway's, turned by ``course_offset`` (+ clockwise, as its course towards the runway is read
    on a chart) where terrain or a steep approach asks for it; the antenna is then where ``position`` puts it.
    ``bias`` is the misalignment of the course; R does not include it. Defaults are about those
    of a category I installation, from memory of Annex 10 volume I, 3.1.3: usable to 17 NM within 35 degrees of the
    course (to 25 NM within 10, which is not modelled); course bends of 0.015 DDM at most near the runway, a tenth of
    a half course of some 2 degrees, read as two standard deviations, and taken for white; aligned within 10.5 m at
    the threshold.
    """

    period: Annotated[float, "s", PERIOD] = 0.2
    sigma: Annotated[float, "rad", ABOVE_ZERO] = math.radians(0.1)
    # + measured too far to the right, seen from the antenna
    bias: Annotated[float, "rad", within(math.radians(5.0), "beyond, nobody would fly it")] = 0.0
    # of the course line from that of the runway
    course_offset: Annotated[float, "rad", within(math.radians(45.0))] = 0.0
    position: Annotated[tuple[float, float, float], "m"] = (2800.0, 0.0, 3.0)  # past the threshold, right, up
    sector: Annotated[float, "rad", ABOVE_ZERO] = math.radians(70.0)  # full width about the course line
    coverage: Annotated[float, "m", ABOVE_ZERO] = 17 * 1852.0
    runway: Annotated[Runway, "given"] = field(default_factory=Runway)

    channels: ClassVar[tuple[str, ...]] = ("azimuth",)
    gives_place: ClassVar[bool] = False  # a direction alone is no place
    clutter: ClassVar[float] = 0.0  # it knows its target
    antenna = property(antenna_of)

    def __post_init__(self) -> None:
        check_ranges(self)

    @property
    def zero_azimuth(self) -> float:
        """The course line, away from the antenna, rad clockwise from north."""
        return float(self.runway.heading + math.pi + self.course_offset)

    def outline(self) -> tuple[tuple[float, float], ...]:
        """The sector."""
        return sector(self.antenna, self.zero_azimuth, self.sector, self.coverage)

    def truth(self, state: AircraftState) -> np.ndarray:
        """Noise-free azimuth, shape (1, ...)."""
        return np.stack(polar(place(state), self.antenna, self.zero_azimuth)[1:2])

    def begin(self, time: float, streams: Streams) -> Sampling:
        """Ready for the first sample, one period after ``time``."""
        return Sampling(time + self.period, streams.normal("noise", 1))

    def step(self, state: Sampling, before: AircraftState, after: AircraftState) -> tuple[Sampling, list[Look]]:
        """Samples between two records; none outside the sector."""
        R = np.array([[self.sigma**2]])

        def sample(epoch: float) -> Look | None:
            noise = state.noise.row()  # row k belongs to epoch k, seen or not
            now = state_at(before, after, epoch)
            slant, azimuth, _ = polar(place(now), self.antenna, self.zero_azimuth)
            if abs(azimuth) > self.sector / 2 or slant > self.coverage:
                return None
            return Look(epoch, epoch, self.truth(now)[:, None] + self.bias + self.sigma * noise, R)

        return looks_until(state, self.period, after.time, sample)
