"""The experiment of Volovyk 2022: filters on the landing pattern, flown by a point mass and by JSBSim.

A measure is given the seed and a number of runs: draws of air and noise of the point mass, flights on JSBSim, each of
which has `DRAWS` of noise and counts once.
"""

from __future__ import annotations

import math
from functools import lru_cache
from itertools import pairwise
from typing import Any, NamedTuple

import numpy as np

from sim.claims.jsbsim_flights import per_flight
from sim.claims.ledger import DRAWS
from sim.claims.papers.volovyk2022.filters import DENSITY, FILTERS, PLOTS, RADAR
from sim.claims.papers.volovyk2022.landing_paths import (
    ALL_ENTRIES,
    EACH,
    ENTRIES,
    JSBSIM,
    JSBSIM_RIGHT,
    LEFT,
    SCAN,
    entered,
    mirrored,
    pattern,
    six_degrees,
)
from sim.flight.truths.landing_pattern import BASE, FINAL, FINAL_TURN, GLIDE
from sim.randomness import stream
from tracking.gaussian import Gaussian, Mixture, merge
from tracking.intervals import Interval, gain, mean_interval
from tracking.monitor import NisMonitor
from tracking.motion import ConstantVelocity
from tracking.smoothing import smooth_fixed_lag
from tracking.track import Measurements, Track, Tracker, chunks, follow, track
from tracking.trackers.kalman import Kalman

PAPER_RUNS = 130
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
ENTRY = (9000.0, 8500.0)  # m to go, where the glide path begins
STRETCHES = ((8000.0, 6000.0), (6000.0, 4500.0), (4500.0, 3000.0), (3000.0, 1500.0), (1500.0, 500.0))  # m, to go


class Experiment(NamedTuple):
    """Scans of an ensemble."""

    measurements: Measurements
    truth: Any  # (k, 2, runs) north, east
    phase: Any  # (k, runs)
    prior: Gaussian
    distance: Any  # (k, runs) m, from the radar
    to_go: Any  # (k, runs) m, to the aiming point
    draws: int = 1  # of each flight, side by side in the runs


@lru_cache(maxsize=4)
def experiment(seed: int, runs: int, truth: str = LEFT) -> Experiment:
    """A landing pattern as the radar sees it."""
    if truth == ALL_ENTRIES:
        path = entered(seed)
    elif truth in (JSBSIM, JSBSIM_RIGHT):
        path = six_degrees(seed, runs, truth)
    else:
        path = pattern(seed, runs) if truth == LEFT else mirrored(pattern(seed, runs))
    north, east = path.place[:, 0] - RADAR[0], path.place[:, 1] - RADAR[1]
    polar = np.stack([np.hypot(north, east), np.arctan2(east, north)], axis=1)
    noise = stream(seed, 0, 0, f"volovyk2022.radar.{truth}").standard_normal(polar.shape)
    R = np.broadcast_to(np.diag(SIGMAS**2), (len(path.time), 2, 2))
    z = polar + SIGMAS[:, None] * noise
    seen = Measurements(("radar.range", "radar.azimuth"), path.time, path.time, z, R)
    to_go = np.hypot(path.place[:, 0] - AIMING_POINT, path.place[:, 1])
    draws = DRAWS if truth in (JSBSIM, JSBSIM_RIGHT) else 1
    return Experiment(seen, path.place, path.phase, Gaussian(path.start, PRIOR), polar[:, 0], to_go, draws)


class Squares(NamedTuple):
    """Squared errors (k, runs) of raw plots and filter: m2 of position, rad2 of azimuth; belief in the fast turn."""

    raw: dict[str, Any]
    own: dict[str, Any]
    turning: Any


@lru_cache(maxsize=10)
def squares(name: str, seed: int, runs: int, truth: str = LEFT) -> Squares:
    """What one of the filters makes of the scans."""
    return errors(FILTERS[name], experiment(seed, runs, truth))


def errors(tracker: Tracker, data: Experiment) -> Squares:
    """What a tracker makes of the scans; it believes in no turn where it has no models."""
    shape, prior = data.phase.shape, data.prior
    position, azimuth, turning = (np.zeros(shape, np.float32) for _ in range(3))
    truth_azimuth = np.arctan2(data.truth[:, 1] - RADAR[1], data.truth[:, 0] - RADAR[0])
    for some in chunks(shape[1], 512):
        begun = prior if prior.mean.ndim == 1 else prior._replace(mean=prior.mean[:, some])
        for epoch in follow(tracker, data.measurements.runs(some), begun, start=0.0):
            estimate = epoch.estimate
            if isinstance(estimate, Mixture):
                turning[epoch.row, some] = estimate.weights[TURN_LEFT]
                estimate = merge(estimate)
            mean = estimate.mean
            position[epoch.row, some] = ((mean[[0, 2]] - data.truth[epoch.row][:, some]) ** 2).sum(axis=0)
            off = np.arctan2(mean[2] - RADAR[1], mean[0] - RADAR[0]) - truth_azimuth[epoch.row, some]
            azimuth[epoch.row, some] = np.angle(np.exp(1j * off)) ** 2
    z = data.measurements.z
    plots_ = np.array(RADAR)[:, None] + z[:, :1] * np.stack([np.cos(z[:, 1]), np.sin(z[:, 1])], axis=1)
    raw = {"position": ((plots_ - data.truth) ** 2).sum(axis=1), "azimuth": (z[:, 1] - truth_azimuth) ** 2}
    return Squares(raw, {"position": position, "azimuth": azimuth}, turning)


