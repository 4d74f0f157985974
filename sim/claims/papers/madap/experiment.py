"""The MADAP benchmark: sixteen flights side by side, seen by one radar or by several.

Its aircraft are of any kind and bank by up to 60 deg, so the models of `imm` are straight flight and turns to both
sides at banks that cover this, none of them flown. With the two turns of a landing pattern, at 15 deg, the speed with
several radars is wrong by 9.9 kt and not by 3.7; position and heading hardly change a verdict. Densities are the
defaults of the kind. Beside the trackers stands one that no radar can have, `ToldTurn`: what its errors leave is what
radars and sites do.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import lru_cache
from typing import Any, NamedTuple

import numpy as np

from autopilot.route import Leg, Route
from sim.flight.truths.madap import BANKS, KNOT, NAUTICAL_MILE, SPEEDS, Madap
from sim.flight.truths.route_capture import NOMINAL
from sim.randomness import stream
from tracking.gaussian import Gaussian, Innovation, Mixture, lift, merge, predict, update
from tracking.intervals import Interval, mean_interval, rmse
from tracking.measurement import LinearMeasurement
from tracking.motion import CARTESIAN, ConstantVelocity, ScheduledTurn, coordinated_turn
from tracking.track import Measurements, follow
from tracking.trackers.imm import MANOEUVRE_DENSITY, STRAIGHT_DENSITY, InteractingMultipleModel, ModelSet
from tracking.trackers.intent_imm import IntentImm
from tracking.trackers.kalman import Kalman


class Radar(NamedTuple):
    """A surveillance radar; the guidelines publish ranges of accuracy and period, no sites: these are ours."""

    north: float  # m
    east: float  # m
    period: float  # s
    first: float  # s
    range_sigma: float  # m
    azimuth_sigma: float  # rad


def _radar(north: float, east: float, period: float, first: float, sigma: float, angle: float) -> Radar:
    return Radar(north, east, period, first, sigma, math.radians(angle))


SINGLE = (_radar(0.0, 0.0, 6.0, 1.0, 60.0, 0.15),)
SEVERAL = (
    *SINGLE,
    _radar(60e3, -30e3, 8.0, 2.5, 44.0, 0.11),
    _radar(-40e3, 60e3, 10.0, 4.0, 70.0, 0.13),
    _radar(70e3, 70e3, 12.0, 5.5, 77.0, 0.18),
)
PLANE = LinearMeasurement(((1.0, 0.0, 0.0, 0.0), (0.0, 0.0, 1.0, 0.0)))
FIRST = Madap()
TOLD = Route(
    (
        Leg(
            (FIRST.north, FIRST.east),
            (
                FIRST.north + FIRST.straight * math.cos(FIRST.course),
                FIRST.east + FIRST.straight * math.sin(FIRST.course),
            ),
            FIRST.speed,
            FIRST.height,
        ),
    )
)  # the first straight of all sixteen
TURNS = tuple(math.radians(bank) for bank in (10.0, 25.0, 40.0, 55.0))  # of the models, to either side
STRAIGHT_STAY, TURN_STAY = 140.0, 58.0  # s, as in the set of a landing pattern


def turning_set(banks: tuple[float, ...] = TURNS) -> ModelSet:
    """Straight flight, and turns to either side at each of some banks; every model is left for any other alike."""
    models = [ScheduledTurn(side * bank, MANOEUVRE_DENSITY) for bank in banks for side in (1.0, -1.0)]
    count = len(models)
    leave = [1.0 / STRAIGHT_STAY, *[1.0 / TURN_STAY] * count]
    switching = tuple(
        tuple(1.0 - share if i == j else share / count for j in range(count + 1)) for i, share in enumerate(leave)
    )
    probabilities = (0.7, *[0.3 / count] * count)
    return ModelSet((ConstantVelocity(STRAIGHT_DENSITY), *models), switching, probabilities, period=1.0)


@dataclass(frozen=True)
class ToldTurn:
    """A filter that is told at what rate the aircraft has turned since the last look; it has but to weigh the plots.

    Its state is the estimate and the number of the next look.
    """

    rates: Any  # (looks, runs) rad/s
    acceleration_density: float = 0.01  # m2/s3
    channels = CARTESIAN

    def begin(self, prior: Gaussian) -> tuple[Gaussian, int]:
        return Gaussian(prior.mean, lift(prior.cov, 2, prior.mean.ndim - 1)), 0

    def step(
        self, state: tuple[Gaussian, int], dt: float, z: Any | None, R: Any | None
    ) -> tuple[tuple[Gaussian, int], Innovation | None]:
        estimate, look = state
        density = self.acceleration_density
        estimate = predict(estimate, *coordinated_turn(dt, self.rates[look], density, density))
        if z is None:
            return (estimate, look), None
        estimate, innovation = update(estimate, *PLANE.linearise(z, R, estimate.mean))
        return (estimate, look + 1), innovation

    def estimate(self, state: tuple[Gaussian, int]) -> Gaussian:
        return state[0]


TOLD_TURN = "told_turn"
TRACKERS: dict[str, Any] = {
    "imm": InteractingMultipleModel(PLANE, turning_set()),
    "constant_velocity": Kalman(PLANE, ConstantVelocity(10.0)),
    "intent_imm": IntentImm(NOMINAL, TOLD, PLANE, law_density=0.1, straight_density=0.05, manoeuvre_density=3.0),
}
NAMES = (*TRACKERS, TOLD_TURN)
STEP = 0.5  # s, of the truth's record; every scan is a multiple
MOST = 100  # runs of the sixteen flights: each is some five hundred scans of each of them
SETTLED = 60.0  # s, of the track's initiation
PRIOR = np.array([300.0, 20.0, 300.0, 20.0])  # m, m/s


class Flown(NamedTuple):
    """All flights at the steps of one record, (k, 16); they fly on straight until the longest has ended."""

    time: Any  # (k,)
    north: Any
    east: Any
    velocity_north: Any
    velocity_east: Any
    judged: Any  # bool: initiated, and not behind the flight's own end
    turning: Any  # bool


@lru_cache(maxsize=1)
def flights() -> Flown:
    """The sixteen, side by side."""
    kinds = [Madap(speed, bank) for speed in SPEEDS for bank in BANKS]
    ends = [flight.fly(step=STEP).time[-1] for flight in kinds]
    last = max(ends)
    parts = []
    for speed, bank, end in zip(np.repeat(SPEEDS, len(BANKS)), np.tile(BANKS, len(SPEEDS)), ends, strict=True):
        flight = Madap(float(speed), float(bank), after=FIRST.after + last - end + 2.0 * STEP).fly(step=STEP)
        s, rows = flight.state, slice(0, math.floor(last / STEP) + 1)
        judged = (s.time >= SETTLED) & (s.time <= end)
        fields = (s.north, s.east, s.velocity_north, s.velocity_east, judged, flight.phase == 1)
        parts.append([np.asarray(field)[rows] for field in fields])
    columns = [np.stack(column, axis=1) for column in zip(*parts, strict=True)]
    return Flown(STEP * np.arange(len(columns[0])), *columns)


class Found(NamedTuple):
    """Errors (epochs of all flights, runs) with the phase of each epoch."""

    position: Any  # NM
    speed: Any  # kt
    heading: Any  # deg
    turning: Any  # (epochs,)


def seen(radars: tuple[Radar, ...], runs: int, generator: np.random.Generator) -> tuple[Any, Measurements]:
    """Rows of the truth at all scans, and the converted plots of an ensemble of all flights (16 x runs)."""
    truth = flights()
    looks = sorted(
        (t, i) for i, radar in enumerate(radars) for t in np.arange(radar.first, truth.time[-1], radar.period)
    )
    rows = np.array([round(t / STEP) for t, _ in looks])
    count = truth.north.shape[1] * runs
    z, R = np.empty((len(rows), 2, count)), np.empty((len(rows), 2, 2, count))
    for k, ((_, which), row) in enumerate(zip(looks, rows, strict=True)):
        radar = radars[which]
        north, east = (np.repeat(column[row], runs) for column in (truth.north, truth.east))
        north, east = north - radar.north, east - radar.east
        noise = generator.standard_normal((2, count))
        distance = np.hypot(north, east) + radar.range_sigma * noise[0]
        azimuth = np.arctan2(east, north) + radar.azimuth_sigma * noise[1]
        cos, sin = np.cos(azimuth), np.sin(azimuth)
        z[k] = radar.north + distance * cos, radar.east + distance * sin
        along, across = radar.range_sigma**2, (distance * radar.azimuth_sigma) ** 2
        mixed = (along - across) * cos * sin
        R[k] = [[along * cos**2 + across * sin**2, mixed], [mixed, along * sin**2 + across * cos**2]]
    time = STEP * rows
    return rows, Measurements(("plots.north", "plots.east"), time, time, z, R)


def turn_rates(rows: Any, runs: int) -> Any:
    """(looks, 16 x runs) mean rate of turn, rad/s, from each look to the next; before the first from the beginning."""
    truth = flights()
    course = np.unwrap(np.arctan2(truth.velocity_east, truth.velocity_north), axis=0)
    before = np.concatenate(([0], rows[:-1]))
    elapsed = np.maximum(STEP * (rows - before), STEP)  # two radars may look at once: no turn in no time
    return np.repeat((course[rows] - course[before]) / elapsed[:, None], runs, axis=1)


@lru_cache(maxsize=16)
def flown(seed: int, runs: int, radars: tuple[Radar, ...], tracker: str) -> Found:
    """One tracker on the sixteen flights."""
    truth, generator = flights(), stream(seed, 0, 0, f"madap.{len(radars)}")
    rows, plots = seen(radars, runs, generator)
    motion = np.stack([truth.north, truth.velocity_north, truth.east, truth.velocity_east], axis=1)  # (k, 4, 16)
    start = np.repeat(motion[0], runs, axis=1)
    start = start + PRIOR[:, None] * generator.standard_normal(start.shape)
    position, velocity, course = [], [], []
    own = ToldTurn(turn_rates(rows, runs)) if tracker == TOLD_TURN else TRACKERS[tracker]
    for epoch in follow(own, plots, Gaussian(start, np.diag(PRIOR**2)), start=0.0):
        estimate = epoch.estimate
        mean = merge(estimate).mean if isinstance(estimate, Mixture) else estimate.mean
        north, north_rate, east, east_rate = np.repeat(motion[rows[epoch.row]], runs, axis=1)
        position.append(np.hypot(mean[0] - north, mean[2] - east) / NAUTICAL_MILE)
        velocity.append((np.hypot(mean[1], mean[3]) - np.hypot(north_rate, east_rate)) / KNOT)
        off = np.arctan2(mean[3], mean[1]) - np.arctan2(east_rate, north_rate)
        course.append(np.degrees(np.angle(np.exp(1j * off))))
    judged, turning = truth.judged[rows], truth.turning[rows]
    off_place, off_speed, off_course = (
        np.array(values).reshape(*judged.shape, runs)[judged] for values in (position, velocity, course)
    )
    return Found(off_place, off_speed, off_course, turning[judged])


def error(quantity: str, statistic: str, radars: tuple[Radar, ...], tracker: str) -> Any:
    """Measure of the mean, the standard deviation or the RMS of an error over all flights."""

    def measured(seed: int, runs: int) -> Interval:
        values = getattr(flown(seed, min(runs, MOST), radars, tracker), quantity)
        if statistic == "mean":
            return mean_interval(values.mean(axis=0))
        if statistic == "sigma":
            return rmse(((values - values.mean()) ** 2).mean(axis=0))
        return rmse((values**2).mean(axis=0))

    return measured


def share(quantity: str, limit: float, turning: bool, radars: tuple[Radar, ...], tracker: str) -> Any:
    """Measure of the share of epochs with an error within a limit, per cent."""

    def measured(seed: int, runs: int) -> Interval:
        found = flown(seed, min(runs, MOST), radars, tracker)
        chosen = getattr(found, quantity)[found.turning == turning]
        return mean_interval(100.0 * (np.abs(chosen) <= limit).mean(axis=0))

    return measured
