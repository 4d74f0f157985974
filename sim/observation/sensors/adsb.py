"""ADS-B as a receiver on the ground stores it: place, pressure altitude and velocity, each with its own age."""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from typing import Annotated, ClassVar, NamedTuple

import numpy as np

from aircraft.air import Air
from aircraft.ranges import ABOVE_ZERO, NOT_NEGATIVE, Range, check_ranges
from aircraft.state import AircraftState
from aircraft.units import SUFFIXES
from sim.flight.interpolation import state_at
from sim.observation.antenna import looks_until, no_outline
from sim.observation.sensor import PERIOD, Look
from sim.observation.sensors.surveillance_radar import ALTIMETRY_SIGMA, STEPS
from sim.randomness import Rows, Streams
from sim.scenario.tables import Runway

RATE_STEP = 64.0 * SUFFIXES["fpm"][1]  # m/s, in which the rate of climb is sent [ICAO Doc 9871, from memory]


class Receiver(NamedTuple):
    """What is kept from row to row; arrays (3, draws)."""

    epoch: float  # s, of the next row
    noise: Rows
    luck: Rows
    altimetry: np.ndarray  # (draws,) m, the constant error of each aircraft's altimetry
    silent: np.ndarray  # (draws,) bool: nothing is received
    place: np.ndarray | None = None  # of the last row, before the first one None
    velocity: np.ndarray | None = None


MISSED = Range(least=0.0, most=0.9, why="of what is left no track follows")


