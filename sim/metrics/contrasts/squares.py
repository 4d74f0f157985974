"""Squared errors of one tracker, each with its time, so that those of another can be paired with them."""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np

from sim.flight.record import Flight
from sim.metrics.tracker import TrackerErrors, where_measured
from tracking.track import Track


class Squares(NamedTuple):
    """Squared errors in one comparison channel."""

    time: np.ndarray  # (k,) s, ascending; of a look-ahead the instants from which it was made
    values: Any  # (k, draws) array in the square of the channel's unit, of many draws in a file


def squared_errors(flight: Flight, track: Track, errors: TrackerErrors) -> dict[str, Any]:
    """`Squares` of a tracker where something was measured: ``overall`` by channel, ``by_phase`` by phase and channel.

    Names are those of metrics.json. Sums over them are the squares of its RMSE.
    """
    found: dict[str, Any] = {"overall": {}, "by_phase": {}}
    for channel, squares, _, measured in where_measured(errors):
        # a pair is of the same moments in all draws
        looked = measured if errors.present is None else measured & errors.present.all(axis=1)
        found["overall"][channel] = Squares(track.time[looked], squares[looked])
        for index in np.unique(errors.truth.phase[looked]):
            chosen = looked & (errors.truth.phase == index)
            by_phase = found["by_phase"].setdefault(flight.phases[index], {})
            by_phase[channel] = Squares(track.time[chosen], squares[chosen])
    return found
