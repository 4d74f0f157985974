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
    """Watches a track, keeps its state at a few epochs and predicts from all of them at once."""

    def __init__(self, tracker: Any, flight: Flight, epochs: np.ndarray, sensors: dict[str, Any]) -> None:
        self.tracker, self.flight, self.sensors = tracker, flight, sensors
        early = epochs[epochs <= flight.time[-1] - SPANS[0]]
        # not the first epochs, which are the prior's
        self.wanted = (
            set(early[np.linspace(0, len(early) - 1, INSTANTS + 1).astype(int)][1:].tolist()) if len(early) else set()
        )
        self.kept: list[tuple[float, Any]] = []  # (s, state of the first draws)

    def __call__(self, epoch: Epoch) -> None:
        """Keep the state of an epoch, once, if it is one of those chosen."""
        if epoch.time not in self.wanted:
            return
        self.wanted.discard(epoch.time)
        draws = np.shape((merge(epoch.estimate) if isinstance(epoch.estimate, Mixture) else epoch.estimate).mean)[-1]
        self.kept.append((epoch.time, narrowed(epoch.state, draws, DRAWS)))
        self.draws = min(draws, DRAWS)

    def figures(self) -> dict[str, dict[str, float]]:
        """RMSE by span and channel, as in metrics.json."""
        if not self.kept:
            return {}
        squares: dict[float, dict[str, list[np.ndarray]]] = {}
        try:
            # the instants side by side as if they were draws: a prediction costs by its steps, hardly by its runs
            groups = [(np.array([time for time, _ in self.kept]), side_by_side([s for _, s in self.kept], self.draws))]
        except TypeError:  # a state of the caller's own making
            groups = [(np.array([time]), state) for time, state in self.kept]
        for times, state in groups:
            done = 0.0
            for span in SPANS:
                within = times + span <= self.flight.time[-1]
                if not within.any():
                    break
                with np.errstate(divide="ignore", over="ignore", invalid="ignore"):  # a lost track is a result
                    state, _ = self.tracker.step(state, span - done, None, None)
                    estimate = self.tracker.estimate(state)
                done = span
                mean, cov = merge(estimate) if isinstance(estimate, Mixture) else estimate
                for channel, found in self._squares(times + span, mean, cov, within).items():
                    squares.setdefault(span, {}).setdefault(channel, []).append(found)
        return {
            f"{span:.0f}_s": {channel: float(np.sqrt(np.mean(np.concatenate(found)))) for channel, found in by.items()}
            for span, by in squares.items()
        }

    def _squares(self, times: np.ndarray, mean: Any, cov: Any, within: np.ndarray) -> dict[str, np.ndarray]:
        """Squared errors (instants within the flight, draws) by channel, from estimates with instants side by side."""
        instants, n = len(times), len(mean)
        cov = cov if np.ndim(cov) == 3 else cov[..., None]
        mean = np.moveaxis(mean.reshape(n, instants, -1), 1, 0)[within]
        cov = np.broadcast_to(cov, (n, n, instants * mean.shape[2]) if cov.shape[2] > 1 or instants > 1 else cov.shape)
        cov = np.moveaxis(cov.reshape(n, n, instants, -1), 2, 0)[within]
        truth = channels.truth_at(self.flight, times[within])
        with np.errstate(divide="ignore", over="ignore", invalid="ignore"):
            errors = channels.compare(self.flight, truth, self.tracker.channels, mean, cov, self.sensors)
        return {channel: channels.squared(compared) for channel, compared in errors.items()}


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


def side_by_side(states: list[Any], draws: int) -> Any:
    """States of one tracker as one state whose last axis holds the draws of the first, then those of the second, ...

    What is alike in all stays shared. Raises ``TypeError`` where something differs that has no axis of draws.
    """
    first = states[0]
    if isinstance(first, tuple):
        parts = [side_by_side(list(part), draws) for part in zip(*states, strict=True)]
        return type(first)(*parts) if hasattr(first, "_fields") else tuple(parts)
    if isinstance(first, dict):
        return {key: side_by_side([state[key] for state in states], draws) for key in first}
    if isinstance(first, np.ndarray) and first.ndim:
        if len({state.shape for state in states}) == 1 and all(np.array_equal(first, s) for s in states[1:]):
            return first if first.shape[-1] != draws or draws == 1 else np.concatenate(states, axis=-1)
        if all(state.shape[-1] in (1, draws) for state in states):
            return np.concatenate([np.broadcast_to(s, (*s.shape[:-1], draws)) for s in states], axis=-1)
    elif isinstance(first, int | float | np.generic):
        return first if all(state == first for state in states) else np.repeat(states, draws)
    elif all(state is first for state in states):
        return first
    raise TypeError(f"states of the type {type(first).__name__} cannot stand side by side")
