"""Figures 3 to 5 and 8 to 10 of Kychak 2011, from our own runs."""

from __future__ import annotations

import math
from collections.abc import Iterator
from typing import Any

import numpy as np

from sim.claims.angle import DEGREE, MEASURED, PRIOR, VARIANCE, drawn
from sim.claims.plots import Curve, Plot
from sim.claims.runs.kychak2011 import FACTOR, SHARE, beam, independent, ratio_needed
from sim.randomness import stream
from sim.truths.mls_profile import MlsProfile
from tracking.gaussian import Mixture, merge
from tracking.track import follow
from tracking.trackers.elevation import Elevation, elevation_of
from tracking.trackers.switching_noise import SwitchingNoise


def plots(seed: int) -> Iterator[Plot]:
    """Figures 3, 4, 5, 8, 9 and 10."""
    flight = MlsProfile().fly()
    state = flight.state
    distance = -state.north
    yield Plot(
        "fig. 3",
        "Landing profile",
        "Level deceleration, glide path, flare.",
        "distance to the beacon, km",
        "height, m",
        (Curve("path", distance / 1000.0, state.height),),
    )
    angle = np.degrees(elevation_of(distance, state.height, -state.velocity_north, state.velocity_up).angle)
    rate = np.gradient(angle, state.time)
    acceleration = np.gradient(rate, state.time)
    near = distance > 300.0
    quantities = (("elevation", angle, "deg"), ("rate", rate, "deg/s"), ("acceleration", acceleration, "deg/s^2"))
    curves = []
    for name, values, unit in quantities:
        largest = float(np.abs(values[near]).max())
        curves.append(Curve(f"{name}, largest {largest:.3g} {unit}", state.time[near], values[near] / largest))
    yield Plot(
        "fig. 4",
        "Elevation and its derivatives",
        "Each divided by its largest value.",
        "time, s",
        "share of the largest",
        tuple(curves),
    )
    away = np.geomspace(750.0, 15000.0, 200)
    curves = []
    for name, variance, at in (("36e-4 at 750 m", VARIANCE, 750.0), ("50e-4 at 15 km", 50e-4, 15000.0)):
        sigmas = [math.sqrt(beam(ratio_needed(variance) * (at / d) ** 2)) for d in away]
        curves.append(Curve(f"{name}, free space", away / 1000.0, sigmas))
    yield Plot(
        "fig. 5",
        "Normalised angle noise along the approach",
        "With the printed 36e-4 deg^2 at the decision height, and with 50e-4 deg^2 at 15 km.",
        "distance to the beacon, km",
        "sigma over beam width",
        tuple(curves),
        logarithmic=True,
    )
    runs, steps = 200, 400
    truth, seen = drawn(stream(seed, 0, 0, "kychak2011.figures"), runs, steps, PRIOR, independent(SHARE), (1.0, FACTOR))
    time = seen.time
    errors: dict[str, list[Any]] = {"Kalman": [], "two hypotheses": []}
    doubt = []
    for name, tracker in (("Kalman", Elevation(MEASURED)), ("two hypotheses", SwitchingNoise(MEASURED))):
        for epoch in follow(tracker, seen, PRIOR, start=0.0):
            estimate = epoch.estimate
            if isinstance(estimate, Mixture):
                doubt.append(estimate.weights[1, 0])
                estimate = merge(estimate)
            errors[name].append((estimate.mean[0] - truth[epoch.row]) / DEGREE)
    yield Plot(
        "fig. 8", "A stream with anomalies and both filters", "One realisation.", "time, s", "elevation, deg",
        (
            Curve("measured", time, seen.z[:, 0, 0] / DEGREE, "dots"),
            *(Curve(name, time, np.array(e)[:, 0] + truth[:, 0] / DEGREE) for name, e in errors.items()),
            Curve("truth", time, truth[:, 0] / DEGREE, "dashed"),
        ),
    )  # fmt: skip
    yield Plot(
        "fig. 9", "Variance of both filters", f"{runs} runs.", "time, s", "variance, deg^2",
        tuple(Curve(name, time, (np.array(e) ** 2).mean(axis=1)) for name, e in errors.items()), logarithmic=True,
    )  # fmt: skip
    yield Plot(
        "fig. 10", "Probability of the anomaly", "The same realisation.", "time, s", "probability",
        (Curve("believed", time, doubt),),
    )  # fmt: skip
