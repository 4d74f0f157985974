"""Both filters of Vasylyev 2003 on whole approaches: the turns and straights of a landing pattern."""

from __future__ import annotations

from collections.abc import Callable
from functools import lru_cache
from typing import Any, NamedTuple

import numpy as np

from sim.claims.jsbsim_flights import WIND, Flown, Ranges, flights
from sim.claims.ledger import DRAWS
from sim.claims.papers.vasylyev2003.experiment import DENSITY, LOST_FOR, PERIOD, SIGMA, START
from sim.randomness import stream
from tracking.gaussian import Gaussian
from tracking.intervals import Interval, gain, mean_interval, paired_difference
from tracking.measurement import LinearMeasurement
from tracking.track import Measurements, follow
from tracking.trackers.linear_feedback import LinearFeedback
from tracking.trackers.saturated_control import SaturatedControl

SCENARIO = "an26_pattern"
BESIDE: Ranges = (("start.cross_track_m", -300.0, 300.0), *WIND)
UNTIL = ("until_s", 420.0)  # the last minute and a half of the glide path is one more straight
AIRCRAFT, POINT_MASS = "an26", "point_mass"
FILTERS = {"linear": LinearFeedback, "saturated": SaturatedControl}
STRAIGHT = ("downwind",)
TURNS = {"turn onto base": ("base_turn", "base"), "turn onto final": ("final_turn", "final")}  # and the new line
PLANE = LinearMeasurement(((1.0, 0.0, 0.0, 0.0), (0.0, 0.0, 1.0, 0.0)))
LOSS = -2.0 * np.log(1e-6)  # squared sigmas of the 1 - 1e-6 ellipse


class Approach(NamedTuple):
    """One flight with all draws of its noise, from the second scan on."""

    phase: Any  # (k,) names
    free: Any  # (k,) where no limit of the law acts
    squares: dict[str, Any]  # squared errors of the position (k, DRAWS), m2, by filter
    outside: dict[str, Any]  # (k, DRAWS) true position outside the ellipse, by filter


@lru_cache(maxsize=4)
def approaches(seed: int, count: int, aircraft: str) -> tuple[Approach, ...]:
    """Flights of the pattern from beside its downwind leg in drawn winds, which their chart shows to the filters."""
    flown = flights(SCENARIO, seed, count, BESIDE, ("aircraft.model", aircraft), UNTIL)
    return tuple(followed(flight, seed, number) for number, flight in enumerate(flown))


def followed(flown: Flown, seed: int, number: int) -> Approach:
    """Both filters, told the route and the law that flies, on the plots of the radar of the paper."""
    flight, rows = flown.flight, np.concatenate([[0], flown.rows(PERIOD)])
    state = flight.state
    motion = np.stack([state.north, state.velocity_north, state.east, state.velocity_east], axis=1)[rows][..., None]
    generator = stream(seed, number, 0, f"vasylyev2003.{SCENARIO}.radar")
    spread = np.tile(START, 2)
    prior = Gaussian(motion[0] + spread[:, None] * generator.standard_normal((4, DRAWS)), np.diag(spread**2))
    z = motion[:, ::2] + SIGMA * generator.standard_normal((len(rows), 2, DRAWS))
    R = np.broadcast_to(SIGMA**2 * np.eye(2), (len(rows), 2, 2))
    seen = Measurements(("radar.north", "radar.east"), flight.time[rows], flight.time[rows], z, R)
    squares, outside = {}, {}
    for name, kind in FILTERS.items():
        epochs = list(follow(kind(flown.law, flown.route, PLANE, DENSITY), seen, prior, 0.0))[1:]
        missed = np.array([epoch.estimate.mean[::2] - motion[epoch.row, ::2] for epoch in epochs])
        cov = np.array([np.broadcast_to(lifted(epoch.estimate.cov)[::2, ::2], (2, 2, DRAWS)) for epoch in epochs])
        whitened = np.linalg.solve(cov.transpose(0, 3, 1, 2), missed.transpose(0, 2, 1)[..., None])[..., 0]
        squares[name] = (missed**2).sum(axis=1)
        outside[name] = np.einsum("kri,kir->kr", whitened, missed) > LOSS
    names = np.array(flight.phases)[flight.phase[rows]]
    return Approach(names[1:], unlimited(flown)[rows][1:], squares, outside)


