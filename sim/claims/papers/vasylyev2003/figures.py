"""Figures 3 and 4 of Vasylyev 2003, from our own runs."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from sim.claims.jsbsim_flights import flown
from sim.claims.ledger import FLIGHTS
from sim.claims.papers.vasylyev2003.experiment import (
    GIVEN_GAINS,
    MODEL,
    OUTSIDE,
    SIGMA,
    UNLIMITED,
    capture,
    errors,
    tracker,
)
from sim.claims.plots import Curve, Plot
from sim.flight.truths.route_capture import NOMINAL, RouteCapture

RUNS = 300


def captures(seed: int) -> Iterator[Plot]:
    """The capture with and without limits."""
    paths = {
        name: RouteCapture("double_integrator", law, OUTSIDE, speed=400.0, duration=200.0).fly(step=0.5).state
        for name, law in (("without limits", UNLIMITED), ("with limits", NOMINAL))
    }
    flight = flown(GIVEN_GAINS, ("start.cross_track_m", OUTSIDE)).state
    shown = flight.time <= 200.0
    yield Plot(
        "fig. 3",
        "Capture of a line",
        "From 5 km beside it; z_max 1250 m at 100 m/s, on JSBSim 900 m at 72 m/s; bank 20 deg.",
        "time, s",
        "cross-track, m",
        (
            *(Curve(name, state.time, state.east) for name, state in paths.items()),
            Curve("with limits, flown on JSBSim", flight.time[shown], flight.east[shown], "dashed"),
        ),
    )


def lateral_errors(seed: int) -> Iterator[Plot]:
    """Errors of both filters, on the model and on JSBSim."""
    for truth, runs, where in (
        (MODEL, RUNS, "in the double integrator"),
        (GIVEN_GAINS, FLIGHTS, f"of {FLIGHTS} flights on JSBSim"),
    ):
        data = capture(seed, runs, OUTSIDE, truth)
        time = data.measurements.time[1:]
        names = {"linear": "linear feedback", "saturated": "saturated control"}
        found = {text: errors(tracker(name, data), data) for name, text in names.items()}
        yield Plot(
            "fig. 4",
            f"Lateral error of both filters, {where}",
            f"RMSE of {data.truth.shape[-1]} runs of the limited capture; the radar has 100 m.",
            "time, s",
            "RMSE, m",
            (
                *(Curve(name, time, np.sqrt((e**2).mean(axis=1))) for name, e in found.items()),
                Curve("radar", time, np.full(len(time), SIGMA), "dashed"),
            ),
            logarithmic=True,
        )


FIGURES = {"fig. 3": captures, "fig. 4": lateral_errors}
