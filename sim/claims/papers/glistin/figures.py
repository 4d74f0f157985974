"""Figure 1 of Glistin and Panasyuk, from our own runs."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

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
    """On a kinematic flight and on JSBSim's."""
    for flight, title in (("base turn", "in a base turn"), (JSBSIM, "in a turn onto final flown on JSBSim")):
        data = case(seed, RUNS, flight, FINE)
        time = data.measurements.time
        turn = time[data.turning]
        yield Plot(
            "fig. 1",
            f"Azimuth error {title}",
            f"{FINE}, {RUNS} runs; the turn lasts from {turn[0]:.0f} to {turn[-1]:.0f} s.",
            "time, s",
            "azimuth RMSE, deg",
            tuple(
                Curve(name, time, np.sqrt(squares(kind, seed, RUNS, flight, FINE).mean(axis=1)))
                for kind, name in NAMES.items()
            ),
        )


FIGURES = {"fig. 1": azimuth_errors}
