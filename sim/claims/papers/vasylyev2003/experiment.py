"""The experiment of Vasylyev 2003: captures of a line, in the double integrator and on JSBSim, and both filters."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import replace
from functools import lru_cache
from typing import Any, NamedTuple

import numpy as np

from autopilot.modes.lateral_navigation import LateralNavigation
from sim.claims.jsbsim_flights import WIND, flights, per_flight
from sim.claims.ledger import DRAWS
from sim.flight.truths.route_capture import NOMINAL, RouteCapture
from sim.randomness import stream
from tracking.gaussian import Gaussian
from tracking.intervals import Interval, gain, mean_interval, paired_difference
from tracking.measurement import LinearMeasurement
from tracking.motion import Transition, constant_velocity
from tracking.reference_path import Line
from tracking.smoothing import smooth_fixed_lag
from tracking.track import Measurements, follow, track
from tracking.trackers.kalman import Kalman
from tracking.trackers.linear_feedback import LinearFeedback
from tracking.trackers.saturated_control import SaturatedControl

SIGMA = 100.0  # m, printed
PERIOD, DENSITY = 4.0, 0.1  # s, m2/s3: ours, of a terminal radar
OUTSIDE, INSIDE = 5000.0, 500.0  # m: starts with and without saturation
BESIDE = 0.2  # of the start, that a flight on JSBSim begins farther or nearer at most
DURATION, SPEED = 300.0, 100.0  # s, m/s
CHARTED = 72.0  # m/s, of the scenarios: wind is not told
NOISES = ((4.0, 0.1), (1.0, 0.1), (10.0, 0.1), (4.0, 0.001), (4.0, 1.0))  # period and density
UNIFORM = (0.03, 0.1, 0.3, 1.0, 3.0, 10.0)  # densities tried for the filter without a law
UNLIMITED = LateralNavigation(NOMINAL.k1, NOMINAL.k2, 1e9, 1e9, 1e9)
GRID = (500.0, 1000.0, 1500.0, 2000.0, 3000.0)  # m, starts around the crossover
CROSS_TRACK = LinearMeasurement(((1.0, 0.0),))
START = np.array([SIGMA, 5.0])  # m, m/s: standard deviations of the prior
LOSS, LOST_FOR = 4.89, 10  # sigmas of the 1 - 1e-6 interval, scans
GATE = 3.0  # sigmas
AHEAD = (20.0, 60.0, 120.0)  # s
DELAYS = (0.0, 4.0, 8.0, 12.0, 20.0)  # s, whole scans
MODEL, GIVEN_GAINS, OWN_GAINS = "model", "vasylyev2003_jsbsim", "vasylyev2003_own_gains"


class UniformOnLine(NamedTuple):
    """Motion across the line without a law."""

    density: float
    channels: tuple[str, ...] = ("cross_track", "cross_track_rate")
    depends_on_state: bool = False

    def transition(self, dt: float, mean: Any) -> Transition:
        """Constant velocity."""
        return Transition(*constant_velocity(dt, self.density))


class Capture(NamedTuple):
    """What is flown and seen, (k, ..., runs), and the law and the line that the filters are told."""

    truth: Any  # (k, 2, runs) deviation, rate
    measurements: Measurements
    prior: Gaussian
    law: Any
    line: Line


def tracker(name: str, data: Capture, density: float = DENSITY, law: Any = None) -> Any:
    """The filter of fig. 1, that of fig. 2, or one that knows no law."""
    if name == "uniform":
        return Kalman(CROSS_TRACK, UniformOnLine(density))
    kind = LinearFeedback if name == "linear" else SaturatedControl
    return kind(data.law if law is None else law, data.line, CROSS_TRACK, density)


def seen(truth: Any, runs: int, generator: np.random.Generator, period: float, law: Any, speed: float) -> Capture:
    """Radar and prior for a truth (k, 2, runs or 1)."""
    prior = Gaussian(truth[0] + START[:, None] * generator.standard_normal((2, runs)), np.diag(START**2))
    z = truth[:, :1] + SIGMA * generator.standard_normal((len(truth), 1, runs))
    time = period * np.arange(len(z))
    measurements = Measurements(("radar.cross_track",), time, time, z, np.full((len(z), 1, 1), SIGMA**2))
    return Capture(np.broadcast_to(truth, (len(z), 2, runs)), measurements, prior, law, Line(speed))


@lru_cache(maxsize=4)
def model_flights(seed: int, runs: int, density: float) -> dict[tuple[float, str], Any]:
    """Deviation and rate (s, 2, runs) at every second in the double integrator, by start (m) and limits."""
    cases = [(OUTSIDE, "limited"), (OUTSIDE, "unlimited")]
    if density == DENSITY:
        cases += [(start, "limited") for start in (*GRID, 8000.0)]
    starts = np.repeat([start for start, _ in cases], runs)
    free = np.repeat([limits == "unlimited" for _, limits in cases], runs)
    limits = ("bank_limit", "cross_track_limit", "cross_track_rate_limit")
    law = replace(NOMINAL, **{name: np.where(free, 1e9, getattr(NOMINAL, name)) for name in limits})
    motion = RouteCapture(
        "double_integrator", law, starts, speed=4.0 * SPEED, duration=DURATION, acceleration_density=density
    )
    state = motion.fly(stream(seed, 0, 0, f"vasylyev2003.{density}.air"), step=1.0).state
    truth = np.stack([state.east, state.velocity_east], axis=1)
    return {case: truth[:, :, i * runs : (i + 1) * runs] for i, case in enumerate(cases)}


@lru_cache(maxsize=8)
def ensemble(seed: int, runs: int, period: float, density: float) -> dict[tuple[float, str], Capture]:
    """Captures with their radar, by start (m) and limits; the period is whole seconds."""
    noise = stream(seed, 0, 0, f"vasylyev2003.{period}.{density}.radar")
    parts = model_flights(seed, runs, density)
    if (period, density) != (PERIOD, DENSITY):
        parts = {case: part for case, part in parts.items() if case[0] == OUTSIDE}
    every = round(period)
    return {case: seen(part[::every], runs, noise, period, NOMINAL, SPEED) for case, part in parts.items()}


def captures(seed: int, count: int, scenario: str, start: float) -> Any:
    """Flights of a bundled scenario from about ``start`` (m), in drawn winds."""
    return flights(
        scenario, seed, count, (("start.cross_track_m", (1.0 - BESIDE) * start, (1.0 + BESIDE) * start), *WIND)
    )


@lru_cache(maxsize=8)
def six_degrees(seed: int, count: int, scenario: str, start: float) -> Capture:
    """Captures that a bundled scenario flies on JSBSim, under its own law, each with all draws of its noise."""
    flown = captures(seed, count, scenario, start)
    rows = np.concatenate([[0], flown[0].rows(PERIOD)])
    truth = np.stack([[one.state.east[rows], one.state.velocity_east[rows]] for one in flown], axis=-1)
    generator = stream(seed, 0, 0, f"{scenario}.{start}")
    runs = np.repeat(truth, DRAWS, axis=-1).swapaxes(0, 1)
    return seen(runs, count * DRAWS, generator, PERIOD, flown[0].law, CHARTED)


def capture(seed: int, runs: int, start: float, truth: str = MODEL) -> Capture:
    """The nominal capture, or one of JSBSim."""
    if truth != MODEL:
        return six_degrees(seed, runs, truth, start)
    return ensemble(seed, runs, PERIOD, DENSITY)[start, "limited"]


def together(captures: Sequence[Capture]) -> Capture:
    """Captures of one law and line side by side."""
    first, *_ = captures
    z = np.concatenate([one.measurements.z for one in captures], axis=2)
    prior = Gaussian(np.concatenate([one.prior.mean for one in captures], axis=1), first.prior.cov)
    truth = np.concatenate([one.truth for one in captures], axis=2)
    return first._replace(truth=truth, measurements=replace(first.measurements, z=z), prior=prior)


def errors(filter_: Any, data: Capture) -> Any:
    """Errors of the deviation (k, runs), m, from the second scan on: the first one only sets the prior."""
    epochs = follow(filter_, data.measurements, data.prior, 0.0)
    return np.array([epoch.estimate.mean[0] - data.truth[epoch.row, 0] for epoch in epochs])[1:]


def squares(filter_: Any, data: Capture) -> Any:
    """Mean squared error of each run (runs,), m2."""
    return (errors(filter_, data) ** 2).mean(axis=0)


@lru_cache(maxsize=24)
def ensemble_squares(name: str, seed: int, runs: int, period: float, density: float) -> dict[tuple[float, str], Any]:
    """Mean squared error of each run by case of the ensemble."""
    data = ensemble(seed, runs, period, density)
    found = squares(tracker(name, both := together(list(data.values())), density), both)
    return dict(zip(data, found.reshape(len(data), runs), strict=True))


@lru_cache(maxsize=24)
def capture_squares(name: str, seed: int, runs: int, start: float, truth: str) -> Any:
    """Mean squared error of each run of one capture, on JSBSim of each flight."""
    if truth == MODEL:
        return ensemble_squares(name, seed, runs, PERIOD, DENSITY)[start, "limited"]
    data = capture(seed, runs, start, truth)
    return per_flight(squares(tracker(name, data), data), runs)


def linear_over_saturated(start: float, period: float = PERIOD, density: float = DENSITY) -> Any:
    """Measure of the RMSE of linear feedback over that of saturated control."""

    def measured(seed: int, runs: int) -> Interval:
        found = [ensemble_squares(name, seed, runs, period, density) for name in ("linear", "saturated")]
        return gain(*(one[start, "limited"] for one in found))

    return measured


def linear_over_saturated_flown(start: float, truth: str) -> Any:
    """The same on JSBSim."""
    return lambda seed, runs: gain(*(capture_squares(n, seed, runs, start, truth) for n in ("linear", "saturated")))


def inverse(measure: Callable[[int, int], Interval]) -> Callable[[int, int], Interval]:
    """Measure of one over a ratio."""

    def measured(seed: int, runs: int) -> Interval:
        value, low, high, count = measure(seed, runs)
        return Interval(1.0 / value, 1.0 / high, 1.0 / low, count)

    return measured


def limits_over_none(period: float, density: float) -> Any:
    """Measure of the RMSE of linear feedback where the limits act over that where the law has none."""

    def measured(seed: int, runs: int) -> Interval:
        found = ensemble_squares("linear", seed, runs, period, density)
        return gain(found[OUTSIDE, "limited"], found[OUTSIDE, "unlimited"])

    return measured


def outside_over_inside(truth: str) -> Any:
    """Measure of the RMSE of linear feedback where the limits act over that from nearby, where they do not."""
    return lambda seed, runs: gain(*(capture_squares("linear", seed, runs, s, truth) for s in (OUTSIDE, INSIDE)))


@lru_cache(maxsize=1)
def largest_differences() -> dict[float, float]:
    """Largest distance between the two undisturbed captures over the radar's sigma, by start."""
    starts = np.array([5000.0, 3000.0, 8000.0])
    paths = [
        RouteCapture("double_integrator", law, starts, speed=400.0, duration=200.0).fly(step=1.0).state.east
        for law in (NOMINAL, UNLIMITED)
    ]
    return dict(zip(starts.tolist(), (np.abs(paths[0] - paths[1]).max(axis=0) / SIGMA).tolist(), strict=True))


