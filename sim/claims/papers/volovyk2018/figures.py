"""Figures 1, 2, 4 and 5 of Volovyk 2018, from our own runs."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from sim.claims.angle_channel import DEGREE, SIGMA, record
from sim.claims.jsbsim_flights import flown
from sim.claims.papers.volovyk2018.experiment import (
    BAND,
    JSBSIM,
    LEG,
    PUBLISHED,
    SAMPLE,
    START,
    STEPS,
    followed,
    on_the_model,
    printed_leg,
)
from sim.claims.plots import Curve, Plot
from sim.flight.truths.mls_profile import MlsProfile
from sim.randomness import stream
from tracking.trackers.elevation import PERIOD, elevation_of

NEAREST = 750.0  # m, printed: the flare that follows is ours


def profile(seed: int) -> Iterator[Plot]:
    """The landing profile."""
    state = MlsProfile().fly().state
    distance = -state.north
    flight = flown(JSBSIM)
    _, away = flight.elevation(flight.flight.time)
    ahead = away > 0.0
    yield Plot(
        "fig. 1",
        "Idealised landing profile",
        "Level deceleration, glide path, flare; flown by an A-4.",
        "distance to the beacon, km",
        "height, m",
        (
            Curve("as printed", distance / 1000.0, state.height),
            Curve("flown on JSBSim", away[ahead] / 1000.0, flight.state.height[ahead], "dashed"),
        ),
    )


def derivatives(figure: str, title: str) -> Plot:
    """The elevation along the printed profile with its derivatives."""
    state = MlsProfile().fly().state
    distance = -state.north
    near = distance > NEAREST
    along, _, up = state.acceleration
    motion = elevation_of(distance, state.height, -state.velocity_north, state.velocity_up, -along, up)
    quantities = tuple(
        (name, np.degrees(values), unit)
        for name, values, unit in zip(
            ("elevation", "rate", "acceleration"), motion, ("deg", "deg/s", "deg/s^2"), strict=True
        )
    )
    curves = []
    for name, values, unit in quantities:
        largest = float(np.abs(values[near]).max())
        curves.append(Curve(f"{name}, largest {largest:.3g} {unit}", state.time[near], values[near] / largest))
    caption = "Each divided by its largest value; up to the decision height, where the flare begins."
    return Plot(figure, title, caption, "time, s", "share of the largest", tuple(curves))


def angles(seed: int) -> Iterator[Plot]:
    """Elevation and its derivatives."""
    yield derivatives("fig. 2", "Elevation and its derivatives over the profile")


def variances(seed: int) -> Iterator[Plot]:
    """Theory, Monte Carlo and the band."""
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
            Curve("20 % below", time, believed * (1.0 - BAND) ** 2, "dashed"),
            Curve("20 % above", time, believed * (1.0 + BAND) ** 2, "dashed"),
        ),
        logarithmic=True,
    )


def one_realisation(seed: int) -> Iterator[Plot]:
    """Measured and filtered."""
    truth = printed_leg().angle[:, 0]
    noise = stream(seed, 0, 0, "volovyk2018.figure").standard_normal((LEG, 1, 1))
    measurements = record(truth[:, None, None] + SIGMA * noise)
    found = followed(PUBLISHED, truth[:, None], measurements, START).errors
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


FIGURES = {"fig. 1": profile, "fig. 2": angles, "fig. 4": variances, "fig. 5": one_realisation}
