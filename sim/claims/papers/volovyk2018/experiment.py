"""The experiments of Volovyk 2018: the elevation filter on its own model, on the paper's level leg and on JSBSim's."""

from __future__ import annotations

import math
from collections.abc import Callable
from functools import lru_cache
from typing import Any, NamedTuple

import numpy as np

from sim.claims.angle_channel import DEGREE, INCREMENT, MEASURED, SIGMA, VARIANCE, drawn, record
from sim.claims.jsbsim_flights import WIND, flights, per_flight, root_mean, side_by_side
from sim.randomness import stream
from tracking.gaussian import Gaussian
from tracking.intervals import Interval, gain, mean_interval, rmse
from tracking.track import follow
from tracking.trackers.elevation import (
    PERIOD,
    Elevation,
    Model,
    band_coverage,
    elevation_of,
    gain_schedule,
    increments,
    manoeuvre_variance,
    stored_gain,
)

SAMPLE, BAND, CONFIDENCE = 50, 0.2, 0.95  # runs, printed
STEPS, SETTLED = 810, 200  # of the experiment on the model: 20 s
LEG, LEG_SETTLED = 3239, 400  # of the level leg: 80 s
SPACING = 8  # steps between the epochs of the level leg at which errors are kept
SPREAD = np.array([math.sqrt(50e-4), 0.0122, 0.001]) * DEGREE  # of the prior
SECOND = np.diag(SPREAD[:2] ** 2)
START = Gaussian(np.array([0.7, 0.0122]) * DEGREE, SECOND)  # ours: the paper does not print it
RECIPE = math.radians(math.sqrt(2.42e-7)) * PERIOD  # rad/s per step: the manoeuvre noise of the recipe at 5 km
PUBLISHED = Elevation(MEASURED)
UNIFORM, UNIFORM_WIDE = "uniformly accelerated", "uniformly accelerated, wide prior"  # Singer's limit T / tau -> 0
FOR_EVER = 1e6  # s: the acceleration loses 8e-5 of itself over the leg
UNIFORMLY = Elevation(MEASURED, 3, acceleration_density=0.0, correlation_time=FOR_EVER)
FILTERS = {
    "as published": PUBLISHED,
    "Q as an acceleration": Elevation(MEASURED, rate_increment=0.01 * PERIOD * DEGREE, held=True),
    "tuned": Elevation(MEASURED, rate_increment=math.sqrt(1e-7) * DEGREE),
    "manoeuvre noise of the recipe": Elevation(MEASURED, rate_increment=RECIPE, held=True),
    "no manoeuvre noise": Elevation(MEASURED, rate_increment=0.0),
    "first order, tuned": Elevation(MEASURED, 1, angle_increment=math.sqrt(1e-5) * DEGREE),
    "first order, Q 1e-4": Elevation(MEASURED, 1, angle_increment=INCREMENT * DEGREE),
    "third order, tuned": Elevation(MEASURED, 3),
    UNIFORM: UNIFORMLY,
    UNIFORM_WIDE: UNIFORMLY,
}
WIDER = {UNIFORM_WIDE: 10.0}  # times the spread of the prior
PAPER, JSBSIM = "paper", "mls_profile"
STARTS = (("start.distance_m", 14e3, 16e3), *WIND)  # ours: of the flights on JSBSim
LONGEST_LEG = 150.0  # s: against the wind


class Legs(NamedTuple):
    """Level legs: angle (rad) and distance (m) at every step (steps, legs), and the rates (rad/s) before the first.

    NaN is behind the end of a leg.
    """

    angle: Any
    distance: Any
    rate: Any


@lru_cache(maxsize=1)
def printed_leg() -> Legs:
    """The level leg as printed, which has no process noise."""
    time = PERIOD * np.arange(1, LEG + 1)
    distance = 15e3 - 150.0 * time + 0.3125 * time**2
    motion = elevation_of(distance, 200.0, -150.0 + 0.625 * time, 0.0, 0.625)
    return Legs(motion.angle[:, None], distance[:, None], motion.rate[:1])


@lru_cache(maxsize=2)
def flown_legs(seed: int, count: int) -> Legs:
    """Level legs as JSBSim flies them, in drawn winds."""
    found = []
    for flight in flights(JSBSIM, seed, count, STARTS, ("until_s", LONGEST_LEG)):
        level = flight.flight.time[flight.during("final")][-1]
        found.append(np.stack(flight.elevation(PERIOD * np.arange(1, math.floor(level / PERIOD))), axis=1))
    angle, distance = side_by_side(found).swapaxes(0, 1)
    return Legs(angle, distance, (angle[1] - angle[0]) / PERIOD)


