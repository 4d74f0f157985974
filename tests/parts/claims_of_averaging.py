"""A textbook as a paper: 25 equally good plots are five times as accurate as one of them."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from sim.claims.ledger import Claim, Reading
from sim.claims.verdict import number
from sim.randomness import stream
from tracking.gaussian import Gaussian, update
from tracking.intervals import Interval, gain

PLOTS, SIGMA = 25, 100.0  # m


def one_over_all(known: float) -> Callable[[int, int], Interval]:
    """RMSE of one plot over that of a Kalman filter after all; ``known`` (m) is the accuracy before the first."""

    def measure(seed: int, runs: int) -> Interval:
        noise = np.stack([stream(seed, 0, run, "plots").standard_normal(1 + PLOTS) for run in range(runs)], axis=-1)
        state = Gaussian(known * noise[:1], np.array([[known**2]]))
        for plot in SIGMA * noise[1:]:
            state, _ = update(state, plot[None], np.eye(1), SIGMA**2 * np.eye(1))
        return gain((SIGMA * noise[1]) ** 2, state.mean[0] ** 2)

    return measure


CLAIMS = (
    Claim(
        "averaging",
        "25 equally good plots are five times as accurate as one",
        "any textbook",
        number("5"),
        (
            Reading("nothing known before", one_over_all(1e4)),
            Reading("as much known before as one plot says", one_over_all(SIGMA)),
        ),
        "times",
        first_runs=400,
    ),
)
