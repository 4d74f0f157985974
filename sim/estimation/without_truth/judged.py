"""The figures of a tracker of which only its plots are known, under the keys that it has with a truth."""

from __future__ import annotations

from typing import Any

import numpy as np

from sim.estimation.without_truth.places import Places
from sim.metrics import comparison
from sim.metrics.without_truth.agreement import Positions, agreement
from sim.metrics.without_truth.innovations import innovation_figures
from sim.metrics.without_truth.predicted import Predicted, predicted_figures
from tracking.track import Track

AGAINST_TRUTH = ("anees", "anees_low", "anees_high", "lost_fraction", "lost_time_s")


def figures_from_plots(track: Track, begin: float, plots: Places, predicted: dict[str, Predicted]) -> dict[str, Any]:
    """Figures of one tracker for metrics.json: what needs a truth is None or empty, what needs none is in ``plots``.

    ``begin`` is when its track begins, s, ``plots`` are all that its sensors made.
    """
    rows = np.isfinite(track.white).sum()
    first, last = (float(plots.time[row]) for row in (0, -1)) if len(plots.time) else (0.0, 0.0)
    return {
        "look_ahead": {},
        "overall": {},
        "by_phase": {},
        **dict.fromkeys(AGAINST_TRUTH),
        "anis": float(np.nansum(track.nis) / rows) if rows else None,
        "plots": {
            **innovation_figures(track, begin, first, last),
            "look_ahead": predicted_figures(predicted),
            "agreement_m": {},
        },
    }


def with_agreement(figures: dict[str, Any], tracks: dict[str, tuple[Track, dict[str, Any]]]) -> None:
    """Put into the figures of trackers how far they are from each other; of each its track and its sensors."""
    placed = {}
    for name, (track, sensors) in tracks.items():
        cov = track.cov if track.cov.ndim == 4 else track.cov[..., None]
        plane = comparison.on_the_plane(track.channels, track.mean, cov, sensors)
        if plane is not None:
            placed[name] = Positions(np.asarray(track.time), plane[0])
    for name, others in agreement(placed).items():
        figures[name]["plots"]["agreement_m"] = others
