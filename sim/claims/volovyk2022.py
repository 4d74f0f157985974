"""Volovyk 2022: interacting multiple models in the azimuth channel of a precision approach radar."""

from __future__ import annotations

import math
import time as clock
from collections.abc import Iterator
from dataclasses import dataclass
from functools import lru_cache
from typing import Any, NamedTuple

import numpy as np

from sim.claims.ledger import Claim, Reading
from sim.claims.plots import Curve, Plot
from sim.claims.verdict import above, at_most, between
from sim.randomness import stream
from sim.truths.landing_pattern import BASE, FINAL, FINAL_TURN, GLIDE, GROUND, LandingPattern
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
NEAR, FAR = (900.0, 1500.0), (6000.0, 8000.0)  # m from the radar, which stands 900 m behind the touchdown


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


SETS = {
    "Q a density of .01": published_set(0.01),
    "Q of B diag(.01) B'": read_as(through_acceleration()),
    "Q .01 I": read_as(0.01 * np.eye(4)),
    "Q a density of .3": published_set(0.3),
    "improved set": improved_set(),
}


class Experiment(NamedTuple):
    """Scans of an ensemble."""

    measurements: Measurements
    truth: Any  # (k, 2, runs) north, east
    phase: Any  # (k, runs)
    prior: Gaussian
    distance: Any  # (k, runs) m, from the radar


@lru_cache(maxsize=2)
def experiment(seed: int, runs: int, side: str = "left", turn: int = 90) -> Experiment:
    """The landing pattern as the radar sees it; ``turn`` is the change of course onto final, deg."""
    pattern = LandingPattern(side="right" if side == "right" else "left", turn=math.radians(turn))
    flight = pattern.fly(stream(seed, 0, 0, f"volovyk2022.air.{side}.{turn}"), runs, step=STEP)
    stride = round(SCAN / STEP)
    rows = np.arange(stride, len(flight.time), stride)
    state = flight.state
    truth = np.stack([state.north[rows], state.east[rows]], axis=1)
    north, east = truth[:, 0] - RADAR[0], truth[:, 1] - RADAR[1]
    polar = np.stack([np.hypot(north, east), np.arctan2(east, north)], axis=1)
    noise = stream(seed, 0, 0, f"volovyk2022.radar.{side}.{turn}").standard_normal(polar.shape)
    R = np.broadcast_to(np.diag(SIGMAS**2), (len(rows), 2, 2))
    seen = Measurements(
        ("radar.range", "radar.azimuth"), flight.time[rows], flight.time[rows], polar + SIGMAS[:, None] * noise, R
    )
    start = [np.ravel(value[0])[0] for value in (state.north, state.velocity_north, state.east, state.velocity_east)]
    return Experiment(seen, truth, flight.phase[rows], Gaussian(np.array(start), PRIOR), polar[:, 0])


def imm(name: str) -> InteractingMultipleModel:
    """One of the sets, with the conversion of the paper; the improved one without its bias."""
    conversion = DebiasedPolar if name == "improved set" else ConvertedPolar
    return InteractingMultipleModel(conversion(position=RADAR, height=0.0), SETS[name])


class Squares(NamedTuple):
    """Squared errors (k, runs) of raw plots and filter: m2 of position, rad2 of azimuth; belief in the fast turn."""

    raw: dict[str, Any]
    own: dict[str, Any]
    turning: Any


@lru_cache(maxsize=6)
def squares(name: str, seed: int, runs: int, side: str = "left", turn: int = 90) -> Squares:
    """What a set of models makes of the scans."""
    data = experiment(seed, runs, side, turn)
    shape = data.phase.shape
    position, azimuth, turning = (np.empty(shape, np.float32) for _ in range(3))
    truth_azimuth = np.arctan2(data.truth[:, 1] - RADAR[1], data.truth[:, 0] - RADAR[0])
    for some in chunks(runs, 512):
        for epoch in follow(imm(name), data.measurements.runs(some), data.prior, start=0.0):
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


def gains(name: str, what: str, leg: str, side: str = "left", turn: int = 90) -> Any:
    """Measure of the RMSE of the plots over that of the filter."""

    def measured(seed: int, runs: int) -> Interval:
        found, phase = squares(name, seed, runs, side, turn), experiment(seed, runs, side, turn).phase
        among = np.isin(phase, LEGS[leg])
        return gain(by_run(found.raw[what], among), by_run(found.own[what], among))

    return measured


