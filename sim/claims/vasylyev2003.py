"""Vasylyev 2003: linear feedback inside the filter against a saturated control outside it, on one captured line."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator
from dataclasses import replace
from functools import lru_cache
from typing import Any, NamedTuple

import numpy as np

from autopilot.modes.lateral_navigation import LateralNavigation
from sim.claims.ledger import Claim, Reading, counted
from sim.claims.plots import Curve, Plot
from sim.claims.verdict import above
from sim.randomness import stream
from sim.truths.route_capture import NOMINAL, RouteCapture
from tracking.gaussian import Gaussian
from tracking.intervals import Interval, gain, paired_difference, rmse
from tracking.measurement import LinearMeasurement
from tracking.motion import Transition, constant_velocity
from tracking.reference_path import Line
from tracking.track import Measurements, follow
from tracking.trackers.kalman import Kalman
from tracking.trackers.linear_feedback import LinearFeedback
from tracking.trackers.saturated_control import SaturatedControl

SIGMA = 100.0  # m, printed
PERIOD, DENSITY = 4.0, 0.1  # s, m2/s3: ours, of a terminal radar
OUTSIDE, INSIDE = 5000.0, 500.0  # m: starts with and without saturation
DURATION = 300.0
CASES = ((4.0, 0.1), (1.0, 0.1), (10.0, 0.1), (4.0, 0.001), (4.0, 1.0))
UNIFORM = (0.03, 0.1, 0.3, 1.0, 3.0, 10.0)  # densities tried for the filter without a law
UNLIMITED = LateralNavigation(NOMINAL.k1, NOMINAL.k2, 1e9, 1e9, 1e9)
LINE = Line(ground_speed=100.0)
CROSS_TRACK = LinearMeasurement(((1.0, 0.0),))
START = np.array([SIGMA, 5.0])  # m, m/s: standard deviations of the prior
LOSS, LOST_FOR = 4.89, 10  # sigmas of the 1 - 1e-6 interval, scans


class UniformOnLine(NamedTuple):
    """Motion across the line without a law."""

    density: float
    channels: tuple[str, ...] = ("cross_track", "cross_track_rate")
    depends_on_state: bool = False

    def transition(self, dt: float, mean: Any) -> Transition:
        """Constant velocity."""
        return Transition(*constant_velocity(dt, self.density))


def linear(density: float = DENSITY, law: LateralNavigation = NOMINAL) -> LinearFeedback:
    """The filter of fig. 1."""
    return LinearFeedback(law, LINE, CROSS_TRACK, density)


def saturated(density: float = DENSITY, law: LateralNavigation = NOMINAL) -> SaturatedControl:
    """The filter of fig. 2."""
    return SaturatedControl(law, LINE, CROSS_TRACK, density)


def uniform(density: float) -> Kalman:
    """The filter that knows no law."""
    return Kalman(CROSS_TRACK, UniformOnLine(density))


@lru_cache(maxsize=32)
def capture(
    seed: int, runs: int, start: float | tuple[float, ...], period: float, density: float, law: LateralNavigation
) -> tuple[Any, Measurements, Gaussian]:
    """Deviation and rate (k, 2, runs) at every scan, what the radar says of them, and what is known at the start.

    Several starts are taken in turn, one for each run.
    """
    starts = np.resize(start, runs)
    motion = RouteCapture(
        "double_integrator", law, starts, speed=400.0, duration=DURATION, acceleration_density=density
    )
    state = motion.fly(stream(seed, 0, 0, f"vasylyev2003.air.{start}.{period}"), runs, step=period).state
    truth = np.stack([state.east, state.velocity_east], axis=1)
    noise = stream(seed, 0, 0, f"vasylyev2003.radar.{start}.{period}")
    prior = Gaussian(truth[0] + START[:, None] * noise.standard_normal((2, runs)), np.diag(START**2))
    z = truth[:, :1] + SIGMA * noise.standard_normal((len(truth), 1, runs))
    time = period * np.arange(len(z))
    R = np.full((len(z), 1, 1), SIGMA**2)
    return truth, Measurements(("radar.cross_track",), time, time, z, R), prior


def errors(tracker: Any, data: tuple[Any, Measurements, Gaussian]) -> Any:
    """Errors of the deviation (k, runs), m, from the second scan on: the first one only sets the prior."""
    truth, measurements, prior = data
    estimates = [epoch.estimate.mean[0] - truth[epoch.row, 0] for epoch in follow(tracker, measurements, prior, 0.0)]
    return np.array(estimates[1:])


def squares(tracker: Any, data: Any) -> Any:
    """Mean squared error of each run (runs,), m2."""
    return (errors(tracker, data) ** 2).mean(axis=0)


def linear_over_saturated(start: float, period: float = PERIOD, density: float = DENSITY) -> Any:
    """Measure of the RMSE of linear feedback over that of saturated control."""

    def measured(seed: int, runs: int) -> Interval:
        data = capture(seed, runs, start, period, density, NOMINAL)
        return gain(squares(linear(density), data), squares(saturated(density), data))

    return measured


def inverse(measure: Callable[[int, int], Interval]) -> Callable[[int, int], Interval]:
    """Measure of one over a ratio."""

    def measured(seed: int, runs: int) -> Interval:
        value, low, high, count = measure(seed, runs)
        return Interval(1.0 / value, 1.0 / high, 1.0 / low, count)

    return measured


def limits_over_none(period: float, density: float) -> Any:
    """Measure of the RMSE of linear feedback where the limits act over that where the law has none."""

    def measured(seed: int, runs: int) -> Interval:
        acting, none = (
            squares(linear(density), capture(seed, runs, OUTSIDE, period, density, law)) for law in (NOMINAL, UNLIMITED)
        )
        return gain(acting, none)

    return measured


@lru_cache(maxsize=1)
def largest_differences() -> dict[float, float]:
    """Largest distance between the two undisturbed captures over the radar's sigma, by start."""
    starts = np.array([5000.0, 3000.0, 8000.0])
    paths = [
        RouteCapture("double_integrator", law, starts, speed=400.0, duration=200.0).fly(step=1.0).state.east
        for law in (NOMINAL, UNLIMITED)
    ]
    return dict(zip(starts.tolist(), (np.abs(paths[0] - paths[1]).max(axis=0) / SIGMA).tolist(), strict=True))


