"""The experiment of Kychak 2011: anomalies of the measured angle, on its own model and on a flown glide path."""

from __future__ import annotations

import math
from dataclasses import replace
from functools import lru_cache
from typing import Any, NamedTuple

import numpy as np

from sim.claims.angle_channel import DEGREE, MEASURED, PRIOR, VARIANCE, along, drawn
from sim.claims.jsbsim_flights import WIND, flights, per_flight
from sim.randomness import stream
from tracking.consistency import lost
from tracking.gaussian import Gaussian, Mixture, merge
from tracking.intervals import Interval, gain, mean_interval
from tracking.track import follow
from tracking.trackers.elevation import PERIOD, Elevation
from tracking.trackers.switching_noise import BeamNoise, SwitchingNoise

STEPS, SETTLED = 400, 200
SHARE, FACTOR = 0.2, 30.0
EFFECTIVE = 1.0 - SHARE + SHARE * FACTOR**2  # variance of the mixture over the nominal one
LONG = 40.0  # scans that a burst lasts on average
EARLY, EARLY_RUNS = 20, 20_000  # scans of the first half second; so few of them cost little
WIDE = Gaussian(PRIOR.mean, np.diag([1.0, 0.25]) * DEGREE**2)  # deg, deg/s squared: little is known at the start
MODEL, JSBSIM = "model", "jsbsim"
SCENARIO, DECISION_HEIGHT = "kychak2011_jsbsim", 30.0  # m, printed
STARTS = (("start.distance_m", 4000.0, 5000.0), *WIND)  # ours: of the flights on JSBSim
ON_A_GLIDE = 50  # draws of noise on each: errors under anomalies have long tails, and the angle hardly moves

Chain = tuple[tuple[float, float], ...]


def independent(share: float) -> Chain:
    """Anomalies that know nothing of each other."""
    return ((1.0 - share, share),) * 2


def bursts(length: float, share: float = SHARE) -> Chain:
    """Anomalies that come as runs of ``length`` on average, with the same share of time."""
    leave = 1.0 / length
    enter = leave * share / (1.0 - share)
    return (1.0 - enter, enter), (leave, 1.0 - leave)


PRINTED_CHAIN = independent(SHARE)
NO_ANOMALIES = independent(0.0)


class Found(NamedTuple):
    """Mean squared errors per run or flight (N,), deg^2, in the steady state, and what is believed."""

    settled: dict[str, Any]
    normalised: dict[str, Any]  # (STEPS, draws) squared errors over the variance believed
    doubt: Any  # (N,) mean probability of an anomaly
    decided: Any  # (N,) share of steps where it exceeds a half


@lru_cache(maxsize=2)
def glides(seed: int, count: int) -> Any:
    """Angles (STEPS + 1, count), rad, flown on JSBSim in drawn winds, up to the decision height."""
    found = []
    for flight in flights(SCENARIO, seed, count, STARTS):
        below = flight.during("glide") & (flight.state.height < DECISION_HEIGHT)
        if not below.any():
            raise ValueError(f"a flight of '{SCENARIO}' never came down to the decision height")
        low = flight.state.time[np.argmax(below)]
        found.append(flight.elevation(low - PERIOD * np.arange(STEPS, -1, -1))[0])
    return np.stack(found, axis=1)


@lru_cache(maxsize=12)
def experiment(
    seed: int, runs: int, chain: Chain, factor: float = FACTOR, truth: str = MODEL, prior: str = "known"
) -> Found:
    """The glide leg and every filter on the same measurements; on JSBSim a run is a flight with all its draws."""
    generator = stream(seed, 0, 0, f"kychak2011.{truth}.{prior}.{chain}.{factor}")
    begun = PRIOR if prior == "known" else WIDE
    if truth == MODEL:
        angle, seen = drawn(generator, runs, STEPS, begun, chain, (1.0, factor))
    else:
        flown = np.repeat(glides(seed, runs), ON_A_GLIDE, axis=1)
        angle, seen, begun = along(generator, flown, begun.cov, chain, (1.0, factor))
    filters: dict[str, Any] = {"kalman": (Elevation(MEASURED), seen), "two": (SwitchingNoise(MEASURED), seen)}
    if (chain, factor) == (PRINTED_CHAIN, FACTOR):
        filters["effective"] = (Elevation(MEASURED), replace(seen, R=EFFECTIVE * seen.R))
    if chain == bursts(LONG):
        filters["markov"] = (SwitchingNoise(MEASURED, switching=chain), seen)
    settled, believed, doubts = {}, {}, []
    for name, (tracker, record) in filters.items():
        errors, normalised = [], []
        for epoch in follow(tracker, record, begun, start=0.0):
            estimate = epoch.estimate
            if isinstance(estimate, Mixture):
                if name == "two":
                    doubts.append(estimate.weights[1])
                estimate = merge(estimate)
            error = estimate.mean[0] - angle[epoch.row]
            errors.append(error)
            normalised.append(error**2 / estimate.cov[0, 0])
        squares = (np.array(errors) / DEGREE) ** 2
        settled[name] = per_flight(squares[SETTLED:].mean(axis=0), runs)
        believed[name] = np.array(normalised, np.float32)
    doubt = np.array(doubts)[SETTLED:]
    shares = (per_flight(share.mean(axis=0), runs) for share in (doubt, doubt > 0.5))
    return Found(settled, believed, *shares)


def squared(interval: Interval) -> Interval:
    """A ratio of RMS as a ratio of variances."""
    return Interval(interval.value**2, interval.low**2, interval.high**2, interval.runs)


