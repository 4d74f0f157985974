"""Distance-measuring equipment: slant range to a transponder."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Annotated, Any, NamedTuple

import numpy as np

from aircraft.state import AircraftState
from sim.flight.interpolation import position_at
from sim.observation.antenna import at_least_a_step, location, polar, positive
from sim.randomness import Rows, Streams
from sim.scenario.tables import Runway


class Look(NamedTuple):
    """What is carried from step to step."""

    epoch: float
    noise: Rows
    bias: np.ndarray  # (1, draws)


@dataclass(frozen=True)
class Dme:
    """Slant range with noise and, per draw, a constant bias."""

    period: Annotated[float, "s"] = 0.1
    sigma: Annotated[float, "m"] = 15.0
    bias_sigma: Annotated[float, "m"] = 0.0
    position: Annotated[tuple[float, float, float], "m"] = (300.0, 120.0, 3.0)
    runway: Annotated[Runway, "given"] = field(default_factory=Runway)

    def __post_init__(self) -> None:
        at_least_a_step(self.period)
        positive(self, "sigma")
        if self.bias_sigma < 0:
            raise ValueError("bias_sigma must not be negative")

    @property
    def channels(self) -> tuple[str, ...]:
        """What is measured."""
        return ("range",)

    @property
    def antenna(self) -> tuple[float, float, float]:
        """(north, east, height) of the transponder, m."""
        return location(self.runway, self.position)

    def truth(self, position: Any) -> np.ndarray:
        """Noise-free channels for (north, east, height), shape (3, ...) -> (1, ...)."""
        return np.stack(polar(position, self.antenna, 0.0)[:1])

    def begin(self, time: float, streams: Streams) -> Look:
        """Ready for the first reply, one period after ``time``."""
        return Look(time + self.period, streams.normal("noise", 1), self.bias_sigma * streams.normal("bias", 1).row())

    def step(
        self, look: Look, before: AircraftState, after: AircraftState
    ) -> tuple[Look, list[tuple[float, float, np.ndarray, np.ndarray]]]:
        """Replies between two records: (epoch, arrival, z (1, draws), R (1, 1))."""
        looks = []
        epoch = look.epoch
        while epoch <= after.time:
            z = self.truth(position_at(before, after, epoch))[:, None] + look.bias + self.sigma * look.noise.row()
            looks.append((epoch, epoch, z, np.array([[self.sigma**2 + self.bias_sigma**2]])))
            epoch += self.period
        return look._replace(epoch=epoch), looks