def by_run(values: Any, among: Any, draws: int = 1) -> Any:
    """Sum over the chosen scans of each run, divided by their mean number: runs weigh as they have scans.

    The ``draws`` of a flight, side by side, are averaged.
    """
    sums = np.where(among, values, 0.0).sum(axis=0) / among.sum(axis=0).mean()
    return per_flight(sums, len(sums) // draws)


def mean_over_scans(values: Any, among: Any, draws: int = 1) -> Interval:
    """Mean over the chosen scans of all runs, with Student's interval of a ratio of means over runs, or flights.

    A run has as many scans as it has: how many is no doubt of the mean.
    """
    sums, scans = (by_run(part, among, draws) for part in (values, np.ones(np.shape(among))))
    value = sums.mean()
    return mean_interval(value + sums - value * scans)


def gains(name: str, what: str, leg: str, truth: str = LEFT) -> Any:
    """Measure of the RMSE of the plots over that of the filter."""

    def measured(seed: int, runs: int) -> Interval:
        found, data = squares(name, seed, runs, truth), experiment(seed, runs, truth)
        among = np.isin(data.phase, LEGS[leg])
        return gain(*(by_run(part[what], among, data.draws) for part in (found.raw, found.own)))

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
        chosen = [glide & (away > low) & (away < high) for low, high in (FAR, NEAR)]
        return gain(*(by_run(own, among, data.draws) for among in chosen))

    return measured


def by_stretch(name: str, what: str, stretches: Any, seed: int, runs: int, truth: str) -> list[Any]:
    """Mean square errors of each run, or flight, on stretches of the glide path."""
    data, own = experiment(seed, runs, truth), squares(name, seed, runs, truth).own[what]
    glide = data.phase == GLIDE
    chosen = [glide & (data.to_go < far) & (data.to_go >= near) for far, near in stretches]
    return [by_run(own, among, data.draws) for among in chosen]


def grows_over_all(name: str, what: str, truth: str = LEFT) -> Any:
    """Measure of the RMSE where the glide path begins over that on its last stretch."""
    return lambda seed, runs: gain(*by_stretch(name, what, (ENTRY, STRETCHES[-1]), seed, runs, truth))


def grows_throughout(name: str, what: str, stretches: Any, truth: str = LEFT) -> Any:
    """Measure of the RMSE on one stretch of the glide path over that on the next, where that ratio is least."""

    def measured(seed: int, runs: int) -> Interval:
        found = by_stretch(name, what, stretches, seed, runs, truth)
        return min((gain(*pair) for pair in pairwise(found)), key=lambda ratio: ratio.value)

    return measured


def gain_over(rival: str, name: str, leg: str, truth: str = LEFT) -> Any:
    """Measure of the position RMSE of a rival over that of interacting models."""

    def measured(seed: int, runs: int) -> Interval:
        data = experiment(seed, runs, truth)
        among = np.isin(data.phase, LEGS[leg])
        own = (squares(one, seed, runs, truth).own["position"] for one in (rival, name))
        return gain(*(by_run(part, among, data.draws) for part in own))

    return measured


def right_belief(leg: str, truth: str = LEFT) -> Any:
    """Measure of the mean probability of the fast turn in the turn, or of its contrary elsewhere."""

    def measured(seed: int, runs: int) -> Interval:
        data, turning = experiment(seed, runs, truth), squares(DENSITY, seed, runs, truth).turning
        belief = turning if leg == "turn onto final" else 1.0 - turning
        return mean_over_scans(belief, np.isin(data.phase, LEGS[leg]), data.draws)

    return measured


def spared(name: str, truth: str = LEFT) -> Any:
    """Measure of the share of runs that are not told of a turn in the 35 s after the glide path begins."""

    def measured(seed: int, runs: int) -> Interval:
        data, turning = experiment(seed, runs, truth), squares(name, seed, runs, truth).turning
        began = np.argmax(data.phase == GLIDE, axis=0)
        scans = np.arange(len(turning))[:, None]
        among = (scans >= began) & (scans < began + round(AFTER / SCAN))
        return mean_interval(per_flight(~((turning > 0.5) & among).any(axis=0), runs))

    return measured


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
        kalman = Kalman(PLOTS, ConstantVelocity(density))
        for epoch in follow(kalman, data.measurements, data.prior, start=0.0):
            window, said = monitor.step(window, epoch.innovation)
            alarms.append(np.zeros(len(began), bool) if said is None else said.alarm)
        late = len(scans)
        first = [
            np.where(seen.any(axis=0), np.argmax(seen, axis=0), late) - began
            for seen in (np.array(alarms) & (scans >= began), (turning > 0.5) & (scans >= began))
        ]
        # a ratio of means of positive delays, linearised over runs
        top, bottom = (per_flight(np.maximum(delay, 1.0), runs) for delay in first)
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
    tracker = Kalman(PLOTS, motion)
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
