"""Volovyk, Havrilov, Mozgovoj 2018: the Kalman filter of the elevation channel and its four realisations."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator
from functools import lru_cache
from typing import Any

import numpy as np

from sim.claims.angle import DEGREE, INCREMENT, MEASURED, VARIANCE, drawn, record
from sim.claims.ledger import Claim, Reading, counted
from sim.claims.manoeuvre import noise_claim
from sim.claims.plots import Curve, Plot
from sim.claims.verdict import above, at_most, between, number
from sim.randomness import stream
from sim.truths.mls_profile import MlsProfile
from tracking.gaussian import Gaussian
from tracking.intervals import Interval, gain, mean_interval, rmse
from tracking.operations import memory, saving
from tracking.track import follow
from tracking.trackers.elevation import (
    PERIOD,
    Elevation,
    Model,
    band_coverage,
    elevation_of,
    gain_schedule,
    increments,
    interval_half_width,
    manoeuvre_variance,
)

SAMPLE, BAND, CONFIDENCE = 50, 0.2, 0.95  # runs, printed
STEPS, SETTLED = 810, 200  # of the experiment on the model: 20 s
LEG, LEG_SETTLED = 3239, 400  # of the level leg: 80 s
SPACING = 8  # steps between the epochs of the level leg at which errors are kept
SECOND = np.diag([50e-4, 0.0122**2]) * DEGREE**2
START = Gaussian(np.array([0.7, 0.0122]) * DEGREE, SECOND)  # ours: the paper does not print it
RECIPE = math.radians(math.sqrt(2.42e-7)) * PERIOD  # rad/s per step: the manoeuvre noise of the recipe at 5 km
PUBLISHED = Elevation(MEASURED)
FILTERS = {
    "as published": PUBLISHED,
    "Q as an acceleration": Elevation(MEASURED, rate_increment=0.01 * PERIOD * DEGREE, held=True),
    "tuned": Elevation(MEASURED, rate_increment=math.sqrt(1e-7) * DEGREE),
    "manoeuvre noise of the recipe": Elevation(MEASURED, rate_increment=RECIPE, held=True),
    "no manoeuvre noise": Elevation(MEASURED, rate_increment=0.0),
    "first order, tuned": Elevation(MEASURED, 1, angle_increment=math.sqrt(1e-5) * DEGREE),
    "first order, Q 1e-4": Elevation(MEASURED, 1, angle_increment=INCREMENT * DEGREE),
}


def followed(tracker: Elevation, truth: Any, measurements: Any, prior: Gaussian) -> tuple[Any, Any]:
    """Errors (steps, runs), deg, and the variance that the filter believes (steps,), deg^2."""
    errors, believed = [], []
    for epoch in follow(tracker, measurements, prior, start=0.0):
        errors.append(epoch.estimate.mean[0] - truth[epoch.row])
        believed.append(np.ravel(epoch.estimate.cov[0, 0])[0])
    return np.array(errors) / DEGREE, np.array(believed) / DEGREE**2


@lru_cache(maxsize=2)
def on_the_model(seed: int, runs: int) -> tuple[Any, Any]:
    """The published filter on truths of its own model."""
    truth, measurements = drawn(stream(seed, 0, 0, "volovyk2018.model"), runs, STEPS, START)
    return followed(PUBLISHED, truth, measurements, START)


def inside(deviation: bool, whole: bool = False) -> Any:
    """Measure of the share of steps, or of samples of fifty runs as a whole, within the band."""

    def measured(seed: int, runs: int) -> Interval:
        errors, believed = on_the_model(seed, runs)
        square = (errors.reshape(STEPS, -1, SAMPLE) ** 2).mean(axis=2) / believed[:, None]
        within = np.abs((np.sqrt(square) if deviation else square) - 1.0) < BAND
        return mean_interval(within.all(axis=0) if whole else within.mean(axis=0))._replace(runs=runs)

    return measured


def fewest(half_width: Callable[[int], float]) -> float:
    """Smallest number of runs with which a band of 20 % is kept with the printed confidence."""
    return float(next(runs for runs in range(2, 1000) if half_width(runs) <= BAND))


def about_theory(runs: int) -> float:
    """Half-width of the band about the theoretical deviation that holds the sample's with the printed confidence."""
    return BAND if band_coverage(BAND, runs) >= CONFIDENCE else math.inf


@lru_cache(maxsize=1)
def level_leg() -> tuple[Any, Any]:
    """Angle and rate, rad, at every step of the level leg, which has no process noise."""
    time = PERIOD * np.arange(1, LEG + 1)
    motion = elevation_of(15e3 - 150.0 * time + 0.3125 * time**2, 200.0, -150.0 + 0.625 * time, 0.0, 0.625)
    return motion.angle, motion.rate


