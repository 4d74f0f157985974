"""Figures 3 to 5 and 8 to 10 of Kychak 2011, from our own runs."""

from __future__ import annotations

import math
from collections.abc import Iterator
from functools import lru_cache
from typing import Any, NamedTuple

import numpy as np

from sim.claims.angle_channel import DEGREE, MEASURED, PRIOR, VARIANCE, drawn
from sim.claims.jsbsim_flights import flown
from sim.claims.papers.kychak2011.cheaper import BURSTS, CHAINS, FILTERS, all_operations, gained
from sim.claims.papers.kychak2011.experiment import FACTOR, PRINTED_CHAIN, SCENARIO, beam, ratio_needed
from sim.claims.papers.volovyk2018.figures import derivatives
from sim.claims.plots import Curve, Plot
from sim.flight.truths.mls_profile import MlsProfile
from sim.randomness import stream
from tracking.gaussian import Mixture, merge
from tracking.track import follow
from tracking.trackers.elevation import Elevation
from tracking.trackers.switching_noise import SwitchingNoise

RUNS, STEPS = 200, 400


def profile(seed: int) -> Iterator[Plot]:
    """The landing profile."""
    state, flight = MlsProfile().fly().state, flown(SCENARIO)
    _, away = flight.elevation(flight.flight.time)
    ahead = away > 0.0
    yield Plot(
        "fig. 3",
        "Landing profile",
        "Level deceleration, glide path, flare; the An-26 joins at 5 km.",
        "distance to the beacon, km",
        "height, m",
        (
            Curve("as printed", -state.north / 1000.0, state.height),
            Curve("flown on JSBSim", away[ahead] / 1000.0, flight.state.height[ahead], "dashed"),
        ),
    )


def angles(seed: int) -> Iterator[Plot]:
    """Elevation and its derivatives."""
    yield derivatives("fig. 4", "Elevation and its derivatives")


def noise(seed: int) -> Iterator[Plot]:
    """Angle noise by the printed formula."""
    away = np.geomspace(750.0, 15000.0, 200)
    curves = []
    for name, variance, at in (("36e-4 at 750 m", VARIANCE, 750.0), ("50e-4 at 15 km", 50e-4, 15000.0)):
        sigmas = [math.sqrt(beam(ratio_needed(variance) * (at / d) ** 2)) for d in away]
        curves.append(Curve(f"{name}, free space", away / 1000.0, sigmas))
    yield Plot(
        "fig. 5",
        "Normalised angle noise along the approach",
        "No signal-to-noise ratio is printed: two that give 36e-4 deg^2 at the decision height and 50e-4 at 15 km.",
        "distance to the beacon, km",
        "sigma over beam width",
        tuple(curves),
        logarithmic=True,
    )


class Realised(NamedTuple):
    """An ensemble under anomalies."""

    time: Any  # (k,) s
    measured: Any  # (k, runs) deg
    truth: Any  # (k, runs) deg
    errors: dict[str, Any]  # (k, runs) deg
    doubt: Any  # (k,) of the first run


@lru_cache(maxsize=1)
def realised(seed: int) -> Realised:
    """Both filters on RUNS streams with anomalies."""
    generator = stream(seed, 0, 0, "kychak2011.figures")
    truth, seen = drawn(generator, RUNS, STEPS, PRIOR, PRINTED_CHAIN, (1.0, FACTOR))
    errors: dict[str, list[Any]] = {"Kalman": [], "two hypotheses": []}
    doubt = []
    for name, tracker in (("Kalman", Elevation(MEASURED)), ("two hypotheses", SwitchingNoise(MEASURED))):
        for epoch in follow(tracker, seen, PRIOR, start=0.0):
            estimate = epoch.estimate
            if isinstance(estimate, Mixture):
                doubt.append(estimate.weights[1, 0])
                estimate = merge(estimate)
            errors[name].append((estimate.mean[0] - truth[epoch.row]) / DEGREE)
    found = {name: np.array(each) for name, each in errors.items()}
    return Realised(seen.time, seen.z[:, 0] / DEGREE, truth / DEGREE, found, np.array(doubt))


def anomalies(seed: int) -> Iterator[Plot]:
    """One stream."""
    found = realised(seed)
    yield Plot(
        "fig. 8",
        "A stream with anomalies and both filters",
        "One realisation.",
        "time, s",
        "elevation, deg",
        (
            Curve("measured", found.time, found.measured[:, 0], "dots"),
            *(Curve(name, found.time, e[:, 0] + found.truth[:, 0]) for name, e in found.errors.items()),
            Curve("truth", found.time, found.truth[:, 0], "dashed"),
        ),
    )


def variances(seed: int) -> Iterator[Plot]:
    """Variance over time."""
    found = realised(seed)
    yield Plot(
        "fig. 9",
        "Variance of both filters",
        f"{RUNS} runs.",
        "time, s",
        "variance, deg^2",
        tuple(Curve(name, found.time, (e**2).mean(axis=1)) for name, e in found.errors.items()),
        logarithmic=True,
    )


def belief(seed: int) -> Iterator[Plot]:
    """Probability of the anomaly."""
    found = realised(seed)
    yield Plot(
        "fig. 10",
        "Probability of the anomaly",
        "The same realisation.",
        "time, s",
        "probability",
        (Curve("believed", found.time, found.doubt),),
    )


NAMES = (  # of the filters, in their order
    "stored gain, gate",
    "Kalman",
    "gate",
    "Huber",
    "missed",
    "Student's t",
    "two",
    "two as printed",
    "two, chain",
    "three",
    "three, chain",
)


def accuracy_against_operations(seed: int) -> Iterator[Plot]:
    """What a filter gains over the Kalman filter, and what a step of it costs."""
    named = dict(zip(FILTERS, NAMES, strict=True))
    told = {anomalies: [name for name in FILTERS if "chain" not in name or anomalies == BURSTS] for anomalies in CHAINS}
    yield Plot(
        "future work",
        "Accuracy against operations",
        f"Variance of the Kalman filter over that of each filter, steady state, {RUNS} runs. Hypotheses take anomalies "
        "as independent, or as the chain of the bursts; a root or an exponential counts as twenty.",
        "multiplications and additions of one step",
        "gain in variance",
        tuple(
            Curve(
                anomalies,
                [all_operations(name) for name in names],
                [gained(name, anomalies)(seed, RUNS).value for name in names],
                "marks",
                tuple(named[name] for name in names),
            )
            for anomalies, names in told.items()
        ),
        logarithmic=True,
    )


FIGURES = {
    "fig. 3": profile,
    "fig. 4": angles,
    "fig. 5": noise,
    "fig. 8": anomalies,
    "fig. 9": variances,
    "fig. 10": belief,
    "future work": accuracy_against_operations,
}
