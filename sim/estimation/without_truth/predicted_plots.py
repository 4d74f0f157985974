"""Look-ahead where no truth is known: predictions are compared with the plots that were made later."""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from sim.estimation.batching import stack_trackers
from sim.estimation.look_ahead import SPANS
from sim.estimation.without_truth.places import Places
from sim.metrics.without_truth.predicted import Predicted
from tracking.gaussian import Mixture, merge
from tracking.track import Epoch, believed, stepped
from tracking.tree import side_by_side

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
        channels, draws = self.trackers[0].channels, self.plots.place.shape[2]
        if not {"north", "east"} <= {*channels}:
            return [{} for _ in self.trackers]
        rows = [channels.index("north"), channels.index("east")]
        found: list[dict[str, list[tuple[Any, Any]]]] = [{} for _ in self.trackers]
        for times, state in self._groups():
            tracker, done = stack_trackers(self.trackers * len(times), draws), 0.0
            for span, ahead in self._ahead(times[0]).items():
                state, _ = stepped(tracker, state, ahead - done)
                done = ahead
                estimate = believed(tracker, state)
                mean, cov = merge(estimate) if isinstance(estimate, Mixture) else estimate
                shape = (len(times), len(self.trackers), draws)
                cov = cov if np.ndim(cov) == 3 else cov[..., None]
                mean = np.broadcast_to(mean[rows], (2, math.prod(shape))).reshape(2, *shape)
                cov = np.broadcast_to(cov[np.ix_(rows, rows)], (2, 2, math.prod(shape))).reshape(2, 2, *shape)
                for place, time in enumerate(times):
                    row = int(np.argmin(np.abs(self.plots.time - (time + ahead))))
                    for number, own in enumerate(found):
                        error = mean[:, place, number] - self.plots.place[row]
                        spread = cov[:, :, place, number] + self.plots.cov[row]
                        own.setdefault(f"{span:.0f}_s", []).append((error, spread))
        return [
            {span: Predicted(*map(np.stack, zip(*pairs, strict=True))) for span, pairs in own.items()} for own in found
        ]

    def _groups(self) -> list[tuple[list[float], Any]]:
        """Epochs from which later plots are as far ahead, and the state that holds them side by side.

        A prediction costs by its steps and hardly by its runs. A state that cannot be put side by side stands alone.
        """
        alike: dict[tuple[float, ...], list[float]] = {}
        for time in self.kept:
            alike.setdefault(tuple(self._ahead(time).values()), []).append(time)
        groups: list[tuple[list[float], Any]] = []
        for times in alike.values():
            states = [self.kept[time] for time in times]
            try:
                if not type(self.trackers[0]).__module__.startswith(("tracking.", "sim.")):
                    raise TypeError("a number in the state of a caller's tracker need not take one value for each draw")
                groups.append((times, side_by_side(states, self.plots.place.shape[2] * len(self.trackers))))
            except (TypeError, ValueError):  # of the caller's own making, or with a memory that is still filling
                groups += [([time], state) for time, state in zip(times, states, strict=True)]
        return groups

    def _ahead(self, time: float) -> dict[float, float]:
        """How far ahead of an epoch the plot is that is nearest to each span, s; none where there is none near."""
        found = {}
        for span in SPANS if len(self.plots.time) else ():
            apart = self.plots.time - time
            nearest = float(apart[np.argmin(np.abs(apart - span))])
            if abs(nearest - span) <= NEAR * span:
                found[span] = round(nearest, 6)
        return found
