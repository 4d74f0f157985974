"""The arrays of a run as tables: columns of equal length, each named with its unit."""

from __future__ import annotations

import numpy as np

from sim.reporting.run_files import with_unit
from sim.scenario.schema import NAME

PER_CHANNEL = ("channels", "units")
Columns = dict[str, np.ndarray]


def groups(arrays: Columns) -> dict[str, Columns]:
    """Arrays by what stands before the last dot of their name: the sensor or the tracker, or ``SENSOR.plots``."""
    groups: dict[str, Columns] = {}
    for name, array in arrays.items():
        group, _, own = name.rpartition(".")
        if group and not all(map(NAME.fullmatch, group.split("."))):
            raise ValueError("a name that no sensor or tracker has")
        groups.setdefault(group, {})[own] = array
    return groups


def table_of(arrays: Columns) -> Columns:
    """Columns of equal length: what has one value at each instant, and channels spread over their noise draws."""
    count = len(arrays["time_s"])
    columns = {name: array for name, array in arrays.items() if array.shape == (count,) and name not in PER_CHANNEL}
    for name in columns:
        names = arrays.get(f"{name}s")
        if names is not None and names.dtype.kind == "U":
            columns[name] = names[columns[name]]
    channels = [str(channel) for channel in arrays.get("channels", ())]
    units = arrays.get("units", [None] * len(channels))  # of sensors; those of trackers follow from their names
    values = next((arrays[name] for name in ("z", "mean") if name in arrays), None)
    if values is None:
        return columns
    draws = values.shape[2]
    columns = {name: np.repeat(column, draws) for name, column in columns.items()}
    columns["draw"] = np.tile(np.arange(draws), count)
    sigma = np.broadcast_to(arrays["sigma"], values.shape)
    for row, (channel, unit) in enumerate(zip(channels, units, strict=True)):
        columns[with_unit(channel, unit)] = values[:, row].ravel()
        columns[with_unit(f"{channel}_sigma", unit)] = sigma[:, row].ravel()
    return columns