@lru_cache(maxsize=16)
def on_the_leg(name: str, seed: int, runs: int) -> tuple[Any, Any]:
    """One of the filters on the real level leg: errors (deg) at a part of the steps, and the variance believed."""
    angle, _ = level_leg()
    tracker = FILTERS[name]
    noise = stream(seed, 0, 0, "volovyk2018.leg").standard_normal((LEG, 1, runs))
    measurements = record(angle[:, None, None] + math.sqrt(VARIANCE) * DEGREE * noise)
    prior = Gaussian(np.array([0.7639, 0.00764])[: tracker.order] * DEGREE, SECOND[: tracker.order, : tracker.order])
    errors, believed = [], []
    for epoch in follow(tracker, measurements, prior, start=0.0):
        if epoch.row % SPACING == SPACING - 1 or epoch.row == LEG - 1:
            errors.append(epoch.estimate.mean[0] - angle[epoch.row])
            believed.append(np.ravel(epoch.estimate.cov[0, 0])[0])
    return np.array(errors) / DEGREE, np.array(believed) / DEGREE**2


FIRST = LEG_SETTLED // SPACING
HALFWAY = 1690 // SPACING  # 10 km


def over_theory(name: str, chosen: slice = slice(FIRST, None)) -> Any:
    """Measure of the RMS error on the level leg over the deviation that the filter believes."""

    def measured(seed: int, runs: int) -> Interval:
        errors, believed = on_the_leg(name, seed, runs)
        return rmse((errors[chosen] ** 2 / believed[chosen, None]).mean(axis=0))

    return measured


def model_over_theory(seed: int, runs: int) -> Interval:
    """RMS error on the model's own truths over the deviation that the filter believes."""
    errors, believed = on_the_model(seed, runs)
    return rmse((errors[SETTLED:] ** 2 / believed[SETTLED:, None]).mean(axis=0))


def worse(first: str, second: str) -> Any:
    """Measure of the RMS error of one filter over that of another on the level leg."""

    def measured(seed: int, runs: int) -> Interval:
        one, other = (on_the_leg(name, seed, runs)[0][FIRST:] for name in (first, second))
        return gain((one**2).mean(axis=0), (other**2).mean(axis=0))

    return measured


def bias(name: str) -> Any:
    """Measure of the mean error at 5 km over the random one."""

    def measured(seed: int, runs: int) -> Interval:
        errors, _ = on_the_leg(name, seed, runs)
        spread = float(errors[-1].std(ddof=1))
        return mean_interval(errors[-1] / spread)

    return measured


@lru_cache(maxsize=4)
def settled_gain() -> tuple[float, float]:
    """The gain that the published filter comes to."""
    A, Q = increments(2, PERIOD, PERIOD, INCREMENT)
    model = Model(A, Q, np.array([[1.0, 0.0]]), np.array([[VARIANCE]]))
    gains, _ = gain_schedule(SECOND / DEGREE**2, model, 1000)
    return float(gains[-1, 0, 0]), float(gains[-1, 1, 0])


def stored(tracker: Callable[[], Elevation], factor: float, chosen: slice) -> Any:
    """Measure of the RMS error of a filter with stored gains over the full one, which is told the noise on line."""

    def measured(seed: int, runs: int) -> Interval:
        truth, seen = drawn(stream(seed, 0, 0, "volovyk2018.stored"), runs, STEPS, START)
        z = truth[:, None] + math.sqrt(factor) * (seen.z - truth[:, None])
        theirs, _ = followed(tracker(), truth, record(z), START)
        ours, _ = followed(PUBLISHED, truth, record(z, factor * VARIANCE), START)
        return gain((theirs[chosen] ** 2).mean(axis=0), (ours[chosen] ** 2).mean(axis=0))

    return measured


def initial(derivative: int) -> Callable[[], float]:
    """The angle or a derivative of it, in degrees, where the level leg begins."""
    return lambda: float(np.degrees(elevation_of(15e3, 200.0, -150.0, 0.0, 0.625)[derivative]))


def manoeuvre_shares() -> float:
    """The printed formula over the variance of its own mixture, summed over a fine grid."""
    largest, rare, none = 1.962, 0.1, 0.5
    grid = (np.arange(100_000) + 0.5) / 100_000 * 2.0 * largest - largest
    summed = 2.0 * rare * largest**2 + (1.0 - none - 2.0 * rare) * float((grid**2).mean())
    return manoeuvre_variance(largest, rare, none) / summed


def constant() -> Elevation:
    """The filter with its settled gain from the start."""
    return Elevation(MEASURED, gain=settled_gain())


