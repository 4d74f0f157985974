"""The errors of one tracker over time, in windows that a figure can show."""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np

from sim.flight.interpolation import Truth
from sim.flight.record import Flight, runs
from sim.metrics import comparison
from sim.metrics.comparison import Compared
from sim.metrics.tracker import TrackerErrors, mean_of_present
from tracking.track import Track

LEVELS = (2.5, 97.5)  # %, of errors
WINDOWS = 240  # most points of a curve
MANY, FEW_WINDOWS = 30, 80  # with fewer draws than MANY a point needs more epochs behind it


class ChannelCurves(NamedTuple):
    """One comparison channel of one tracker over w short windows of time, over all draws and epochs in each."""

    rmse: np.ndarray  # (w,)
    sigma: np.ndarray  # (w,) of the tracker's own covariance, root of the mean trace
    raw: np.ndarray  # (w,) RMSE of the measurement itself; NaN where there was none
    low: np.ndarray  # (w,) percentiles of the signed error, of one dimension only
    high: np.ndarray  # (w,)
    p95: np.ndarray  # (w,) 95th percentile of the size of the error
    anees: np.ndarray  # (w,) mean normalised error squared per dimension
    of_draws: np.ndarray  # (draws,) mean squared error over the epochs that were measured


class DrawnPath(NamedTuple):
    """Where one draw of a tracker was, for maps; NaN where it did not know or had seen nothing yet."""

    time: np.ndarray  # (k,) s
    place: np.ndarray  # (k, 2) m north, east
    spread: np.ndarray  # (k, 2, 2) m2
    height: np.ndarray  # (k,) m; of an angle, at the true distance
    height_sigma: np.ndarray  # (k,) m


class ErrorCurves(NamedTuple):
    """All channels of one tracker; w windows of equal length in time, since the first measurement of the place."""

    time: np.ndarray  # (w,) s, mean of the epochs in each
    phase: np.ndarray  # (w,) index into the flight's phases
    draws: int
    channels: dict[str, ChannelCurves]
    nis: np.ndarray  # (w,) mean normalised innovation squared per measured component
    nis_samples: np.ndarray  # (w,) how many measured components are behind each
    sensors: frozenset[str]  # whose measurements the tracker uses
    path: DrawnPath  # of draw 0