def lifted(cov: Any) -> Any:
    """A covariance with an axis of runs."""
    return cov if cov.ndim == 3 else cov[..., None]


def unlimited(flown: Flown) -> Any:
    """(k,) bool: where neither the bank is at its limit nor an input of the law beyond its own."""
    deviation = flown.flight.deviation
    free = np.abs(flown.flight.command.bank) < flown.law.bank_limit * (1.0 - 1e-6)
    for one in flown.law.limits():
        free &= np.abs(getattr(deviation, one.of)) < one.limit
    return free


def within(seed: int, count: int, aircraft: str, name: str, phases: tuple[str, ...]) -> Any:
    """Mean squared error (count,) of a filter in some phases of each flight, m2."""
    return np.array([one.squares[name][np.isin(one.phase, phases)].mean() for one in approaches(seed, count, aircraft)])


def linear_over_saturated(aircraft: str, phases: tuple[str, ...]) -> Callable[[int, int], Interval]:
    """Measure of the RMSE of linear feedback over that of saturated control in some phases."""
    return lambda seed, count: gain(*(within(seed, count, aircraft, name, phases) for name in ("linear", "saturated")))


def turn_over_straight(aircraft: str, phases: tuple[str, ...]) -> Callable[[int, int], Interval]:
    """Measure of the RMSE of linear feedback in some phases over that on the straight before all turns."""
    return lambda seed, count: gain(*(within(seed, count, aircraft, "linear", part) for part in (phases, STRAIGHT)))


def lost(approach: Approach, name: str, phases: tuple[str, ...]) -> float:
    """Share of the draws whose true position stays outside the ellipse for ten scans of some phases."""
    run, longest = np.zeros(DRAWS), np.zeros(DRAWS)
    for outside in approach.outside[name][np.isin(approach.phase, phases)]:
        run = np.where(outside, run + 1, 0)
        longest = np.maximum(longest, run)
    return float((longest >= LOST_FOR).mean())


def lost_more(aircraft: str, phases: tuple[str, ...], beside: str = "saturated") -> Callable[[int, int], Interval]:
    """Measure of the share of runs that linear feedback loses in some phases.

    Less that of saturated control there, or with ``beside`` "straight" less its own on the straight before all turns.
    """
    other = ("linear", STRAIGHT) if beside == "straight" else (beside, phases)

    def measured(seed: int, count: int) -> Interval:
        flown = approaches(seed, count, aircraft)
        ours, beside_it = (np.array([lost(one, *what) for one in flown]) for what in (("linear", phases), other))
        return paired_difference(ours, beside_it)

    return measured


def share_of_the_time(aircraft: str, of: Callable[[Approach], Any]) -> Callable[[int, int], Interval]:
    """Measure of the share of scans for which something holds."""
    return lambda seed, count: mean_interval([of(one).mean() for one in approaches(seed, count, aircraft)])


def free(one: Approach) -> Any:
    """(k,) where no limit of the law acts."""
    return one.free


def no_worse(one: Approach) -> Any:
    """(k,) where no limit acts, on those legs and turns on which linear feedback is then no worse on average."""
    found = np.zeros_like(one.free)
    for phase in np.unique(one.phase[one.free]):
        here = one.free & (one.phase == phase)
        if one.squares["linear"][here].mean() <= one.squares["saturated"][here].mean():
            found |= here
    return found


def better_than_plots(one: Approach) -> Any:
    """(k,) where the error of linear feedback is below that of the plots."""
    return one.squares["linear"].mean(axis=1) < 2.0 * SIGMA**2