def lost(tracker: Any, data: tuple[Any, Measurements, Gaussian]) -> Any:
    """(runs,) 1 where the truth stays outside its 1 - 1e-6 interval for ten scans behind a gate of three sigmas."""
    truth, measurements, prior = data
    state = tracker.begin(Gaussian(prior.mean, prior.cov[..., None]))
    outside = longest = np.zeros(truth.shape[2], int)
    for k in range(1, len(truth)):
        state, _ = tracker.step(state, PERIOD, None, None)
        mean, cov = tracker.estimate(state)
        near = np.abs(measurements.z[k] - mean[:1]) < 3.0 * np.sqrt(cov[0, 0] + SIGMA**2)
        seen = np.where(near, measurements.z[k], np.nan)
        state, _ = tracker.step(state, 0.0, seen, measurements.R[k][..., None])
        mean, cov = tracker.estimate(state)
        outside = np.where(np.abs(mean[0] - truth[k, 0]) > LOSS * np.sqrt(cov[0, 0]), outside + 1, 0)
        longest = np.maximum(longest, outside)
    return (longest >= LOST_FOR).astype(float)


def lost_more(start: float) -> Any:
    """Measure of the share of runs that linear feedback loses less that of saturated control."""

    def measured(seed: int, runs: int) -> Interval:
        data = capture(seed, runs, start, PERIOD, DENSITY, NOMINAL)
        return paired_difference(lost(linear(), data), lost(saturated(), data))

    return measured