def error_curves(flight: Flight, sensors: dict[str, Any], track: Track, errors: TrackerErrors) -> ErrorCurves:
    """The curves of a track from its errors; ``sensors`` are those that it uses.

    Angles are among them where the tracker estimates them: an estimate of the place projected onto them is left to the
    tables.
    """
    estimated = {channel.partition(".")[0] for channel in track.channels}
    compared = {
        channel: one
        for channel, one in errors.estimates.items()
        if "." not in channel or channel.partition(".")[0] in estimated
    }
    first, draws = _first_seen(errors.plots), track.mean.shape[2]
    edges = windows(track.time, first, flight, draws)
    with np.errstate(invalid="ignore", divide="ignore", over="ignore"):  # a lost track is a result
        curves = {
            channel: _curves(it, errors.plots.get(channel), edges, errors.present) for channel, it in compared.items()
        }
        nis, samples = _innovations(track, edges)
        path = DrawnPath(track.time, *(_from(first, values) for values in _path(errors.truth, sensors, compared)))
    middle = np.array([(a + b - 1) // 2 for a, b in edges], int)
    return ErrorCurves(
        pooled(track.time, edges), errors.truth.phase[middle], draws, curves, nis, samples, frozenset(sensors), path
    )


def curves_without_truth(flight: Flight, sensors: dict[str, Any], track: Track) -> ErrorCurves:
    """The curves of a track against which there is no truth: its innovations, and where it was; no channel has errors.

    An angle is no height without a true distance.
    """
    k, draws = len(track.time), track.mean.shape[2]
    edges = windows(track.time, 0, flight, draws)
    cov = track.cov if track.cov.ndim == 4 else track.cov[..., None]
    place, spread, height, sigma = (np.full((k, *shape), np.nan) for shape in ((2,), (2, 2), (), ()))
    with np.errstate(invalid="ignore", divide="ignore", over="ignore"):  # a lost track is a result
        plane = comparison.on_the_plane(track.channels, track.mean, cov, sensors)
        if plane is not None:
            place, spread = plane[0][..., 0], plane[1][..., 0]
        if "height" in track.channels:
            row = track.channels.index("height")
            height, sigma = track.mean[:, row, 0], np.sqrt(cov[:, row, row, 0])
        nis, samples = _innovations(track, edges)
    path = DrawnPath(track.time, *map(_finite, (place, spread, height, sigma)))
    phase = np.zeros(len(edges), int)
    return ErrorCurves(pooled(track.time, edges), phase, draws, {}, nis, samples, frozenset(sensors), path)


def _innovations(track: Track, edges: list[tuple[int, int]]) -> tuple[np.ndarray, np.ndarray]:
    """(w,) mean normalised innovation squared per measured component, and how many of these are behind each."""
    counted = pooled(np.isfinite(track.white).sum(axis=(1, 2)), edges)
    nis = np.where(counted > 0, pooled(np.nansum(track.nis, axis=1), edges) / counted, np.nan)
    return nis, np.round(counted * np.array([b - a for a, b in edges]))


def windows(time: np.ndarray, first: int, flight: Flight, draws: int) -> list[tuple[int, int]]:
    """(first, one past last) epochs of windows of equal length in time, from the first measurement on."""
    most = WINDOWS if draws >= MANY else FEW_WINDOWS
    width = max(float(flight.time[-1] - flight.time[0]), 1e-6) / most
    place = np.floor((time[first:] - flight.time[0]) / width)
    return [(first + a, first + b) for a, b in runs(place)]


def pooled(values: np.ndarray, edges: list[tuple[int, int]]) -> np.ndarray:
    """(w,) mean over the epochs of each window, and over whatever axes follow."""
    starts, ends = np.array(edges).T
    return np.asarray(np.add.reduceat(values.reshape(len(values), -1).mean(axis=1), starts) / (ends - starts))


def _percentiles(values: np.ndarray, edges: list[tuple[int, int]], levels: tuple[float, ...]) -> np.ndarray:
    """(levels, w) percentiles of the values (k, draws) in each window; windows of one length at a time."""
    starts, ends = np.array(edges).T
    found = np.empty((len(levels), len(edges)))
    for length in np.unique(ends - starts):
        chosen = ends - starts == length
        rows = values[starts[chosen, None] + np.arange(length)].reshape(int(chosen.sum()), -1)
        found[:, chosen] = np.percentile(rows, levels, axis=1)
    return found


def _path(truth: Truth, sensors: dict[str, Any], compared: dict[str, Compared]) -> tuple[np.ndarray, ...]:
    """Place and height of draw 0; the height of an elevation is that at the true distance from its antenna."""
    k = len(truth.time)
    place, spread, height, sigma = (np.full((k, *shape), np.nan) for shape in ((2,), (2, 2), (), ()))
    if "position_m" in compared:
        error, cov = compared["position_m"]
        place, spread = truth.position[:2].T + error[..., 0], cov[..., 0]
    angle = next((name for name in compared if name.endswith(".elevation_deg")), None)
    if "height_m" in compared:
        error, cov = compared["height_m"]
        height, sigma = truth.position[2] + error[:, 0, 0], np.sqrt(cov[:, 0, 0, 0])
    elif angle is not None:
        error, cov = compared[angle]
        antenna = np.array(sensors[angle.partition(".")[0]].antenna)[:, None]
        distance = np.hypot(*(truth.position - antenna)[:2])
        slope = distance * (1.0 + ((truth.position - antenna)[2] / distance) ** 2)  # d height / d elevation
        height = truth.position[2] + slope * np.radians(error[:, 0, 0])
        sigma = slope * np.radians(np.sqrt(cov[:, 0, 0, 0]))
    return place, spread, height, sigma


def _filled(values: np.ndarray, present: np.ndarray | None) -> np.ndarray:
    """Values (k, draws) with the mean of the draws that are present where one is absent: so they count by epochs."""
    if present is None:
        return values
    count = present.sum(axis=1)
    mean = np.where(count > 0, np.where(present, values, 0.0).sum(axis=1) / np.maximum(count, 1), np.nan)
    return np.where(present, values, mean[:, None])


def _curves(
    compared: Compared, plots: Compared | None, edges: list[tuple[int, int]], present: np.ndarray | None
) -> ChannelCurves:
    squares, dimension = comparison.squared(compared), compared.error.shape[1]
    spread = np.einsum("kiin->kn", compared.cov)
    measured = np.full(squares.shape, np.nan) if plots is None else comparison.squared(plots)
    seen = np.isfinite(measured)
    share = pooled(seen, edges)
    raw = np.where(share > 0, np.sqrt(pooled(np.where(seen, measured, 0.0), edges) / share), np.nan)
    low = high = np.full(len(edges), np.nan)
    if dimension == 1:
        low, high = _percentiles(compared.error[:, 0], edges, LEVELS)
    (p95,) = _percentiles(squares, edges, (95.0,))
    looked = seen.any(axis=1) if seen.any() else np.ones(len(squares), bool)
    rmse, sigma = (np.sqrt(pooled(_filled(values, present), edges)) for values in (squares, spread))
    anees = pooled(_filled(comparison.normalised(compared), present), edges) / dimension
    return ChannelCurves(
        _finite(rmse),
        _finite(sigma),
        _finite(raw),
        _finite(low),
        _finite(high),
        _finite(np.sqrt(p95)),
        _finite(anees),
        mean_of_present(squares[looked], None if present is None else present[looked]),
    )


def _finite(values: np.ndarray) -> np.ndarray:
    return np.where(np.isfinite(values), values, np.nan)


def _first_seen(plots: dict[str, Compared]) -> int:
    """Epoch of the first measurement that says where the target is: before it a track is what was handed over."""
    places = (plot for channel, plot in plots.items() if comparison.says_place(channel))
    seen = [np.isfinite(plot.error).any(axis=(1, 2)) for plot in places]
    return int(np.argmax(np.any(seen, axis=0))) if seen else 0


def _from(first: int, values: np.ndarray) -> np.ndarray:
    """The finite values from an epoch on, NaN elsewhere."""
    hidden = _finite(values)
    hidden[:first] = np.nan
    return hidden
