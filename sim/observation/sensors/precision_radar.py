"""Precision approach radar: slant range, azimuth and elevation inside its sector, with missed plots and false ones."""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from typing import Annotated, Any, ClassVar, Literal, NamedTuple

import numpy as np
from scipy.special import pdtr, pdtrik

from aircraft.ranges import ABOVE_ZERO, NOT_NEGATIVE, SHARE, Range, check_ranges
from aircraft.state import AircraftState
from sim.flight.interpolation import state_at
from sim.observation.antenna import (
    antenna_of,
    looks_until,
    place,
    polar,
    sector,
    zero_azimuth_of,
)
from sim.observation.sensor import PERIOD, Look
from sim.randomness import Rows, Streams
from sim.scenario.tables import Runway

# Largest errors of Annex 10 volume I, 3.2.3.3 (edition and paragraph as quoted in secondary sources; the range figure
# is from memory). They are read as two standard deviations, because a limit that may not be exceeded is met by 95 %.
ANNEX_10_SIGMAS = 2.0

# False plots are made within so many standard deviations of the aircraft. A gate of 0.9997 is 4 standard deviations of
# the innovation wide, so farther ones would meet no gate of a tracker that is still on the aircraft.
REACH = 6.0
STATED = 3.0  # standard deviations of the ellipse in which ``clutter`` counts
MOST_CLUTTER = 10.0  # beyond, a look is nothing but false plots, and their record grows without use
RARE = 1e-9  # probability of more false plots in a look than are made


class Scan(NamedTuple):
    """What the radar carries from step to step."""

    epoch: float
    noise: Rows
    detection: Rows
    clutter: Rows | None  # of the count, then of range, azimuth and elevation of each false plot


