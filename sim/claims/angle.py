"""The angle channel of the two papers on the landing system, drawn from their own model."""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from tracking.gaussian import Gaussian
from tracking.track import Measurements
from tracking.trackers.elevation import PERIOD, increments
from tracking.trackers.switching_noise import stationary

DEGREE = math.pi / 180.0
VARIANCE = 0.0036  # deg^2, printed
INCREMENT = 0.01  # deg/s per step: the printed Q = 1e-4 with B = [0, 1]'
MEASURED = ("mls.elevation",)
PRIOR = Gaussian(np.array([2.2906, 0.0]) * DEGREE, np.diag([0.005, 0.0122**2]) * DEGREE**2)


def drawn(
    generator: np.random.Generator,
    runs: int,
    steps: int,
    prior: Gaussian,
    chain: Any = ((1.0,),),
    factors: tuple[float, ...] = (1.0,),
) -> tuple[Any, Measurements]:
    """Truth of the angle (steps, runs), rad, and its measurements, whose accuracies follow a Markov chain."""
    transition, _ = increments(2, PERIOD, PERIOD, INCREMENT)
    chances, scale = np.array(chain), np.array(factors)
    cumulative = chances.cumsum(axis=1)
    cumulative[:, -1] = 1.0
    first = np.append(stationary(chances).cumsum()[:-1], 1.0) if len(chances) > 1 else np.ones(1)
    state = (generator.random(runs)[:, None] > first).sum(axis=1)
    x = prior.mean[:, None] + np.sqrt(np.diag(prior.cov))[:, None] * generator.standard_normal((2, runs))
    truth, z = np.empty((steps, runs)), np.empty((steps, 1, runs))
    for k in range(steps):
        if len(chances) > 1:
            state = (generator.random(runs)[:, None] > cumulative[state]).sum(axis=1)
        x = transition @ x
        x[1] += INCREMENT * DEGREE * generator.standard_normal(runs)
        truth[k] = x[0]
        z[k] = x[0] + math.sqrt(VARIANCE) * DEGREE * scale[state] * generator.standard_normal(runs)
    return truth, record(z)


def record(z: Any, variance: float = VARIANCE) -> Measurements:
    """Measurements of angles z (steps, 1, runs), rad, at the printed rate."""
    time = PERIOD * np.arange(1, len(z) + 1)
    return Measurements(MEASURED, time, time, z, np.full((len(z), 1, 1), variance * DEGREE**2))
