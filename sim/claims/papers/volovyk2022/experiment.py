"""The experiment of Volovyk 2022: sets of models on the landing pattern, flown by a point mass and by JSBSim."""

from __future__ import annotations

import math
import time as clock
from dataclasses import dataclass
from functools import lru_cache
from itertools import pairwise
from typing import Any, NamedTuple

import numpy as np

from sim.claims.papers.volovyk2022.landing_paths import (
    ALL_ENTRIES,
    EACH,
    ENTRIES,
    JSBSIM,
    JSBSIM_RIGHT,
    LEFT,
    RIGHT,
    SCAN,
    entered,
    mirrored,
    pattern,
    six_degrees,
)
from sim.flight.truths.landing_pattern import BASE, FINAL, FINAL_TURN, GLIDE
from sim.randomness import stream
from tracking.gaussian import Gaussian, merge
from tracking.intervals import Interval, gain, mean_interval
from tracking.measurement import ConvertedPolar, DebiasedPolar
from tracking.monitor import NisMonitor
from tracking.motion import ConstantVelocity, Transition
from tracking.smoothing import smooth_fixed_lag
from tracking.track import Measurements, Track, chunks, follow, track
from tracking.trackers.imm import InteractingMultipleModel, ModelSet, improved_set, published_set
from tracking.trackers.kalman import Kalman

PAPER_RUNS = 130
RADAR = (1200.0, 150.0)  # m: 900 m past the aiming point, 150 m right of the centreline; ours
AIMING_POINT = 300.0  # m
SIGMAS = np.array([30.0, math.radians(1.0)])
PRIOR = np.diag([1e3, 0.05, 1e3, 0.05])
SMALLEST = 130  # runs of the quick form
TURN_LEFT = 1  # the model of the fast turn
DELAYS, DELAYED_RUNS = (0.0, 2.1, 4.9, 9.8, 20.3), 20  # s, whole scans
AFTER = 35.0  # s behind the glide path's beginning
LEGS = {
    "all": (BASE, FINAL_TURN, FINAL, GLIDE),
    "base": (BASE,),
    "turn onto final": (FINAL_TURN,),
    "final before the glide path": (FINAL,),
    "glide path": (GLIDE,),
}
NEAR, FAR = (900.0, 1500.0), (6000.0, 8000.0)  # m
STRETCHES = ((8000.0, 6000.0), (6000.0, 4500.0), (4500.0, 3000.0), (3000.0, 1500.0), (1500.0, 500.0))  # m, to go
NORM_SHARE, NORM_LEAST, NORM_OF_DEVIATION = 0.006, 9.0, 0.1  # Annex 10, 3.2.3.3.1: of the distance, m, of the deviation


@dataclass(frozen=True)
class Printed:
    """A published model with another reading of its process noise, Q(dt) = ``noise``."""

    motion: Any
    noise: tuple[tuple[float, ...], ...]

    @property
    def channels(self) -> tuple[str, ...]:
        return tuple(self.motion.channels)

    @property
    def depends_on_state(self) -> bool:
        return bool(self.motion.depends_on_state)

    def transition(self, dt: float, mean: Any) -> Transition:
        """The model's F with the noise as read."""
        return Transition(self.motion.transition(dt, mean).F, np.array(self.noise))


def read_as(noise: Any) -> ModelSet:
    """The published set under another reading of Q."""
    published = published_set()
    rows = tuple(map(tuple, np.asarray(noise, float).tolist()))
    return published._replace(models=tuple(Printed(model, rows) for model in published.models))


def through_acceleration() -> Any:
    """B diag(.01, .01) B' with an acceleration held over the scan."""
    column = np.array([[0.5 * SCAN**2], [SCAN]])
    return np.kron(np.eye(2), 0.01 * column @ column.T)


DENSITY, DENSER, IMPROVED = "Q a density of .01", "Q a density of .3", "improved set"
SETS = {
    DENSITY: published_set(0.01),
    "Q of B diag(.01) B'": read_as(through_acceleration()),
    "Q .01 I": read_as(0.01 * np.eye(4)),
    DENSER: published_set(0.3),
    IMPROVED: improved_set(0.01, 0.05),
}