def largest_difference(start: float) -> float:
    """Of the captures from one of the starts."""
    return largest_differences()[start]


def difference_flown(scenario: str) -> Any:
    """Measure of the same between the flights on JSBSim and their law without limits, as the double integrator has it.

    No aircraft flies the bank that it asks for.
    """

    def measured(seed: int, count: int) -> Interval:
        flown = captures(seed, count, scenario, OUTSIDE)
        rows = np.concatenate([[0], flown[0].rows(1.0)])[:201]
        beside = np.array([one.state.east[rows] for one in flown]).T
        free = LateralNavigation(flown[0].law.k1, flown[0].law.k2, 1e9, 1e9, 1e9)
        motion = RouteCapture("double_integrator", free, beside[0], speed=4000.0, duration=200.0)
        return mean_interval(np.abs(beside - motion.fly(step=1.0).state.east).max(axis=0) / SIGMA)

    return measured


@lru_cache(maxsize=8)
def lost(name: str, seed: int, runs: int, starts: tuple[float, ...], truth: str) -> dict[float, Any]:
    """(runs,) 1 where the truth stays outside its 1 - 1e-6 interval for ten scans behind a gate, by start.

    On JSBSim the share of the draws of each flight.
    """
    data = together([capture(seed, runs, start, truth) for start in starts])
    filter_, z, R = tracker(name, data), data.measurements.z, data.measurements.R
    state = filter_.begin(Gaussian(data.prior.mean, data.prior.cov[..., None]))
    outside = longest = np.zeros(z.shape[2], int)
    for k in range(1, len(z)):
        state, _ = filter_.step(state, PERIOD, None, None)
        mean, cov = filter_.estimate(state)
        near = np.abs(z[k] - mean[:1]) < GATE * np.sqrt(cov[0, 0] + SIGMA**2)
        state, _ = filter_.step(state, 0.0, np.where(near, z[k], np.nan), R[k][..., None])
        mean, cov = filter_.estimate(state)
        outside = np.where(np.abs(mean[0] - data.truth[k, 0]) > LOSS * np.sqrt(cov[0, 0]), outside + 1, 0)
        longest = np.maximum(longest, outside)
    ends = (longest >= LOST_FOR).astype(float).reshape(len(starts), -1)
    return {start: per_flight(end, runs) for start, end in zip(starts, ends, strict=True)}


