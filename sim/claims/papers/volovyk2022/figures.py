"""Figures 1 to 4 of Volovyk 2022, from our own runs."""

from __future__ import annotations

from collections.abc import Iterator
from functools import lru_cache
from typing import Any, NamedTuple

import numpy as np

from sim.claims.ledger import FLIGHTS
from sim.claims.papers.volovyk2022.experiment import SMALLEST, experiment, squares
from sim.claims.papers.volovyk2022.filters import DENSITY, FILTERS, IMPROVED, RADAR
from sim.claims.papers.volovyk2022.landing_paths import JSBSIM, LEFT, SCAN
from sim.claims.plots import Curve, Plot
from sim.flight.truths.landing_pattern import GROUND
from tracking.gaussian import Mixture, merge
from tracking.track import follow

RUNS = {LEFT: SMALLEST, JSBSIM: FLIGHTS}


def landing_pattern(seed: int) -> Iterator[Plot]:
    """The path."""
    curves = []
    for truth, name, look in ((LEFT, "point mass", "line"), (JSBSIM, "flown on JSBSim", "dashed")):
        data = experiment(seed, RUNS[truth], truth)
        airborne = data.phase[:, 0] < GROUND
        north, east = data.truth[airborne, :, 0].T / 1e3
        curves.append(Curve(name, north, -east, look))
    yield Plot(
        "fig. 1",
        "Landing pattern",
        "From the base leg to the touchdown; the radar stands beside the runway.",
        "past the threshold, km",
        "left of the centreline, km",
        (*curves, Curve("radar", [RADAR[0] / 1e3], [-RADAR[1] / 1e3], "places")),
        equal=True,
    )


class Realised(NamedTuple):
    """One realisation."""

    time: Any  # (k,) s
    weights: Any  # (k, models)
    estimate: Any  # (k, 2) km, north and east
    measured: Any  # (2, k) km
    truth: Any  # (k, 2) km


@lru_cache(maxsize=1)
def realised(seed: int) -> Realised:
    """The first run of the published set."""
    data = experiment(seed, SMALLEST)
    airborne = data.phase[:, 0] < GROUND
    weights, means = [], []
    tracker = FILTERS[DENSITY]
    for epoch in follow(tracker, data.measurements.runs(slice(0, 1)), data.prior, start=0.0):
        mixture = epoch.estimate
        assert isinstance(mixture, Mixture)
        weights.append(mixture.weights[:, 0])
        means.append(merge(mixture).mean[[0, 2], 0] / 1e3)
    z = data.measurements.z[airborne, :, 0]
    measured = np.array(RADAR)[:, None] / 1e3 + z[:, 0] / 1e3 * np.stack([np.cos(z[:, 1]), np.sin(z[:, 1])])
    return Realised(
        data.measurements.time[airborne],
        np.array(weights)[airborne],
        np.array(means)[airborne],
        measured,
        data.truth[airborne, :, 0] / 1e3,
    )


def probabilities(seed: int) -> Iterator[Plot]:
    """Belief in the models."""
    found = realised(seed)
    names = ("turn .001 rad/s", "turn .045 rad/s", "straight")
    curves = tuple(Curve(name, found.time, column) for name, column in zip(names, found.weights.T, strict=True))
    yield Plot("fig. 2", "Model probabilities", "One realisation.", "time, s", "probability", curves)


def estimates(seed: int) -> Iterator[Plot]:
    """Plots, truth and estimate, all of them and in the turn."""
    found = realised(seed)
    north = found.truth[:, 0]
    near = (found.time > found.time[0] + 55.0) & (found.time < found.time[0] + 125.0)
    for title, chosen in (("", np.ones(len(north), bool)), (", the turn onto final", near)):
        measured, estimate, truth = found.measured[:, chosen], found.estimate[chosen], found.truth[chosen]
        yield Plot(
            "fig. 3",
            f"Measurement, truth and estimate{title}",
            "One realisation.",
            "past the threshold, km",
            "left of the centreline, km",
            (
                Curve("measured", measured[0], -measured[1], "dots"),
                Curve("estimate", estimate[:, 0], -estimate[:, 1]),
                Curve("truth", truth[:, 0], -truth[:, 1], "dashed"),
            ),
            equal=True,
        )


def errors(seed: int) -> Iterator[Plot]:
    """RMSE of plots and filters over time; runs and flights are brought together at the touchdown."""
    for truth, where in ((LEFT, "point mass"), (JSBSIM, f"{FLIGHTS} flights on JSBSim")):
        data = experiment(seed, RUNS[truth], truth)
        found, better = (squares(name, seed, RUNS[truth], truth) for name in (DENSITY, IMPROVED))
        ends = (data.phase < GROUND).sum(axis=0)
        scans = np.arange(ends.min())[:, None] + ends - ends.min()
        yield Plot(
            "fig. 4",
            f"Error of measurement and filter, {where}",
            f"{data.phase.shape[1]} runs; from the base leg to the touchdown.",
            "time to the touchdown, s",
            "position RMSE, m",
            tuple(
                Curve(
                    name,
                    SCAN * np.arange(-len(scans), 0),
                    np.sqrt(np.take_along_axis(part["position"], scans, axis=0).mean(axis=1)),
                    look,
                )
                for name, part, look in (
                    ("measurement", found.raw, "line"),
                    ("filter as published", found.own, "line"),
                    ("with a model of the deceleration", better.own, "dashed"),
                )
            ),
        )


FIGURES = {"fig. 1": landing_pattern, "fig. 2": probabilities, "fig. 3": estimates, "fig. 4": errors}