@lru_cache(maxsize=64)
def looked_ahead(seed: int, runs: int, name: str, density: float, ahead: float) -> Any:
    """Mean squared error per run of what is predicted ``ahead`` seconds on, from every fourth scan."""
    truth, measurements, prior = data = capture(seed, runs, OUTSIDE, PERIOD, DENSITY, NOMINAL)
    tracker: Any = {"linear": linear, "saturated": saturated, "uniform": uniform}[name](density)
    found, steps = [], round(ahead / PERIOD)
    for epoch in follow(tracker, measurements, prior, 0.0):
        then = epoch.row + steps
        if epoch.row and epoch.row % 4 == 0 and then < len(truth):
            later, _ = tracker.step(epoch.state, ahead, None, None)
            found.append((tracker.estimate(later).mean[0] - data[0][then, 0]) ** 2)
    return np.mean(found, axis=0)


def better_ahead(ahead: float) -> Any:
    """Measure of the look-ahead RMSE of the best filter without a law over that of saturated control."""

    def measured(seed: int, runs: int) -> Interval:
        free = min((looked_ahead(seed, runs, "uniform", q, ahead) for q in UNIFORM), key=np.mean)
        return gain(free, looked_ahead(seed, runs, "saturated", DENSITY, ahead))

    return measured


def told(law: LateralNavigation) -> Any:
    """Measure of the RMSE of saturated control that is told another law over that told the right one."""

    def measured(seed: int, runs: int) -> Interval:
        data = capture(seed, runs, OUTSIDE, PERIOD, DENSITY, NOMINAL)
        return gain(squares(saturated(law=law), data), squares(saturated(), data))

    return measured


def crossover(seed: int, runs: int) -> Interval:
    """Start of the capture (m) from which on both filters are equally good, between the distances of a grid."""
    starts = np.array([500.0, 1000.0, 1500.0, 2000.0, 3000.0])
    data = capture(seed, runs * len(starts), tuple(starts.tolist()), PERIOD, DENSITY, NOMINAL)
    both = [squares(tracker, data).reshape(-1, len(starts)) for tracker in (linear(), saturated())]
    found = [np.log(gain(*(column[:, i] for column in both))[:3]) for i in range(len(starts))]
    value, high, low = (float(np.interp(0.0, column, starts)) for column in np.array(found).T)
    return Interval(value, low, high, runs)


