"""Downlink of load factors, bank and path angles from the aircraft: the overload vector and the way it points."""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from typing import Annotated, ClassVar, Literal

import numpy as np

from aircraft.ranges import ABOVE_ZERO, NOT_NEGATIVE, check_ranges
from aircraft.state import AircraftState
from sim.observation.antenna import Sampling, looks_until, no_outline
from sim.observation.sensor import PERIOD, Look
from sim.randomness import Streams
from sim.scenario.tables import Runway
from tracking.measurement import wrap

CHANNELS = (
    "load_factor_forward",
    "load_factor_right",
    "load_factor_up",
    "aerodynamic_bank",
    "flight_path_angle",
    "air_course",
)


@dataclass(frozen=True)
class Downlink:
    """Six measured quantities with noise, bias, latency and, in a window of time, silence [Glistin, specification].

    ``path = "air"`` sends the angles of the velocity through the air, about which load factors are measured;
    ``"ground"`` sends those of the ground track, the error that wind then brings.
    """

    period: Annotated[float, "s", PERIOD] = 0.25
    latency: Annotated[float, "s", NOT_NEGATIVE] = 0.0
    load_factor_sigma: Annotated[float, ABOVE_ZERO] = 0.01
    bank_sigma: Annotated[float, "rad", ABOVE_ZERO] = math.radians(0.5)
    path_sigma: Annotated[float, "rad", ABOVE_ZERO] = math.radians(0.3)
    course_sigma: Annotated[float, "rad", ABOVE_ZERO] = math.radians(0.5)
    load_factor_bias: tuple[float, float, float] = (0.0, 0.0, 0.0)  # forward, right, up
    bank_bias: Annotated[float, "rad"] = 0.0
    course_bias: Annotated[float, "rad"] = 0.0
    silent_from: Annotated[float, "s"] = 1e9
    silent_until: Annotated[float, "s"] = 1e9
    path: Literal["air", "ground"] = "air"
    runway: Annotated[Runway, "given"] = field(default_factory=Runway)

    gives_place: ClassVar[bool] = False  # it does not say where the aircraft is on the ground plane
    clutter: ClassVar[float] = 0.0  # it knows its target
    antenna: ClassVar[None] = None  # it is in the aircraft
    zero_azimuth: ClassVar[None] = None  # it measures none
    outline = no_outline  # it has no limits on the ground

    def __post_init__(self) -> None:
        check_ranges(self)
        if self.silent_until < self.silent_from:
            raise ValueError("silent_until must not lie before silent_from")

    @property
    def channels(self) -> tuple[str, ...]:
        """What is measured, in the order of z."""
        return CHANNELS

    def sigmas(self) -> np.ndarray:
        """Standard deviations of the channels, shape (6,)."""
        return np.array((*(3 * (self.load_factor_sigma,)), self.bank_sigma, self.path_sigma, self.course_sigma))

    def biases(self) -> np.ndarray:
        """Constant errors of the channels, shape (6,)."""
        return np.array((*self.load_factor_bias, self.bank_bias, 0.0, self.course_bias))

    def truth(self, state: AircraftState) -> np.ndarray:
        """Noise-free channels, shape (6, ...)."""
        if self.path == "air":
            angle, course = state.flight_path_angle, state.air_course
        else:
            angle, course = np.arctan2(state.velocity_up, state.ground_speed), state.course
        return np.stack([*state.load_factor, state.aerodynamic_bank, angle, course])

    def begin(self, time: float, streams: Streams) -> Sampling:
        """Ready for the first message, one period after ``time``."""
        return Sampling(time + self.period, streams.normal("noise", 6))

    def step(self, state: Sampling, before: AircraftState, after: AircraftState) -> tuple[Sampling, list[Look]]:
        """Messages between two records, none while it is silent; the channels themselves are linear in between."""

        def message(epoch: float) -> Look | None:
            noise = state.noise.row()  # row k belongs to epoch k, sent or not
            if self.silent_from <= epoch < self.silent_until:
                return None
            share = (epoch - before.time) / (after.time - before.time)
            first, second = self.truth(before), self.truth(after)
            change = second - first
            change[3:] = wrap(change[3:])
            exact = first + share * change + self.biases()
            z = exact[:, None] + self.sigmas()[:, None] * noise
            return Look(epoch, epoch + self.latency, z, np.diag(self.sigmas() ** 2))

        return looks_until(state, self.period, after.time, message)
