"""Tracks as estimates that CAT062 holds: a tracker is a system of its own."""

from __future__ import annotations

from typing import Any

import numpy as np

from aircraft.runway import Runway as Place
from sim.estimation.tracked.outcome import Tracked, joined
from sim.interchange.asterix.writing import Estimates
from sim.metrics.comparison import on_the_plane
from sim.results.result import Result

FARTHEST, FASTEST = 1e6, 4e3  # m, m/s: beyond, an estimate is one of a track that is lost
RATES = ("east_rate", "north_rate")


def estimates_of(result: Result, one: Tracked, begins: float, draws: np.ndarray) -> tuple[Estimates | None, int]:
    """The estimates of some draws of a tracker, None where they are of no place on the ground plane; and how many are
    left out, because no item holds them.

    Places are in the plane that touches the earth at the threshold. A track on it has no height, and which latitude and
    longitude a place has depends on that: it is taken from the flight. ``begins`` is the time 0 of the flight, s since
    1970.
    """
    track = one.track if one.rollout is None else joined(one.track, one.rollout)
    cov = track.cov if track.cov.ndim == 4 else track.cov[..., None]
    plane = on_the_plane(track.channels, track.mean, cov, result.scenario.sensors)
    if plane is None:
        return None, 0
    count, _, runs = track.mean.shape
    place = plane[0][..., draws]  # (k, 2, draws) north, east
    spread = np.broadcast_to(plane[1], (count, 2, 2, runs))[..., draws]
    velocity, sigma = _velocity(track.channels, track.mean, cov)
    runway, state = result.scenario.runway, result.flight.whole.state
    height = np.interp(track.time, state.time, state.height) if result.flight.known else np.zeros(count)
    with np.errstate(all="ignore"):  # an estimate that is lost may be anywhere
        threshold = Place(runway.latitude, runway.longitude, runway.elevation)
        latitude, longitude = threshold.geodetic(place[:, 0], place[:, 1], height[:, None])
    epoch, number = (grid.ravel() for grid in np.indices((count, len(draws))))
    found = Estimates(
        begins + track.time[epoch],
        draws[number],
        latitude.ravel(),
        longitude.ravel(),
        np.moveaxis(place[:, ::-1], 1, 0).reshape(2, -1),
        velocity[..., draws].reshape(2, -1),
        np.moveaxis(spread[:, ::-1, ::-1], 0, 2).reshape(2, 2, -1),
        sigma[..., draws].reshape(2, -1),
        epoch == 0,
        epoch == count - 1,
    )
    sound = _sound(found)
    return Estimates(*(column[..., sound] for column in found)), int(np.sum(~sound))


def _velocity(channels: tuple[str, ...], mean: np.ndarray, cov: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """(2, k, draws) to the east and north with standard deviations; NaN where the states are others."""
    shape = (2, len(mean), mean.shape[2])
    if not {*RATES} <= {*channels}:
        return np.full(shape, np.nan), np.full(shape, np.nan)
    rows = [channels.index(name) for name in RATES]
    with np.errstate(invalid="ignore"):
        sigma = np.sqrt(np.stack([cov[:, row, row] for row in rows]))
    return np.moveaxis(mean[:, rows], 1, 0), np.broadcast_to(sigma, shape)


def _sound(estimates: Estimates) -> Any:
    """(n,) whether an estimate is one of an aircraft, with a covariance."""
    x, y = estimates.position
    with np.errstate(invalid="ignore"):
        near = np.hypot(x, y) < FARTHEST
        slow = np.isnan(estimates.velocity).all(axis=0) | (np.abs(estimates.velocity) < FASTEST).all(axis=0)
        variance = estimates.position_cov[0, 0] + estimates.position_cov[1, 1] + estimates.position_cov[0, 1]
    return near & slow & np.isfinite(variance) & np.isfinite(estimates.latitude + estimates.longitude)
