"""How well a tracker did: its errors in comparison channels, by phase, beside those of the raw measurements."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any, NamedTuple

import numpy as np

from sim.flight.interpolation import Truth, truth_at
from sim.flight.record import Flight
from sim.metrics import comparison
from sim.metrics.comparison import Compared
from tracking import consistency
from tracking.height_profile import Charted
from tracking.intervals import gain, mean_interval, rmse
from tracking.track import Measurements, Track


class TrackerErrors(NamedTuple):
    """Errors of a tracker and of the measurements that it was given, by comparison channel."""

    truth: Truth  # at the epochs
    estimates: dict[str, Compared]
    plots: dict[str, Compared]
    present: np.ndarray | None = None  # (k, draws) of a track that was made elsewhere: where it has an estimate


def plot_errors(flight: Flight, sensors: dict[str, Any], chart: Charted, record: Measurements) -> dict[str, Compared]:
    """Errors of measurements in order of arrival; a plot is compared with the truth at the time it was taken."""
    order: Any = np.argsort(record.arrival, kind="stable")
    order = slice(None) if (np.diff(order) == 1).all() else order  # the usual case: no copy
    taken = truth_at(flight, record.time[order])
    return comparison.raw(flight, taken, record.channels, record.z[order], sensors, chart)


def looked_for(errors: dict[str, Compared], plots: dict[str, Compared]) -> dict[str, Compared]:
    """The errors of measurements with which those of estimates are compared, and those that say a place."""
    return {channel: plot for channel, plot in plots.items() if channel in errors or comparison.says_place(channel)}


def tracker_errors(flight: Flight, sensors: dict[str, Any], track: Track, plots: dict[str, Compared]) -> TrackerErrors:
    """Errors of estimates, each at its epoch; ``sensors`` are those that the tracker uses."""
    truth = truth_at(flight, track.time)
    cov = track.cov if track.cov.ndim == 4 else track.cov[..., None]
    return TrackerErrors(truth, comparison.compare(flight, truth, track.channels, track.mean, cov, sensors), plots)


def tracker_metrics(flight: Flight, track: Track, errors: TrackerErrors) -> dict[str, Any]:
    """The figures of one tracker for metrics.json."""
    truth = errors.truth
    figures: dict[str, Any] = {"overall": {}, "by_phase": {}}
    for channel, squares, measured, looked in where_measured(errors):
        figures["overall"][channel] = _figure(squares[looked], measured[looked], _of(errors.present, looked))
        for index in np.unique(truth.phase[looked]):
            chosen = looked & (truth.phase == index)
            by_phase = figures["by_phase"].setdefault(flight.phases[index], {})
            by_phase[channel] = _figure(squares[chosen], measured[chosen], _of(errors.present, chosen))
    first = next(iter(errors.estimates.values()), None)
    if first is not None:
        dimension = first.error.shape[1]
        squares = comparison.normalised(first)
        anees = mean_interval(mean_of_present(squares, errors.present) / dimension)
        figures |= {"anees": anees.value, "anees_low": anees.low, "anees_high": anees.high}
        if errors.present is not None:
            squares = np.where(errors.present, squares, 0.0)
        if errors.present is not None and not np.isfinite(squares).all():  # it states no covariance
            figures |= dict.fromkeys(("anees", "anees_low", "anees_high", "lost_fraction", "lost_time_s"))
        else:
            lost = consistency.lost_by(squares, dimension)
            figures["lost_fraction"] = float(np.mean(lost[-1]))
            figures["lost_time_s"] = _lost_time(track.time, lost)
    rows = np.isfinite(track.white).sum(axis=1)
    if rows.any():
        figures["anis"] = float(np.sum(np.where(rows > 0, track.nis, 0.0)) / rows.sum())
    return figures


def skipped(track: Track) -> dict[str, Any]:
    """How many looks a tracker could not use, of how many, and since when; empty where it could use all."""
    unusable = np.zeros(len(track.time), bool) if track.skipped is None else track.skipped.any(axis=1)
    if not unusable.any():
        return {}
    first = float(track.time[unusable][0])
    return {"skipped": {"looks": int(unusable.sum()), "of_looks": len(unusable), "first_s": first}}


def where_measured(errors: TrackerErrors) -> Iterator[tuple[str, np.ndarray, np.ndarray, np.ndarray]]:
    """Channel, squared errors of estimates and of measurements (k, draws), and the epochs (k,) that count.

    These are the epochs with a measurement in any draw; all of them in a channel that no sensor measures.
    """
    for channel, compared in errors.estimates.items():
        squares = comparison.squared(compared)
        plots = errors.plots.get(channel)
        measured = np.full_like(squares, np.nan) if plots is None else comparison.squared(plots)
        looked = np.ones(len(squares), bool) if plots is None else np.isfinite(measured).any(axis=1)
        if looked.any():
            yield channel, squares, measured, looked


def _lost_time(time: np.ndarray, lost: np.ndarray) -> float | None:
    """When the first of the draws was lost, s; None = never."""
    ever = lost.any(axis=1)
    return float(time[np.argmax(ever)]) if ever.any() else None


def mean_of_present(values: np.ndarray, present: np.ndarray | None) -> np.ndarray:
    """Mean over epochs (k, draws) of each draw that has any; None = all have all."""
    if present is None:
        return np.asarray(values.mean(axis=0))
    count = present.sum(axis=0)
    return np.asarray(np.where(present, values, 0.0).sum(axis=0)[count > 0] / count[count > 0])


def _of(present: np.ndarray | None, chosen: np.ndarray) -> np.ndarray | None:
    return None if present is None else present[chosen]


def _figure(squares: np.ndarray, raw: np.ndarray, present: np.ndarray | None) -> dict[str, float | None]:
    """RMSE over epochs and draws with an interval over draws, beside that of the raw measurements.

    The gain is the ratio of the two where both are known, its interval a paired one: each draw's noise is in both.
    """
    own = rmse(mean_of_present(squares, present))
    figure: dict[str, float | None] = {"rmse": own.value, "low": own.low, "high": own.high}
    figure |= dict.fromkeys(("raw", "gain", "gain_low", "gain_high"))
    finite = np.isfinite(raw) if present is None else np.isfinite(raw) & present
    if finite.any():
        measured = float(np.sqrt(np.mean(raw[finite])))
        common = float(np.sqrt(np.mean(squares[finite])))
        # sums, so that a draw counts by its looks
        paired = gain(*(np.where(finite, values, 0.0).sum(axis=0) for values in (raw, squares)))
        figure |= {"raw": measured, "gain": measured / common if common else None}
        figure |= {"gain_low": paired.low, "gain_high": paired.high}
    return figure
