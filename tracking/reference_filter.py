"""What can be achieved on a jump-Markov system: a tree of mode histories, each followed exactly.

The posterior of such a system is a mixture with one Gaussian per history of modes. Here the histories are kept one by
one, without merging, and thinned to a fixed number by the optimal resampling of Fearnhead and Clifford (2003): heavy
histories survive with their own weight, of the light ones an unbiased choice survives with a common weight. Merging
trackers are measured against it; greedy thinning is not a substitute, it forgets the histories that become right later.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Annotated, Any, NamedTuple

import numpy as np

from tracking.gaussian import Gaussian, Innovation, Mixture, lift, predict, update_mixture
from tracking.measurement import MeasurementModel
from tracking.trackers.imm import ModelSet, switching_over, transitions

Array = Any

GOLDEN = (math.sqrt(5.0) - 1.0) / 2.0


class Histories(NamedTuple):
    """Histories of modes, by their last mode."""

    mixture: Mixture  # along the histories
    mode: Array  # (histories, *B)
    epoch: int


@dataclass(frozen=True)
class ReferenceFilter:
    """Bayes' posterior of a set of switching models, up to the thinning to ``histories`` Gaussians.

    The offset of the systematic choice walks the golden-ratio sequence, which is equidistributed: no randomness is
    drawn, and equal measurements give equal estimates.
    """

    measurement: Annotated[MeasurementModel, "given"]
    model_set: Annotated[ModelSet, "given"]
    histories: int = 300

    def __post_init__(self) -> None:
        if self.histories < 1:
            raise ValueError("histories must be at least 1")

    @property
    def channels(self) -> tuple[str, ...]:
        return self.model_set.models[0].channels

    def begin(self, prior: Gaussian) -> Histories:
        batch = prior.mean.ndim - 1
        modes = np.arange(len(self.model_set.models))
        weights = lift(np.array(self.model_set.probabilities), 1, batch)
        mean = np.repeat(prior.mean[:, None], len(modes), axis=1)
        cov = np.repeat(lift(prior.cov, 2, batch)[:, :, None], len(modes), axis=2)
        return Histories(Mixture(weights, mean, cov), modes.reshape(-1, *(1,) * batch), 0)

    def step(self, state: Histories, dt: float, z: Any | None, R: Any | None) -> tuple[Histories, Innovation | None]:
        mixture, mode, epoch = state
        if dt > 0.0:  # no time, no switching
            mixture, mode = self._branched(mixture, mode, dt)
        innovation = None
        if z is not None:
            predicted = np.einsum("m...,im...->i...", mixture.weights, mixture.mean)
            mixture, innovation = update_mixture(mixture, *self.measurement.linearise(z, R, predicted))
        if mixture.mean.shape[1] > self.histories:
            mixture, mode = self._thinned(mixture, mode, math.modf((epoch + 1) * GOLDEN)[0])
        return Histories(mixture, mode, epoch + 1), innovation

    def estimate(self, state: Histories) -> Mixture:
        return state.mixture

    def _branched(self, mixture: Mixture, mode: Array, dt: float) -> tuple[Mixture, Array]:
        """Each history continued in each mode: children in the order (mode, parent)."""
        models = self.model_set.models
        count, parents, batch = len(models), mixture.mean.shape[1], mixture.mean.ndim - 2
        weights = np.moveaxis(switching_over(self.model_set, dt)[mode], -1, 0) * mixture.weights
        weights = weights.reshape(-1, *weights.shape[2:])
        mean = np.repeat(mixture.mean[:, None], count, axis=1)
        F, Q, u = transitions(models, dt, mean)
        F, Q = (np.broadcast_to(A, (*A.shape[:3], parents, *A.shape[4:])) for A in (F, Q))
        F, Q = (A.reshape(*A.shape[:2], -1, *A.shape[4:]) for A in (F, Q))
        u = None if u is None else u.reshape(len(u), -1, *u.shape[3:])
        cov = np.tile(mixture.cov, (1, 1, count, *(1,) * (mixture.cov.ndim - 3)))
        moved = predict(Gaussian(mean.reshape(len(mean), -1, *mean.shape[3:]), cov), F, Q, u)
        modes = np.repeat(np.arange(count), parents).reshape(-1, *(1,) * batch)
        return Mixture(weights, moved.mean, moved.cov), modes

    def _thinned(self, mixture: Mixture, mode: Array, offset: float) -> tuple[Mixture, Array]:
        shape = mixture.mean.shape[1:]
        index, weights = optimal_resampling(np.broadcast_to(mixture.weights, shape), self.histories, offset)
        cov = np.broadcast_to(lift(mixture.cov, 3, len(shape) - 1), (*mixture.cov.shape[:2], *shape))
        mean = np.take_along_axis(mixture.mean, index[None], axis=1)
        cov = np.take_along_axis(cov, index[None, None], axis=2)
        return Mixture(weights, mean, cov), np.take_along_axis(np.broadcast_to(mode, shape), index, axis=0)


def optimal_resampling(weights: Array, count: int, offset: float) -> tuple[Array, Array]:
    """Indices and weights (count, *B) of a thinned mixture with weights (H, *B) that sum to one.

    Minimises the expected squared change of the weights among all unbiased choices: with the threshold t that solves
    ``sum min(w / t, 1) = count``, a weight of at least t is kept; of the others those survive, with weight t, in which
    a comb of spacing t and of the given offset in [0, 1) has a tooth.
    """
    ordered = -np.sort(-weights, axis=0)
    tail = np.cumsum(ordered[::-1], axis=0)[::-1]  # of the sorted weights from i on
    left = np.arange(count, 0, -1).reshape(-1, *(1,) * (weights.ndim - 1))
    fits = ordered[:count] * left <= tail[:count]
    kept = np.argmax(fits, axis=0)  # the first that fits; the last always does
    threshold = np.take_along_axis(tail[:count] / left, kept[None], axis=0)[0]
    rank = np.argsort(np.argsort(-weights, axis=0, kind="stable"), axis=0)
    heavy = rank < kept
    share = np.where(heavy, 0.0, weights) / np.where(threshold > 0.0, threshold, 1.0)
    comb = np.floor(np.cumsum(share, axis=0) + offset)
    tooth = np.diff(comb, axis=0, prepend=math.floor(offset)) > 0.0
    thinned = np.where(heavy, weights, np.where(tooth, threshold, 0.0))
    index = np.argsort(~(heavy | tooth), axis=0, kind="stable")[:count]
    chosen = np.take_along_axis(thinned, index, axis=0)
    return index, chosen / chosen.sum(axis=0)