def grows(name: str, what: str) -> Any:
    """Measure of the RMSE at 6-8 km from the radar over that at the end, 0.9-1.5 km from it."""

    def measured(seed: int, runs: int) -> Interval:
        data, own = experiment(seed, runs), squares(name, seed, runs).own[what]
        glide = data.phase == GLIDE
        far, near = (by_run(own, glide & (data.distance > low) & (data.distance < high)) for low, high in (FAR, NEAR))
        return gain(far, near)

    return measured


def right_belief(leg: str) -> Any:
    """Measure of the mean probability of the fast turn in the turn, or of its contrary elsewhere."""

    def measured(seed: int, runs: int) -> Interval:
        data, turning = experiment(seed, runs), squares("Q a density of .01", seed, runs).turning
        belief = turning if leg == "turn onto final" else 1.0 - turning
        return mean_interval(by_run(belief, np.isin(data.phase, LEGS[leg])))

    return measured


def spared(name: str) -> Any:
    """Measure of the share of runs that are not told of a turn in the 35 s after the glide path begins."""

    def measured(seed: int, runs: int) -> Interval:
        data, turning = experiment(seed, runs), squares(name, seed, runs).turning
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
    for _ in follow(imm("Q a density of .01"), one, data.prior, start=0.0):
        pass
    share = (clock.perf_counter() - began) / len(one.time) / SCAN
    power = 10.0 ** math.ceil(math.log10(share))
    return Interval(power, power, power, 1)


def delays(density: float) -> Any:
    """Measure of the delay of a detector on one Kalman filter over that of the models, both from the turn's begin.

    The detector sums the normalised innovations of five scans and raises one false alarm in a thousand scans; the
    models have detected where the fast turn is the likeliest.
    """

    def measured(seed: int, runs: int) -> Interval:
        runs = min(runs, 4 * SMALLEST)
        data = experiment(seed, runs)
        turning = squares("Q a density of .01", seed, runs).turning
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


ENTRIES = [("left", 90), ("left", 0), ("left", 30), ("left", 60), ("left", 120)]
ENTRIES += [("right", 30), ("right", 60), ("right", 90), ("right", 120)]


def pinned(measure: Any, runs_at_most: int = 40) -> Any:
    """The measure with few runs: entries are many, and what they show is large."""
    return lambda seed, runs: measure(seed, min(runs, runs_at_most))


DENSITY = "Q a density of .01"
OURS = "ours"
CLAIMS: tuple[Claim, ...] = (
    Claim(
        "accuracy_gain",
        "position or azimuth 1.3-1.5 times more accurate than without the filter",
        "conclusions, fig. 4",
        between("1.3", "1.5", good=1),
        tuple(
            Reading(f"{what}, {leg}, {name}", gains(name, what, leg))
            for name, what, leg in (
                (DENSITY, "azimuth", "glide path"),
                (DENSITY, "position", "glide path"),
                ("Q of B diag(.01) B'", "azimuth", "glide path"),
                ("Q of B diag(.01) B'", "position", "glide path"),
                ("Q .01 I", "azimuth", "glide path"),
                ("Q .01 I", "position", "glide path"),
                (DENSITY, "azimuth", "all"),
                (DENSITY, "position", "all"),
                (DENSITY, "position", "base"),
                (DENSITY, "position", "turn onto final"),
                (DENSITY, "position", "final before the glide path"),
            )
        ),
        "times",
        truth="kinematic",
        geometry_by=OURS,
        paper_runs=PAPER_RUNS,
        first_runs=SMALLEST,
        note="The low gain on the glide path comes from the deceleration that no model of the paper has.",
    ),
    Claim(
        "grows_towards_touchdown",
        "accuracy grows towards touchdown",
        "fig. 4, conclusions",
        above(1.0),
        (
            Reading("in metres", grows(DENSITY, "position")),
            Reading("in degrees", grows(DENSITY, "azimuth")),
            Reading("in metres, density .3", grows("Q a density of .3", "position")),
            Reading("in degrees, density .3", grows("Q a density of .3", "azimuth")),
        ),
        "RMSE at 6-8 km over the end",
        truth="kinematic",
        geometry_by=OURS,
        paper_runs=PAPER_RUNS,
        first_runs=SMALLEST,
    ),
    Claim(
        "turn_adaptation",
        "the model probabilities follow the turn correctly",
        "fig. 2",
        above(0.5),
        (
            *(
                Reading(f"mean probability of what is flown, {leg}", right_belief(leg))
                for leg in ("turn onto final", "base", "final before the glide path", "glide path")
            ),
            Reading("runs without a false turn in the 35 s after the glide path begins", spared(DENSITY)),
        ),
        truth="kinematic",
        geometry_by=OURS,
        paper_runs=1,
        first_runs=SMALLEST,
    ),
    Claim(
        "cheap",
        "computing effort is small",
        "conclusions",
        at_most(1.0),
        (Reading("wall time of a scan is below", share_of_the_scan),),
        "of the time between scans",
        truth="kinematic",
        geometry_by=OURS,
        note="No limit is printed; judged by whether it keeps up with the radar, on the machine at hand.",
    ),
    Claim(
        "any_trajectory",
        "works for an entry from any direction",
        "conclusions",
        above(1.0),
        tuple(
            Reading(f"{side}, turn onto final {turn} deg", pinned(gains(DENSITY, "position", "all", side, turn)))
            for side, turn in ENTRIES
        ),
        "times",
        truth="kinematic",
        geometry_by=OURS,
        first_runs=SMALLEST,
        note="Only left turns are modelled.",
    ),
    Claim(
        "less_delay",
        "manoeuvres are detected with less delay",
        "abstract",
        above(1.0),
        (
            Reading("an innovation detector on a Kalman filter, density .01", delays(0.01)),
            Reading("an innovation detector on a Kalman filter, density 3", delays(3.0)),
        ),
        "times less delay",
        truth="kinematic",
        geometry_by=OURS,
        first_runs=SMALLEST,
        note="The paper does not say less than what: window 5 scans, one false alarm in 1000 scans.",
    ),
    Claim(
        "one_model_more",
        "gain with a model of the deceleration and turns to either side",
        "not said",
        None,
        (
            Reading("glide path", gains("improved set", "position", "glide path")),
            Reading("all", gains("improved set", "position", "all")),
            Reading("all, right-hand", gains("improved set", "position", "all", "right")),
            Reading("published set with density .3, all", gains("Q a density of .3", "position", "all")),
        ),
        "times",
        truth="kinematic",
        geometry_by=OURS,
        first_runs=SMALLEST,
        overlooked=True,
    ),
)


