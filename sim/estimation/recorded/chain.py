"""One estimate for each epoch and draw, of the rows of a recorded track: one track of the aircraft after another."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, NamedTuple

import numpy as np

MOST = 20_000_000  # epochs times draws


class Rows(NamedTuple):
    """r estimates in any order."""

    time: np.ndarray  # (r,) s of the flight
    draw: np.ndarray  # (r,) of the noise
    number: np.ndarray  # (r,) of the track
    mean: np.ndarray  # (r, n) with or without rates: north, north_rate, east, east_rate
    cov: np.ndarray | None  # (r, 2, 2) m2 of north and east, NaN where none is stated

    def chosen(self, some: np.ndarray) -> Rows:
        """Some of the rows."""
        cov = None if self.cov is None else self.cov[some]
        return Rows(self.time[some], self.draw[some], self.number[some], self.mean[some], cov)


class Chain(NamedTuple):
    """k epochs of all draws; NaN, and number -1, where a draw has no estimate."""

    time: np.ndarray  # (k,) s, ascending
    mean: np.ndarray  # (k, n, draws)
    cov: np.ndarray  # (k, 2, 2, draws)
    number: np.ndarray  # (k, draws) of the track that is judged
    tracks: np.ndarray  # (k, draws) how many had an estimate

    @property
    def present(self) -> np.ndarray:
        """(k, draws) whether there is an estimate."""
        return self.number >= 0

    def rows(self, chosen: Any) -> Chain:
        """Some epochs."""
        return Chain(*(part[chosen] for part in self))


def chained(rows: Rows, draws: int, place_at: Callable[[np.ndarray], np.ndarray]) -> Chain:
    """The track of the aircraft in every draw.

    Where several tracks have an estimate at an epoch, the one of the epoch before goes on; where that has none, the
    nearest to the aircraft is taken. ``place_at`` gives where it was, (k, 2) m north and east, at times (k,).

    Raises ``ValueError`` in one sentence for a draw that the scenario has not, and for a track with two estimates at
    one time.
    """
    if (rows.draw >= draws).any():
        raise ValueError(f"has estimates of draw {rows.draw.max()}, and the scenario has draws 0 to {draws - 1}")
    time, epoch = np.unique(rows.time, return_inverse=True)
    if len(time) * draws > MOST:
        raise ValueError(f"has {len(time)} different times in {draws} draws, more than can be judged at once")
    tracks = np.zeros((len(time), draws), int)
    np.add.at(tracks, (epoch, rows.draw), 1)
    taken = np.full((len(time), draws), -1)  # row of the file
    single = tracks[epoch, rows.draw] == 1
    taken[epoch[single], rows.draw[single]] = np.flatnonzero(single)
    if not single.all():
        _choose(rows, epoch, taken, place_at(time))
    there = taken >= 0
    n = rows.mean.shape[1]
    mean, cov = np.full((len(time), n, draws), np.nan), np.full((len(time), 2, 2, draws), np.nan)
    k, draw = np.nonzero(there)
    mean[k, :, draw] = rows.mean[taken[k, draw]]
    if rows.cov is not None:
        cov[k, :, :, draw] = rows.cov[taken[k, draw]]
    return Chain(time, mean, cov, np.where(there, rows.number[taken], -1), tracks)


def _choose(rows: Rows, epoch: np.ndarray, taken: np.ndarray, place: np.ndarray) -> None:
    """Put into ``taken`` the rows of those draws that have several tracks at an epoch."""
    east = rows.mean.shape[1] // 2
    several = taken[epoch, rows.draw] < 0
    for draw in np.unique(rows.draw[several]):
        own = np.flatnonzero(rows.draw == draw)
        own = own[np.argsort(epoch[own], kind="stable")]
        followed = -1
        for some in np.split(own, np.flatnonzero(np.diff(epoch[own])) + 1):
            k, numbers = epoch[some[0]], rows.number[some]
            if len(np.unique(numbers)) < len(some):
                raise ValueError(f"has two estimates of one track at {rows.time[some[0]]:g} s in draw {draw}")
            distance = np.hypot(rows.mean[some, 0] - place[k, 0], rows.mean[some, east] - place[k, 1])
            best = np.flatnonzero(numbers == followed)
            taken[k, draw] = some[best[0] if len(best) else int(np.argmin(distance))]
            followed = rows.number[taken[k, draw]]