FAR = (5000.0, 3000.0, 8000.0)


def lost_more(start: float, truth: str = MODEL) -> Any:
    """Measure of the share of runs that linear feedback loses less that of saturated control."""
    starts = FAR if truth == MODEL else (OUTSIDE,)
    return lambda seed, runs: paired_difference(
        *(lost(name, seed, runs, starts, truth)[start] for name in ("linear", "saturated"))
    )


def lost_share(name: str, start: float) -> Any:
    """Measure of the share of runs that a filter loses."""
    starts = FAR if start in FAR else GRID
    return lambda seed, runs: mean_interval(lost(name, seed, runs, starts, MODEL)[start])


@lru_cache(maxsize=32)
def looked_ahead(seed: int, runs: int, name: str, density: float, truth: str) -> dict[float, Any]:
    """Mean squared error per run, or flight, of what is predicted from every fourth scan, by how far ahead (s)."""
    data = capture(seed, runs, OUTSIDE, truth)
    filter_ = tracker(name, data, density)
    epochs = [e for e in follow(filter_, data.measurements, data.prior, 0.0) if e.row and e.row % 4 == 0]
    rows = np.array([epoch.row for epoch in epochs])
    # all instants at once: a prediction of the mean knows neither their times nor their covariances
    means = np.concatenate([epoch.estimate.mean for epoch in epochs], axis=1)
    state, done, found = filter_.begin(Gaussian(means, np.diag(START**2))), 0.0, {}
    for ahead in AHEAD:
        state, _ = filter_.step(state, ahead - done, None, None)
        done, then = ahead, rows + round(ahead / PERIOD)
        told = filter_.estimate(state).mean[0].reshape(len(rows), -1)
        inside = then < len(data.truth)
        found[ahead] = per_flight(((told[inside] - data.truth[then[inside], 0]) ** 2).mean(axis=0), runs)
    return found


