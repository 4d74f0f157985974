"""Distance-measuring equipment: slant range to a transponder."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Annotated, ClassVar, NamedTuple

import numpy as np

from aircraft.ranges import ABOVE_ZERO, NOT_NEGATIVE, check_ranges
from aircraft.state import AircraftState
from sim.flight.interpolation import state_at
from sim.observation.antenna import (
    antenna_of,
    looks_until,
    no_outline,
    place,
    polar,
)
from sim.observation.sensor import PERIOD, Look
from sim.randomness import Rows, Streams
from sim.scenario.tables import Runway


class Interrogator(NamedTuple):
    """The state of the sensor from step to step."""

    epoch: float
    noise: Rows
    bias: np.ndarray  # (1, draws)


@dataclass(frozen=True)
class Dme:
    """Slant range with noise and, per draw, a constant bias."""

    period: Annotated[float, "s", PERIOD] = 0.1
    sigma: Annotated[float, "m", ABOVE_ZERO] = 15.0
    bias_sigma: Annotated[float, "m", NOT_NEGATIVE] = 0.0
    position: Annotated[tuple[float, float, float], "m"] = (300.0, 120.0, 3.0)
    runway: Annotated[Runway, "given"] = field(default_factory=Runway)

    channels: ClassVar[tuple[str, ...]] = ("range",)
    gives_place: ClassVar[bool] = False  # it does not say where the aircraft is on the ground plane
    clutter: ClassVar[float] = 0.0  # it knows its target
    antenna = property(antenna_of)
    zero_azimuth: ClassVar[None] = None  # it measures none
    outline = no_outline  # it has no limits on the ground

    def __post_init__(self) -> None:
        check_ranges(self)

    def truth(self, state: AircraftState) -> np.ndarray:
        """Noise-free channels, shape (1, ...)."""
        return np.stack(polar(place(state), self.antenna, 0.0)[:1])

    def begin(self, time: float, streams: Streams) -> Interrogator:
        """Ready for the first reply, one period after ``time``."""
        bias = self.bias_sigma * streams.normal("bias", 1).row()
        return Interrogator(time + self.period, streams.normal("noise", 1), bias)

    def step(self, state: Interrogator, before: AircraftState, after: AircraftState) -> tuple[Interrogator, list[Look]]:
        """Replies between two records."""
        R = np.array([[self.sigma**2 + self.bias_sigma**2]])

        def reply(epoch: float) -> Look:
            exact = self.truth(state_at(before, after, epoch))
            return Look(epoch, epoch, exact[:, None] + state.bias + self.sigma * state.noise.row(), R)

        return looks_until(state, self.period, after.time, reply)
