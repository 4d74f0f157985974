"""The records of a run as comma-separated values, one file for the flight, each sensor and each tracker."""

from __future__ import annotations

import csv
import itertools
import zipfile
import zlib
from collections.abc import Iterator
from pathlib import Path

import numpy as np

from sim.errors import OutputError
from sim.output import MARK, staged

RECORDS = ("flight", "measurements", "tracks")
ANGLES = ("azimuth", "elevation", "bearing", "course", "bank", "heading", "turn", "path_angle")  # others are lengths
PER_TIME = {"_rate": "ps", "_speed": "ps", "_acceleration": "ps2"}  # how a channel's name ends -> how its unit does
Columns = dict[str, np.ndarray]


def export_csv(folder: Path) -> list[Path]:
    """Write the records of a run folder beside themselves as CSV; returns the files written.

    Numbers are written in full; what is absent is an empty cell. Sensors and trackers get one row for each epoch and
    noise draw. Raises ``OutputError`` in one sentence for a folder that is not a run, or a record that is missing or
    damaged.
    """
    if not folder.is_dir():
        raise OutputError(f"{folder}: no such folder; name the folder that 'shortfinal run' wrote")
    if not (folder / MARK).is_file():
        raise OutputError(f"{folder}: not a run folder; name one that 'shortfinal run' wrote")
    tables = {
        f"{record}.{group}.csv" if group else f"{record}.csv": _table(arrays)
        for record in RECORDS
        for group, arrays in _groups(_load(folder / f"{record}.npz")).items()
    }
    with staged(folder) as place:
        for name, table in tables.items():
            _write(place / name, table)
    return [folder / name for name in tables]


def _load(path: Path) -> Columns:
    if not path.is_file():
        raise OutputError(f"{path}: missing; run the scenario again")
    try:
        with path.open("rb") as file, np.load(file) as arrays:
            return dict(arrays.items())
    except (OSError, ValueError, TypeError, EOFError, zipfile.BadZipFile, zlib.error):
        raise OutputError(f"{path}: damaged; run the scenario again") from None


def _groups(arrays: Columns) -> dict[str, Columns]:
    """Arrays by what stands before the last dot of their name, which is the sensor or the tracker."""
    groups: dict[str, Columns] = {}
    for name, array in arrays.items():
        group, _, own = name.rpartition(".")
        groups.setdefault(group, {})[own] = array
    return groups


def _table(arrays: Columns) -> Columns:
    """Columns of equal length: what has one value at each instant, and channels spread over their noise draws."""
    count = len(arrays["time_s"])
    columns = {name: array for name, array in arrays.items() if array.shape == (count,)}
    for name in columns:
        names = arrays.get(f"{name}s")
        if names is not None and names.dtype.kind == "U":
            columns[name] = names[columns[name]]
    channels = [str(channel) for channel in arrays.get("channels", ())]
    values = next((arrays[name] for name in ("z", "mean") if name in arrays), None)
    if values is None:
        return columns
    draws = values.shape[2]
    columns = {name: np.repeat(column, draws) for name, column in columns.items()}
    columns["draw"] = np.tile(np.arange(draws), count)
    sigma = np.broadcast_to(arrays["sigma"], values.shape)
    for row, channel in enumerate(channels):
        columns[_with_unit(channel)] = values[:, row].ravel()
        columns[_with_unit(f"{channel}_sigma")] = sigma[:, row].ravel()
    return columns


def _with_unit(channel: str) -> str:
    """The channel, or its standard deviation, with the SI suffix of its quantity."""
    plain = channel.removesuffix("_sigma")
    if "load_factor" in plain:
        return channel
    quantity = "rad" if any(angle in plain for angle in ANGLES) else "m"
    per_time = next((suffix for ending, suffix in PER_TIME.items() if plain.endswith(ending)), "")
    return f"{channel}_{quantity}{per_time}"


def _write(path: Path, columns: Columns) -> None:
    with path.open("w", newline="", encoding="utf-8") as file:
        writer = csv.writer(file, lineterminator="\n")
        writer.writerow(columns)
        writer.writerows(zip(*(_cells(column) for column in columns.values()), strict=True))


def _cells(column: np.ndarray) -> Iterator[object]:
    """Plain Python values, an empty cell for NaN."""
    if column.dtype.kind != "f":
        return iter(column.tolist())
    absent = np.isnan(column)
    return itertools.chain("" if gone else value for value, gone in zip(column.tolist(), absent.tolist(), strict=True))
