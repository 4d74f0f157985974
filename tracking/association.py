"""Which of several plots is the target's? Probabilistic data association under any tracker.

The textbook form corrects a Kalman filter by one combined innovation. That form needs the filter's gain, and for an
IMM one gain per model; a pseudo-measurement that would do the same to an arbitrary tracker need not exist, because
doubt about the plot can leave a covariance larger than the prediction. So each hypothesis - this plot, or none - is
handed to the tracker itself, weighed by the likelihood that the tracker gives it, and the resulting states are merged
by their moments. For a Kalman filter this is the textbook update; for an IMM the merging is within each model, which
is the joint posterior of model and plot.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Annotated, Any

import numpy as np

from tracking.gaussian import Gaussian, Innovation, Mixture, lift, merge, reweigh
from tracking.intervals import chi_square
from tracking.packed import Packed, pack, unpack
from tracking.track import Tracker
from tracking.tree import walk

Array = Any


def clutter_density(count: float, R: Array, sigmas: float = 3.0) -> Array:
    """False alarms per unit volume (*C) that put ``count`` of them, on average, inside ``sigmas`` of R (m, m, *C)."""
    m = len(R)
    unit_ball = math.pi ** (m / 2) / math.gamma(m / 2 + 1)
    return count / (unit_ball * sigmas**m * np.sqrt(np.linalg.det(np.moveaxis(np.asarray(R), (0, 1), (-2, -1)))))


@dataclass(frozen=True)
class ProbabilisticDataAssociation:
    """Any tracker, fed with the candidates (c, m, *B) of an epoch instead of one measurement.

    A candidate with a NaN is none. What a run may have seen: at most one candidate is the target's, the others are
    false alarms, Poisson in number and uniform in place. The tracker's state must be a `Gaussian`, a `Mixture`, or
    (nested tuples of) these and arrays; an array that is neither is taken from the most probable hypothesis. The
    tracker predicts once; a step of no time must be a mere update.

    The innovation is the combined one, its log-likelihood the logarithm of the ratio "target and false alarms" to
    "false alarms alone", which is the usual track score. Its NIS is smaller than chi-square.
    """

    tracker: Annotated[Tracker, "given"]
    clutter: Annotated[Any, "given"]  # false alarms per unit volume of the tracker's innovations, e.g. per m2
    detection_probability: float = 0.9
    gate_probability: float = 0.9997  # that the target's own plot, if there is one, is inside the gate

    def __post_init__(self) -> None:
        if not 0.0 < self.detection_probability <= 1.0:
            raise ValueError("detection_probability must lie above 0 and not above 1")
        if not 0.0 < self.gate_probability < 1.0:
            raise ValueError("gate_probability must lie between 0 and 1")
        if not np.all(np.asarray(self.clutter) > 0.0):
            raise ValueError("clutter must be positive; without false alarms use the tracker itself")

    @property
    def channels(self) -> tuple[str, ...]:
        return self.tracker.channels

    def begin(self, prior: Gaussian) -> Any:
        return self.tracker.begin(prior)

    def step(self, state: Any, dt: float, z: Any | None, R: Any | None) -> tuple[Any, Innovation | None]:
        """Predict by dt, then update with the candidates z (c, m, *B) that share R (m, m, *C)."""
        missed, _ = self.tracker.step(state, dt, None, None)
        if z is None:
            return missed, None
        candidates = [self.tracker.step(missed, 0.0, one, R) for one in z if not np.isnan(one).all()]
        hits = [(hit, innovation) for hit, innovation in candidates if innovation is not None]
        if not hits:
            return missed, None
        white = np.stack([innovation.white for _, innovation in hits])  # (c, m, *B)
        limit = chi_square(self.gate_probability, white.shape[1])
        nis = np.stack([innovation.nis for _, innovation in hits])
        inside = np.isfinite(white).all(axis=1) & (nis <= limit)
        score = np.stack([innovation.log_likelihood for _, innovation in hits])
        score = score + math.log(self.detection_probability) - np.log(self.clutter)
        none = np.full_like(score[:1], math.log1p(-self.detection_probability * self.gate_probability))
        score = np.concatenate([none, np.where(inside, score, -np.inf)])
        weights, total = reweigh(np.ones_like(score), score)
        combined = np.einsum("c...,ci...->i...", weights[1:], np.where(inside[:, None], white, 0.0))
        combined = np.where(inside.any(axis=0), combined, np.nan)
        nis = np.nansum(combined**2, axis=0)
        weights = np.where(np.isfinite(weights), weights, 0.0)
        return blend(weights, [missed, *(hit for hit, _ in hits)]), Innovation(combined, nis, total)

    def estimate(self, state: Any) -> Gaussian | Mixture:
        return self.tracker.estimate(state)


def blend(weights: Array, states: list[Any]) -> Any:
    """One state for all hypotheses of weights (h, *B): Gaussians merged by their moments, mixtures model by model."""

    def blended(first: Any, *others: Any) -> Any:
        leaves = [first, *others]
        if all(leaf is first for leaf in others):
            return first
        if isinstance(first, Gaussian):
            return _merged(weights, leaves)
        if isinstance(first, Mixture):
            return _merged_models(weights, leaves)
        if isinstance(first, Packed):
            return pack(_merged_models(weights, [unpack(leaf) for leaf in leaves]))
        return _most_probable(weights, leaves) if isinstance(first, np.ndarray | np.generic) else first

    return walk(blended, *states, whole=(Gaussian, Mixture, Packed))


def _merged(weights: Array, states: list[Gaussian]) -> Gaussian:
    batch = weights.ndim - 1
    means = np.stack(np.broadcast_arrays(*(state.mean for state in states)), axis=1)
    covs = np.stack(np.broadcast_arrays(*(lift(state.cov, 2, batch) for state in states)), axis=2)
    # what the hypothesis of weight zero holds may be NaN; it is not part of the mixture
    means = np.where(weights > 0.0, means, means[:, :1])
    covs = np.where(weights > 0.0, covs, covs[:, :, :1])
    return merge(Mixture(weights, means, covs))


def _merged_models(weights: Array, states: list[Mixture]) -> Mixture:
    batch = weights.ndim - 1
    models = np.stack(np.broadcast_arrays(*(state.weights for state in states)))  # (h, M, *B)
    joint = np.where(weights[:, None] > 0.0, weights[:, None] * models, 0.0)
    total = joint.sum(axis=0)
    share = np.where(total > 0.0, joint / np.where(total > 0.0, total, 1.0), weights[:, None])
    each = [Gaussian(state.mean, lift(state.cov, 3, batch)) for state in states]
    moved = _merged(share, each)
    return Mixture(total, moved.mean, moved.cov)


def _most_probable(weights: Array, states: list[Array]) -> Array:
    """Values of the likeliest hypothesis, run by run."""
    best = weights.argmax(axis=0)
    chosen = np.asarray(states[0])
    for h, state in enumerate(states[1:], start=1):
        if state is not states[0]:
            chosen = np.where(best == h, state, chosen)
    return chosen
