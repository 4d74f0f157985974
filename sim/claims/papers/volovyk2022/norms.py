"""The accuracy of the angle against what is regulated: Annex 10, and what the paper takes for it."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np

from sim.claims.papers.volovyk2022.experiment import SIGMAS, Experiment, by_run, experiment, mean_over_scans, squares
from sim.claims.papers.volovyk2022.landing_paths import LEFT
from sim.flight.truths.landing_pattern import FINAL, GLIDE
from tracking.intervals import Interval, gain

NORM_SHARE, NORM_LEAST, NORM_OF_DEVIATION = 0.006, 9.0, 0.1  # Annex 10, 3.2.3.3.1: of the distance, m, of the deviation
WITHIN = 1.959964  # standard deviations that hold 95 % of a Gaussian
Norm = Callable[[Experiment], Any]  # largest cross-range error (k, runs), m


def annex_10(data: Experiment) -> Any:
    """What Annex 10 allows a precision approach radar."""
    share = NORM_SHARE * data.distance + NORM_OF_DEVIATION * np.abs(data.truth[:, 1])
    return np.maximum(share, NORM_LEAST)


def one_degree(data: Experiment) -> Any:
    """The 1 deg that the paper calls the requirement, as the largest error."""
    return SIGMAS[1] * data.distance


def two_sigma(data: Experiment) -> Any:
    """The same as the standard deviation that it is in the experiment: what holds 95 % of it."""
    return WITHIN * SIGMAS[1] * data.distance


def norm_over(name: str, truth: str = LEFT) -> Any:
    """Measure of the RMS of the norm of Annex 10 over the cross-range RMSE on the glide path."""

    def measured(seed: int, runs: int) -> Interval:
        data, own = experiment(seed, runs, truth), squares(name, seed, runs, truth).own["azimuth"]
        glide = data.phase == GLIDE
        parts = (annex_10(data) ** 2, own * data.distance**2)
        return gain(*(by_run(part, glide, data.draws) for part in parts))

    return measured


def within(norm: Norm, name: str, far: float, near: float, truth: str = LEFT) -> Any:
    """Measure of the share of scans (per cent) with a cross-range error within a norm, from ``far`` to ``near`` (m)."""

    def measured(seed: int, runs: int) -> Interval:
        data, own = experiment(seed, runs, truth), squares(name, seed, runs, truth).own["azimuth"]
        among = np.isin(data.phase, (FINAL, GLIDE)) & (data.to_go < far) & (data.to_go >= near)
        return mean_over_scans(100.0 * (np.sqrt(own) * data.distance <= norm(data)), among, data.draws)

    return measured
