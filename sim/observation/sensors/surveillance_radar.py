"""Terminal surveillance radar: slant range and azimuth once a turn, and the height where a transponder says it."""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from typing import Annotated, Any, ClassVar, Literal, NamedTuple

import numpy as np

from aircraft.air import Air
from aircraft.ranges import ABOVE_ZERO, NOT_NEGATIVE, SHARE, Range, check_ranges
from aircraft.state import AircraftState
from aircraft.units import SUFFIXES
from sim.flight.interpolation import state_at
from sim.observation.antenna import (
    antenna_of,
    beam_passes,
    looks_until,
    place,
    polar,
    quantised,
    sector,
    zero_azimuth_of,
)
from sim.observation.sensor import PERIOD, Look
from sim.randomness import Rows, Streams
from sim.scenario.tables import Runway

FOOT = SUFFIXES["ft"][1]  # m
STEPS = (25.0 * FOOT, 100.0 * FOOT)  # of a Mode S and of a Mode A/C transponder

# The height that is sent agrees with what the altimeter measures within 125 ft with a probability of 95 % [ICAO
# Annex 10 volume IV, 3.1.1.7.12.2, from memory]: two standard deviations. It is an error of the aircraft, not of the
# look.
ALTIMETRY_SIGMA = 125.0 * FOOT / 2.0


POLAR_ERRORS = ("range_bias", "azimuth_bias", "north_error", "range_step", "azimuth_step")


class Turning(NamedTuple):
    """What the radar carries from turn to turn."""

    epoch: float  # s, of the next look; of a beam that turns: before it there is none
    noise: Rows
    luck: Rows | None  # of detection; None = every plot is made
    altimetry: np.ndarray  # (draws,) m, the constant error of each aircraft's altimetry; zeros without Mode C
    begun: float  # s, when the beam pointed at zero azimuth


CONE = Range(least=0.0, below=math.pi / 2, why="beyond, it would see nothing above its horizon")


