"""Accuracy of a tracker's prediction: propagated without measurements, compared with the later truth."""

from __future__ import annotations

import functools
from typing import Any

import numpy as np

from sim.estimation.batching import stack_trackers
from sim.flight.interpolation import truth_at
from sim.flight.record import Flight
from sim.metrics import comparison
from sim.metrics.contrasts.squares import Squares
from sim.observation.record import SensorRecord
from tracking.gaussian import Mixture, merge
from tracking.track import Epoch, believed, stepped
from tracking.tree import narrowed, side_by_side

SPANS = (20.0, 60.0, 120.0)  # s
INSTANTS = 12  # from which is looked ahead
DRAWS = 16  # of the ensemble that look ahead; their spread over draws is far smaller than over instants


Looks = dict[str, dict[str, Squares]]
"""Squared errors of one tracker's predictions by span and channel, at the instants from which was looked ahead."""


def instants_of(flight: Flight, records: dict[str, SensorRecord]) -> np.ndarray:
    """When is looked ahead, s: evenly over the flight, and where sensors keep step when all of them deliver.

    So trackers with different sensors look from the same instants. Where the sensors do not keep step, each tracker
    looks from its own last epoch before.
    """
    first, last = float(flight.time[0]), float(flight.time[-1]) - SPANS[0]
    if last <= first:
        return np.zeros(0)
    even = np.linspace(first, last, INSTANTS + 1)[1:]
    together = functools.reduce(np.intersect1d, (record.arrival for record in records.values()))
    if not len(together):
        return even
    found = np.unique(together[np.maximum(np.searchsorted(together, even, side="right") - 1, 0)])
    return found if len(found) == len(even) else even


class LookAhead:
    """Watches batched trackers, keeps their state at a few epochs and predicts from all of them at once."""

    def __init__(
        self,
        trackers: list[Any],
        flight: Flight,
        instants: np.ndarray,
        epochs: np.ndarray,
        sensors: dict[str, Any],
    ) -> None:
        self.trackers, self.flight, self.sensors = trackers, flight, sensors
        self.wanted: set[float] = set()  # the last epoch before each instant
        if len(instants) and len(epochs):
            # not at once when a track begins: that would be a prediction of the prior
            begun = instants[instants >= epochs[0] + 0.5 * (instants[-1] - instants[0]) / INSTANTS]
            self.wanted.update(epochs[np.searchsorted(epochs, begun, side="right") - 1].tolist())
        self.kept: dict[float, Any] = {}  # state of some draws of every tracker by epoch
        self.draws = DRAWS  # of each tracker

    def __call__(self, epoch: Epoch) -> None:
        """Keep the state of an epoch if it is one of those chosen; of several at one time, the last."""
        if epoch.time not in self.wanted:
            return
        runs = np.shape(epoch.estimate.mean)[-1]
        own = runs // len(self.trackers)
        self.draws = min(own, DRAWS)
        rows = np.add.outer(own * np.arange(len(self.trackers)), np.arange(self.draws)).ravel()
        self.kept[epoch.time] = narrowed(epoch.state, runs, rows)

    def looks(self) -> list[Looks]:
        """Squared errors of each tracker; only of what was to come within the flight."""
        found: list[dict[str, dict[str, list[Squares]]]] = [{} for _ in self.trackers]
        for times, state in self._groups():
            tracker, done = stack_trackers(self.trackers * len(times), self.draws), 0.0
            for span in SPANS:
                within = times + span <= self.flight.time[-1]
                if not within.any():
                    break
                with np.errstate(divide="ignore", over="ignore", invalid="ignore"):  # a lost track is a result
                    state, _ = stepped(tracker, state, span - done)
                    estimate = believed(tracker, state)
                    mean, cov = merge(estimate) if isinstance(estimate, Mixture) else estimate
                done = span
                for own, squares in zip(found, self._squares(times + span, within, mean, cov), strict=True):
                    by_channel = own.setdefault(f"{span:.0f}_s", {})
                    for channel, values in squares.items():
                        by_channel.setdefault(channel, []).append(Squares(times[within], values))
        return [
            {
                span: {channel: _joined(parts) for channel, parts in by_channel.items()}
                for span, by_channel in own.items()
            }
            for own in found
        ]

    def _groups(self) -> list[tuple[np.ndarray, Any]]:
        """Instants and the state that holds them side by side: all in one, where the state allows it.

        A prediction costs by its steps and hardly by its runs.
        """
        if not self.kept:
            return []
        try:
            if not type(self.trackers[0]).__module__.startswith(("tracking.", "sim.")):
                raise TypeError("a number in the state of a caller's tracker need not take one value for each draw")
            joined = side_by_side([*self.kept.values()], self.draws * len(self.trackers))
        except TypeError:  # a state of the caller's own making
            return [(np.array([time]), state) for time, state in self.kept.items()]
        return [(np.array([*self.kept]), joined)]

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


def _joined(parts: list[Squares]) -> Squares:
    return Squares(*(np.concatenate(each) for each in zip(*parts, strict=True)))


def look_ahead_rmse(looks: Looks) -> dict[str, dict[str, float]]:
    """RMSE over instants and draws by span and channel, as in metrics.json."""
    return {
        span: {channel: float(np.sqrt(np.mean(one.values))) for channel, one in by_channel.items()}
        for span, by_channel in looks.items()
    }
