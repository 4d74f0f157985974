"""Figure 1 of Glistin and Panasyuk, from our own runs."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from sim.claims.ledger import DRAWS, FLIGHTS
from sim.claims.papers.glistin.cases import FINE, JSBSIM, case
from sim.claims.papers.glistin.experiment import squares
from sim.claims.plots import Curve, Plot

RUNS = 100
NAMES = {
    "kinematic": "without load factors",
    "published": "formula as published",
    "corrected": "corrected",
    "corrected_residual": "corrected, with a residual",
}


def azimuth_errors(seed: int) -> Iterator[Plot]:
    """On a kinematic flight and on those of JSBSim."""
    for flight, title, runs, said in (
        ("base turn", "in a base turn", RUNS, f"{RUNS} runs"),
        (JSBSIM, "in turns onto final flown on JSBSim", FLIGHTS, f"{FLIGHTS} flights of {DRAWS} draws"),
    ):
        data = case(seed, runs, flight, FINE)
        time = data.measurements.time
        turn = time[data.turning.any(axis=1)]
        yield Plot(
            "fig. 1",
            f"Azimuth error {title}",
            f"{FINE}, {said}; turns from {turn[0]:.0f} to {turn[-1]:.0f} s.",
            "time, s",
            "azimuth RMSE, deg",
            tuple(
                Curve(name, time, np.sqrt(squares(kind, seed, runs, flight, FINE).mean(axis=1)))
                for kind, name in NAMES.items()
            ),
        )


FIGURES = {"fig. 1": azimuth_errors}