FAR = slice(FIRST, HALFWAY)
WHOLE = slice(SETTLED, None)
CLAIMS: tuple[Claim, ...] = (
    Claim(
        "multiplications_saved",
        "a stored gain saves 82 per cent of the multiplications",
        "eq. (24)",
        number("82", good=1),
        (Reading("counted, matrices taken as dense", counted(lambda: 100.0 * saving(2, 1)[0])),),
        "%",
    ),
    Claim(
        "additions_saved",
        "a stored gain saves 80 per cent of the additions",
        "eq. (25)",
        number("80", good=1),
        (Reading("counted, matrices taken as dense", counted(lambda: 100.0 * saving(2, 1)[1])),),
        "%",
    ),
    Claim(
        "band",
        "the Monte-Carlo accuracy stays within 20 per cent of the theoretical one with 50 runs",
        "fig. 4",
        number("0.95", good=1),
        (
            Reading("steps inside, on the deviation", inside(True)),
            Reading("steps inside, on the variance", inside(False)),
            Reading("samples inside at every step", inside(True, whole=True)),
        ),
        "of the steps",
        paper_runs=SAMPLE,
        first_runs=4000,
        note="The sentence speaks of the variance, the formula of its root.",
    ),
    Claim(
        "runs_needed",
        "50 runs suffice for 20 per cent at 0.95",
        "confidence interval",
        at_most(50),
        (
            Reading("band about the theory, as in fig. 4", counted(lambda: fewest(about_theory))),
            Reading("interval about the sample", counted(lambda: fewest(lambda n: interval_half_width(CONFIDENCE, n)))),
        ),
        "runs",
    ),
    Claim(
        "first_order_dynamic_error",
        "a first-order filter has considerable dynamic errors",
        "introduction of the model",
        above(1.0),
        (
            Reading("RMS of both tuned", worse("first order, tuned", "tuned")),
            Reading("first tuned, second as published", worse("first order, tuned", "as published")),
            Reading("both with Q 1e-4", worse("first order, Q 1e-4", "as published")),
        ),
        "times",
        truth="kinematic",
        geometry_by="paper",
    ),
    Claim(
        "stored_gain_convergence",
        "with stored gains convergence is no longer guaranteed",
        "variant 4",
        above(1.0),
        (
            Reading("the schedule, as modelled", stored(lambda: PUBLISHED, 1.0, slice(None))),
            Reading("a constant gain, first half second", stored(constant, 1.0, slice(0, 20))),
            Reading("the schedule, noise 25 times larger", stored(lambda: PUBLISHED, 25.0, WHOLE)),
        ),
        "times",
        note="The gain does not look at the data: only what is told on line can make a difference.",
    ),
    Claim(
        "far_no_manoeuvre_noise",
        "far out the manoeuvre noise may be neglected",
        "conclusions",
        between("0.8", "1.2"),
        (
            Reading("none, 15 to 10 km", over_theory("no manoeuvre noise", FAR)),
            Reading("that of the recipe, 15 to 10 km", over_theory("manoeuvre noise of the recipe", FAR)),
        ),
        "RMS over theory",
        truth="kinematic",
        geometry_by="paper",
        note="Judged by the paper's own 20 per cent about the theoretical deviation.",
    ),
    Claim(
        "online_accuracy",
        "the covariance serves as a monitor of the current accuracy",
        "introduction, conclusions",
        between("0.8", "1.2"),
        (
            Reading("as published, truth of the model", model_over_theory),
            Reading("as published, real level leg", over_theory("as published")),
            Reading("Q as an acceleration, real level leg", over_theory("Q as an acceleration")),
            Reading("Q of the recipe, real level leg", over_theory("manoeuvre noise of the recipe")),
        ),
        "RMS over theory",
        truth="kinematic",
        geometry_by="paper",
        note="The covariance knows nothing of the data: it is as good as its Q.",
    ),
    Claim(
        "memory",
        "the volume of memory decides between the realisations beside the operations",
        "resources of the variants",
        above(1.0),
        (
            Reading("gains of the whole leg", counted(lambda: sum(memory(4, 2, 1, LEG)) / sum(memory(1, 2, 1)))),
            Reading("gains until they settle", counted(lambda: sum(memory(4, 2, 1, 200)) / sum(memory(1, 2, 1)))),
        ),
        "words of variant 4 over variant 1",
    ),
    Claim(
        "second_order_suffices",
        "a second-order model suffices while half the angular acceleration over a period is small",
        "eq. (3)",
        between("0.8", "1.2"),
        (
            Reading("as published", over_theory("as published")),
            Reading("Q of the recipe", over_theory("manoeuvre noise of the recipe")),
        ),
        "RMS over theory",
        truth="kinematic",
        geometry_by="paper",
        note="The condition holds by five orders in both cases: the memory of the filter counts, not the period.",
    ),
    Claim(
        "initial_values", "0.7 deg where the level leg begins", "fig. 2", number("0.7"),
        (Reading("from the printed geometry", counted(initial(0))),), "deg", "kinematic", "paper",
    ),
    Claim(
        "initial_values_rate", "0.0122 deg/s where the level leg begins", "fig. 2", number("0.0122"),
        (Reading("from the printed geometry", counted(initial(1))),), "deg/s", "kinematic", "paper",
        note="0.0122 is 0.7 deg in radians.",
    ),
    Claim(
        "initial_values_acceleration", "0.0002 deg/s^2 where the level leg begins", "fig. 2", number("0.0002"),
        (Reading("from the printed geometry", counted(initial(2))),), "deg/s^2", "kinematic", "paper",
    ),
    noise_claim("manoeuvre_noise", "process noise 3.6e-8 (deg/s^2)^2 at 10 km", "experiment", "3.6e-8", 10000.0),
    noise_claim("manoeuvre_noise_5_km", "process noise 7e-4 (deg/s^2)^2 at 5 km", "experiment", "7e-4", 5000.0),
    noise_claim("manoeuvre_noise_1_km", "process noise 11.5e-4 at 1 km", "experiment", "11.5e-4", 1000.0, 40.0),
    Claim(
        "manoeuvre_variance",
        "variance of the manoeuvre acceleration from its largest value and two probabilities",
        "Singer",
        number("1.00"),
        (Reading("formula over the mixture summed", counted(manoeuvre_shares)),),
        "times",
    ),
    Claim(
        "lag_at_five_kilometres",
        "lag at the end of the level leg, over the random error beside it",
        "not said",
        None,
        tuple(Reading(n, bias(n)) for n in ("manoeuvre noise of the recipe", "as published", "first order, tuned")),
        "times",
        truth="kinematic",
        geometry_by="paper",
        overlooked=True,
    ),
)  # fmt: skip