def plots(seed: int) -> Iterator[Plot]:
    """Figures 1 to 4."""
    data, found = experiment(seed, SMALLEST), squares(DENSITY, seed, SMALLEST)
    time, north, east = data.measurements.time, data.truth[:, 0, 0] / 1000.0, data.truth[:, 1, 0] / 1000.0
    flown = data.phase[:, 0] < GROUND
    yield Plot(
        "fig. 1",
        "Landing pattern",
        "From the base leg to the touchdown; the radar stands beside the runway.",
        "north, km",
        "east, km",
        (Curve("path", north[flown], east[flown]), Curve("radar", [RADAR[0] / 1e3], [RADAR[1] / 1e3], "dots")),
        equal=True,
    )
    weights, means = [], []
    for epoch in follow(imm(DENSITY), data.measurements.runs(slice(0, 1)), data.prior, start=0.0):
        weights.append(epoch.estimate.weights[:, 0])
        means.append(merge(epoch.estimate).mean[[0, 2], 0] / 1000.0)
    names = ("turn .001 rad/s", "turn .045 rad/s", "straight")
    curves = tuple(
        Curve(name, time[flown], column[flown]) for name, column in zip(names, np.array(weights).T, strict=True)
    )
    yield Plot("fig. 2", "Model probabilities", "One realisation.", "time, s", "probability", curves)
    z, estimate = data.measurements.z[:, :, 0], np.array(means)
    plotted = np.array(RADAR)[:, None] / 1e3 + z[:, 0] / 1e3 * np.stack([np.cos(z[:, 1]), np.sin(z[:, 1])])
    yield Plot(
        "fig. 3",
        "Measurement, truth and estimate",
        "One realisation.",
        "north, km",
        "east, km",
        (
            Curve("measured", plotted[0][flown], plotted[1][flown], "dots"),
            Curve("estimate", estimate[flown, 0], estimate[flown, 1]),
            Curve("truth", north[flown], east[flown], "dashed"),
        ),
        equal=True,
    )
    rows = np.flatnonzero((data.phase < GROUND).all(axis=1))
    curves = tuple(
        Curve(name, time[rows], np.sqrt(part["position"][rows].mean(axis=1)))
        for name, part in (("measurement", found.raw), ("filter", found.own))
    )
    yield Plot("fig. 4", "Error of measurement and filter", f"{SMALLEST} runs.", "time, s", "position RMSE, m", curves)
