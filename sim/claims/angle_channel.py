"""The angle channel of the two papers on the landing system: drawn from their own model, or along a flight."""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from tracking.gaussian import Gaussian
from tracking.track import Measurements
from tracking.trackers.elevation import PERIOD
from tracking.trackers.switching_noise import stationary

DEGREE = math.pi / 180.0
VARIANCE = 0.0036  # deg^2, printed
SIGMA = math.sqrt(VARIANCE) * DEGREE  # rad
INCREMENT = 0.01  # deg/s per step: the printed Q = 1e-4 with B = [0, 1]'
MEASURED = ("mls.elevation",)
PRIOR = Gaussian(np.array([2.2906, 0.0]) * DEGREE, np.diag([0.005, 0.0122**2]) * DEGREE**2)
STEADY = ((1.0,),)  # one accuracy for ever


def drawn(
    generator: np.random.Generator,
    runs: int,
    steps: int,
    prior: Gaussian,
    chain: Any = STEADY,
    factors: tuple[float, ...] = (1.0,),
) -> tuple[Any, Measurements]:
    """Truth of the angle (steps, runs), rad, by the model (5), and its measurements."""
    scale = accuracies(generator, runs, steps, chain, factors)
    angle, rate = prior.mean[:, None] + np.sqrt(np.diag(prior.cov))[:, None] * generator.standard_normal((2, runs))
    pushed = INCREMENT * DEGREE * generator.standard_normal((steps, runs))
    rates = rate + np.concatenate([np.zeros((1, runs)), pushed[:-1].cumsum(axis=0)])  # before each step
    truth = angle + PERIOD * rates.cumsum(axis=0)
    return truth, record((truth + SIGMA * scale * generator.standard_normal((steps, runs)))[:, None])


def along(
    generator: np.random.Generator,
    truth: Any,
    spread: Any,
    chain: Any = STEADY,
    factors: tuple[float, ...] = (1.0,),
) -> tuple[Any, Measurements, Gaussian]:
    """Truth (steps, runs), measurements and prior on angles that are flown; ``truth`` begins a step before."""
    steps, runs = len(truth) - 1, truth.shape[1]
    scale = accuracies(generator, runs, steps, chain, factors)
    start = np.stack([truth[0], (truth[1] - truth[0]) / PERIOD])
    mean = start + np.sqrt(np.diag(spread))[:, None] * generator.standard_normal((2, runs))
    z = truth[1:] + SIGMA * scale * generator.standard_normal((steps, runs))
    return truth[1:], record(z[:, None]), Gaussian(mean, spread)


def accuracies(generator: np.random.Generator, runs: int, steps: int, chain: Any, factors: tuple[float, ...]) -> Any:
    """Factor of the sigma (steps, runs) that follows a Markov chain from its stationary state."""
    chances, scale = np.array(chain), np.array(factors)
    if len(chances) == 1:
        return np.full((steps, 1), scale[0])
    cumulative = chances.cumsum(axis=1)
    cumulative[:, -1] = 1.0
    state = (generator.random(runs)[:, None] > np.append(stationary(chances).cumsum()[:-1], 1.0)).sum(axis=1)
    states = np.empty((steps, runs), int)
    for k, chance in enumerate(generator.random((steps, runs, 1))):
        state = states[k] = (chance > cumulative[state]).sum(axis=1)
    return scale[states]


def record(z: Any, variance: float = VARIANCE) -> Measurements:
    """Measurements of angles z (steps, 1, runs), rad, at the printed rate."""
    time = PERIOD * np.arange(1, len(z) + 1)
    return Measurements(MEASURED, time, time, z, np.full((len(z), 1, 1), variance * DEGREE**2))
