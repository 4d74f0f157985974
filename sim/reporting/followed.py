"""What every tracker believed against the truth, at its own epochs: the numbers behind the figures of the trackers."""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np

from sim import channels
from sim.flight import Flight
from sim.reporting import style

FIRST = ("position_m", "cross_track_m", "height_m")  # channels in the order in which they are shown
LEVELS = (2.5, 97.5)  # %, of the draws


class Curves(NamedTuple):
    """One comparison channel of one tracker over its k epochs."""

    rmse: np.ndarray  # (k,) over draws
    sigma: np.ndarray  # (k,) of the tracker's own covariance, root of the mean trace
    raw: np.ndarray  # (k,) RMSE of the measurement itself; NaN where there was none
    low: np.ndarray  # (k,) percentiles of the signed error, of one dimension only
    high: np.ndarray  # (k,)
    p95: np.ndarray  # (k,) 95th percentile of the size of the error
    anees: np.ndarray  # (k,) mean normalised error squared per dimension
    of_draws: np.ndarray  # (draws,) mean squared error over the epochs that were measured


class Shown(NamedTuple):
    """Where one draw of a tracker was, for maps; NaN where it did not know or had seen nothing yet."""

    place: np.ndarray  # (k, 2) m north, east
    spread: np.ndarray  # (k, 2, 2) m2
    height: np.ndarray  # (k,) m; of an angle, at the true distance
    height_sigma: np.ndarray  # (k,) m


class Followed(NamedTuple):
    """One tracker's whole record, compared."""

    name: str
    law_from: str | None
    look: dict[str, Any]  # colour and dashes, the same in every figure
    time: np.ndarray  # (k,) s
    phase: np.ndarray  # (k,) index into the flight's phases
    leg: np.ndarray  # (k,)
    draws: int
    curves: dict[str, Curves]
    nis: np.ndarray  # (k,) mean normalised innovation squared per measured component
    nis_samples: np.ndarray  # (k,) how many measured components are behind each
    sensors: tuple[str, ...]
    shown: Shown  # draw 0


def follow(scenario: Any, flight: Flight, tracked: dict[str, Any]) -> list[Followed]:
    """Compare every tracker with the flight."""
    looks = _looks(scenario, tracked)
    return [_one(scenario, flight, name, looks[name], one) for name, one in tracked.items()]


def shown_channels(followed: list[Followed]) -> list[str]:
    """Names of the channels that the trackers have: place first, angles where no tracker knows a place."""
    found = dict.fromkeys(channel for one in followed for channel in one.curves)
    first = [channel for channel in FIRST if channel in found]
    return first or list(found)


def _one(scenario: Any, flight: Flight, name: str, look: dict[str, Any], one: Any) -> Followed:
    track, record = one.track, one.measurements
    # only sensors whose channels the tracker estimates: the projections of a place onto angles stay in the tables
    heard = {channel.partition(".")[0] for channel in record.channels}
    spoken = {channel.partition(".")[0] for channel in track.channels}
    sensors = {sensor: it for sensor, it in scenario.sensors.items() if sensor in heard}
    truth = channels.truth_at(flight, track.time)
    cov = track.cov if track.cov.ndim == 4 else track.cov[..., None]
    own = {sensor: it for sensor, it in sensors.items() if sensor in spoken}
    compared = channels.compare(flight, truth, track.channels, track.mean, cov, own)
    order = np.argsort(record.arrival, kind="stable")
    taken = channels.truth_at(flight, record.time[order])
    plots = channels.raw(flight, taken, record.channels, record.z[order], sensors, flight.route.legs[0].height)
    with np.errstate(invalid="ignore", divide="ignore"):
        curves = {channel: _curves(it, plots.get(channel)) for channel, it in compared.items()}
        samples = np.isfinite(track.white).sum(axis=(1, 2))
        nis = np.where(samples > 0, np.nansum(track.nis, axis=1) / np.maximum(samples, 1), np.nan)
    draws = track.mean.shape[2]
    first = _first_seen(plots)
    curves = {c: Curves(*(_from(first, values) for values in it[:-1]), it.of_draws) for c, it in curves.items()}
    shown = Shown(*(_from(first, values) for values in _shown(truth, sensors, compared)))
    return Followed(
        name, one.law_from, look, track.time, truth.phase, truth.leg, draws, curves, nis, samples, tuple(sensors), shown
    )  # fmt: skip


def _shown(truth: Any, sensors: dict[str, Any], compared: dict[str, Any]) -> Shown:
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
    return Shown(place, spread, height, sigma)


def _curves(compared: Any, plots: Any) -> Curves:
    squares = channels.squared(compared)
    spread = np.einsum("kiin->kn", compared.cov).mean(axis=1)
    nowhere = np.full(len(squares), np.nan)
    raw = nowhere
    if plots is not None:
        measured = channels.squared(plots)
        seen = np.isfinite(measured)
        total = np.where(seen, measured, 0.0).sum(axis=1)
        raw = np.where(seen.any(axis=1), np.sqrt(total / np.maximum(seen.sum(axis=1), 1)), np.nan)
    low, high = np.percentile(compared.error[:, 0], LEVELS, axis=1) if compared.error.shape[1] == 1 else (nowhere,) * 2
    looked = np.isfinite(raw) if np.isfinite(raw).any() else np.ones(len(raw), bool)
    return Curves(
        np.sqrt(squares.mean(axis=1)),
        np.sqrt(spread),
        raw,
        low,
        high,
        np.sqrt(np.percentile(squares, 95.0, axis=1)),
        channels.normalised(compared).mean(axis=1) / compared.error.shape[1],
        squares[looked].mean(axis=0),
    )


def _first_seen(plots: dict[str, Any]) -> int:
    """Epoch of the first measurement that says where the target is: before it a track is what was handed over."""
    seen = [np.isfinite(plot.error).any(axis=(1, 2)) for plot in plots.values()]
    return int(np.argmax(np.any(seen, axis=0))) if seen else 0


def _from(first: int, values: np.ndarray) -> np.ndarray:
    """The finite values from an epoch on, NaN elsewhere."""
    hidden = np.where(np.isfinite(values), values, np.nan)
    hidden[:first] = np.nan
    return hidden


def _looks(scenario: Any, tracked: dict[str, Any]) -> dict[str, dict[str, Any]]:
    """A colour for each kind that is told a law and for every other tracker; dashes where it was told wrong."""
    colours: dict[str, str] = {}
    looks: dict[str, dict[str, Any]] = {}
    for name, one in tracked.items():
        choice = scenario.trackers.get(name)
        family = name if choice is None or one.law_from is None else f"kind {choice.kind}"
        colour = colours.setdefault(family, style.TRACKERS[len(colours) % len(style.TRACKERS)])
        looks[name] = {"color": colour, "dashes": style.DASHED if one.law_from == "told wrong" else style.SOLID}
    return looks
