"""Is an estimate as good as it says? Errors against covariances, with intervals over independent runs.

What is accumulated is sums per run and sums per epoch, so that an ensemble needs no histories; errors of one run are
correlated in time, so every interval is over runs.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import lru_cache
from itertools import pairwise
from typing import Any, NamedTuple

import numpy as np
from scipy import special

from tracking.gaussian import Gaussian, Innovation, Mixture, merge, whitened
from tracking.intervals import Interval, chi_square, correlation_band, mean_interval, proportion, rmse

Array = Any

LOST_PROBABILITY = 1e-6  # of a true position outside the ellipse of a consistent tracker
LOST_EPOCHS = 10
LEVELS = (0.5, 0.9, 0.95)


def normalised_error(estimate: Gaussian | Mixture, truth: Array, components: tuple[int, ...] | None = None) -> Array:
    """Normalised estimation error squared ``e' P^-1 e`` (*B), of all or of some components.

    Parameters
    ----------
    truth : (n, *B), broadcasting.
    components : indices of the components that are judged; None judges the whole state. Name the two apart: the
        position of a four-state filter has an expectation of 2, its full state of 4.
    """
    gaussian = merge(estimate) if isinstance(estimate, Mixture) else estimate
    error, cov = gaussian.mean - truth, gaussian.cov
    if components is not None:
        error, cov = error[list(components)], cov[np.ix_(components, components)]
    white = whitened(cov, error)
    return np.einsum("i...,i...->...", white, white)


def lost(nees: Array, degrees: int) -> Array:
    """Whether each run (*B) was lost: non-finite, or outside its 1 - 1e-6 ellipse for ten epochs in a row.

    Parameters
    ----------
    nees : (k, *B), of the position.
    degrees : components of the position.
    """
    return lost_by(nees, degrees)[-1] if len(nees) else np.zeros(np.shape(nees)[1:], dtype=bool)


def lost_by(nees: Array, degrees: int) -> Array:
    """Whether each run has been `lost` up to each epoch (k, *B)."""
    outside, ever = np.zeros(np.shape(nees)[1:], dtype=int), ~np.isfinite(nees)
    for row, epoch in enumerate(nees):
        outside = _outside(outside, epoch, degrees)
        ever[row] |= outside >= LOST_EPOCHS
    return np.logical_or.accumulate(ever, axis=0)


def _outside(before: Array, nees: Array, degrees: int) -> Array:
    """Epochs in a row outside the ellipse, up to now."""
    return np.where(nees <= _lost_square(degrees), 0, before + 1)


def autocorrelation(white: Array, lags: int) -> Array:
    """Autocorrelation (lags + 1, *B) of whitened innovations (k, m, *B) along time, 1 at lag 0.

    Compare with `correlation_band` of the m k samples. Absent rows count as zero.
    """
    white = np.nan_to_num(np.asarray(white, dtype=float), nan=0.0)
    power = np.einsum("ki...,ki...->...", white, white)
    steps = len(white)
    products = [np.einsum("ki...,ki...->...", white[lag:], white[: steps - lag]) for lag in range(lags + 1)]
    return np.stack(products) / power


class RunSums(NamedTuple):
    """Sums over the epochs of each run; the last axis is the run."""

    squares: Array  # (n, N) squared errors
    nees: Array  # (N,)
    nees_position: Array  # (N,)
    inside: Array  # (levels, N) epochs inside the ellipses of the full state
    inside_position: Array  # (levels, N)
    log_ratio: Array  # (N,) log10 of NEES over that of the true mean square error matrix
    absolute_log_ratio: Array  # (N,)
    log_likelihood: Array  # (N,)
    nis: Array  # (N,)
    degrees: Array  # (N,) channels that were measured
    lagged: Array  # (N,) products of neighbouring whitened innovations
    outside: Array  # (N,) epochs in a row outside the position ellipse, up to now
    lost: Array  # (N,) whether it ever was lost


class EpochSums(NamedTuple):
    """Sums over the runs of one epoch."""

    runs: int  # with a finite estimate
    error: Array  # (n,)
    product: Array  # (n, n) sum of e e'
    cov: Array  # (n, n) sum of P
    nees: float
    nees_position: float
    nis: float
    degrees: float
    lagged: Array  # (m,) sum of products with the epoch before
    power: Array  # (m,) sum of squares


class Sums(NamedTuple):
    """What `Consistency` carries from epoch to epoch."""

    runs: RunSums | None
    epochs: tuple[EpochSums, ...]
    white: Array | None  # (m, N) the last whitened innovation


@dataclass(frozen=True)
class Consistency:
    """Statistics of an ensemble of runs, one epoch at a time.

    ``begin``, ``add`` for each epoch of `follow`, ``join`` over chunks of runs, ``summary`` at the end.
    """

    position: tuple[int, ...]  # indices of the position components of the state

    def begin(self) -> Sums:
        """Nothing accumulated."""
        return Sums(None, (), None)

    def add(self, sums: Sums, estimate: Gaussian | Mixture, truth: Array, innovation: Innovation | None) -> Sums:
        """Add one epoch.

        Parameters
        ----------
        estimate : mean (n, N) or (n,); a mixture is judged as its moment-matched Gaussian.
        truth : (n, N) or, common to all runs, (n, 1) or (n,).
        """
        gaussian = merge(estimate) if isinstance(estimate, Mixture) else estimate
        mean, cov = np.atleast_2d(np.asarray(gaussian.mean).T).T, np.asarray(gaussian.cov)
        cov = cov[..., None] if cov.ndim == 2 else cov
        truth = np.asarray(truth, dtype=float)
        error = mean - (truth[:, None] if truth.ndim == 1 else truth)
        with np.errstate(invalid="ignore", over="ignore", divide="ignore"):
            nees = normalised_error(Gaussian(error, cov), np.zeros(1))
            nees_position = normalised_error(Gaussian(error, cov), np.zeros(1), self.position)
            finite = np.isfinite(error).all(axis=0) & np.isfinite(nees)
            sums_of_epoch, log_ratio = self._epoch(error, cov, nees, nees_position, finite)
        runs = sums.runs if sums.runs is not None else _no_runs(*error.shape)
        outside = _outside(runs.outside, np.where(finite, nees_position, np.nan), len(self.position))
        runs = runs._replace(
            squares=runs.squares + error**2,
            nees=runs.nees + nees,
            nees_position=runs.nees_position + nees_position,
            inside=runs.inside + (nees <= _ellipses(len(error))),
            inside_position=runs.inside_position + (nees_position <= _ellipses(len(self.position))),
            log_ratio=runs.log_ratio + log_ratio,
            absolute_log_ratio=runs.absolute_log_ratio + np.abs(log_ratio),
            outside=outside,
            lost=runs.lost | (outside >= LOST_EPOCHS) | ~finite,
        )
        if innovation is None:
            return Sums(runs, (*sums.epochs, sums_of_epoch), sums.white)
        white = np.atleast_2d(np.asarray(innovation.white).T).T
        degrees = np.isfinite(white).sum(axis=0)
        seen = np.nan_to_num(white, nan=0.0)
        before = np.zeros_like(seen) if sums.white is None else sums.white
        nis = np.where(degrees > 0, innovation.nis, 0.0)
        runs = runs._replace(
            log_likelihood=runs.log_likelihood + innovation.log_likelihood,
            nis=runs.nis + nis,
            degrees=runs.degrees + degrees,
            lagged=runs.lagged + np.einsum("ij,ij->j", seen, before),
        )
        sums_of_epoch = sums_of_epoch._replace(
            nis=float(nis[finite].sum()),
            degrees=float(degrees[finite].sum()),
            lagged=np.einsum("ij,ij->i", seen[:, finite], before[:, finite]),
            power=np.einsum("ij,ij->i", seen[:, finite], seen[:, finite]),
        )
        return Sums(runs, (*sums.epochs, sums_of_epoch), seen)

    def _epoch(
        self, error: Array, cov: Array, nees: Array, nees_position: Array, finite: Array
    ) -> tuple[EpochSums, Array]:
        """Sums over the runs of an epoch, and the credibility ratio of each run (N,)."""
        count = int(finite.sum())
        good = error[:, finite]
        product = good @ good.T
        spread = cov[..., finite].sum(axis=-1) if cov.shape[-1] == len(finite) else cov[..., 0] * count
        log_ratio = np.full(len(finite), np.nan)
        if count > len(error):
            ideal = normalised_error(Gaussian(good, (product / count)[..., None]), np.zeros(1))
            log_ratio[finite] = np.log10(nees[finite] / ideal)
        sums = EpochSums(
            count,
            good.sum(axis=1),
            product,
            spread,
            float(nees[finite].sum()),
            float(nees_position[finite].sum()),
            0.0,
            0.0,
            np.zeros(0),
            np.zeros(0),
        )
        return sums, log_ratio

    def join(self, one: Sums, other: Sums) -> Sums:
        """Sums of two chunks of runs over the same epochs."""
        if one.runs is None or other.runs is None:
            return other if one.runs is None else one
        if len(one.epochs) != len(other.epochs):
            raise ValueError("chunks can only be joined over the same epochs")
        runs = RunSums(*(np.concatenate(pair, axis=-1) for pair in zip(one.runs, other.runs, strict=True)))
        epochs = (
            EpochSums(*(a + b for a, b in zip(*pair, strict=True)))
            for pair in zip(one.epochs, other.epochs, strict=True)
        )
        return Sums(runs, tuple(epochs), None)

    def summary(self, sums: Sums, level: float = 0.95) -> Summary:
        """All statistics with their intervals over runs."""
        if sums.runs is None:
            raise ValueError("no epoch was accumulated")
        runs, epochs = sums.runs, len(sums.epochs)
        n, count = runs.squares.shape
        position = list(self.position)
        with np.errstate(invalid="ignore", divide="ignore"):
            correlation = runs.lagged / runs.nis
            anis = runs.nis / runs.degrees
        return Summary(
            runs=count,
            epochs=epochs,
            rmse=tuple(rmse(row / epochs, level) for row in runs.squares),
            rmse_position=rmse(runs.squares[position].sum(axis=0) / epochs, level),
            anees=mean_interval(runs.nees / (n * epochs), level),
            anees_position=mean_interval(runs.nees_position / (len(position) * epochs), level),
            anis=mean_interval(anis, level),
            log_score=mean_interval(runs.log_likelihood / epochs, level),
            coverage=tuple(mean_interval(row / epochs, level) for row in runs.inside),
            coverage_position=tuple(mean_interval(row / epochs, level) for row in runs.inside_position),
            noncredibility=mean_interval(10.0 * runs.absolute_log_ratio / epochs, level),
            inclination=mean_interval(10.0 * runs.log_ratio / epochs, level),
            lost=proportion(int(runs.lost.sum()), count, level),
            white_epochs=_white_epochs(sums.epochs, level),
            correlation=mean_interval(correlation, level),
            unbiased_epochs=_unbiased_epochs(sums.epochs, level),
        )


class Summary(NamedTuple):
    """Statistics of an ensemble. ANEES and ANIS are per component: 1 where the covariance is right."""

    runs: int
    epochs: int
    rmse: tuple[Interval, ...]  # of each state component, all epochs
    rmse_position: Interval  # m, of the distance
    anees: Interval  # full state
    anees_position: Interval
    anis: Interval
    log_score: Interval  # mean log-likelihood of a measurement given those before it
    coverage: tuple[Interval, ...]  # share of epochs inside the 50, 90, 95 % ellipses of the full state
    coverage_position: tuple[Interval, ...]
    noncredibility: Interval  # Li and Zhao's index, 0 for the ideal covariance
    inclination: Interval  # its signed form: + too small a covariance
    lost: Interval
    white_epochs: Interval  # share of epochs and channels whose lag-one correlation over runs is inside its band
    correlation: Interval  # lag-one correlation of the whitened innovations along each run
    unbiased_epochs: Interval  # share of epochs whose mean error is inside its ellipse


def _white_epochs(epochs: tuple[EpochSums, ...], level: float) -> Interval:
    """Share of lag-one correlations over runs inside +-1.96/sqrt(N): independent from epoch to epoch when white."""
    inside = trials = 0
    for before, epoch in pairwise(epochs):
        if len(before.power) and len(epoch.power):
            with np.errstate(invalid="ignore", divide="ignore"):
                correlation = epoch.lagged / np.sqrt(epoch.power * before.power)
            known = np.isfinite(correlation)
            inside += int((np.abs(correlation[known]) <= correlation_band(epoch.runs, level)).sum())
            trials += int(known.sum())
    return proportion(inside, trials, level)


def _unbiased_epochs(epochs: tuple[EpochSums, ...], level: float) -> Interval:
    """Share of epochs with ``N mean(e)' mean(P)^-1 mean(e)`` below its chi-square limit."""
    inside = trials = 0
    for epoch in epochs:
        if epoch.runs:
            bias = epoch.error / math.sqrt(epoch.runs)
            square = float(normalised_error(Gaussian(bias, epoch.cov / epoch.runs), np.zeros(len(bias))))
            inside += int(square <= chi_square(level, len(bias)))
            trials += 1
    return proportion(inside, trials, level)


def _no_runs(n: int, count: int) -> RunSums:
    def zeros(*shape: int) -> Array:
        return np.zeros((*shape, count))

    levels = len(LEVELS)
    return RunSums(
        squares=zeros(n),
        nees=zeros(),
        nees_position=zeros(),
        inside=zeros(levels),
        inside_position=zeros(levels),
        log_ratio=zeros(),
        absolute_log_ratio=zeros(),
        log_likelihood=zeros(),
        nis=zeros(),
        degrees=zeros(),
        lagged=zeros(),
        outside=np.zeros(count, dtype=int),
        lost=np.zeros(count, dtype=bool),
    )


@lru_cache
def _lost_square(degrees: int) -> float:
    return float(2.0 * special.gammainccinv(0.5 * degrees, LOST_PROBABILITY))


@lru_cache
def _ellipses(degrees: int) -> Array:
    """Chi-square limits (levels, 1) of the coverage ellipses."""
    return np.array([[chi_square(level, degrees)] for level in LEVELS])
