"""How far apart trackers are: where no truth is known, a tracker that stands alone is to be looked at."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np


class Positions(NamedTuple):
    """Where a tracker believed the aircraft."""

    time: np.ndarray  # (k,) s
    place: np.ndarray  # (k, 2, draws) m north, east


def agreement(tracked: dict[str, Positions]) -> dict[str, dict[str, float]]:
    """RMS distance, m, of every tracker from each other, at the epochs that both have."""
    found: dict[str, dict[str, float]] = {name: {} for name in tracked}
    for name, own in tracked.items():
        for other, its in tracked.items():
            _, rows, columns = np.intersect1d(own.time, its.time, return_indices=True)
            if name != other and rows.size:
                apart = own.place[rows] - its.place[columns]
                found[name][other] = float(np.sqrt(np.mean(np.einsum("kin,kin->kn", apart, apart))))
    return found
