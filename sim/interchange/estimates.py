"""Estimates that a tracker made elsewhere: a table with a line for each update, its columns known by their names."""

from __future__ import annotations

import math
from typing import Any, NamedTuple

import numpy as np

from sim.interchange.cells import CellTable, Column, Columns, listed, text_columns
from sim.interchange.clocks import Stamps

COLUMNS = {
    "north": (Column(("north",), "m"), Column(("y",), "m")),
    "east": (Column(("east",), "m"), Column(("x",), "m")),
    "latitude": (Column(("latitude", "lat"), "rad", "deg"),),
    "longitude": (Column(("longitude", "lon", "long"), "rad", "deg"),),
    "north_rate": (Column(("north_rate", "velocity_north", "vy"), "m/s"),),
    "east_rate": (Column(("east_rate", "velocity_east", "vx"), "m/s"),),
    "north_variance": (Column(("north_variance", "variance_north"), "m2", "m2"),),
    "east_variance": (Column(("east_variance", "variance_east"), "m2", "m2"),),
    "covariance": (Column(("north_east_covariance", "covariance_north_east"), "m2", "m2"),),
}
DRAW = ("draw",)
NUMBER = ("track_number", "track", "track_id", "number")
SPREAD = ("north_variance", "east_variance", "covariance")
PAIRS = (("north", "east"), ("latitude", "longitude"), ("north_rate", "east_rate"))
MOST_DRAWS = 100_000
SLACK = 1e-9  # of a correlation above 1: digits of a file


class Estimates(NamedTuple):
    """r rows in the order of the file; SI, None = no such column."""

    stamps: Stamps  # of (r,) seconds, in any order
    draw: np.ndarray | None  # (r,) of the noise
    number: np.ndarray | None  # (r,) of the track, texts
    place: tuple[Any, Any]  # (r,) m north and east of the threshold, or latitude and longitude, rad, WGS 84
    is_geographic: bool  # which of the two
    velocity: np.ndarray | None  # (r, 2) m/s north, east
    cov: np.ndarray | None  # (r, 2, 2) m2 of the position, north and east


def read_estimates(content: bytes) -> Estimates:
    """The estimates of comma-separated values.

    Raises ``ValueError`` in one sentence, with the line, for what cannot be read as estimates.
    """
    return estimates_of(text_columns(content, "estimates"))


def estimates_of(found: Columns) -> Estimates:
    """The estimates of a table of texts; as `read_estimates`."""
    table = CellTable(found, COLUMNS)
    stamps = table.stamps(rising=False)
    values = {field: table.quantity(field) for field in COLUMNS}
    for pair in PAIRS:
        there = [field for field in pair if values[field] is not None]
        if len(there) == 1:
            lacking = next(field for field in pair if field != there[0])
            raise ValueError(f"has a column of {_words(there[0])} and none of {_words(lacking)}")
    local, geographic = values["north"] is not None, values["latitude"] is not None
    if local == geographic:
        wanted = "north_m and east_m, or latitude and longitude"
        what = "no columns say a place; it takes" if not local else "it says the place twice; it takes"
        raise ValueError(f"{what} {wanted} (columns: {listed(found.header)})")
    place = PAIRS[1] if geographic else PAIRS[0]
    for field in place:
        table.refuse(field, values[field], lambda v: ~np.isfinite(v), "is no place")
    table.refuse("latitude", values["latitude"], lambda v: np.abs(v) > math.pi / 2, "is no latitude")
    table.refuse("longitude", values["longitude"], lambda v: np.abs(v) > 2 * math.pi, "is no longitude")
    rates = [values[field] for field in PAIRS[2]]
    velocity = None if rates[0] is None else np.column_stack([rate for rate in rates if rate is not None])
    return Estimates(
        stamps,
        _draws(table),
        _numbers(table),
        (values[place[0]], values[place[1]]),
        geographic,
        velocity,
        _covariance(table, {field: values[field] for field in SPREAD}),
    )


def _words(field: str) -> str:
    return field.replace("_", " ")


def _draws(table: CellTable) -> np.ndarray | None:
    column = table.only("draw", [i for i, name in enumerate(table.names) if name in DRAW])
    if column is None:
        return None
    found = table.numbers(column)
    bad = ~((found >= 0) & (found < MOST_DRAWS) & (found == np.floor(found)))
    if bad.any():
        row = int(np.argmax(bad))
        raise ValueError(f"line {table.lines[row]}: '{table.columns[column][row][:20]}' is no number of a draw")
    return found.astype(int)


def _numbers(table: CellTable) -> np.ndarray | None:
    column = table.only("track number", [i for i, name in enumerate(table.names) if name in NUMBER])
    return None if column is None else np.array([cell.strip() for cell in table.columns[column]])


def _covariance(table: CellTable, values: dict[str, np.ndarray | None]) -> np.ndarray | None:
    """(r, 2, 2); None where the file states none, and where it leaves out how the two errors go together."""
    north, east, both = (values[field] for field in SPREAD)
    if north is None or east is None or both is None:
        return None
    cov = np.stack((north, both, both, east), axis=1).reshape(-1, 2, 2)
    stated = np.isfinite(cov).all(axis=(1, 2))
    determinant = north * east - both**2
    bad = stated & ~((north >= 0.0) & (east >= 0.0) & (determinant >= -SLACK * np.abs(north * east)))
    if bad.any():
        row = int(np.argmax(bad))
        raise ValueError(
            f"line {table.lines[row]}: its covariance is none: variances {north[row]:.4g} and {east[row]:.4g} m2 "
            f"with {both[row]:.4g} m2 between them is negative in some direction"
        )
    cov[~stated] = np.nan
    return cov
