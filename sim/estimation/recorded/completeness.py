"""How whole a recorded track is: when it began, what it missed, how often it changed its number."""

from __future__ import annotations

from typing import Any

import numpy as np

from sim.estimation.recorded.chain import Chain
from tracking.track import Measurements


def completeness(chain: Chain, looks: Measurements) -> dict[str, Any]:
    """Figures of a track beside the looks that it was made from, in order of arrival; means over draws.

    A look of a draw is taken up where the draw has an estimate within half the median time between looks. Of the looks
    of a draw ``completeness`` is the share that is taken up, ``initiation_s`` the time from the first look to the first
    estimate, and ``longest_gap_s`` the longest time, in any draw, from an estimate to the next.
    """
    seen = np.isfinite(looks.z).any(axis=1)  # (looks, draws)
    half = 0.5 * float(np.median(np.diff(np.unique(looks.arrival)))) if len(looks.arrival) > 1 else 0.0
    whole, begun, gaps, changes, numbers = [], [], [], [], []
    for draw in range(seen.shape[1]):
        expected, own = looks.arrival[seen[:, draw]], chain.time[chain.present[:, draw]]
        if not len(own):
            whole.append(0.0)
            continue
        whole.append(float(np.mean(_nearest(expected, own) <= half)) if len(expected) else 1.0)
        begun.append(float(own[0] - expected[0]) if len(expected) else 0.0)
        gaps.append(float(np.diff(own).max()) if len(own) > 1 else 0.0)
        number = chain.number[chain.present[:, draw], draw]
        changes.append(int(np.count_nonzero(np.diff(number))))
        numbers.append(len(np.unique(number)))
    present = chain.present
    return {
        "completeness": float(np.mean(whole)),
        "begun_fraction": len(begun) / len(whole),
        "initiation_s": float(np.mean(begun)) if begun else None,
        "longest_gap_s": max(gaps, default=None),
        "number_changes": float(np.mean(changes)) if changes else None,
        "redundant_fraction": float(np.mean(chain.tracks[present] > 1)) if present.any() else None,
    }


def _nearest(times: np.ndarray, others: np.ndarray) -> np.ndarray:
    """(k,) s from each of the times to the nearest of others, which ascend."""
    after = np.minimum(np.searchsorted(others, times), len(others) - 1)
    before = np.maximum(after - 1, 0)
    return np.asarray(np.minimum(np.abs(times - others[before]), np.abs(times - others[after])))
