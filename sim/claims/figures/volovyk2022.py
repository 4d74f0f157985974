"""Figures 1 to 4 of Volovyk 2022, from our own runs."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from sim.claims.plots import Curve, Plot
from sim.claims.runs.landing_paths import JSBSIM, LEFT
from sim.claims.runs.volovyk2022 import DENSITY, IMPROVED, RADAR, SMALLEST, experiment, imm, squares
from sim.truths.landing_pattern import GROUND
from tracking.gaussian import merge
from tracking.track import follow


def plots(seed: int) -> Iterator[Plot]:
    """Figures 1 to 4."""
    data, found = experiment(seed, SMALLEST), squares(DENSITY, seed, SMALLEST)
    time, north, east = data.measurements.time, data.truth[:, 0, 0] / 1000.0, data.truth[:, 1, 0] / 1000.0
    flown = data.phase[:, 0] < GROUND
    six = experiment(seed, SMALLEST, JSBSIM)
    airborne = six.phase[:, 0] < GROUND
    yield Plot(
        "fig. 1",
        "Landing pattern",
        "From the base leg to the touchdown; the radar stands beside the runway.",
        "north, km",
        "east, km",
        (
            Curve("point mass", north[flown], east[flown]),
            Curve("flown on JSBSim", *(six.truth[airborne, i, 0] / 1e3 for i in (0, 1)), "dashed"),
            Curve("radar", [RADAR[0] / 1e3], [RADAR[1] / 1e3], "dots"),
        ),
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
    for truth, where in ((LEFT, "point mass"), (JSBSIM, "flown on JSBSim")):
        data, found = experiment(seed, SMALLEST, truth), squares(DENSITY, seed, SMALLEST, truth)
        better = squares(IMPROVED, seed, SMALLEST, truth)
        rows = np.flatnonzero((data.phase < GROUND).all(axis=1))
        yield Plot(
            "fig. 4",
            f"Error of measurement and filter, {where}",
            f"{SMALLEST} runs; from the base leg to the touchdown.",
            "time, s",
            "position RMSE, m",
            tuple(
                Curve(name, data.measurements.time[rows], np.sqrt(part["position"][rows].mean(axis=1)), look)
                for name, part, look in (
                    ("measurement", found.raw, "line"),
                    ("filter as published", found.own, "line"),
                    ("with a model of the deceleration", better.own, "dashed"),
                )
            ),
        )
