"""Comparison channels: truth and any estimate brought to position, cross-track, height or a sensor's own angles."""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np

from sim.flight import Flight
from sim.interpolation import hermite


class Truth(NamedTuple):
    """The flight at the epochs of a tracker; k instants."""

    time: np.ndarray  # (k,)
    position: np.ndarray  # (3, k) m
    velocity: np.ndarray  # (3, k) m/s
    leg: np.ndarray  # (k,) leg active in truth
    phase: np.ndarray  # (k,) index into the flight's phases


class Compared(NamedTuple):
    """One channel of one tracker, or of the raw measurements, against the truth."""

    error: np.ndarray  # (k, d, draws)
    cov: np.ndarray | None  # (k, d, d, draws or 1)


def truth_at(flight: Flight, time: np.ndarray) -> Truth:
    """The flight interpolated at ``time`` (k,), cubic between its records."""
    s = flight.state
    after = np.clip(np.searchsorted(s.time, time), 1, len(s.time) - 1)
    before = after - 1
    position = np.array((s.north, s.east, s.height))
    velocity = np.array((s.velocity_north, s.velocity_east, s.velocity_up))
    t0, t1 = s.time[before], s.time[after]
    share = (time - t0) / (t1 - t0)
    return Truth(
        time,
        hermite(t0, t1, position[:, before], position[:, after], velocity[:, before], velocity[:, after], time),
        velocity[:, before] * (1 - share) + velocity[:, after] * share,
        flight.leg[before],
        flight.phase[before],
    )


def compare(
    flight: Flight, truth: Truth, channels: tuple[str, ...], mean: np.ndarray, cov: np.ndarray
) -> dict[str, Compared]:
    """Errors of estimates (k, n, draws) in every comparison channel that their components allow."""
    found: dict[str, Compared] = {}
    if "north" in channels and "east" in channels:
        rows = [channels.index("north"), channels.index("east")]
        error = mean[:, rows] - truth.position[:2].T[:, :, None]
        spread = cov[:, rows][:, :, rows]
        found["position_m"] = Compared(error, spread)
        found["cross_track_m"] = Compared(*_across(flight, truth, error, spread))
    elif "cross_track" in channels:
        row = channels.index("cross_track")
        deviation = flight.route.deviation(truth.leg, truth.position[:2], truth.velocity[:2]).cross_track
        error = mean[:, [row]] - deviation[:, None, None]
        found["cross_track_m"] = Compared(error, cov[:, [row]][:, :, [row]])
    if "height" in channels:
        row = channels.index("height")
        found["height_m"] = Compared(mean[:, [row]] - truth.position[2][:, None, None], cov[:, [row]][:, :, [row]])
    return found


def _across(flight: Flight, truth: Truth, error: np.ndarray, cov: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """The part of position errors across the leg active in truth, + right."""
    course = np.array([leg.course for leg in flight.route.legs])[truth.leg]
    right = np.stack((-np.sin(course), np.cos(course)), axis=1)  # (k, 2)
    across = np.einsum("ki,kin->kn", right, error)[:, None]
    spread = np.einsum("ki,kijn,kj->kn", right, cov, right)[:, None, None]
    return across, spread


def raw(flight: Flight, truth: Truth, plots: np.ndarray) -> dict[str, Compared]:
    """Errors of converted measurements (k, 2, draws) north, east; NaN where nothing was measured."""
    error = plots - truth.position[:2].T[:, :, None]
    course = np.array([leg.course for leg in flight.route.legs])[truth.leg]
    right = np.stack((-np.sin(course), np.cos(course)), axis=1)
    return {
        "position_m": Compared(error, None),
        "cross_track_m": Compared(np.einsum("ki,kin->kn", right, error)[:, None], None),
    }


def squared(compared: Compared) -> np.ndarray:
    """Squared length of the errors (k, draws)."""
    return np.asarray(np.einsum("kdn,kdn->kn", compared.error, compared.error))


def normalised(compared: Compared) -> np.ndarray:
    """Normalised error squared e' P^-1 e (k, draws)."""
    cov: Any = compared.cov
    if cov.shape[1] == 1:
        return np.asarray(compared.error[:, 0] ** 2 / cov[:, 0, 0])
    a, b, c = cov[:, 0, 0], cov[:, 0, 1], cov[:, 1, 1]
    x, y = compared.error[:, 0], compared.error[:, 1]
    return np.asarray((c * x * x - 2 * b * x * y + a * y * y) / (a * c - b * b))
