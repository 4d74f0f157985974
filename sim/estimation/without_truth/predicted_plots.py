"""Look-ahead where no truth is known: predictions are compared with the plots that were made later."""

from __future__ import annotations

from typing import Any

import numpy as np

from sim.estimation.batching import stack_laws
from sim.estimation.look_ahead import SPANS
from sim.estimation.without_truth.places import Places
from sim.metrics.without_truth.predicted import Predicted
from tracking.gaussian import Mixture, merge
from tracking.track import Epoch, believed, stepped

INSTANTS = 40  # from which is looked ahead: errors of one track are correlated, and more would say little more
NEAR = 0.1  # of the span, by which a plot may be early or late


class PredictedPlots:
    """Watches batched trackers, keeps their state at some epochs and predicts later plots from each."""

    def __init__(self, trackers: list[Any], epochs: np.ndarray, plots: Places) -> None:
        self.trackers, self.plots = trackers, plots
        last = float(epochs[-1]) - SPANS[0]
        usable = epochs[epochs <= last]
        few = np.unique(np.linspace(0, len(usable) - 1, INSTANTS).astype(int)) if len(usable) else np.zeros(0, int)
        self.wanted = {*usable[few].tolist()}
        self.kept: dict[float, Any] = {}

    def __call__(self, epoch: Epoch) -> None:
        """Keep the state of an epoch if it is one of those chosen; of several at one time, the last."""
        if epoch.time in self.wanted:
            self.kept[epoch.time] = epoch.state

    def looks(self) -> list[dict[str, Predicted]]:
        """Of each tracker, by span; none for one that knows no place."""
        channels = self.trackers[0].channels
        if not {"north", "east"} <= {*channels}:
            return [{} for _ in self.trackers]
        rows = [channels.index("north"), channels.index("east")]
        tracker = stack_laws(self.trackers, self.plots.place.shape[2])
        found: dict[str, list[tuple[Any, Any]]] = {}
        for time, kept in self.kept.items():
            state, done = kept, time
            for span in SPANS:
                row = self._plot(time + span, span)
                if row is None:
                    continue
                later = float(self.plots.time[row])
                state, _ = stepped(tracker, state, later - done)
                done = later
                estimate = believed(tracker, state)
                mean, cov = merge(estimate) if isinstance(estimate, Mixture) else estimate
                times = len(self.trackers)
                place, spread = (np.concatenate([one[row]] * times, axis=-1) for one in self.plots[1:])
                shared = cov if np.ndim(cov) == 3 else cov[..., None]
                found.setdefault(f"{span:.0f}_s", []).append((mean[rows] - place, shared[np.ix_(rows, rows)] + spread))
        return [self._of(place, found) for place in range(len(self.trackers))]

    def _plot(self, time: float, span: float) -> int | None:
        """The plot nearest to a time; None = there is none near."""
        if not len(self.plots.time):
            return None
        row = int(np.argmin(np.abs(self.plots.time - time)))
        return row if abs(float(self.plots.time[row]) - time) <= NEAR * span else None

    def _of(self, place: int, found: dict[str, list[tuple[Any, Any]]]) -> dict[str, Predicted]:
        """The predictions of one tracker of the batch."""
        draws = self.plots.place.shape[2]
        own = slice(place * draws, (place + 1) * draws)
        return {
            span: Predicted(*(np.stack([part[..., own] for part in parts]) for parts in zip(*pairs, strict=True)))
            for span, pairs in found.items()
        }