class Experiment(NamedTuple):
    """Scans of an ensemble."""

    measurements: Measurements
    truth: Any  # (k, 2, runs) north, east
    phase: Any  # (k, runs)
    prior: Gaussian
    distance: Any  # (k, runs) m, from the radar
    to_go: Any  # (k, runs) m, to the aiming point


@lru_cache(maxsize=3)
def experiment(seed: int, runs: int, truth: str = LEFT) -> Experiment:
    """A landing pattern as the radar sees it."""
    if truth == ALL_ENTRIES:
        path = entered(seed)
    elif truth in (JSBSIM, JSBSIM_RIGHT):
        path = six_degrees(runs, LEFT if truth == JSBSIM else RIGHT)
    else:
        path = pattern(seed, runs) if truth == LEFT else mirrored(pattern(seed, runs))
    north, east = path.place[:, 0] - RADAR[0], path.place[:, 1] - RADAR[1]
    polar = np.stack([np.hypot(north, east), np.arctan2(east, north)], axis=1)
    noise = stream(seed, 0, 0, f"volovyk2022.radar.{truth}").standard_normal(polar.shape)
    R = np.broadcast_to(np.diag(SIGMAS**2), (len(path.time), 2, 2))
    z = polar + SIGMAS[:, None] * noise
    seen = Measurements(("radar.range", "radar.azimuth"), path.time, path.time, z, R)
    to_go = np.hypot(path.place[:, 0] - AIMING_POINT, path.place[:, 1])
    return Experiment(seen, path.place, path.phase, Gaussian(path.start, PRIOR), polar[:, 0], to_go)


def imm(name: str) -> InteractingMultipleModel:
    """One of the sets, with the conversion of the paper; the improved one without its bias."""
    conversion = DebiasedPolar if name == IMPROVED else ConvertedPolar
    return InteractingMultipleModel(conversion(position=RADAR, height=0.0), SETS[name])


class Squares(NamedTuple):
    """Squared errors (k, runs) of raw plots and filter: m2 of position, rad2 of azimuth; belief in the fast turn."""

    raw: dict[str, Any]
    own: dict[str, Any]
    turning: Any


@lru_cache(maxsize=10)
def squares(name: str, seed: int, runs: int, truth: str = LEFT) -> Squares:
    """What a set of models makes of the scans."""
    data = experiment(seed, runs, truth)
    shape, prior = data.phase.shape, data.prior
    position, azimuth, turning = (np.empty(shape, np.float32) for _ in range(3))
    truth_azimuth = np.arctan2(data.truth[:, 1] - RADAR[1], data.truth[:, 0] - RADAR[0])
    tracker = imm(name)
    for some in chunks(shape[1], 512):
        begun = prior if prior.mean.ndim == 1 else prior._replace(mean=prior.mean[:, some])
        for epoch in follow(tracker, data.measurements.runs(some), begun, start=0.0):
            mixture = tracker.estimate(epoch.state)
            mean = merge(mixture).mean
            turning[epoch.row, some] = mixture.weights[TURN_LEFT]
            position[epoch.row, some] = ((mean[[0, 2]] - data.truth[epoch.row][:, some]) ** 2).sum(axis=0)
            off = np.arctan2(mean[2] - RADAR[1], mean[0] - RADAR[0]) - truth_azimuth[epoch.row, some]
            azimuth[epoch.row, some] = np.angle(np.exp(1j * off)) ** 2
    z = data.measurements.z
    plots_ = np.array(RADAR)[:, None] + z[:, :1] * np.stack([np.cos(z[:, 1]), np.sin(z[:, 1])], axis=1)
    raw = {"position": ((plots_ - data.truth) ** 2).sum(axis=1), "azimuth": (z[:, 1] - truth_azimuth) ** 2}
    return Squares(raw, {"position": position, "azimuth": azimuth}, turning)


def by_run(values: Any, among: Any) -> Any:
    """Sum over the chosen scans of each run, divided by their mean number: runs weigh as they have scans."""
    return np.where(among, values, 0.0).sum(axis=0) / among.sum(axis=0).mean()


