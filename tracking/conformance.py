"""Page's test on the model probabilities of a tracker that has intents: is the assumed law left?"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np

from tracking.track import ARMED, Track, intents_of

UNLIKELY = 1e-300  # so little is left of a hypothesis that a look rules out
BELIEVED = 40.0  # s, for which an armed law has to be more probable than not before it is taken to be flown


class Watched(NamedTuple):
    """What the test says at each of k epochs, for each noise draw."""

    time: np.ndarray  # (k,) s
    assumed: str  # the intent of the law that the tracker assumes
    belief: dict[str, np.ndarray]  # (k, draws) probability of each intent
    sum: np.ndarray  # (k, draws) of log likelihood ratios against the assumed law, never below zero
    limit: float

    @property
    def alarm(self) -> np.ndarray:
        """(k, draws) bool."""
        return np.asarray(self.sum > self.limit)


@dataclass(frozen=True)
class ConformanceTest:
    """Page's test for a change from the assumed law to anything else [beyond the papers].

    The test of a tracker for which the law may only be armed begins once the law has been more probable than not for
    `BELIEVED` seconds on end: who flies a heading leaves no law. All others assume that the law flies from the start.
    """

    looks_between_false_alarms: float = 1000.0  # at least, on average

    def __post_init__(self) -> None:
        if not self.looks_between_false_alarms > 1.0:
            raise ValueError(f"looks_between_false_alarms must be above 1, not {self.looks_between_false_alarms}")

    @property
    def limit(self) -> float:
        """Of the sum."""
        return math.log(self.looks_between_false_alarms)

    def step(self, total: Any, evidence: Any, belief: Any) -> Any:
        """The sum after one more look, which leaves the assumed law with the probability ``belief``.

        A lost draw (NaN) counts as one that does not follow it.
        """
        following = np.maximum(total + np.nan_to_num(evidence, nan=self.limit), 0.0)
        return np.where((total > self.limit) & (belief > 0.5), 0.0, following)

    def watch(self, tracker: Any, track: Track) -> Watched | None:
        """The test along the record of a tracker; None for one that has no intents."""
        names = intents_of(tracker)
        if not names or track.model_probabilities is None:
            return None
        after = np.asarray(track.model_probabilities)
        before = np.full_like(after, 1.0 / len(names))
        steps = np.diff(track.time)[:, None, None]
        before[1:] = tracker.switched(after[:-1], steps, np.asarray(track.mean)[:-1])
        assumed = np.array([name == names[0] for name in names])
        with np.errstate(invalid="ignore"):  # a lost draw is a result
            evidence = _log_odds(after, assumed) - _log_odds(before, assumed)
        belief = {
            name: after[:, np.array([other == name for other in names])].sum(axis=1) for name in dict.fromkeys(names)
        }
        flown = _flown(belief[names[0]], np.asarray(track.time)) if ARMED in names else np.ones(evidence.shape, bool)
        sums = np.empty_like(evidence)
        total: Any = 0.0
        for row, look in enumerate(evidence):
            total = sums[row] = np.where(flown[row], self.step(total, look, belief[names[0]][row]), 0.0)
        return Watched(track.time, names[0], belief, sums, self.limit)


CONFORMANCE = ConformanceTest()


def _log_odds(weights: np.ndarray, assumed: np.ndarray) -> np.ndarray:
    """Logarithm of the odds (k, draws) against the assumed law."""
    against, by = weights[:, ~assumed].sum(axis=1), weights[:, assumed].sum(axis=1)
    return np.asarray(np.log(np.maximum(against, UNLIKELY)) - np.log(np.maximum(by, UNLIKELY)))


def _flown(belief: np.ndarray, time: np.ndarray) -> np.ndarray:
    """(k, draws) bool: whether the law has ever been more probable than not for `BELIEVED` seconds on end."""
    since = np.where(belief > 0.5, -np.inf, time[:, None])  # the last look at which it was not
    since = np.maximum(np.maximum.accumulate(since, axis=0), time[0])
    return np.asarray(np.maximum.accumulate(time[:, None] - since >= BELIEVED, axis=0))