def legs(truth: str, seed: int, runs: int) -> tuple[Legs, int]:
    """Level legs of a row and the draws of noise on each: all on the printed one, or a sample on every flight."""
    return (printed_leg(), runs) if truth == PAPER else (flown_legs(seed, runs), SAMPLE)


class Followed(NamedTuple):
    """Errors (epochs, runs), deg, and the variance that the filter believes (epochs,), deg^2."""

    errors: Any
    believed: Any


def followed(tracker: Elevation, truth: Any, measurements: Any, prior: Gaussian) -> Followed:
    """A filter at every step."""
    errors, believed = [], []
    for epoch in follow(tracker, measurements, prior, start=0.0):
        errors.append(epoch.estimate.mean[0] - truth[epoch.row])
        believed.append(np.ravel(epoch.estimate.cov[0, 0])[0])
    return Followed(np.array(errors) / DEGREE, np.array(believed) / DEGREE**2)


@lru_cache(maxsize=2)
def schedule(steps: int) -> tuple[Any, Any, Any]:
    """Transitions (3, 3, F, 1), gains (steps, 3, 1, F, 1) and variances (steps, F) of all filters, side by side."""
    A, Q, P = (np.zeros((3, 3, len(FILTERS))) for _ in range(3))
    for place, (name, tracker) in enumerate(FILTERS.items()):
        n = tracker.order
        A[:n, :n, place], Q[:n, :n, place] = tracker.transition(PERIOD)
        P[:n, :n, place] = np.diag((WIDER.get(name, 1.0) * SPREAD[:n]) ** 2)
    gains, covariances = gain_schedule(P, Model(A, Q, np.eye(1, 3), np.array([[SIGMA**2]])), steps)
    return A[..., None], gains[..., None], covariances[:, 0, 0] / DEGREE**2


@lru_cache(maxsize=4)
def on_the_leg(seed: int, runs: int, truth: str = PAPER) -> dict[str, Followed]:
    """All filters on level legs, at a part of the steps: realisation 4, which is realisation 1 to the last bit."""
    leg, draws = legs(truth, seed, runs)
    angle, rate = (np.repeat(part, draws, axis=-1) for part in (leg.angle, leg.rate))
    steps = len(angle)
    A, gains, believed = schedule(steps)
    z = angle + SIGMA * stream(seed, 0, 0, f"volovyk2018.leg.{truth}").standard_normal(angle.shape)
    x = np.zeros((3, len(FILTERS), angle.shape[1]))
    x[0] = angle[0] - PERIOD * rate
    x[1] = rate * np.array([tracker.order > 1 for tracker in FILTERS.values()])[:, None]
    C, kept, errors = np.eye(1, 3)[..., None, None], range(SPACING - 1, steps, SPACING), []
    for k in range(steps):
        x = stored_gain(x, z[k][None, None], gains[k], A, C)
        if k in kept:
            errors.append((x[0] - angle[k]) / DEGREE)
    found = np.array(errors)
    return {name: Followed(found[:, i], believed[kept, i]) for i, name in enumerate(FILTERS)}