def gains(name: str, what: str, leg: str, truth: str = LEFT) -> Any:
    """Measure of the RMSE of the plots over that of the filter."""

    def measured(seed: int, runs: int) -> Interval:
        found, phase = squares(name, seed, runs, truth), experiment(seed, runs, truth).phase
        among = np.isin(phase, LEGS[leg])
        return gain(by_run(found.raw[what], among), by_run(found.own[what], among))

    return measured


def entry_gains(side: str, turn: int) -> Any:
    """Measure of the same for one entry of the published set, over all legs."""
    first = EACH * ENTRIES.index((side, turn))
    some = slice(first, first + EACH)

    def measured(seed: int, runs: int) -> Interval:
        found, phase = squares(DENSITY, seed, EACH, ALL_ENTRIES), experiment(seed, EACH, ALL_ENTRIES).phase
        among = np.isin(phase[:, some], LEGS["all"])
        return gain(*(by_run(part["position"][:, some], among) for part in (found.raw, found.own)))

    return measured


def grows(name: str, what: str, origin: str, truth: str = LEFT) -> Any:
    """Measure of the RMSE at 6-8 km over that at 0.9-1.5 km, from the radar or from the aiming point."""

    def measured(seed: int, runs: int) -> Interval:
        data, own = experiment(seed, runs, truth), squares(name, seed, runs, truth).own[what]
        away = data.distance if origin == "radar" else data.to_go
        glide = data.phase == GLIDE
        far, near = (by_run(own, glide & (away > low) & (away < high)) for low, high in (FAR, NEAR))
        return gain(far, near)

    return measured


def grows_throughout(name: str, what: str, truth: str = LEFT) -> Any:
    """Measure of the RMSE on one stretch of the glide path over that on the next, where that ratio is least."""

    def measured(seed: int, runs: int) -> Interval:
        data, own = experiment(seed, runs, truth), squares(name, seed, runs, truth).own[what]
        glide = data.phase == GLIDE
        found = [by_run(own, glide & (data.to_go < far) & (data.to_go >= near)) for far, near in STRETCHES]
        return min((gain(*pair) for pair in pairwise(found)), key=lambda ratio: ratio.value)

    return measured


def norm(data: Experiment) -> Any:
    """Largest cross-range error (k, runs), m, that Annex 10 allows a precision approach radar."""
    share = NORM_SHARE * data.distance + NORM_OF_DEVIATION * np.abs(data.truth[:, 1])
    return np.maximum(share, NORM_LEAST)


def norm_over(name: str, truth: str = LEFT) -> Any:
    """Measure of the RMS of that norm over the cross-range RMSE on the glide path."""

    def measured(seed: int, runs: int) -> Interval:
        data, own = experiment(seed, runs, truth), squares(name, seed, runs, truth).own["azimuth"]
        glide = data.phase == GLIDE
        return gain(by_run(norm(data) ** 2, glide), by_run(own * data.distance**2, glide))

    return measured


def within_norm(name: str, far: float, near: float, truth: str = LEFT) -> Any:
    """Measure of the share of scans (per cent) with a cross-range error within the radar norm of Annex 10."""

    def measured(seed: int, runs: int) -> Interval:
        data, own = experiment(seed, runs, truth), squares(name, seed, runs, truth).own["azimuth"]
        among = np.isin(data.phase, (FINAL, GLIDE)) & (data.to_go < far) & (data.to_go >= near)
        return mean_interval(100.0 * by_run(np.sqrt(own) * data.distance <= norm(data), among))

    return measured


def right_belief(leg: str, truth: str = LEFT) -> Any:
    """Measure of the mean probability of the fast turn in the turn, or of its contrary elsewhere."""

    def measured(seed: int, runs: int) -> Interval:
        data, turning = experiment(seed, runs, truth), squares(DENSITY, seed, runs, truth).turning
        belief = turning if leg == "turn onto final" else 1.0 - turning
        return mean_interval(by_run(belief, np.isin(data.phase, LEGS[leg])))

    return measured


def spared(name: str, truth: str = LEFT) -> Any:
    """Measure of the share of runs that are not told of a turn in the 35 s after the glide path begins."""

    def measured(seed: int, runs: int) -> Interval:
        data, turning = experiment(seed, runs, truth), squares(name, seed, runs, truth).turning
        began = np.argmax(data.phase == GLIDE, axis=0)
        scans = np.arange(len(turning))[:, None]
        among = (scans >= began) & (scans < began + round(AFTER / SCAN))
        return mean_interval((~((turning > 0.5) & among).any(axis=0)).astype(float))

    return measured