@dataclass(frozen=True)
class Adsb:
    """One row a second, as tables of recorded traffic have it.

    A position is true at another time than its stamp, by ``stamp_sigma``, and some rows repeat that of the row before.
    R counts both, by the mean square of the age: along the track over the ground they are an error of the speed times
    the age. Within the age of a stamp the motion is taken as straight, which in a turn is wrong by
    ``g tan(bank) age^2 / 2``, a tenth of a metre.
    The velocity comes with messages of its own, one every ``velocity_period`` on average; between them it is held. R
    knows nothing of its age: in a turn of 3 deg/s a course is behind by 4 deg on average. The altitude is that of the
    transponder: above 1013.25 hPa, in steps, with a constant error of its altimetry; no QNH is taken off.
    Gaps of the receiver last ``gap_length`` on average and take a share of all rows.
    """

    period: Annotated[float, "s", PERIOD] = 1.0
    stamp_sigma: Annotated[float, "s", NOT_NEGATIVE] = 0.2
    stale_share: Annotated[float, MISSED] = 0.03  # of rows whose position and altitude are those of the row before
    position_sigma: Annotated[float, "m", ABOVE_ZERO] = 2.0  # in each direction
    velocity_sigma: Annotated[float, "m/s", ABOVE_ZERO] = 0.3  # in each direction
    velocity_period: Annotated[float, "s"] = 2.5
    gap_share: Annotated[float, MISSED] = 0.02
    gap_length: Annotated[float, "s", ABOVE_ZERO] = 8.0
    altitude_step: Annotated[float, "m"] = STEPS[0]  # 25 ft, or 100
    runway: Annotated[Runway, "given"] = field(default_factory=Runway)
    air: Annotated[Air, "given"] = field(default_factory=Air)

    channels: ClassVar[tuple[str, ...]] = (
        *("north", "east", "pressure_altitude"),
        *("ground_speed", "course", "vertical_rate"),
    )
    gives_place: ClassVar[bool] = True
    clutter: ClassVar[float] = 0.0  # the aircraft says who it is
    antenna: ClassVar[None] = None  # the place is measured in the aircraft
    zero_azimuth: ClassVar[None] = None
    outline = no_outline

    def __post_init__(self) -> None:
        check_ranges(self)
        if not self.velocity_period >= self.period:
            raise ValueError("velocity_period must be at least the period of the rows")
        if not any(math.isclose(self.altitude_step, step) for step in STEPS):
            raise ValueError("altitude_step must be 25 ft or 100 ft")

    @property
    def mean_square_age(self) -> float:
        """Of a position at its stamp, s2: that of the stamp, and that of rows that repeat the one before.

        n rows in a row repeat with the probability (1 - s) s^n; the mean of n^2 is s (1 + s) / (1 - s)^2.
        """
        s = self.stale_share
        return self.stamp_sigma**2 + self.period**2 * s * (1.0 + s) / (1.0 - s) ** 2

    def truth(self, state: AircraftState) -> np.ndarray:
        """Channels without error, shape (6, ...)."""
        altitude = self.air.pressure_altitude(state.height)
        return np.stack([state.north, state.east, altitude, state.ground_speed, state.course, state.velocity_up])

    def begin(self, time: float, streams: Streams) -> Receiver:
        """Ready for the first row, one period after ``time``."""
        altimetry = ALTIMETRY_SIGMA * streams.normal("altimetry", 1).row()[0]
        silent = np.zeros(len(altimetry), bool)
        return Receiver(time + self.period, streams.normal("noise", 6), streams.uniform("luck", 3), altimetry, silent)

    def step(self, state: Receiver, before: AircraftState, after: AircraftState) -> tuple[Receiver, list[Look]]:
        """Rows between two records; NaN in the draws whose receiver has a gap."""
        kept = state

        def row(epoch: float) -> Look:
            nonlocal kept
            now = state_at(before, after, epoch)
            noise, luck = kept.noise.row(), kept.luck.row()  # row k belongs to epoch k
            place = self._position(now, noise, kept.altimetry)
            velocity = self._velocity(now, noise)
            if kept.place is not None and kept.velocity is not None:
                place = np.where(luck[0] < self.stale_share, kept.place, place)
                velocity = np.where(luck[1] < self.period / self.velocity_period, velocity, kept.velocity)
            silent = self._silent(kept.silent, luck[2])
            kept = kept._replace(place=place, velocity=velocity, silent=silent)
            z = np.where(silent, np.nan, np.concatenate((place, velocity)))
            return Look(epoch, epoch, z, self._covariance(velocity))

        after_it, looks = looks_until(state, self.period, after.time, row)
        return kept._replace(epoch=after_it.epoch), looks

    def _position(self, now: AircraftState, noise: np.ndarray, altimetry: np.ndarray) -> np.ndarray:
        """(3, draws) north, east and pressure altitude when they were measured."""
        age = self.stamp_sigma * noise[2]
        north = now.north + now.velocity_north * age + self.position_sigma * noise[0]
        east = now.east + now.velocity_east * age + self.position_sigma * noise[1]
        altitude = self.air.pressure_altitude(now.height + now.velocity_up * age) + altimetry
        return np.stack((north, east, np.round(altitude / self.altitude_step) * self.altitude_step))

    def _velocity(self, now: AircraftState, noise: np.ndarray) -> np.ndarray:
        """(3, draws) ground speed, course and rate of climb."""
        north, east, up = (
            speed + self.velocity_sigma * error
            for speed, error in zip((now.velocity_north, now.velocity_east, now.velocity_up), noise[3:], strict=True)
        )
        return np.stack((np.hypot(north, east), np.arctan2(east, north), np.round(up / RATE_STEP) * RATE_STEP))

    def _silent(self, silent: np.ndarray, luck: np.ndarray) -> np.ndarray:
        """(draws,) bool: whether the next row is in a gap, a Markov chain of the given share and mean length."""
        leave = min(1.0, self.period / self.gap_length)
        enter = min(1.0, leave * self.gap_share / (1.0 - self.gap_share))
        return np.asarray(np.where(silent, luck >= leave, luck < enter))

    def _covariance(self, velocity: np.ndarray) -> np.ndarray:
        """R (6, 6, draws), the age of a position turned along the velocity that is known (3, draws)."""
        speed, course, _ = velocity
        ages = self.mean_square_age * speed**2
        R = np.zeros((6, 6, len(speed)))
        along, across = np.cos(course), np.sin(course)
        R[0, 0] = self.position_sigma**2 + ages * along**2
        R[1, 1] = self.position_sigma**2 + ages * across**2
        R[0, 1] = R[1, 0] = ages * along * across
        R[2, 2] = ALTIMETRY_SIGMA**2 + self.altitude_step**2 / 12.0
        R[3, 3] = self.velocity_sigma**2
        R[4, 4] = (self.velocity_sigma / np.maximum(speed, 1.0)) ** 2
        R[5, 5] = self.velocity_sigma**2 + RATE_STEP**2 / 12.0
        return R