def mean_squares(name: str, truth: str, seed: int, runs: int, distance: float = 0.0, shares: bool = False) -> Any:
    """Mean squared errors (runs or flights,) from the settled filter on down to a distance (m).

    ``shares`` = over the variance that the filter believes, otherwise deg^2.
    """
    leg, draws = legs(truth, seed, runs)
    found = on_the_leg(seed, runs, truth)[name]
    chosen = leg.distance[SPACING - 1 :: SPACING] > distance  # never of a NaN
    chosen[: LEG_SETTLED // SPACING] = False
    square = found.errors**2 / (found.believed[:, None] if shares else 1.0)
    return per_flight(np.nanmean(np.where(np.repeat(chosen, draws, axis=1), square, np.nan), axis=0), runs)


def over_theory(name: str, truth: str = PAPER, distance: float = 0.0) -> Any:
    """Measure of the RMS error on the level leg over the deviation that the filter believes."""

    def measured(seed: int, runs: int) -> Interval:
        return root_mean(mean_squares(name, truth, seed, runs, distance, shares=True), runs)

    return measured


def worse(first: str, second: str, truth: str = PAPER) -> Any:
    """Measure of the RMS error of one filter over that of another on the level leg."""

    def measured(seed: int, runs: int) -> Interval:
        return gain(*(mean_squares(name, truth, seed, runs) for name in (first, second)))

    return measured


def bias(name: str) -> Any:
    """Measure of the mean error at the end of the printed level leg over the random one."""

    def measured(seed: int, runs: int) -> Interval:
        errors = on_the_leg(seed, runs)[name].errors[-1]
        return mean_interval(errors / float(errors.std(ddof=1)))

    return measured


@lru_cache(maxsize=2)
def on_the_model(seed: int, runs: int) -> Followed:
    """The published filter on truths of its own model."""
    truth, measurements = drawn(stream(seed, 0, 0, "volovyk2018.model"), runs, STEPS, START)
    return followed(PUBLISHED, truth, measurements, START)


def inside(deviation: bool, whole: bool = False, truth: str = "model") -> Any:
    """Measure of the share of steps, or of samples of fifty runs as a whole, within the band."""

    def measured(seed: int, runs: int) -> Interval:
        if truth == "model":
            errors, believed = on_the_model(seed, runs)
        else:
            errors, believed = on_the_leg(seed, runs, truth)["as published"]
        square = (errors.reshape(len(errors), -1, SAMPLE) ** 2).mean(axis=2) / believed[:, None]
        within = np.abs((np.sqrt(square) if deviation else square) - 1.0) < BAND
        flying = np.isfinite(square)
        share = (within & flying).sum(axis=0) / flying.sum(axis=0)
        return mean_interval(share == 1.0 if whole else share)._replace(runs=runs)

    return measured


def model_over_theory(seed: int, runs: int) -> Interval:
    """RMS error on the model's own truths over the deviation that the filter believes."""
    errors, believed = on_the_model(seed, runs)
    return rmse((errors[SETTLED:] ** 2 / believed[SETTLED:, None]).mean(axis=0))


def fewest(half_width: Callable[[int], float]) -> float:
    """Smallest number of runs with which a band of 20 % is kept with the printed confidence."""
    return float(next(runs for runs in range(2, 1000) if half_width(runs) <= BAND))


def about_theory(runs: int) -> float:
    """Half-width of the band about the theoretical deviation that holds the sample's with the printed confidence."""
    return BAND if band_coverage(BAND, runs) >= CONFIDENCE else math.inf


@lru_cache(maxsize=1)
def settled_gain() -> tuple[float, float]:
    """The gain that the published filter comes to."""
    A, Q = increments(2, PERIOD, PERIOD, INCREMENT)
    model = Model(A, Q, np.array([[1.0, 0.0]]), np.array([[VARIANCE]]))
    gains, _ = gain_schedule(SECOND / DEGREE**2, model, 1000)
    return float(gains[-1, 0, 0]), float(gains[-1, 1, 0])


class Stored(NamedTuple):
    """What happens to the filters with a stored and with a computed gain."""

    constant: bool = False  # the settled gain from the start; else the schedule
    noise: float = 1.0  # factor of the variance, which only the computed gain is told
    missed: float = 0.0  # share of the measurements that are missed, independently


@lru_cache(maxsize=8)
def stored_and_full(seed: int, runs: int, case: Stored) -> tuple[Any, Any]:
    """Errors (STEPS, runs), deg, with a stored gain and with the full filter, which is told what happens on line."""
    generator = stream(seed, 0, 0, "volovyk2018.stored")
    truth, seen = drawn(generator, runs, STEPS, START)
    z = truth[:, None] + math.sqrt(case.noise) * (seen.z - truth[:, None])
    z = np.where(generator.random(z.shape) < case.missed, np.nan, z)
    told = followed(PUBLISHED, truth, record(z, case.noise * VARIANCE), START)
    if case.constant or case.missed:
        constant = Elevation(MEASURED, gain=settled_gain())
        return followed(constant, truth, record(z), START).errors, told.errors
    if case == Stored():
        A, Q = PUBLISHED.transition(PERIOD)
        gains, _ = gain_schedule(SECOND, Model(A, Q, np.eye(1, 2), np.array([[SIGMA**2]])), STEPS)
        x, found = START.mean[:, None], []
        for k in range(STEPS):
            x = stored_gain(x, z[k], gains[k][..., None], A[..., None], np.eye(1, 2)[..., None])
            found.append((x[0] - truth[k]) / DEGREE)
        return np.array(found), told.errors
    return followed(PUBLISHED, truth, record(z), START).errors, told.errors


def stored(case: Stored, chosen: slice) -> Any:
    """Measure of the RMS error of a filter with stored gains over the full one."""

    def measured(seed: int, runs: int) -> Interval:
        found = gain(*((errors[chosen] ** 2).mean(axis=0) for errors in stored_and_full(seed, runs, case)))
        value, low, high = (round(end, 9) for end in (found.value, found.low, found.high))
        return Interval(value, low, high, runs)  # what rounding does is not worse

    return measured


def manoeuvre_shares() -> float:
    """The printed formula over the variance of its own mixture, summed over a fine grid."""
    largest, rare, none = 1.962, 0.1, 0.5
    grid = (np.arange(100_000) + 0.5) / 100_000 * 2.0 * largest - largest
    summed = 2.0 * rare * largest**2 + (1.0 - none - 2.0 * rare) * float((grid**2).mean())
    return manoeuvre_variance(largest, rare, none) / summed