def share_of_the_scan(seed: int, runs: int) -> Interval:
    """Computing time of one scan of one aircraft over the time between scans, as the power of ten above it."""
    data = experiment(seed, SMALLEST)
    one = data.measurements.runs(slice(0, 1))
    began = clock.perf_counter()
    for _ in follow(imm(DENSITY), one, data.prior, start=0.0):
        pass
    share = (clock.perf_counter() - began) / len(one.time) / SCAN
    power = 10.0 ** math.ceil(math.log10(share))
    return Interval(power, power, power, 1)


def delays(density: float, truth: str = LEFT) -> Any:
    """Measure of the delay of a detector on one Kalman filter over that of the models, both from the turn's begin.

    The detector sums the normalised innovations of five scans and raises one false alarm in a thousand scans; the
    models have detected where the fast turn is the likeliest.
    """

    def measured(seed: int, runs: int) -> Interval:
        runs = min(runs, 4 * SMALLEST)
        data = experiment(seed, runs, truth)
        turning = squares(DENSITY, seed, runs, truth).turning
        began = np.argmax(data.phase == FINAL_TURN, axis=0)
        scans = np.arange(len(turning))[:, None]
        monitor, alarms = NisMonitor(window=5, false_alarm_rate=1e-3), []
        window = monitor.begin()
        kalman = Kalman(ConvertedPolar(position=RADAR, height=0.0), ConstantVelocity(density))
        for epoch in follow(kalman, data.measurements, data.prior, start=0.0):
            window, said = monitor.step(window, epoch.innovation)
            alarms.append(np.zeros(runs, bool) if said is None else said.alarm)
        late = len(scans)
        first = [
            np.where(seen.any(axis=0), np.argmax(seen, axis=0), late) - began
            for seen in (np.array(alarms) & (scans >= began), (turning > 0.5) & (scans >= began))
        ]
        # a ratio of means of positive delays, linearised over runs
        top, bottom = (np.maximum(delay, 1.0) for delay in first)
        value = float(top.mean() / bottom.mean())
        spread = mean_interval(top / top.mean() - bottom / bottom.mean())
        return Interval(value, value * math.exp(spread.low), value * math.exp(spread.high), runs)

    return measured


@lru_cache(maxsize=1)
def delayed(seed: int) -> dict[float, tuple[Any, Any]]:
    """Mean squared errors per run of the plots and of a fixed-lag smoother, from the turn onto final on, by delay (s).

    One Kalman filter of density 3, smoothed: a set of models takes a minute for it.
    """
    data = experiment(seed, SMALLEST)
    some = slice(0, DELAYED_RUNS)
    seen, motion = data.measurements.runs(some), ConstantVelocity(3.0)
    tracker = Kalman(ConvertedPolar(position=RADAR, height=0.0), motion)
    record = track(tracker, seen, data.prior, 0.0)
    turning = np.flatnonzero((data.phase[:, some] == FINAL_TURN).any(axis=1))
    longest = round(max(DELAYS) / SCAN)
    part = slice(turning[0], turning[-1] + 1 + longest)
    window = Track(record.channels, *(None if field is None else field[part] for field in record[1:]))
    truth = data.truth[part, :, some]
    z = seen.z[part]
    plots_ = np.array(RADAR)[:, None] + z[:, :1] * np.stack([np.cos(z[:, 1]), np.sin(z[:, 1])], axis=1)
    judged = slice(0, len(turning))
    raw = ((plots_ - truth) ** 2).sum(axis=1)[judged].mean(axis=0)
    found = {}
    for delay in DELAYS:
        mean = smooth_fixed_lag(window, motion, round(delay / SCAN)).mean
        found[delay] = (raw, ((mean[:, [0, 2]] - truth) ** 2).sum(axis=1)[judged].mean(axis=0))
    return found


def after_delay(delay: float) -> Any:
    """Measure of the RMSE of the plots over that of the smoother, in the turn onto final."""
    return lambda seed, runs: gain(*delayed(seed)[delay])
