"""Plots on the ground plane, each with its covariance, as trackers read them."""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np

from sim.estimation.setup import height_profile, sensor_model
from sim.flight.preparation import Prepared
from sim.metrics.comparison import plotted
from tracking.track import Measurements


class Places(NamedTuple):
    """k plots that say a place, in order of arrival."""

    time: np.ndarray  # (k,) s, of arrival
    place: np.ndarray  # (k, 2, draws) m north, east
    cov: np.ndarray  # (k, 2, 2, draws)


def places(prepared: Prepared, sensors: dict[str, Any], record: Measurements) -> Places:
    """The plots of a record of sensors that give a place each; a plot that is missing in any draw is left out.

    The conversion is that of trackers on the ground plane, without bias, at the plot itself.
    """
    draws = record.z.shape[2]
    time, place, cov = [np.empty(0)], [np.empty((0, 2, draws))], [np.empty((0, 2, 2, draws))]
    for name, sensor in sensors.items():
        model = sensor_model(prepared, sensor) if sensor.gives_place else None
        if model is None:
            continue
        rows = [record.channels.index(f"{name}.{channel}") for channel in sensor.channels]
        seen = np.flatnonzero(np.isfinite(record.z[:, rows]).all(axis=(1, 2)))
        if not seen.size:
            continue
        z = np.moveaxis(record.z[seen][:, rows], 1, 0)  # (m, k, draws)
        R = np.moveaxis(record.R[seen][:, rows][:, :, rows], 0, 2)  # (m, m, k, draws or 1)
        rough = plotted(dict(zip(sensor.channels, z, strict=True)), sensor, height_profile(prepared))
        if rough is None:
            continue
        still = np.zeros_like(rough[0])
        found = model.linearise(
            z, np.broadcast_to(R, (*R.shape[:3], draws)), np.array([rough[0], still, rough[1], still])
        )
        usable = np.isfinite(found.z).all(axis=(0, 2))
        spread = np.broadcast_to(found.R, (2, 2, seen.size, draws))
        time.append(record.arrival[seen][usable])
        place.append(np.moveaxis(found.z, 1, 0)[usable])
        cov.append(np.moveaxis(spread, 2, 0)[usable])
    order = np.argsort(np.concatenate(time), kind="stable")
    return Places(np.concatenate(time)[order], np.concatenate(place)[order], np.concatenate(cov)[order])
