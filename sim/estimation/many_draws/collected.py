"""Tracks and errors of all draws from those of their parts; of several parts the arrays of a track lie in files."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np

from sim.estimation.many_draws.filed_array import FiledArray
from sim.metrics.comparison import Compared
from sim.metrics.contrasts.squares import Squares
from tracking.track import Track

PER_DRAW = ("mean", "cov", "white", "nis", "log_likelihood", "model_probabilities", "skipped")


class CollectedTrack:
    """The track of one tracker, given part by part of the draws.

    A covariance that serves all runs of all parts still does.
    """

    def __init__(self) -> None:
        self._first: Track | None = None
        self._filed: dict[str, FiledArray] = {}
        self._draws = 0

    def add(self, part: Track) -> None:
        """The track of further draws."""
        if self._first is None:
            self._first = part
        else:
            for name in PER_DRAW:
                self._add(name, getattr(part, name), part.mean.shape[-1])
        self._draws += part.mean.shape[-1]

    def _add(self, name: str, values: Any, draws: int) -> None:
        assert self._first is not None
        first = getattr(self._first, name)
        if name not in self._filed:
            if values is None and first is None:
                return
            if name == "cov" and first.shape[-1] == values.shape[-1] == 1:
                return
            self._filed[name] = FiledArray(self._whole(name, first, self._draws))
        self._filed[name].add(self._whole(name, values, draws))

    def _whole(self, name: str, values: Any, draws: int) -> np.ndarray:
        """An array of a part with one value for each of its draws."""
        assert self._first is not None
        if values is None:  # nothing was skipped
            return np.zeros((len(self._first.time), draws), bool)
        return np.broadcast_to(values, (*np.shape(values)[:-1], draws))

    def whole(self) -> Track:
        """The track of all draws so far."""
        assert self._first is not None, "a track has a part at least"
        filed: dict[str, Any] = {**self._filed}
        return self._first._replace(**filed)


def filed(tables: dict[str, Any]) -> dict[str, Any]:
    """Tables of squared errors, by whatever names, with their values in files."""
    return {
        name: one._replace(values=FiledArray(one.values)) if isinstance(one, Squares) else filed(one)
        for name, one in tables.items()
    }


def joined_errors(parts: Sequence[dict[str, Compared]]) -> dict[str, Compared]:
    """Errors of all draws from those of their parts, which are given up."""
    if len(parts) < 2:
        return parts[0] if parts else {}
    found = {}
    for channel in [*parts[0]]:
        own = [part.pop(channel) for part in parts]
        draws = [one.error.shape[-1] for one in own]
        shared = all(one.cov.shape[-1] == 1 for one in own)
        covs = [np.broadcast_to(one.cov, (*one.cov.shape[:-1], n)) for one, n in zip(own, draws, strict=True)]
        cov = own[0].cov if shared else np.concatenate(covs, axis=-1)
        found[channel] = Compared(np.concatenate([one.error for one in own], axis=-1), cov)
    return found
