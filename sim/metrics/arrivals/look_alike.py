"""How near the last turns of many flights come to the distributions of others, known by their quantiles alone."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from typing import Any, NamedTuple

import numpy as np

from sim.metrics.arrivals.last_turn import LastTurn

SHARES = (0.05, 0.5, 0.9, 0.95)  # of the quantiles that distributions are told by


class Figure(NamedTuple):
    """A figure of a last turn that distributions are compared in."""

    label: str
    unit: str
    of: Callable[[LastTurn], float | None]  # in that unit


FIGURES = (
    Figure("overshoot", "m", lambda turn: turn.overshoot),
    Figure("largest bank", "deg", lambda turn: math.degrees(turn.bank)),
    Figure("duration of the turn", "s", lambda turn: turn.duration),
    Figure("largest roll rate", "deg/s", lambda turn: math.degrees(turn.roll_rate)),
    Figure("settling after the turn", "s", lambda turn: turn.settling),
    Figure("cross-track sd on final", "m", lambda turn: turn.cross_track_sd),
    Figure("bank rms on final", "deg", lambda turn: None if turn.bank_rms is None else math.degrees(turn.bank_rms)),
)


def values(turns: Sequence[LastTurn], figure: Figure) -> Any:
    """(n,) of the turns that have the figure, in its unit."""
    return np.array([value for turn in turns if (value := figure.of(turn)) is not None], float)


def distance(found: Any, quantiles: Sequence[float]) -> float:
    """The largest difference between the shares of ``found`` (n,) at or below ``quantiles`` and ``SHARES``, 0 to 1.

    It is the statistic of Kolmogorov and Smirnov as far as four quantiles tell it, and never above it.
    """
    shares = [float(np.mean(np.asarray(found) <= quantile)) for quantile in quantiles]
    return max(abs(share - told) for share, told in zip(shares, SHARES, strict=True))


def rank_correlation(one: Sequence[float], other: Sequence[float]) -> float:
    """Spearman's, -1 to 1."""
    from scipy.stats import spearmanr

    return float(spearmanr(one, other).statistic)
