"""How a track begins where nothing is known of the aircraft but its plots: from the first two of them.

A value and its rate follow from two measurements v1, v2, made T apart with the errors of their R: v2 and (v2 - v1) / T,
with the covariance [R2, R2 / T; R2 / T, (R1 + R2) / T^2] [Bar-Shalom, Li and Kirubarajan 2001, 5.5.3, from memory].
What the aircraft does between the two, a turn say, is in no R: it is small beside the errors of plots some seconds
apart. An acceleration is taken for zero.
"""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np

from sim.errors import ScenarioError
from sim.estimation.prior import split
from sim.estimation.without_truth.places import places
from sim.flight.preparation import Prepared
from sim.observation.sensor import quantity_of
from tracking.gaussian import Gaussian
from tracking.measurement import wrap
from tracking.track import Measurements

PLANE = ("north", "east")
ACCELERATION = 2.0  # m/s2, of the unit of a component: standard deviation of turns of up to 20 deg of bank, all alike


class Series(NamedTuple):
    """What was measured of some components at once, d in number."""

    what: str
    time: np.ndarray  # (k,) s
    value: np.ndarray  # (k, d, draws)
    cov: np.ndarray  # (k, d, d, draws)


class Start(NamedTuple):
    """What is known when a track begins; what arrived until then is in it."""

    time: float  # s
    prior: Gaussian


def two_plot_start(
    prepared: Prepared, name: str, sensors: dict[str, Any], record: Measurements, components: tuple[str, ...]
) -> Start | None:
    """The state of tracker ``name`` after the second plot; None where the record has not two of each component.

    Raises ``ScenarioError`` for a component of which plots say nothing.
    """
    plane = _on_the_plane(prepared, sensors, record)
    rows = [
        (plane, PLANE.index(quantity), order) if quantity in PLANE else (_measured(name, record, quantity), 0, order)
        for quantity, order in map(split, components)
    ]
    if any(len(series.time) < 2 for series, _, _ in rows):
        return None
    start = max(float(series.time[1]) for series, _, _ in rows)
    draws = record.z.shape[2]
    mean, cov = np.zeros((len(rows), draws)), np.zeros((len(rows), len(rows), draws))
    for i, (series, row, order) in enumerate(rows):
        if order == 2:
            cov[i, i] = ACCELERATION**2
            continue
        first, second = _weights(series, order, start)
        mean[i] = first * series.value[0, row] + second * series.value[1, row]
        for j, (other, column, another) in enumerate(rows):
            if other.what == series.what and another < 2:
                before, after = _weights(other, another, start)
                cov[i, j] = first * before * series.cov[0, row, column] + second * after * series.cov[1, row, column]
    return Start(start, Gaussian(mean, cov))


def _weights(series: Series, order: int, start: float) -> tuple[float, float]:
    """Of the first and the second value in the value, or its rate, on the straight line through both at ``start``."""
    first, second = (float(time) for time in series.time[:2])
    apart = second - first
    if order == 1:
        return -1.0 / apart, 1.0 / apart
    beyond = (start - second) / apart
    return -beyond, 1.0 + beyond


def _on_the_plane(prepared: Prepared, sensors: dict[str, Any], record: Measurements) -> Series:
    """Places; of several at one instant the first."""
    found = places(prepared, sensors, record)
    _, first = np.unique(found.time, return_index=True)
    return Series("place", found.time[first], found.place[first], found.cov[first])


def _measured(name: str, record: Measurements, quantity: str) -> Series:
    """What the looks say of a quantity of one sensor, or of the height from whichever measures it."""
    rows = [i for i, channel in enumerate(record.channels) if quantity in (channel, channel.rpartition(".")[2])]
    if not rows:
        raise ScenarioError(f"[trackers.{name}] no plot says anything of its component {quantity}, so no track begins")
    row = rows[0]
    seen = np.isfinite(record.z[:, row]).all(axis=1)
    value = record.z[seen][:, [row]]
    if quantity_of(quantity).wraps and len(value):
        value = value[:1] + wrap(value - value[:1])
    cov = record.R[seen][:, [row]][:, :, [row]]
    return Series(quantity, record.arrival[seen], value, np.broadcast_to(cov, (*cov.shape[:3], record.z.shape[2])))
