"""How far ahead a tracker can be believed: its own prediction without measurements, against what then happened."""

from __future__ import annotations

from typing import Any

import numpy as np

from sim import channels
from sim.flight import Flight
from tracking.gaussian import Mixture, merge
from tracking.track import Epoch

SPANS = (20.0, 60.0, 120.0)  # s
INSTANTS = 4  # from which is looked ahead, spread over the track
DRAWS = 16  # of the ensemble that look ahead; their spread over draws is far smaller than over instants


class LookAhead:
    """Watches a track and predicts from a few of its epochs, each prediction carried on from span to span."""

    def __init__(self, tracker: Any, flight: Flight, epochs: np.ndarray, sensors: dict[str, Any]) -> None:
        self.tracker, self.flight, self.sensors = tracker, flight, sensors
        early = epochs[epochs <= flight.time[-1] - SPANS[0]]
        # not the first epochs, which are the prior's
        self.wanted = (
            set(early[np.linspace(0, len(early) - 1, INSTANTS + 1).astype(int)][1:].tolist()) if len(early) else set()
        )
        self.squares: dict[float, dict[str, list[np.ndarray]]] = {}

    def __call__(self, epoch: Epoch) -> None:
        """Look ahead from an epoch, once, if it is one of those chosen."""
        if epoch.time not in self.wanted:
            return
        self.wanted.discard(epoch.time)
        draws = np.shape((merge(epoch.estimate) if isinstance(epoch.estimate, Mixture) else epoch.estimate).mean)[-1]
        state, done = narrowed(epoch.state, draws, DRAWS), 0.0
        for span in SPANS:
            if epoch.time + span > self.flight.time[-1]:
                return
            with np.errstate(divide="ignore", over="ignore", invalid="ignore"):  # a lost track is a result
                state, _ = self.tracker.step(state, span - done, None, None)
                estimate = self.tracker.estimate(state)
            done = span
            gaussian = merge(estimate) if isinstance(estimate, Mixture) else estimate
            truth = channels.truth_at(self.flight, np.array([epoch.time + span]))
            cov = gaussian.cov if gaussian.cov.ndim == 3 else gaussian.cov[..., None]
            errors = channels.compare(
                self.flight, truth, self.tracker.channels, gaussian.mean[None], cov[None], self.sensors
            )
            for channel, compared in errors.items():
                self.squares.setdefault(span, {}).setdefault(channel, []).append(channels.squared(compared))

    def figures(self) -> dict[str, dict[str, float]]:
        """RMSE by span and channel, as in metrics.json."""
        return {
            f"{span:.0f}_s": {channel: float(np.sqrt(np.mean(squares))) for channel, squares in by_channel.items()}
            for span, by_channel in self.squares.items()
        }


def narrowed(state: Any, draws: int, keep: int) -> Any:
    """A tracker's state with the first ``keep`` of its draws: every array whose last axis is the draws is cut."""
    if draws <= keep:
        return state
    if isinstance(state, np.ndarray):
        return state[..., :keep] if state.ndim and state.shape[-1] == draws else state
    if isinstance(state, dict):
        return {key: narrowed(value, draws, keep) for key, value in state.items()}
    if isinstance(state, tuple):
        parts = [narrowed(part, draws, keep) for part in state]
        return type(state)(*parts) if hasattr(state, "_fields") else tuple(parts)
    return state
