"""The experiment of Volovyk 2022: sets of models on the landing pattern, flown by a point mass and by JSBSim."""

from __future__ import annotations

import math
import time as clock
from dataclasses import dataclass
from functools import lru_cache
from itertools import pairwise
from typing import Any, NamedTuple

import numpy as np

from sim.claims.flown import flown
from sim.randomness import stream
from sim.truths.landing_pattern import BASE, FINAL, FINAL_TURN, GLIDE, GROUND, LandingPattern
from sim.truths.madap import Madap
from tracking.gaussian import Gaussian, merge
from tracking.intervals import Interval, gain, mean_interval
from tracking.measurement import ConvertedPolar, DebiasedPolar
from tracking.monitor import NisMonitor
from tracking.motion import ConstantVelocity, Transition
from tracking.track import Measurements, chunks, follow
from tracking.trackers.imm import InteractingMultipleModel, ModelSet, improved_set, published_set
from tracking.trackers.kalman import Kalman

SCAN, STEP, PAPER_RUNS = 0.7, 0.35, 130
RADAR = (1200.0, 150.0)  # m: 900 m past the aiming point, 150 m right of the centreline; ours
AIMING_POINT = 300.0  # m
SIGMAS = np.array([30.0, math.radians(1.0)])
PRIOR = np.diag([1e3, 0.05, 1e3, 0.05])
SMALLEST = 130  # runs of the quick form
TURN_LEFT = 1  # the model of the fast turn
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
SCENARIO = "volovyk2022_jsbsim"
PHASES = {"base": BASE, "final_turn": FINAL_TURN, "final": FINAL, "glide": GLIDE, "flare": GLIDE}
LEFT, RIGHT, ALL_ENTRIES, JSBSIM, JSBSIM_RIGHT = "left", "right", "entries", "jsbsim", "jsbsim right"
TURNS = (0, 30, 60, 90, 120, 150, 180)  # deg onto final
SHARPEST = 120  # deg that the law turns onto one leg; more are flown as a turn onto the base leg before
BEFORE, BANK = 5000.0, math.radians(15.0)  # m straight before that turn, rad
FINER = 7  # records of that turn within a scan
ENTRIES = [(LEFT, turn) for turn in TURNS] + [(RIGHT, turn) for turn in TURNS[1:]]
EACH = 40  # runs of an entry: entries are many, and what they show is large


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
    IMPROVED: improved_set(),
}


class Path(NamedTuple):
    """What is flown, at every scan."""

    time: Any  # (k,)
    place: Any  # (k, 2, runs) north, east
    phase: Any  # (k, runs)
    start: Any  # (4,) or (4, runs): north, its rate, east, its rate


class Experiment(NamedTuple):
    """Scans of an ensemble."""

    measurements: Measurements
    truth: Any  # (k, 2, runs) north, east
    phase: Any  # (k, runs)
    prior: Gaussian
    distance: Any  # (k, runs) m, from the radar
    to_go: Any  # (k, runs) m, to the aiming point


@lru_cache(maxsize=4)
def pattern(seed: int, runs: int, turn: int = 90) -> Path:
    """The left-hand landing pattern; ``turn`` is the change of course onto final, deg."""
    if turn > SHARPEST:
        return preceded(pattern(seed, runs), turn)
    motion = LandingPattern(turn=math.radians(turn))
    flight = motion.fly(stream(seed, 0, 0, f"volovyk2022.air.{turn}"), runs, step=STEP)
    stride = round(SCAN / STEP)
    rows = np.arange(stride, len(flight.time), stride)
    state = flight.state
    start = [np.ravel(value[0])[0] for value in (state.north, state.velocity_north, state.east, state.velocity_east)]
    place = np.stack([state.north[rows], state.east[rows]], axis=1)
    return Path(flight.time[rows], place, flight.phase[rows], np.array(start))


