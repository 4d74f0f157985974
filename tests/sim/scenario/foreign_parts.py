"""Parts as somebody else writes them: one sensor, one tracker, one mode, one wind event, in one file with one table."""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from functools import cached_property
from typing import Annotated, Any, ClassVar, NamedTuple

import numpy as np

from sim.flight.interpolation import state_at
from sim.observation.sensor import Look
from sim.scenario.tables import Runway
from tracking.measurement import MeasurementModel
from tracking.motion import ConstantVelocity
from tracking.trackers.kalman import Kalman


class Ping(NamedTuple):
    """What a beacon carries from step to step."""

    epoch: float
    noise: Any


@dataclass(frozen=True)
class Beacon:
    """Says where it is, with noise."""

    period: Annotated[float, "s"] = 1.0
    sigma: Annotated[float, "m"] = 20.0
    runway: Annotated[Runway, "given"] = field(default_factory=Runway)

    channels: ClassVar[tuple[str, ...]] = ("north", "east")
    gives_place: ClassVar[bool] = True
    clutter: ClassVar[float] = 0.0
    antenna: ClassVar[None] = None  # it stands nowhere
    zero_azimuth: ClassVar[None] = None

    def __post_init__(self) -> None:
        if not self.sigma > 0.0:
            raise ValueError("sigma must be above 0")

    def truth(self, state: Any) -> np.ndarray:
        """(north, east), m."""
        return np.stack((state.north, state.east))

    def outline(self) -> tuple[Any, ...]:
        """Nothing that could be drawn."""
        return ()

    def begin(self, time: float, streams: Any) -> Ping:
        """Ready for the first ping."""
        return Ping(time + self.period, streams.normal("noise", 2))

    def step(self, ping: Ping, before: Any, after: Any) -> tuple[Ping, list[Any]]:
        """Pings between two records."""
        looks, epoch = [], ping.epoch
        while epoch <= after.time:
            z = self.truth(state_at(before, after, epoch))[:, None] + self.sigma * ping.noise.row()
            looks.append(Look(epoch, epoch, z, self.sigma**2 * np.eye(2)))
            epoch += self.period
        return ping._replace(epoch=epoch), looks


@dataclass(frozen=True)
class Calm:
    """A Kalman filter that takes the aircraft for a calm one."""

    measurement: Annotated[MeasurementModel, "given"]
    acceleration_density: Annotated[float, "m2/s3"] = 1.0

    @cached_property
    def inner(self) -> Kalman:
        """The filter."""
        return Kalman(self.measurement, ConstantVelocity(self.acceleration_density))

    @property
    def channels(self) -> tuple[str, ...]:
        """As the filter's."""
        return self.inner.channels

    def begin(self, prior: Any) -> Any:
        """As the filter."""
        return self.inner.begin(prior)

    def step(self, state: Any, dt: float, z: Any, R: Any) -> Any:
        """As the filter."""
        return self.inner.step(state, dt, z, R)

    def estimate(self, state: Any) -> Any:
        """As the filter."""
        return self.inner.estimate(state)


@dataclass(frozen=True)
class Thermal:
    """Air that rises everywhere, as a sine for a while."""

    up: Annotated[float, "m/s"] = 2.0
    at: Annotated[float, "s"] = 1.0
    lasts: Annotated[float, "s"] = 4.0

    def velocity(self, time: float, position: Any, airspeed: float) -> tuple[float, float, float]:
        """(north, east, up), m/s."""
        share = (time - self.at) / self.lasts
        return 0.0, 0.0, self.up * math.sin(math.pi * share) if 0.0 < share < 1.0 else 0.0

    def words(self) -> str:
        """What it is."""
        return f"thermal of {self.up:.1f} m/s, from {self.at:.0f} s for {self.lasts:.0f} s"

    def outline(self) -> tuple[Any, ...]:
        """It is everywhere."""
        return ()

    def standing(self) -> None:
        """It passes."""
        return


@dataclass(frozen=True)
class TrackHold:
    """A law that only holds the course of the leg."""

    bank_limit: Annotated[Any, "rad"]
    gain: float = 1.0  # rad of bank per rad off the course

    intent: ClassVar[str] = "course law"
    standard: ClassVar[bool] = False
    intercept: ClassVar[tuple[str, ...]] = ()

    @classmethod
    def designed(cls, given: dict[str, Any], case: Any) -> TrackHold:
        """As the file says, within the limit of the bank."""
        return cls(**{"bank_limit": case.bank_limit, **given})

    def __call__(self, deviation: Any) -> Any:
        """Bank command, rad."""
        return np.clip(-self.gain * deviation.track_error, -self.bank_limit, self.bank_limit)

    def limits(self) -> tuple[Any, ...]:
        """Nothing that could be drawn."""
        return ()

    def explain(self) -> str:
        """What it does."""
        return f"bank = c{{-{self.gain:g} dpsi}}, bank limit {math.degrees(self.bank_limit):.1f} deg"

    def check_convergence(self, ground_speed: float, offset: float = math.inf, turns: bool = False) -> None:
        """It does not ask where it is."""


SHORTFINAL = {
    "sensors": {"beacon": Beacon},
    "trackers": {"calm": Calm},
    "modes": {"track_hold": TrackHold},
    "wind_events": {"thermal": Thermal},
}
