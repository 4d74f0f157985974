"""Is a track what its plots say? Innovations are judged where no truth is known.

Innovations of a tracker whose model holds are white and of the covariance that it states: their NIS is chi-square, and
neighbouring ones are uncorrelated. A track that is wrong in a way that its plots do not show is not found out: a bias
that all plots have, say.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from tracking.consistency import LOST_EPOCHS, LOST_PROBABILITY, autocorrelation
from tracking.intervals import chi_square, correlation_band, mean_square_band
from tracking.track import Track


def innovation_figures(track: Track, begin: float, first_plot: float, last_plot: float) -> dict[str, Any]:
    """What innovations say of a track that began at ``begin``, s, over all draws; None where nothing is known.

    ``anis_low`` and ``anis_high`` bound the ANIS of a consistent tracker with 95 %, ``whiteness_limit`` the size of
    ``whiteness``, the correlation of neighbouring innovations. The track lasts until ten looks running lie outside the
    1 - 1e-6 ellipse of its predictions; ``continuity`` is its share of the time from the first plot to the last, s.
    """
    white, nis = np.asarray(track.white), np.asarray(track.nis)
    counted = np.isfinite(white).sum(axis=1)  # (k, draws)
    looked = counted.any(axis=1)
    freedom, looks = int(counted.sum()), int(looked.sum())
    low, high = mean_square_band(freedom, 1) if freedom else (None, None)
    correlated = autocorrelation(white[looked], 1)[1] if looks > 1 else np.array([np.nan])
    time = np.asarray(track.time)[looked]
    lost = _lost(nis[looked], counted[looked])
    until = float(time[lost]) if lost is not None else float(time[-1]) if looks else None
    return {
        "anis_low": low,
        "anis_high": high,
        "whiteness": float(np.mean(correlated)),
        "whiteness_limit": correlation_band(freedom) if freedom else None,
        "looks": looks,
        "gap_max_s": float(np.diff(time).max()) if looks > 1 else None,
        "begin_s": begin,
        "lost_time_s": None if lost is None else until,
        "length_s": None if until is None else until - begin,
        "continuity": None if until is None or last_plot <= first_plot else (until - begin) / (last_plot - first_plot),
    }


def _lost(nis: np.ndarray, counted: np.ndarray) -> int | None:
    """Row of the look with which any draw was lost; None = none was."""
    limit = np.array(
        [np.inf, *(chi_square(1.0 - LOST_PROBABILITY, m) for m in range(1, int(counted.max(initial=0)) + 1))]
    )
    outside = ~(nis <= limit[counted]) & (counted > 0)
    running = np.zeros(nis.shape[1], int)
    for row, look in enumerate(outside):
        running = np.where(counted[row] > 0, np.where(look, running + 1, 0), running)
        if (running >= LOST_EPOCHS).any():
            return row
    return None
