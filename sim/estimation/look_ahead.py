"""Accuracy of a tracker's prediction: propagated without measurements, compared with the later truth."""

from __future__ import annotations

from typing import Any

import numpy as np

from sim.estimation.batching import stack_laws
from sim.flight.interpolation import truth_at
from sim.flight.record import Flight
from sim.metrics import comparison
from tracking.gaussian import Mixture, merge
from tracking.track import Epoch, believed, stepped
from tracking.tree import narrowed, side_by_side

SPANS = (20.0, 60.0, 120.0)  # s
INSTANTS = 4  # from which is looked ahead, spread over the track
DRAWS = 16  # of the ensemble that look ahead; their spread over draws is far smaller than over instants


class LookAhead:
    """Watches batched trackers, keeps their state at a few epochs and predicts from all of them at once."""

    def __init__(self, trackers: list[Any], flight: Flight, epochs: np.ndarray, sensors: dict[str, Any]) -> None:
        self.trackers, self.flight, self.sensors = trackers, flight, sensors
        early = epochs[epochs <= flight.time[-1] - SPANS[0]]
        # not the first epochs, which are the prior's
        self.wanted = (
            set(early[np.linspace(0, len(early) - 1, INSTANTS + 1).astype(int)][1:].tolist()) if len(early) else set()
        )
        self.kept: list[tuple[float, Any]] = []  # (s, state of some draws of every tracker)
        self.draws = DRAWS  # of each tracker

    def __call__(self, epoch: Epoch) -> None:
        """Keep the state of an epoch, once, if it is one of those chosen."""
        if epoch.time not in self.wanted:
            return
        self.wanted.discard(epoch.time)
        runs = np.shape(epoch.estimate.mean)[-1]
        own = runs // len(self.trackers)
        self.draws = min(own, DRAWS)
        rows = np.add.outer(own * np.arange(len(self.trackers)), np.arange(self.draws)).ravel()
        self.kept.append((epoch.time, narrowed(epoch.state, runs, rows)))

    def figures(self) -> list[dict[str, dict[str, float]]]:
        """RMSE by span and channel of each tracker, as in metrics.json."""
        found: list[dict[float, dict[str, list[np.ndarray]]]] = [{} for _ in self.trackers]
        for times, state in self._groups():
            tracker, done = stack_laws(self.trackers * len(times), self.draws), 0.0
            for span in SPANS:
                within = times + span <= self.flight.time[-1]
                if not within.any():
                    break
                with np.errstate(divide="ignore", over="ignore", invalid="ignore"):  # a lost track is a result
                    state, _ = stepped(tracker, state, span - done)
                    estimate = believed(tracker, state)
                    mean, cov = merge(estimate) if isinstance(estimate, Mixture) else estimate
                done = span
                for place, squares in enumerate(self._squares(times + span, within, mean, cov)):
                    for channel, values in squares.items():
                        found[place].setdefault(span, {}).setdefault(channel, []).append(values)
        return [{f"{span:.0f}_s": _rmse(by_channel) for span, by_channel in own.items()} for own in found]

    def _groups(self) -> list[tuple[np.ndarray, Any]]:
        """Instants and the state that holds them side by side: all in one, where the state allows it.

        A prediction costs by its steps and hardly by its runs.
        """
        if not self.kept:
            return []
        try:
            if not type(self.trackers[0]).__module__.startswith(("tracking.", "sim.")):
                raise TypeError("a number in the state of a caller's tracker need not take one value for each draw")
            joined = side_by_side([state for _, state in self.kept], self.draws * len(self.trackers))
        except TypeError:  # a state of the caller's own making
            return [(np.array([time]), state) for time, state in self.kept]
        return [(np.array([time for time, _ in self.kept]), joined)]

    def _squares(self, times: np.ndarray, within: np.ndarray, mean: Any, cov: Any) -> list[dict[str, np.ndarray]]:
        """Squared errors (instants within the flight, draws) by channel, for each tracker."""
        n, shape = len(mean), (len(times), len(self.trackers), self.draws)
        cov = np.broadcast_to(cov if np.ndim(cov) == 3 else cov[..., None], (n, n, mean.shape[1]))
        mean = np.moveaxis(mean.reshape(n, *shape), 1, 0)[within]  # (instants, n, trackers, draws)
        cov = np.moveaxis(cov.reshape(n, n, *shape), 2, 0)[within]
        truth = truth_at(self.flight, times[within])
        names = self.trackers[0].channels
        with np.errstate(divide="ignore", over="ignore", invalid="ignore"):
            errors = [
                comparison.compare(self.flight, truth, names, mean[:, :, place], cov[..., place, :], self.sensors)
                for place in range(len(self.trackers))
            ]
        return [{channel: comparison.squared(one) for channel, one in compared.items()} for compared in errors]


def _rmse(by_channel: dict[str, list[np.ndarray]]) -> dict[str, float]:
    return {channel: float(np.sqrt(np.mean(np.concatenate(parts)))) for channel, parts in by_channel.items()}