OURS = "ours"
WRONG = {
    "z_max halved": replace(NOMINAL, cross_track_limit=625.0),
    "z_max doubled": replace(NOMINAL, cross_track_limit=2500.0, cross_track_rate_limit=120.0),
    "both gains x 0.7": replace(NOMINAL, k1=0.7 * NOMINAL.k1, k2=0.7 * NOMINAL.k2),
    "k1 x 1.3": replace(NOMINAL, k1=1.3 * NOMINAL.k1),
    "k2 x 0.7": replace(NOMINAL, k2=0.7 * NOMINAL.k2),
    "bank limit 15 deg": replace(NOMINAL, bank_limit=math.radians(15.0)),
}
CLAIMS: tuple[Claim, ...] = (
    Claim(
        "trajectories_differ",
        "with limits the captured trajectory differs greatly from the unlimited one",
        "fig. 3",
        above(1.0),
        tuple(
            Reading(f"from {start:.0f} m", counted(lambda start=start: largest_differences()[start]))
            for start in (5000.0, 3000.0, 8000.0)
        ),
        "sigmas",
        geometry_by=OURS,
    ),
    Claim(
        "linear_feedback_degrades",
        "the linear-feedback filter loses accuracy sharply once limits act",
        "fig. 4",
        above(1.0),
        tuple(Reading(f"every {t:g} s, q {q:g} m2/s3", limits_over_none(t, q)) for t, q in CASES),
        "times",
        geometry_by=OURS,
    ),
    Claim(
        "saturated_control_accurate",
        "where limits act, the filter with the limited control formed outside stays accurate",
        "fig. 4",
        above(1.0),
        tuple(Reading(f"every {t:g} s, q {q:g} m2/s3", linear_over_saturated(OUTSIDE, t, q)) for t, q in CASES),
        "times less RMSE",
        geometry_by=OURS,
        first_runs=100,
    ),
    Claim(
        "breaks_of_tracking",
        "large deviations can break the tracking of the linear-feedback filter",
        "introduction, conclusions",
        above(0.0),
        tuple(Reading(f"from {start:.0f} m", lost_more(start)) for start in (5000.0, 3000.0, 8000.0)),
        "of the runs",
        geometry_by=OURS,
    ),
    Claim(
        "less_uncertain_prediction",
        "knowing the law makes the predicted position less uncertain",
        "introduction",
        above(1.0),
        tuple(Reading(f"{ahead:.0f} s ahead", better_ahead(ahead)) for ahead in (60.0, 20.0, 120.0)),
        "times less RMSE",
        geometry_by=OURS,
    ),
    Claim(
        "inside_the_limits",
        "where no limit acts, saturated control is worse than linear feedback",
        "not said",
        None,
        (Reading("from 500 m", inverse(linear_over_saturated(INSIDE))),),
        "times",
        geometry_by=OURS,
        first_runs=100,
        overlooked=True,
        note="The filter does not know that the error, too, is fed back.",
    ),
    Claim(
        "crossover",
        "start of the capture beyond which saturated control is the better one",
        "not said",
        None,
        (Reading("between 500 and 3000 m", crossover),),
        "m",
        geometry_by=OURS,
        overlooked=True,
    ),
    Claim(
        "told_wrong",
        "what a wrongly told law costs: the ratio of the gains and z_max matter, the bank limit does not",
        "not said",
        None,
        tuple(Reading(name, told(law)) for name, law in WRONG.items()),
        "times",
        geometry_by=OURS,
        overlooked=True,
    ),
    Claim(
        "look_ahead",
        "position 60 s ahead during the capture",
        "not said",
        None,
        (
            Reading("saturated control", lambda s, n: rmse(looked_ahead(s, n, "saturated", DENSITY, 60.0))),
            Reading("linear feedback", lambda s, n: rmse(looked_ahead(s, n, "linear", DENSITY, 60.0))),
            Reading("no law, 0.3 m2/s3", lambda s, n: rmse(looked_ahead(s, n, "uniform", 0.3, 60.0))),
        ),
        "m RMSE",
        geometry_by=OURS,
        overlooked=True,
    ),
)


def plots(seed: int) -> Iterator[Plot]:
    """Figures 3 and 4."""
    paths = {
        name: RouteCapture("double_integrator", law, OUTSIDE, speed=400.0, duration=200.0).fly(step=0.5).state
        for name, law in (("without limits", UNLIMITED), ("with limits", NOMINAL))
    }
    yield Plot(
        "fig. 3", "Capture of a line", "From 5 km beside it; z_max 1250 m, bank 20 deg.", "time, s", "cross-track, m",
        tuple(Curve(name, state.time, state.east) for name, state in paths.items()),
    )  # fmt: skip
    data = capture(seed, 300, OUTSIDE, PERIOD, DENSITY, NOMINAL)
    found = {"linear feedback": errors(linear(), data), "saturated control": errors(saturated(), data)}
    time = data[1].time[1:]
    yield Plot(
        "fig. 4", "Lateral error of both filters", "RMSE of 300 runs of the limited capture; the radar has 100 m.",
        "time, s", "RMSE, m",
        (
            *(Curve(name, time, np.sqrt((e**2).mean(axis=1))) for name, e in found.items()),
            Curve("radar", time, np.full(len(time), SIGMA), "dashed"),
        ),
        logarithmic=True,
    )  # fmt: skip