def ratio(
    over: str, under: str, chain: Any = PRINTED_CHAIN, factor: float = FACTOR, variance: bool = True, truth: str = MODEL
) -> Any:
    """Measure of the gain of one filter over another in the steady state."""

    def measured(seed: int, runs: int) -> Interval:
        found = experiment(seed, runs, chain, factor, truth).settled
        interval = gain(found[over], found[under])
        return squared(interval) if variance else interval

    return measured


@lru_cache(maxsize=4)
def early(seed: int, runs: int, truth: str) -> dict[str, Any]:
    """Squared errors (EARLY, runs or flights) of both filters at the first scans, of EARLY_RUNS draws in all."""
    generator = stream(seed, 0, 0, f"kychak2011.early.{truth}")
    if truth == MODEL:
        angle, seen = drawn(generator, EARLY_RUNS, EARLY, PRIOR, PRINTED_CHAIN, (1.0, FACTOR))
        begun = PRIOR
    else:
        first = np.repeat(glides(seed, runs)[: EARLY + 1], EARLY_RUNS // runs, axis=1)
        angle, seen, begun = along(generator, first, PRIOR.cov, PRINTED_CHAIN, (1.0, FACTOR))
    found: dict[str, list[Any]] = {"kalman": [], "two": []}
    for name, tracker in (("kalman", Elevation(MEASURED)), ("two", SwitchingNoise(MEASURED))):
        for epoch in follow(tracker, seen, begun, start=0.0):
            estimate = epoch.estimate
            mean = (merge(estimate) if isinstance(estimate, Mixture) else estimate).mean
            found[name].append((mean[0] - angle[epoch.row]) ** 2)
    samples = EARLY_RUNS if truth == MODEL else runs
    return {name: per_flight(errors, samples) for name, errors in found.items()}


def steady_over(scans: slice, truth: str = MODEL) -> Any:
    """Measure of the gain in the steady state over that at some of the first scans, in variance."""

    def measured(seed: int, runs: int) -> Interval:
        settled = experiment(seed, runs, PRINTED_CHAIN, FACTOR, truth).settled
        late = gain(settled["kalman"], settled["two"])
        begun = early(seed, EARLY_RUNS if truth == MODEL else runs, truth)
        first = gain(*(begun[name][scans].mean(axis=0) for name in ("kalman", "two")))
        value = (late.value / first.value) ** 2
        spread = 2.0 * math.hypot(math.log(late.high / late.value), math.log(first.high / first.value))
        return Interval(value, value * math.exp(-spread), value * math.exp(spread), runs)

    return measured


def percent(interval: Interval) -> Interval:
    """A share in per cent."""
    return Interval(100.0 * interval.value, 100.0 * interval.low, 100.0 * interval.high, interval.runs)


def doubted(what: str, truth: str = MODEL) -> Any:
    """Measure of what is believed of anomalies, per cent, where there is none."""

    def measured(seed: int, runs: int) -> Interval:
        return percent(mean_interval(getattr(experiment(seed, runs, NO_ANOMALIES, FACTOR, truth), what)))

    return measured


def excess(variance: bool, truth: str = MODEL) -> Any:
    """Measure of how much worse two hypotheses are without anomalies, per cent."""

    def measured(seed: int, runs: int) -> Interval:
        interval = ratio("two", "kalman", NO_ANOMALIES, variance=variance, truth=truth)(seed, runs)
        return percent(Interval(interval.value - 1.0, interval.low - 1.0, interval.high - 1.0, interval.runs))

    return measured


def lost_share(name: str, chain: Chain, prior: str) -> Any:
    """Measure of the share of runs that lose the angle, per cent."""

    def measured(seed: int, runs: int) -> Interval:
        found = experiment(seed, runs, chain, FACTOR, MODEL, prior).normalised[name]
        return percent(mean_interval(lost(found, 1).astype(float)))

    return measured


def missed_against(name: str) -> Any:
    """Measure of the RMSE where a fifth of the measurements is missed over that where it is anomalous."""

    def measured(seed: int, runs: int) -> Interval:
        generator = stream(seed, 0, 0, "kychak2011.missed")
        angle, seen = drawn(generator, runs, STEPS, PRIOR)
        bad = generator.random(seen.z.shape) < SHARE
        noise = seen.z - angle[:, None]
        squares = {}
        for case, z in (
            ("missed", np.where(bad, np.nan, seen.z)),
            ("anomalous", angle[:, None] + np.where(bad, FACTOR, 1.0) * noise),
        ):
            tracker = Elevation(MEASURED) if name == "kalman" else SwitchingNoise(MEASURED)
            errors = []
            for epoch in follow(tracker, replace(seen, z=z), PRIOR, start=0.0):
                estimate = epoch.estimate
                mean = (merge(estimate) if isinstance(estimate, Mixture) else estimate).mean
                errors.append(mean[0] - angle[epoch.row])
            squares[case] = (np.array(errors)[SETTLED:] ** 2).mean(axis=0)
        return gain(squares["anomalous"], squares["missed"])

    return measured


def beam(signal_ratio: float) -> float:
    """Variance of the angle, deg^2, at a signal-to-noise ratio."""
    return float(BeamNoise(10.0, 1000.0, 0.0).of_ratio(signal_ratio)) / DEGREE**2


def ratio_needed(variance: float) -> float:
    """Signal-to-noise ratio that gives a variance of the angle, deg^2."""
    low, high = 1e-3, 1e6
    for _ in range(200):
        middle = math.sqrt(low * high)
        low, high = (middle, high) if beam(middle) > variance else (low, middle)
    return low


NEEDED = 10.0 * math.log10(ratio_needed(VARIANCE))  # dB
