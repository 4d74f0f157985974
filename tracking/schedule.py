"""Gains computed once for a whole ensemble: the covariance of a linear filter does not look at the data.

With an accuracy that all runs share, one epoch of a linear filter is one small matrix that takes the states and
measurements of all runs to their new states and whitened innovations. `schedule` computes these matrices, `Scheduled`
is the tracker that applies them. Chunks of an ensemble, and every further ensemble of the same epochs, reuse them.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np

from tracking.gaussian import Gaussian, Innovation, lift
from tracking.track import Measurements, Tracker

LINEAR = 1e-9  # relative: superposition of a linear filter holds to rounding


class Gain(NamedTuple):
    """One epoch: ``[x+; white] = from_state x + from_measurement z``."""

    from_state: Any  # (n + m, n)
    from_measurement: Any | None  # (n + m, m); None where nothing is measured
    present: Any | None  # (m,) mask of the measured rows where not all are
    cov: Any  # (n, n) after the epoch
    log_volume: float  # log-likelihood of a zero innovation


class ScheduledState(NamedTuple):
    """Where in the schedule the filter is, and what it believes."""

    epoch: int
    gaussian: Gaussian


@dataclass(frozen=True, eq=False)
class Scheduled:
    """A linear filter with stored gains, exact for the epochs it was scheduled for."""

    channels: tuple[str, ...]
    gains: tuple[Gain, ...]

    def begin(self, prior: Gaussian) -> ScheduledState:
        return ScheduledState(0, prior)

    def step(
        self, state: ScheduledState, dt: float, z: Any | None, R: Any | None
    ) -> tuple[ScheduledState, Innovation | None]:
        """Next epoch of the schedule, which holds dt and R already."""
        if state.epoch == len(self.gains):
            raise ValueError(f"the schedule ends after {len(self.gains)} epochs")
        gain, n = self.gains[state.epoch], len(self.channels)
        mean = state.gaussian.mean
        both = _times(gain.from_state, mean)
        innovation = None
        if gain.from_measurement is not None:
            if z is None:
                raise ValueError(f"the schedule has a measurement in epoch {state.epoch}, the record has none")
            part = _times(gain.from_measurement, z if gain.present is None else z[gain.present])
            both = np.add(both, part, out=part)  # z has the batch; the mean may still be shared
            innovation = _innovation(both[n:], gain)
        elif z is not None:
            raise ValueError(f"the record has a measurement in epoch {state.epoch}, the schedule has none")
        posterior = Gaussian(both[:n], lift(gain.cov, 2, mean.ndim - 1))
        return ScheduledState(state.epoch + 1, posterior), innovation

    def estimate(self, state: ScheduledState) -> Gaussian:
        return state.gaussian


def schedule(tracker: Tracker, measurements: Measurements, prior: Gaussian, start: float | None = None) -> Scheduled:
    """Stored gains of a linear tracker for the epochs and accuracies of a record [Volovyk 2018, eqs. (7)-(10)].

    The tracker itself is asked: its response to unit states and unit measurements are the columns of the matrices, so
    its algebra exists once. ``measurements`` needs no more than one run; of its values only presence counts.

    Raises
    ------
    ValueError : the tracker's answer is not linear, or its covariance depends on the data or differs between runs.
    """
    time = np.asarray(measurements.arrival, dtype=float)
    order = np.argsort(time, kind="stable")
    now = float(time[order[0]]) if start is None else float(start)
    absent = np.isnan(np.asarray(measurements.z)).reshape(*measurements.z.shape[:2], -1)
    if (absent != absent[:, :, :1]).any():
        raise ValueError("a channel is absent in some runs only: their covariances differ, so no schedule serves them")
    R = np.asarray(measurements.R, dtype=float).reshape(*measurements.R.shape[:3], -1)
    if (R[..., :1] != R).any():
        raise ValueError("the accuracy differs between runs, so no schedule serves them")
    n, m = len(prior.mean), absent.shape[1]
    cov = np.asarray(prior.cov, dtype=float).reshape(n, n, -1)
    if cov.shape[-1] != 1:
        raise ValueError("the covariance of the prior differs between runs, so no schedule serves them")
    if not isinstance(tracker.begin(Gaussian(lift(np.asarray(prior.mean), 1, 1), cov)), Gaussian):
        raise ValueError("a tracker of several hypotheses has no schedule: its weights depend on the data")
    gains = []
    for k in order.tolist():
        here = ~absent[k, :, 0]
        gain = _probe(tracker, cov, float(time[k]) - now, R[k, :, :, :1], here, n, m)
        gains.append(gain)
        cov, now = gain.cov[:, :, None], float(time[k])
    return Scheduled(tracker.channels, tuple(gains))


def _probe(tracker: Tracker, cov: Any, dt: float, R: Any, here: Any, n: int, m: int) -> Gain:
    """Matrices of one epoch from the tracker's response to unit vectors, to zero and to a superposition."""
    weights = 1.0 + np.arange(n + m)
    columns = np.concatenate([np.eye(n + m), np.zeros((n + m, 1)), weights[:, None]], axis=1)
    z = np.where(here[:, None], columns[n:], np.nan) if here.any() else None
    state, innovation = tracker.step(Gaussian(columns[:n], cov), dt, z, R if here.any() else None)
    if np.ptp(state.cov, axis=-1).any():
        raise ValueError("the covariance of this tracker depends on the data: it has no schedule")
    answer = state.mean if innovation is None else np.concatenate([state.mean, innovation.white[here]])
    matrix, zero, both = answer[:, : n + m], answer[:, n + m], answer[:, n + m + 1]
    scale = np.abs(matrix) @ weights
    if zero.any() or not (np.abs(matrix @ weights - both) <= LINEAR * scale).all():
        raise ValueError("this tracker is not linear in its state and measurements: it has no schedule")
    if innovation is None:
        return Gain(matrix[:, :n].copy(), None, None, state.cov[..., 0], 0.0)
    present = None if here.all() else here
    volume = float(innovation.log_likelihood[n + m])
    return Gain(matrix[:, :n].copy(), matrix[:, n:][:, here].copy(), present, state.cov[..., 0], volume)


def _innovation(white: Any, gain: Gain) -> Innovation:
    nis = np.einsum("i...,i...->...", white, white)
    log_likelihood = nis * -0.5
    log_likelihood += gain.log_volume
    if gain.present is not None:
        every = np.full((len(gain.present), *white.shape[1:]), np.nan)
        every[gain.present] = white
        white = every
    return Innovation(white, nis, log_likelihood)


def _times(A: Any, x: Any) -> Any:
    """``A x`` for A (p, n) and x (n, *B); BLAS is slow where n = 1."""
    if A.shape[1] == 1:
        return lift(A[:, 0], 1, x.ndim - 1) * x
    return A @ x if x.ndim <= 2 else np.einsum("ij,j...->i...", A, x)
