"""Estimates from measurements before and after: for debriefing (the whole record) or with a fixed delay.

One model: Rauch, Tung and Striebel's step corrects a filtered estimate by what the epoch after it has become. Several
models: the past (the IMM's filtered estimate) is multiplied by the likelihood of the future, which is an IMM run
backwards. The backward step of one model cannot serve there: between nearly deterministic models it repeats the next
epoch's estimate backwards and forgets the filtered one, so that errors of the merging add up along the record.

Either step, applied once from the end to the start, smooths over the whole record; applied L times to all epochs at
once it smooths each over the L measurements after it.
"""

from __future__ import annotations

from dataclasses import dataclass
from itertools import pairwise
from typing import Any, NamedTuple

import numpy as np

from tracking.gaussian import Gaussian, Mixture, interact, lift, merge, predict, reweigh, update, update_mixture
from tracking.motion import Motion
from tracking.track import Epoch, Measurements, Track, follow, track
from tracking.trackers.imm import InteractingMultipleModel, switching_over, transitions

Array = Any

DIFFUSE = 1e6  # times the filtered covariance, where the future says nothing yet


def smooth(track: Track, motion: Motion) -> Track:
    """Means and covariances given the whole record of a one-model filter (Rauch, Tung, Striebel).

    Exact for a linear motion; for one that depends on the state, linearised where the filter linearised it.

    Parameters
    ----------
    track : of a filter that moved with ``motion`` and nothing else, mean (k, n, *B).
    """
    estimates, links = _links(track, motion)
    for k in range(len(links) - 1, -1, -1):
        estimates[k] = _corrected(estimates[k], links[k], estimates[k + 1])
    return _replaced(track, estimates)


def smooth_fixed_lag(track: Track, motion: Motion, lag: int) -> Track:
    """Means and covariances given the measurements up to ``lag`` epochs later, fewer at the end of the record.

    The estimate of time[k] is known at time[k + lag].
    """
    if lag < 0:
        raise ValueError("lag must not be negative")
    filtered, links = _links(track, motion)
    estimates = list(filtered)
    for _ in range(min(lag, len(links))):
        corrected = [_corrected(filtered[k], links[k], estimates[k + 1]) for k in range(len(links))]
        estimates = [*corrected, filtered[-1]]
    return _replaced(track, estimates)


def smooth_models(
    tracker: InteractingMultipleModel,
    measurements: Measurements,
    prior: Gaussian,
    start: float | None = None,
    lag: int | None = None,
) -> Track:
    """Estimates and model probabilities of an IMM given the whole record, or given ``lag`` further measurements.

    With i the model of an epoch and x its state, ``p(x, i | all) ~ p(x, i | past) p(future | x, i)``. The last factor
    obeys a recursion backwards in time that is an IMM again: update with a measurement, undo each model's motion,
    mix over the next model with the rows of the switching matrix. Its merging to one Gaussian for each model is the
    approximation, as in the filter. It begins with a covariance ``DIFFUSE`` times the filtered one, in place of
    knowing nothing. One model: `smooth`, to about 1/DIFFUSE.

    Models and measurements that depend on the state are linearised where the filter found it.

    Parameters
    ----------
    As for `track`, which gives the same record without smoothing; lag None is the whole record.
    """
    if lag is not None and lag < 0:
        raise ValueError("lag must not be negative")
    epochs = list(follow(tracker, measurements, prior, start))
    filtered = [_mixture(epoch) for epoch in epochs]
    ahead = [_diffuse(estimate) for estimate in filtered]
    steps = [_Step(tracker, measurements, *pair) for pair in pairwise(epochs)]
    if lag is None:
        for k in range(len(steps) - 1, -1, -1):
            ahead[k] = steps[k].back(ahead[k + 1])
    else:
        for _ in range(min(lag, len(steps))):
            ahead = [*(step.back(later) for step, later in zip(steps, ahead[1:], strict=True)), ahead[-1]]
    smoothed = filtered if lag == 0 else [*map(_joined, filtered[:-1], ahead[:-1]), filtered[-1]]
    record = track(tracker, measurements, prior, start)
    merged = [merge(estimate) for estimate in smoothed]
    weights = np.stack(np.broadcast_arrays(*(estimate.weights for estimate in smoothed)))
    return _replaced(record, merged)._replace(model_probabilities=weights)


class _Link(NamedTuple):
    """How one epoch leads to the next."""

    F: Array
    Q: Array
    predicted: Array  # mean of the next epoch
    gain: Array  # P F' (F P F' + Q)^-1


def _link(filtered: Gaussian, F: Array, Q: Array, u: Array | None) -> _Link:
    moved = predict(filtered, F, Q, u)
    batch = max(F.ndim, np.ndim(filtered.cov)) - 2
    cross = np.einsum("ij...,jk...->ik...", lift(F, 2, batch), lift(filtered.cov, 2, batch))  # F P
    return _Link(F, Q, moved.mean, _solve(moved.cov, cross).swapaxes(0, 1))