@dataclass(frozen=True)
class PrecisionRadar:
    """Plots of a precision approach radar that looks up the approach.

    With ``accuracy = "annex_10"`` the errors grow with distance: azimuth 0.6 % of it and 10 % of the deviation but 9 m
    at least, elevation 0.4 % and 10 % but 6 m, range 30 m and 3 % of the distance to touchdown, each read as two
    standard deviations. With ``"constant"`` they are the given ones [Volovyk 2022, experiment].

    With ``clutter`` a look also holds false plots, Poisson in number and uniform about the aircraft: so many on average
    inside 3 standard deviations of range and azimuth. The sensor does not say which plot is the target's.

    Biases are added to all that it measures of the target, and neither R nor the sector knows of them; ``latency``
    later than it was true a plot is known.
    """

    period: Annotated[float, "s", PERIOD] = 0.7
    accuracy: Literal["annex_10", "constant"] = "annex_10"
    range_sigma: Annotated[float, "m", ABOVE_ZERO] = 30.0
    azimuth_sigma: Annotated[float, "rad", ABOVE_ZERO] = math.radians(1.0)
    elevation_sigma: Annotated[float, "rad", ABOVE_ZERO] = math.radians(0.5)
    position: Annotated[tuple[float, float, float], "m"] = (1200.0, 150.0, 3.0)
    course: Annotated[float, "rad"] = math.pi  # of the antenna's axis relative to the runway
    sector: Annotated[float, "rad", ABOVE_ZERO] = math.radians(
        20.0
    )  # full width about the axis; 360 deg sees all round
    coverage: Annotated[float, "m", ABOVE_ZERO] = 20_000.0
    detection: Annotated[float, SHARE] = 1.0  # probability that a plot is made
    # mean number of false plots inside 3 standard deviations of range and azimuth
    clutter: Annotated[float, Range(least=0.0, most=MOST_CLUTTER)] = 0.0
    range_bias: Annotated[float, "m"] = 0.0
    azimuth_bias: Annotated[float, "rad"] = 0.0  # + measures too far to the right
    elevation_bias: Annotated[float, "rad"] = 0.0  # + measures too high
    latency: Annotated[float, "s", NOT_NEGATIVE] = 0.0
    runway: Annotated[Runway, "given"] = field(default_factory=Runway)

    channels: ClassVar[tuple[str, ...]] = ("range", "azimuth", "elevation")
    gives_place: ClassVar[bool] = True  # one plot is a place
    antenna = property(antenna_of)
    zero_azimuth = property(zero_azimuth_of)

    def __post_init__(self) -> None:
        check_ranges(self)

    def sigmas(self, slant: Any, azimuth: Any, elevation: Any) -> np.ndarray:
        """Standard deviations (range m, azimuth rad, elevation rad) at a place, shape (3, ...)."""
        slant = np.maximum(slant, 1.0)
        if self.accuracy == "constant":
            constant = (self.range_sigma, self.azimuth_sigma, self.elevation_sigma)
            return np.stack([np.full(np.shape(slant), sigma) for sigma in constant])
        across = np.maximum(0.006 * slant + 0.1 * slant * np.abs(np.sin(azimuth)), 9.0)
        above = slant * np.abs(np.sin(elevation - self.runway.glide_path))
        height = np.maximum(0.004 * slant + 0.1 * above, 6.0)
        touchdown = np.maximum(slant - abs(self.position[0] - self.runway.aiming_point), 0.0)
        return np.stack((30.0 + 0.03 * touchdown, across / slant, height / slant)) / ANNEX_10_SIGMAS

    def outline(self) -> tuple[tuple[float, float], ...]:
        """The sector."""
        return sector(self.antenna, self.zero_azimuth, self.sector, self.coverage)

    def truth(self, state: AircraftState) -> np.ndarray:
        """Noise-free channels, shape (3, ...)."""
        return np.stack(polar(place(state), self.antenna, self.zero_azimuth))

    def clutter_density(self, slant: Any, azimuth: Any, elevation: Any) -> Any:
        """False plots per m2 of the ground plane at a place."""
        range_sigma, azimuth_sigma, _ = self.sigmas(slant, azimuth, elevation)
        # the ground plane shortens a slant range by the cosine of the elevation, and so the arc of an azimuth
        area = math.pi * STATED**2 * range_sigma * azimuth_sigma * slant * np.cos(elevation) ** 2
        return self.clutter / area

    @property
    def _mean_count(self) -> float:
        """Mean number of false plots of a look: those of the ellipse, by the area of the square about it."""
        return self.clutter * (2.0 * REACH) ** 2 / (math.pi * STATED**2)

    def begin(self, time: float, streams: Streams) -> Scan:
        """Ready for the first look, one period after ``time``."""
        clutter = None
        if self.clutter > 0.0:
            most = math.ceil(pdtrik(1.0 - RARE, self._mean_count))
            clutter = streams.uniform("clutter", 1 + 3 * most)
        return Scan(time + self.period, streams.normal("noise", 3), streams.uniform("detection", 1), clutter)

    def step(self, state: Scan, before: AircraftState, after: AircraftState) -> tuple[Scan, list[Look]]:
        """Looks between two records; none outside the sector.

        With clutter the candidates are (c, 3, draws), NaN = none. They share R, the accuracy at the target's own plot.
        """

        bias = np.array([[self.range_bias], [self.azimuth_bias], [self.elevation_bias]])

        def look(epoch: float) -> Look | None:
            noise, luck = state.noise.row(), state.detection.row()[0]  # row k belongs to epoch k, seen or not
            false = None if state.clutter is None else state.clutter.row()
            exact = self.truth(state_at(before, after, epoch))
            if abs(exact[1]) > self.sector / 2 or exact[0] > self.coverage:
                return None
            z = exact[:, None] + bias + self.sigmas(*exact)[:, None] * noise
            # the accuracy that the radar states is that at the place that it measured
            R = np.einsum("ij,in->ijn", np.eye(3), self.sigmas(*z) ** 2)
            z = np.where(luck < self.detection, z, np.nan)
            plots = None if false is None else np.concatenate((z[None], self._false_plots(exact, false)))
            return Look(epoch, epoch + self.latency, z, R, plots)

        return looks_until(state, self.period, after.time, look)

    def _false_plots(self, exact: np.ndarray, uniform: np.ndarray) -> np.ndarray:
        """False plots (c, 3, draws) about a place (3,) from uniform numbers (1 + 3 c, draws); NaN beyond their count.

        The count is the quantile of the Poisson law, cut at c, which is exceeded once in 1e9 looks. Plots behind the
        antenna are dropped.
        """
        most = len(uniform) // 3
        count = np.searchsorted(pdtr(np.arange(most), self._mean_count), uniform[0])
        offset = REACH * (2.0 * uniform[1:].reshape(most, 3, -1) - 1.0)
        plots = exact[:, None] + self.sigmas(*exact)[:, None] * offset
        made = (np.arange(most)[:, None] < count) & (plots[:, 0] > 0.0)
        return np.where(made[:, None], plots, np.nan)
