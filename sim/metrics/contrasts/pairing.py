"""The paired contrast of two trackers: the ratio of their RMSE over one and the same moments and draws of noise.

Both trackers have seen the same flight and the same draws, so most of what makes one run of them worse than another is
in both. The ratio is therefore taken pair by pair: over the epochs at which both have an estimate and something was
measured for both, and of look-aheads over the instants from which both looked. Each draw gives two mean squares over
these; the ratio is the root of that of their means over draws, and its interval Student's for the linearised logarithm
(`tracking.intervals.gain`), in which the noise that both share cancels. What is correlated in time is within a draw, so
it does not matter. Where losses are rarer than one in the number of draws no interval of these draws can know of them.

A tracker whose errors are not finite in one of the draws is lost there, and leaving the draw out would flatter it: its
RMSE is None, and with it the ratio.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any

import numpy as np

from sim.metrics.contrasts.squares import Squares
from sim.scenario.tables import Contrast
from tracking.intervals import gain

TABLES = ("overall", "by_phase", "look_ahead")  # of a contrast
Entry = dict[str, Any]


def contrasts_of_flight(asked: Sequence[Contrast], trackers: dict[str, dict[str, Any]]) -> dict[str, Entry]:
    """The contrasts of one flight by their pair, as in the records of flights.

    Parameters
    ----------
    trackers : `Squares` in the tables ``TABLES`` by tracker; those that never tracked are absent

    The tables of an entry are empty where two trackers have nothing in common.
    """
    return {one.pair: entry(one, _paired(trackers.get(one.of, {}), trackers.get(one.against, {}))) for one in asked}


def entry(asked: Contrast, tables: dict[str, Any]) -> Entry:
    """A contrast as in metrics.json, all its tables there."""
    return {"of": asked.of, "against": asked.against, "name": asked.name, **{name: {} for name in TABLES}, **tables}


def figure(of: np.ndarray, against: np.ndarray) -> dict[str, float | int | None]:
    """The ratio of RMSE with its interval, and both RMSE, from mean squares (n,) of the same n draws or flights.

    Two that err alike in each of them are equal: exactly 1, from 1 to 1. What there is no finite number for is None.
    """
    with np.errstate(over="ignore", invalid="ignore"):  # a lost track is a result
        roots = [float(np.sqrt(np.mean(squares))) for squares in (of, against)]
    ratio = low = high = math.nan
    if all(map(math.isfinite, roots)):
        ratio, low, high = (1.0, 1.0, 1.0) if np.array_equal(of, against) else gain(of, against)[:3]
    named = {"ratio": ratio, "low": low, "high": high, "of": roots[0], "against": roots[1]}
    return {**{name: value if math.isfinite(value) else None for name, value in named.items()}, "n": len(of)}


def _paired(of: Any, against: Any) -> Any:
    """Figures of all that two tables have in common; what has nothing in common is left out."""
    if isinstance(of, Squares):
        return _at_common_times(of, against)
    found = {name: _paired(of[name], against[name]) for name in of if name in against}
    return {name: inner for name, inner in found.items() if inner}


def _at_common_times(of: Squares, against: Squares) -> dict[str, float | int | None]:
    """The figure over the times that both have; nothing where they have none."""
    if not np.array_equal(of.time, against.time):
        one, other = _last_of_each(of), _last_of_each(against)
        _, rows, others = np.intersect1d(one.time, other.time, assume_unique=True, return_indices=True)
        of, against = (Squares(s.time[k], s.values[k]) for s, k in ((one, rows), (other, others)))
    if not len(of.time):
        return {}
    with np.errstate(over="ignore", invalid="ignore"):  # a lost track is a result
        return figure(*(np.asarray(one.values).mean(axis=0) for one in (of, against)))


def _last_of_each(squares: Squares) -> Squares:
    """Without the first of two epochs at one time, when plots arrive together that were taken one after another."""
    last = np.append(np.diff(squares.time) > 0.0, True) if len(squares.time) else np.zeros(0, bool)
    return Squares(squares.time[last], squares.values[last])
