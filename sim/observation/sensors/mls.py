"""Microwave landing system: one angle at 40.5 Hz, with an accuracy that changes without notice."""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from typing import Annotated, ClassVar, Literal, NamedTuple

import numpy as np

from aircraft.ranges import ABOVE_ZERO, SHARE, check_ranges
from aircraft.state import AircraftState
from sim.flight.interpolation import state_at
from sim.observation.antenna import (
    FAR,
    antenna_of,
    place,
    polar,
    sector,
    zero_azimuth_of,
)
from sim.observation.sensor import PERIOD, Look
from sim.randomness import Rows, Streams
from sim.scenario.tables import Runway
from tracking.trackers.switching_noise import BeamNoise


class Receiver(NamedTuple):
    """What is carried from step to step."""

    epoch: float
    noise: Rows
    luck: Rows
    anomalous: np.ndarray  # (draws,) bool: the accuracy of the epoch before
    sign: np.ndarray  # (draws,) of the bias of the running burst


@dataclass(frozen=True)
class Mls:
    """Azimuth or elevation with anomalous samples [Volovyk 2018, eq. (4)], [Kychak 2011, eq. (5)].

    ``anomalies``: ``iid`` samples have ``factor`` times the nominal sigma with probability ``anomaly_share``;
    ``bursts`` are the same in runs of ``burst_length`` on average (a Markov chain with that share); ``bias_bursts`` add
    a constant ``bias`` of either sign during a run, as multipath does; ``dropouts`` have no measurement during a run.
    The stated R is always the nominal one: the receiver does not detect the anomaly.
    """

    angle: Literal["elevation", "azimuth"] = "elevation"
    period: Annotated[float, "s", PERIOD] = 1 / 40.5
    sigma: Annotated[float, "rad", ABOVE_ZERO] = math.radians(0.06)
    anomalies: Literal["none", "iid", "bursts", "bias_bursts", "dropouts"] = "none"
    anomaly_share: Annotated[float, SHARE] = 0.2
    factor: Annotated[float, ABOVE_ZERO] = 30.0
    burst_length: float = 40.0  # samples
    bias: Annotated[float, "rad"] = math.radians(0.3)
    position: Annotated[tuple[float, float, float], "m"] = (300.0, 120.0, 0.0)
    course: Annotated[float, "rad"] = math.pi
    sector: Annotated[float, "rad", ABOVE_ZERO] = math.radians(80.0)  # full width about the course
    beam: BeamNoise | None = None  # live accuracy by the signal-to-noise ratio, which a receiver knows; replaces sigma
    runway: Annotated[Runway, "given"] = field(default_factory=Runway)

    gives_place: ClassVar[bool] = False  # it does not say where the aircraft is on the ground plane
    clutter: ClassVar[float] = 0.0  # it knows its target
    antenna = property(antenna_of)
    zero_azimuth = property(zero_azimuth_of)

    def __post_init__(self) -> None:
        check_ranges(self)
        least = self.anomaly_share / (1 - self.anomaly_share) if self.anomaly_share < 1 else math.inf
        if self.anomalies not in ("none", "iid") and not self.burst_length >= max(1.0, least):
            raise ValueError(
                f"burst_length must be at least {max(1.0, least):.3g} samples to have a share of {self.anomaly_share:g}"
            )

    @property
    def channels(self) -> tuple[str, ...]:
        """What is measured."""
        return (self.angle,)

    def outline(self) -> tuple[tuple[float, float], ...]:
        """The sector, drawn to 20 NM: it is not cut off by distance."""
        return sector(self.antenna, self.zero_azimuth, self.sector, FAR)

    def truth(self, state: AircraftState) -> np.ndarray:
        """Noise-free angle, shape (1, ...)."""
        _, azimuth, elevation = polar(place(state), self.antenna, self.zero_azimuth)
        return np.stack((azimuth if self.angle == "azimuth" else elevation,))

    def begin(self, time: float, streams: Streams) -> Receiver:
        """Ready for the first sample, one period after ``time``; the chain starts in its stationary state."""
        luck = streams.uniform("anomaly", 2)
        first = luck.row()
        return Receiver(
            time + self.period,
            streams.normal("noise", 1),
            luck,
            first[0] < self.anomaly_share,
            np.where(first[1] < 0.5, -1.0, 1.0),
        )

    def step(self, state: Receiver, before: AircraftState, after: AircraftState) -> tuple[Receiver, list[Look]]:
        """Samples between two records; none outside the sector."""
        looks = []
        epoch, anomalous, sign = state.epoch, state.anomalous, state.sign
        while epoch <= after.time:
            noise, luck = state.noise.row(), state.luck.row()
            was = anomalous
            anomalous = self._chain(anomalous, luck[0])
            sign = np.where(anomalous & ~was, np.where(luck[1] < 0.5, -1.0, 1.0), sign)
            now = state_at(before, after, epoch)
            distance, azimuth, _ = polar(place(now), self.antenna, self.zero_azimuth)
            if abs(azimuth) <= self.sector / 2:
                variance = self.sigma**2 if self.beam is None else float(self.beam.variance(distance))
                z = self._measured(self.truth(now)[:, None], math.sqrt(variance) * noise, anomalous, sign)
                looks.append(Look(epoch, epoch, z, np.array([[variance]])))
            epoch += self.period
        return state._replace(epoch=epoch, anomalous=anomalous, sign=sign), looks

    def _chain(self, anomalous: np.ndarray, luck: np.ndarray) -> np.ndarray:
        """The accuracy of the next epoch."""
        if self.anomalies == "none":
            return np.zeros_like(anomalous)
        if self.anomalies == "iid":
            return np.asarray(luck < self.anomaly_share)
        leave = 1.0 / self.burst_length
        enter = leave * self.anomaly_share / (1.0 - self.anomaly_share)
        return np.asarray(np.where(anomalous, luck >= leave, luck < enter))

    def _measured(self, exact: np.ndarray, noise: np.ndarray, anomalous: np.ndarray, sign: np.ndarray) -> np.ndarray:
        nominal = exact + noise
        if self.anomalies == "dropouts":
            return np.where(anomalous, np.nan, nominal)
        if self.anomalies == "bias_bursts":
            return np.asarray(nominal + np.where(anomalous, sign * self.bias, 0.0))
        return np.asarray(exact + np.where(anomalous, self.factor, 1.0) * noise)