def better_ahead(ahead: float, truth: str = MODEL) -> Any:
    """Measure of the look-ahead RMSE of the best filter without a law over that of saturated control."""

    def measured(seed: int, runs: int) -> Interval:
        free = min((looked_ahead(seed, runs, "uniform", q, truth)[ahead] for q in UNIFORM), key=np.mean)
        return gain(free, looked_ahead(seed, runs, "saturated", DENSITY, truth)[ahead])

    return measured


WRONG = {
    "z_max halved": {"cross_track_limit": 625.0},
    "z_max doubled": {"cross_track_limit": 2500.0, "cross_track_rate_limit": 120.0},
    "both gains x 0.7": {"k1": 0.7 * NOMINAL.k1, "k2": 0.7 * NOMINAL.k2},
    "k1 x 1.3": {"k1": 1.3 * NOMINAL.k1},
    "k2 x 0.7": {"k2": 0.7 * NOMINAL.k2},
    "bank limit 15 deg": {"bank_limit": math.radians(15.0)},
}


@lru_cache(maxsize=4)
def told_wrong(seed: int, runs: int) -> dict[str, Any]:
    """Mean squared error of each run of saturated control by the law that it is told; "" is the right one."""
    laws = {"": NOMINAL} | {name: replace(NOMINAL, **changes) for name, changes in WRONG.items()}
    fields = ("k1", "k2", "bank_limit", "cross_track_limit", "cross_track_rate_limit")
    side_by_side = LateralNavigation(*(np.repeat([getattr(law, f) for law in laws.values()], runs) for f in fields))
    data = together([capture(seed, runs, OUTSIDE)] * len(laws))
    found = squares(tracker("saturated", data, law=side_by_side), data)
    return dict(zip(laws, found.reshape(len(laws), runs), strict=True))


def told(name: str) -> Any:
    """Measure of the RMSE of saturated control that is told another law over that told the right one."""
    return lambda seed, runs: gain(told_wrong(seed, runs)[name], told_wrong(seed, runs)[""])


def crossover(seed: int, runs: int) -> Interval:
    """Start of the capture (m) from which on both filters are equally good, between the distances of a grid."""
    both = [ensemble_squares(name, seed, runs, PERIOD, DENSITY) for name in ("linear", "saturated")]
    found = [np.log(gain(*(one[start, "limited"] for one in both))[:3]) for start in GRID]
    value, high, low = (float(np.interp(0.0, column, GRID)) for column in np.array(found).T)
    return Interval(value, low, high, runs)


@lru_cache(maxsize=1)
def delayed(seed: int, runs: int) -> dict[float, Any]:
    """Mean squared error of each run of the best filter without a law, by how long one waits for it (s)."""
    data = capture(seed, runs, OUTSIDE)
    found: dict[float, Any] = {}
    for density in UNIFORM:
        filter_ = tracker("uniform", data, density)
        record = track(filter_, data.measurements, data.prior, 0.0)
        for delay in DELAYS:
            mean = smooth_fixed_lag(record, filter_.motion, round(delay / PERIOD)).mean
            each = ((mean[1:, 0] - data.truth[1:, 0]) ** 2).mean(axis=0)
            found[delay] = min(found.get(delay, each), each, key=np.mean)
    return found


def after_delay(delay: float) -> Any:
    """Measure of the RMSE of that filter over the one of saturated control at once."""
    return lambda seed, runs: gain(delayed(seed, runs)[delay], capture_squares("saturated", seed, runs, OUTSIDE, MODEL))
