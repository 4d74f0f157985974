"""Radio altimeter: height of the wheels above the ground, low down only."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Annotated, Any, NamedTuple

import numpy as np

from aircraft.state import AircraftState
from sim.flight.interpolation import position_at
from sim.observation.antenna import at_least_a_step, positive
from sim.randomness import Rows, Streams
from sim.scenario.tables import Runway


class Look(NamedTuple):
    """What is carried from step to step."""

    epoch: float
    noise: Rows


@dataclass(frozen=True)
class RadioAltimeter:
    """Height above level ground at the threshold's elevation; silent above ``coverage``."""

    period: Annotated[float, "s"] = 0.05
    sigma: Annotated[float, "m"] = 0.5
    coverage: Annotated[float, "m"] = 750.0
    runway: Annotated[Runway, "given"] = field(default_factory=Runway)

    def __post_init__(self) -> None:
        at_least_a_step(self.period)
        positive(self, "sigma", "coverage")

    @property
    def channels(self) -> tuple[str, ...]:
        """What is measured."""
        return ("height",)

    def truth(self, position: Any) -> np.ndarray:
        """Noise-free channels for (north, east, height), shape (3, ...) -> (1, ...)."""
        return np.stack((np.asarray(position[2]),))

    def begin(self, time: float, streams: Streams) -> Look:
        """Ready for the first reading, one period after ``time``."""
        return Look(time + self.period, streams.normal("noise", 1))

    def step(
        self, look: Look, before: AircraftState, after: AircraftState
    ) -> tuple[Look, list[tuple[float, float, np.ndarray, np.ndarray]]]:
        """Readings between two records: (epoch, arrival, z (1, draws), R (1, 1))."""
        looks = []
        epoch = look.epoch
        while epoch <= after.time:
            noise = look.noise.row()
            exact = self.truth(position_at(before, after, epoch))
            if exact[0] <= self.coverage:
                looks.append((epoch, epoch, exact[:, None] + self.sigma * noise, np.array([[self.sigma**2]])))
            epoch += self.period
        return look._replace(epoch=epoch), looks
