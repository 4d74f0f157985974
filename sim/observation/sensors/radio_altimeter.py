"""Radio altimeter: height of the wheels above the ground, low down only."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Annotated, ClassVar

import numpy as np

from aircraft.ranges import ABOVE_ZERO, check_ranges
from aircraft.state import AircraftState
from sim.flight.interpolation import state_at
from sim.observation.antenna import Sampling, looks_until, no_outline
from sim.observation.sensor import PERIOD, Look
from sim.randomness import Streams
from sim.scenario.tables import Runway


@dataclass(frozen=True)
class RadioAltimeter:
    """Height above level ground at the threshold's elevation; silent above ``coverage``."""

    period: Annotated[float, "s", PERIOD] = 0.05
    sigma: Annotated[float, "m", ABOVE_ZERO] = 0.5
    coverage: Annotated[float, "m", ABOVE_ZERO] = 750.0
    runway: Annotated[Runway, "given"] = field(default_factory=Runway)

    channels: ClassVar[tuple[str, ...]] = ("height",)
    gives_place: ClassVar[bool] = False  # it does not say where the aircraft is on the ground plane
    clutter: ClassVar[float] = 0.0  # it knows its target
    antenna: ClassVar[None] = None  # it is in the aircraft
    zero_azimuth: ClassVar[None] = None  # it measures none
    outline = no_outline  # it has no limits on the ground

    def __post_init__(self) -> None:
        check_ranges(self)

    def truth(self, state: AircraftState) -> np.ndarray:
        """Noise-free channels, shape (1, ...)."""
        return np.stack((np.asarray(state.height),))

    def begin(self, time: float, streams: Streams) -> Sampling:
        """Ready for the first reading, one period after ``time``."""
        return Sampling(time + self.period, streams.normal("noise", 1))

    def step(self, state: Sampling, before: AircraftState, after: AircraftState) -> tuple[Sampling, list[Look]]:
        """Readings between two records; none above ``coverage``."""
        R = np.array([[self.sigma**2]])

        def reading(epoch: float) -> Look | None:
            noise = state.noise.row()  # row k belongs to epoch k, seen or not
            exact = self.truth(state_at(before, after, epoch))
            return Look(epoch, epoch, exact[:, None] + self.sigma * noise, R) if exact[0] <= self.coverage else None

        return looks_until(state, self.period, after.time, reading)