def plots(seed: int) -> Iterator[Plot]:
    """Figures 1, 2, 4 and 5."""
    state = MlsProfile().fly().state
    distance = -state.north
    yield Plot(
        "fig. 1",
        "Idealised landing profile",
        "Level deceleration, glide path, flare.",
        "distance to the beacon, km",
        "height, m",
        (Curve("path", distance / 1000.0, state.height),),
    )
    motion = elevation_of(distance, state.height, -state.velocity_north, state.velocity_up)
    near = distance > 300.0
    angle, rate = np.degrees(motion.angle), np.degrees(motion.rate)
    curves = []
    quantities = (("elevation, deg", angle), ("rate, deg/s", rate), ("acceleration", np.gradient(rate, state.time)))
    for name, values in quantities:
        largest = float(np.abs(values[near]).max())
        curves.append(Curve(f"{name}, largest {largest:.3g}", state.time[near], values[near] / largest))
    yield Plot(
        "fig. 2",
        "Elevation and its derivatives over the profile",
        "Each divided by its largest value; the acceleration in deg/s^2.",
        "time, s",
        "share of the largest",
        tuple(curves),
    )
    errors, believed = on_the_model(seed, SAMPLE)
    time = PERIOD * np.arange(1, STEPS + 1)
    yield Plot(
        "fig. 4",
        "Theoretical and Monte-Carlo variance",
        "One sample of 50 runs; the band is 20 % on the deviation.",
        "time, s",
        "variance, deg^2",
        (
            Curve("50 runs", time, (errors**2).mean(axis=1)),
            Curve("theory", time, believed),
            Curve("band", time, believed * (1.0 - BAND) ** 2, "dashed"),
            Curve("band", time, believed * (1.0 + BAND) ** 2, "dashed"),
        ),
        logarithmic=True,
    )
    truth, _ = level_leg()
    noise = stream(seed, 0, 0, "volovyk2018.leg").standard_normal((LEG, 1, 1))
    measurements = record(truth[:, None, None] + math.sqrt(VARIANCE) * DEGREE * noise)
    found, _ = followed(PUBLISHED, truth[:, None], measurements, START)
    time = measurements.time
    yield Plot(
        "fig. 5",
        "Measured and filtered elevation",
        "One realisation on the level leg.",
        "time, s",
        "elevation, deg",
        (
            Curve("measured", time, measurements.z[:, 0, 0] / DEGREE, "dots"),
            Curve("filtered", time, truth / DEGREE + found[:, 0]),
            Curve("truth", time, truth / DEGREE, "dashed"),
        ),
    )
