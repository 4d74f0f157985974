"""Doppler radar: slant range, and the rate at which it grows, of which no tracker here makes use."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Annotated

import numpy as np

from aircraft.ranges import ABOVE_ZERO, check_ranges
from aircraft.state import AircraftState
from sim.flight.interpolation import state_at
from sim.observation.antenna import Sampling, location, looks_until, place, polar
from sim.observation.sensor import PERIOD, Look
from sim.randomness import Streams
from sim.scenario.tables import Runway


@dataclass(frozen=True)
class DopplerRadar:
    """Range and range rate, seen all round from beside the runway; its fields are the keys of its table."""

    period: Annotated[float, "s", PERIOD] = 0.5
    range_sigma: Annotated[float, "m", ABOVE_ZERO] = 30.0
    range_rate_sigma: Annotated[float, "m/s", ABOVE_ZERO] = 0.5
    position: Annotated[tuple[float, float, float], "m"] = (300.0, 200.0, 3.0)  # past the threshold, right, up
    runway: Annotated[Runway, "given"] = field(default_factory=Runway)  # by the simulation, never by a file

    channels = ("range", "range_rate")  # of sim.observation.sensor.QUANTITIES: metres, metres per second
    gives_place, clutter, zero_azimuth = False, 0.0, None  # a range is no place; no false plots; no azimuth

    def __post_init__(self) -> None:
        check_ranges(self)

    @property
    def antenna(self) -> tuple[float, float, float]:  # from where the range is counted
        return location(self.runway, self.position)

    def outline(self) -> tuple[()]:
        return ()  # no edge that could be drawn

    def truth(self, state: AircraftState) -> np.ndarray:
        slant, azimuth, elevation = polar(place(state), self.antenna, 0.0)
        over_ground = state.velocity_north * np.cos(azimuth) + state.velocity_east * np.sin(azimuth)
        return np.stack((slant, over_ground * np.cos(elevation) + state.velocity_up * np.sin(elevation)))

    def begin(self, time: float, streams: Streams) -> Sampling:
        return Sampling(time + self.period, streams.normal("noise", 2))

    def step(self, state: Sampling, before: AircraftState, after: AircraftState) -> tuple[Sampling, list[Look]]:
        sigma = np.array((self.range_sigma, self.range_rate_sigma))

        def look(epoch: float) -> Look:
            z = self.truth(state_at(before, after, epoch))[:, None] + sigma[:, None] * state.noise.row()
            return Look(epoch, epoch, z, np.diag(sigma**2))  # when it was true, when it was known, what, how well

        return looks_until(state, self.period, after.time, look)


SHORTFINAL = {"sensors": {"doppler_radar": DopplerRadar}}  # what this file brings, where it stays outside
