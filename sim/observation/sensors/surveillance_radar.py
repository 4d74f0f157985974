"""Terminal surveillance radar: slant range and azimuth once a turn, and the height where a transponder says it."""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from typing import Annotated, Any, ClassVar, Literal, NamedTuple

import numpy as np

from aircraft.air import Air
from aircraft.state import AircraftState
from aircraft.units import SUFFIXES
from sim.flight.interpolation import state_at
from sim.observation.antenna import (
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
from sim.randomness import Rows, Streams
from sim.scenario.tables import Runway

FOOT = SUFFIXES["ft"][1]  # m
STEPS = (25.0 * FOOT, 100.0 * FOOT)  # of a Mode S and of a Mode A/C transponder

# The height that is sent agrees with what the altimeter measures within 125 ft with a probability of 95 % [ICAO
# Annex 10 volume IV, 3.1.1.7.12.2, from memory]: two standard deviations. It is an error of the aircraft, not of the
# look.
ALTIMETRY_SIGMA = 125.0 * FOOT / 2.0


class Turning(NamedTuple):
    """What the radar carries from turn to turn."""

    epoch: float  # s, of the next look
    noise: Rows
    altimetry: np.ndarray  # (draws,) m, the constant error of each aircraft's altimetry; zeros without Mode C


@dataclass(frozen=True)
class SurveillanceRadar:
    """Slant range and azimuth, or position with the same accuracy along both axes where the papers assume that.

    With ``height = "mode_c"`` the transponder's answer gives a height too: pressure altitude, with a constant error of
    its altimetry, in steps. The ground takes off the pressure altitude of the threshold, which follows from the QNH.
    On a cold day the aircraft is then lower than its answer says, and on a hot day higher, by 4 % of the height for
    10 K: that error is real and stays, and R, which counts the altimetry and the steps, knows nothing of it.
    """

    period: Annotated[float, "s"] = 4.0
    range_sigma: Annotated[float, "m"] = 60.0
    azimuth_sigma: Annotated[float, "rad"] = math.radians(0.15)
    position_sigma: Annotated[float | None, "m"] = None
    position: Annotated[tuple[float, float, float], "m"] = (0.0, 2000.0, 10.0)  # past threshold, right, up
    course: Annotated[float, "rad"] = 0.0  # of zero azimuth, relative to the runway
    height: Literal["none", "mode_c"] = "none"  # what of the height is measured
    height_step: Annotated[float, "m"] = STEPS[0]  # 25 ft, which the Mode S transponders of transports answer, or 100
    runway: Annotated[Runway, "given"] = field(default_factory=Runway)
    air: Annotated[Air, "given"] = field(default_factory=Air)

    gives_place: ClassVar[bool] = True  # one scan is a place
    clutter: ClassVar[float] = 0.0  # it knows its target
    antenna = property(antenna_of)
    zero_azimuth = property(zero_azimuth_of)
    outline = no_outline  # it sees all round, as far as there is something to see

    def __post_init__(self) -> None:
        at_least_a_step(self.period)
        positive(self, "range_sigma", "azimuth_sigma", "position_sigma")
        if not any(math.isclose(self.height_step, step) for step in STEPS):
            raise ValueError(f"height_step must be 25 ft or 100 ft, not {self.height_step / FOOT:.6g} ft")

    @property
    def channels(self) -> tuple[str, ...]:
        """What is measured, in the order of z."""
        place_channels = ("range", "azimuth") if self.position_sigma is None else ("north", "east")
        return (*place_channels, "height") if self._answered else place_channels

    @property
    def _answered(self) -> bool:
        return self.height == "mode_c"

    def covariance(self) -> np.ndarray:
        """R of one scan, shape (m, m); a step is a uniform error, of the variance step^2 / 12."""
        if self.position_sigma is not None:
            variances = [self.position_sigma**2, self.position_sigma**2]
        else:
            variances = [self.range_sigma**2, self.azimuth_sigma**2]
        return np.diag([*variances, ALTIMETRY_SIGMA**2 + self.height_step**2 / 12.0] if self._answered else variances)

    def truth(self, state: AircraftState) -> np.ndarray:
        """Noise-free channels, shape (m, ...)."""
        if self.position_sigma is not None:
            channels = [state.north, state.east]
        else:
            channels = list(polar(place(state), self.antenna, self.zero_azimuth)[:2])
        return np.stack([*channels, state.height] if self._answered else channels)

    def reported_height(self, height: Any, altimetry: Any = 0.0) -> Any:
        """Height above the threshold, m, that the ground makes of the answer at a true height and an altimetry error.

        An altimeter set to the QNH shows the elevation at the threshold, so the pressure altitude there is what the
        QNH takes off, with the elevation.
        """
        steps = np.round((self.air.pressure_altitude(height) + altimetry) / self.height_step)
        return steps * self.height_step - self.air.pressure_altitude(0.0)

    def begin(self, time: float, streams: Streams) -> Turning:
        """Ready for the first look, one period after ``time``."""
        altimetry = ALTIMETRY_SIGMA * streams.normal("altimetry", 1).row()[0] if self._answered else np.zeros(1)
        return Turning(time + self.period, streams.normal("noise", 2), altimetry)

    def step(self, state: Turning, before: AircraftState, after: AircraftState) -> tuple[Turning, list[Look]]:
        """Looks that fall between two records."""
        R = self.covariance()
        sigma = np.sqrt(np.diag(R))[:2, None]

        def scan(epoch: float) -> Look:
            now = state_at(before, after, epoch)
            z = self.truth(now)[:2, None] + sigma * state.noise.row()
            if self._answered:
                z = np.concatenate((z, self.reported_height(now.height, state.altimetry)[None]))
            return Look(epoch, epoch, z, R)

        return looks_until(state, self.period, after.time, scan)
