"""One draw of a tracker in the runway frame: where it took the aircraft to be, and on which course."""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np

from sim.errors import OutputError
from sim.estimation.tracked.outcome import Tracked, joined
from sim.metrics.comparison import on_the_plane
from sim.results.asterix.trackers import FARTHEST
from sim.results.result import Result
from tracking.track import Track


class Estimated(NamedTuple):
    """Estimates at k times, roll-out included; what is lost is left out."""

    time: np.ndarray  # (k,) s
    place: np.ndarray  # (2, k) m north, east
    height: np.ndarray | None  # (k,) m above the threshold; None = it estimates none
    course: np.ndarray  # (k,) rad clockwise from north; NaN where it estimates no velocity
    lost: int  # estimates of places where no aircraft is, which are left out


def refuse_draw(draw: int, draws: int) -> None:
    """Raise ``OutputError`` for a draw that a run has not."""
    if not 0 <= draw < draws:
        raise OutputError(f"--draw {draw}: the run has the draws 0 to {draws - 1}")


def track_of(one: Tracked, draw: int) -> Track:
    """One draw of a track to the end of its roll-out; arrays keep their axis of draws, of length 1."""
    whole = one.track if one.rollout is None else joined(one.track, one.rollout)
    cov = np.asarray(whole.cov)
    cov = cov[..., None] if cov.ndim == 3 else cov[..., [draw if cov.shape[3] > 1 else 0]]
    return whole._replace(mean=np.asarray(whole.mean)[..., [draw]], cov=cov)


def estimated(result: Result, one: Tracked, draw: int) -> Estimated | None:
    """The estimates of a tracker; None for one that estimates no place on the ground plane."""
    track, sensors = track_of(one, draw), result.scenario.sensors
    with np.errstate(all="ignore"):  # a lost track is a result
        plane = on_the_plane(track.channels, track.mean, track.cov, sensors)
        if plane is None:
            return None
        place = plane[0][..., 0].T
        sound = np.hypot(*place) < FARTHEST
    state = dict(zip(track.channels, np.moveaxis(track.mean[..., 0], 1, 0), strict=True))
    course = np.full(len(track.time), np.nan)
    if {"north_rate", "east_rate"} <= {*state}:
        course = np.arctan2(state["east_rate"], state["north_rate"])
    height = _height(state, sensors)
    sound &= True if height is None else np.isfinite(height)
    chosen = None if height is None else height[sound]
    return Estimated(track.time[sound], place[:, sound], chosen, course[sound], int(np.sum(~sound)))


def _height(state: dict[str, np.ndarray], sensors: dict[str, Any]) -> np.ndarray | None:
    """(k,) m of the height that is estimated, or that range and elevation from an antenna give."""
    if "height" in state:
        return state["height"]
    for name, sensor in sensors.items():
        slant, elevation = state.get(f"{name}.range"), state.get(f"{name}.elevation")
        if slant is not None and elevation is not None:
            return np.asarray(sensor.antenna[2] + slant * np.sin(elevation))
    return None