def preceded(path: Path, turn: int) -> Path:
    """The pattern after a straight and a turn onto its base leg, so that course changes by ``turn`` (deg) in all."""
    north, north_rate, east, east_rate = path.start
    speed, course = math.hypot(north_rate, east_rate), math.atan2(east_rate, north_rate)
    change = math.radians(turn) - 0.5 * math.pi
    leg = Madap(speed, BANK, straight=BEFORE, turn=-change, after=1.0, course=course + change)
    joined = leg.fly(step=SCAN / FINER).state
    first = (len(joined.time) - 1) % FINER
    rows = np.arange(first, len(joined.time), FINER)  # every scan, the last where the pattern begins
    moved = (joined.north - joined.north[-1] + north)[rows], (joined.east - joined.east[-1] + east)[rows]
    before = np.stack(moved, axis=1)[..., None]
    return Path(
        SCAN * np.arange(1, len(rows) + len(path.time)),
        np.concatenate([np.broadcast_to(before[1:], (len(rows) - 1, *path.place.shape[1:])), path.place]),
        np.concatenate([np.full((len(rows) - 1, path.phase.shape[1]), BASE), path.phase]),
        np.array([before[0, 0, 0], joined.velocity_north[first], before[0, 1, 0], joined.velocity_east[first]]),
    )


def mirrored(path: Path) -> Path:
    """The same on the other side of the centreline."""
    return path._replace(place=path.place * [[1.0], [-1.0]], start=path.start * [1.0, 1.0, -1.0, -1.0])


def six_degrees(runs: int, side: str) -> Path:
    """The pattern that JSBSim flies."""
    flight = flown(SCENARIO, ("route.side", side))
    rows, s = flight.rows(SCAN), flight.state
    names = np.array([PHASES.get(name, GROUND) for name in flight.flight.phases])
    place = np.stack([s.north[rows], s.east[rows]], axis=1)[..., None]
    phase = names[flight.flight.phase[rows]][:, None]
    start = np.array([s.north[0], s.velocity_north[0], s.east[0], s.velocity_east[0]])
    shape = (len(rows), runs)
    return Path(s.time[rows], np.broadcast_to(place, (shape[0], 2, runs)), np.broadcast_to(phase, shape), start)


def entered(seed: int) -> Path:
    """All entries side by side, EACH runs of each; those that land earlier stand still."""
    paths = {turn: pattern(seed, EACH, turn) for turn in TURNS}
    chosen = [paths[turn] if side == LEFT else mirrored(paths[turn]) for side, turn in ENTRIES]
    longest = max(chosen, key=lambda path: len(path.time))
    k = len(longest.time)

    def padded(values: Any) -> Any:
        return np.concatenate([values, np.repeat(values[-1:], k - len(values), axis=0)])

    place = np.concatenate([padded(path.place) for path in chosen], axis=2)
    phase = np.concatenate([padded(path.phase) for path in chosen], axis=1)
    start = np.concatenate([np.repeat(path.start[:, None], EACH, axis=1) for path in chosen], axis=1)
    return Path(longest.time, place, phase, start)


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
    for some in chunks(shape[1], 512):
        begun = prior if prior.mean.ndim == 1 else prior._replace(mean=prior.mean[:, some])
        for epoch in follow(imm(name), data.measurements.runs(some), begun, start=0.0):
            mixture = epoch.estimate
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


def within_norm(name: str, far: float, near: float, truth: str = LEFT) -> Any:
    """Measure of the share of scans (per cent) with a cross-range error within the radar norm of Annex 10."""

    def measured(seed: int, runs: int) -> Interval:
        data, own = experiment(seed, runs, truth), squares(name, seed, runs, truth).own["azimuth"]
        among = np.isin(data.phase, (FINAL, GLIDE)) & (data.to_go < far) & (data.to_go >= near)
        norm = NORM_SHARE * data.distance + NORM_OF_DEVIATION * np.abs(data.truth[:, 1])
        kept = np.sqrt(own) * data.distance <= np.maximum(norm, NORM_LEAST)
        return mean_interval(100.0 * by_run(kept, among))

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