@dataclass(frozen=True)
class SurveillanceRadar:
    """Slant range and azimuth, or position with the same accuracy along both axes where the papers assume that.

    With ``height = "mode_c"`` the transponder's answer gives a height too: pressure altitude, with a constant error of
    its altimetry, in steps. The ground takes off the pressure altitude of the threshold, which follows from the QNH.
    On a cold day the aircraft is then lower than its answer says, and on a hot day higher, by 4 % of the height for
    10 K: that error is real and stays, and R, which counts the altimetry and the steps, knows nothing of it.

    It can err as radars do and does not say: ``range_bias`` and ``azimuth_bias`` are added to what it measures; a zero
    mark that stands ``north_error`` to the right of where it should makes every azimuth so much smaller. R counts none
    of the three. ``range_step`` and ``azimuth_step`` are those of its counters, which R counts. With ``rotating`` a
    look is made when the beam, which turns clockwise once a period and begins at its zero, passes the aircraft; else
    at multiples of the period. What lies beyond ``coverage``, or within ``cone_of_silence`` of the vertical above the
    antenna, is not seen; ``latency`` later than it was true a plot is known.
    """

    period: Annotated[float, "s", PERIOD] = 4.0
    range_sigma: Annotated[float, "m", ABOVE_ZERO] = 60.0
    azimuth_sigma: Annotated[float, "rad", ABOVE_ZERO] = math.radians(0.15)
    position_sigma: Annotated[float | None, "m", ABOVE_ZERO] = None
    position: Annotated[tuple[float, float, float], "m"] = (0.0, 2000.0, 10.0)  # past threshold, right, up
    course: Annotated[float, "rad"] = 0.0  # of zero azimuth, relative to the runway
    height: Literal["none", "mode_c"] = "none"  # what of the height is measured
    height_step: Annotated[float, "m"] = STEPS[0]  # 25 ft, which the Mode S transponders of transports answer, or 100
    detection: Annotated[float, SHARE] = 1.0  # probability that a plot is made
    range_bias: Annotated[float, "m"] = 0.0
    azimuth_bias: Annotated[float, "rad"] = 0.0  # + measures too far to the right
    north_error: Annotated[float, "rad"] = 0.0  # of its zero mark, + to the right
    range_step: Annotated[float, "m", NOT_NEGATIVE] = 0.0  # 0 = none
    azimuth_step: Annotated[float, "rad", NOT_NEGATIVE] = 0.0  # of 4096 azimuth counts: 0.088 deg
    rotating: bool = False  # the beam meets the aircraft where it is, not at multiples of the period
    coverage: Annotated[float | None, "m", ABOVE_ZERO] = None  # slant; absent = as far as there is something to see
    cone_of_silence: Annotated[float, "rad", CONE] = 0.0  # half angle about the vertical
    latency: Annotated[float, "s", NOT_NEGATIVE] = 0.0
    runway: Annotated[Runway, "given"] = field(default_factory=Runway)
    air: Annotated[Air, "given"] = field(default_factory=Air)

    gives_place: ClassVar[bool] = True  # one scan is a place
    clutter: ClassVar[float] = 0.0  # it knows its target
    antenna = property(antenna_of)
    zero_azimuth = property(zero_azimuth_of)

    def __post_init__(self) -> None:
        check_ranges(self)
        polar_errors = [name for name in POLAR_ERRORS if getattr(self, name) != 0.0]
        if self.position_sigma is not None and polar_errors:
            raise ValueError(
                f"{polar_errors[0]} is an error of range or azimuth, and position_sigma gives neither: "
                f"take position_sigma out"
            )
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
            steps = (self.range_step**2 / 12.0, self.azimuth_step**2 / 12.0)
            variances = [self.range_sigma**2 + steps[0], self.azimuth_sigma**2 + steps[1]]
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

    def outline(self) -> tuple[tuple[float, float], ...]:
        """A circle of the coverage, if it has any."""
        if self.coverage is None:
            return ()
        return sector(self.antenna, self.zero_azimuth, 2.0 * math.pi, self.coverage)

    def begin(self, time: float, streams: Streams) -> Turning:
        """Ready for the first look, one period after ``time``, or the first pass of the beam."""
        altimetry = ALTIMETRY_SIGMA * streams.normal("altimetry", 1).row()[0] if self._answered else np.zeros(1)
        luck = streams.uniform("detection", 1) if self.detection < 1.0 else None
        first = time if self.rotating else time + self.period
        return Turning(first, streams.normal("noise", 2), luck, altimetry, time)

    def step(self, state: Turning, before: AircraftState, after: AircraftState) -> tuple[Turning, list[Look]]:
        """Looks that fall between two records; row k of the streams belongs to look k, seen or not."""
        R = self.covariance()

        def scan(epoch: float) -> Look | None:
            now = state_at(before, after, epoch)
            noise, luck = state.noise.row(), None if state.luck is None else state.luck.row()[0]
            if not self._sees(now):
                return None
            z = self._measured(self.truth(now)[:2, None], noise)
            if self._answered:
                z = np.concatenate((z, self.reported_height(now.height, state.altimetry)[None]))
            if luck is not None:
                z = np.where(luck < self.detection, z, np.nan)
            return Look(epoch, epoch + self.latency, z, R)

        if not self.rotating:
            return looks_until(state, self.period, after.time, scan)
        epochs, epoch = beam_passes(self, state.begun, state.epoch, before, after)
        looks = [look for look in map(scan, epochs) if look is not None]
        return state._replace(epoch=epoch), looks

    def _sees(self, state: AircraftState) -> bool:
        slant, _, elevation = polar(place(state), self.antenna, self.zero_azimuth)
        near = self.coverage is None or slant <= self.coverage
        return bool(near and elevation <= math.pi / 2 - self.cone_of_silence)

    def _measured(self, exact: np.ndarray, noise: np.ndarray) -> np.ndarray:
        """Place channels of a look, (2, draws), from the exact ones (2, 1) and standard normal noise (2, draws)."""
        if self.position_sigma is not None:
            return np.asarray(exact + self.position_sigma * noise)
        bias = np.array([[self.range_bias], [self.azimuth_bias - self.north_error]])
        z = exact + bias + np.array([[self.range_sigma], [self.azimuth_sigma]]) * noise
        return np.stack((quantised(z[0], self.range_step), quantised(z[1], self.azimuth_step)))