def _corrected(filtered: Gaussian, link: _Link, after: Gaussian) -> Gaussian:
    """The estimate given what the next epoch has become.

    ``P + G (P+ - P-) G'`` written as ``(1 - G F) P (1 - G F)' + G (P+ + Q) G'``, which cannot become indefinite.
    """
    batch = link.gain.ndim - 2
    F, Q, P, later = (lift(matrix, 2, batch) for matrix in (link.F, link.Q, filtered.cov, after.cov))
    mean = filtered.mean + np.einsum("ij...,j...->i...", link.gain, after.mean - link.predicted)
    rest = lift(np.eye(len(P)), 2, batch) - np.einsum("ij...,jk...->ik...", link.gain, F)
    cov = _congruent(rest, P) + _congruent(link.gain, later + Q)
    return Gaussian(mean, 0.5 * (cov + cov.swapaxes(0, 1)))


def _links(track: Track, motion: Motion) -> tuple[list[Gaussian], list[_Link]]:
    estimates = [Gaussian(mean, cov) for mean, cov in zip(track.mean, track.cov, strict=True)]
    links = [
        _link(estimate, *motion.transition(float(dt), estimate.mean))
        for estimate, dt in zip(estimates[:-1], np.diff(track.time), strict=True)
    ]
    return estimates, links


def _replaced(track: Track, estimates: list[Gaussian]) -> Track:
    covs = np.broadcast_arrays(*(estimate.cov for estimate in estimates))
    return track._replace(mean=np.stack([estimate.mean for estimate in estimates]), cov=np.stack(covs))


@dataclass(frozen=True)
class _Step:
    """From one epoch to the next, for the likelihood of the future."""

    tracker: InteractingMultipleModel
    measurements: Measurements
    before: Epoch
    after: Epoch

    def back(self, ahead: Mixture) -> Mixture:
        """Likelihood of what follows the earlier epoch from that of what follows the later one."""
        ahead = self._measured(ahead)
        dt = self.after.time - self.before.time
        if dt <= 0.0:  # no time, no motion and no switching
            return ahead
        model_set = self.tracker._set
        switching = switching_over(model_set, dt)
        mixed = interact(_mixture(self.before), switching).mean  # where the filter linearised
        F, Q, u = transitions(model_set.models, dt, mixed)
        inverse = _solve(F, lift(np.eye(len(F)), 2, F.ndim - 2))
        mean = ahead.mean if u is None else ahead.mean - u
        moved = predict(Gaussian(mean, ahead.cov), inverse, _congruent(inverse, Q))
        mixture = interact(Mixture(ahead.weights, moved.mean, moved.cov), switching.T)
        return mixture._replace(weights=mixture.weights / mixture.weights.sum(axis=0))

    def _measured(self, ahead: Mixture) -> Mixture:
        """Take in the measurement of the later epoch."""
        z = self.measurements.z[self.after.row]
        if np.isnan(z).all():
            return ahead
        R = lift(self.measurements.R[self.after.row], 2, z.ndim - 1)
        found = merge(_mixture(self.after)).mean
        return update_mixture(ahead, *self.tracker.measurement.linearise(z, R, found))[0]


def _mixture(epoch: Epoch) -> Mixture:
    """The estimate of an epoch of an IMM."""
    assert isinstance(epoch.estimate, Mixture)
    return epoch.estimate


def _diffuse(filtered: Mixture) -> Mixture:
    """A likelihood of the state that says next to nothing."""
    merged = merge(filtered)
    count = len(filtered.weights)
    weights = np.full(filtered.weights.shape, 1.0 / count)
    mean = np.repeat(merged.mean[:, None], count, axis=1)
    return Mixture(weights, mean, DIFFUSE * np.repeat(merged.cov[:, :, None], count, axis=2))


def _joined(filtered: Mixture, ahead: Mixture) -> Mixture:
    """Product of the past with the likelihood of the future, model by model."""
    batch = filtered.mean.ndim - 1
    past = Gaussian(filtered.mean, lift(filtered.cov, 2, batch))
    joint, innovation = update(past, ahead.mean, np.eye(len(past.mean)), lift(ahead.cov, 2, batch))
    weights, _ = reweigh(filtered.weights * ahead.weights, innovation.log_likelihood)
    return Mixture(weights, joint.mean, joint.cov)


def _solve(A: Array, X: Array) -> Array:
    """``A^-1 X`` for A (n, n, *C) and X (n, m, *C)."""
    batch = max(A.ndim, X.ndim) - 2
    A, X = (np.moveaxis(lift(matrix, 2, batch), (0, 1), (-2, -1)) for matrix in (A, X))
    return np.moveaxis(np.linalg.solve(A, X), (-2, -1), (0, 1))


def _congruent(A: Array, P: Array) -> Array:
    """``A P A'``."""
    return np.einsum("ij...,jk...,lk...->il...", A, P, A)
