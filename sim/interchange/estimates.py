"""Estimates that a tracker made elsewhere: a table with a line for each update, or the system tracks of ASTERIX."""

from __future__ import annotations

import csv
import math
from pathlib import Path
from typing import NamedTuple

import numpy as np

from sim.errors import OutputError
from sim.files import whole
from sim.interchange.asterix.tracks import read_estimates as read_asterix
from sim.interchange.asterix.writing import ADDRESS
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
    """r rows in the order of the file; SI, None = not said."""

    stamps: Stamps  # of (r,) seconds, in any order
    draw: np.ndarray | None  # (r,) of the noise
    number: np.ndarray | None  # (r,) of the track, texts
    local: np.ndarray | None  # (r, 2) m north and east of the threshold
    geographic: np.ndarray | None  # (r, 2) latitude and longitude, rad, WGS 84
    velocity: np.ndarray | None  # (r, 2) m/s north, east
    cov: np.ndarray | None  # (r, 2, 2) m2 of the position, north and east

    def save(self, path: str | Path) -> Path:
        """Write them as comma-separated values, in full: what `read_estimates` reads again.

        Raises ``OutputError`` for a file that exists, or cannot be written.
        """
        path = Path(path)
        if path.exists() or path.is_symlink():
            raise OutputError(f"{path}: exists already; choose another name")
        columns = {name: values.tolist() for name, values in _written(self).items() if values is not None}
        with whole(path) as partial, partial.open("w", newline="", encoding="utf-8") as file:
            rows = csv.writer(file, lineterminator="\n")
            rows.writerow(columns)
            rows.writerows(zip(*columns.values(), strict=True))
        return path


def _written(said: Estimates) -> dict[str, np.ndarray | None]:
    """The columns of a file; None = there is nothing to write."""
    nothing = (None, None)
    latitude, longitude = nothing if said.geographic is None else np.degrees(said.geographic.T)
    north, east = nothing if said.local is None else said.local.T
    north_rate, east_rate = nothing if said.velocity is None else said.velocity.T
    cov = None if said.cov is None else np.where(np.isfinite(said.cov), said.cov.astype(object), "")
    return {
        **{"time_s": said.stamps.time, "draw": said.draw, "track_number": said.number},
        **{"north_m": north, "east_m": east, "latitude_deg": latitude, "longitude_deg": longitude},
        **{"north_rate_mps": north_rate, "east_rate_mps": east_rate},
        "north_variance_m2": None if cov is None else cov[:, 0, 0],
        "east_variance_m2": None if cov is None else cov[:, 1, 1],
        "north_east_covariance_m2": None if cov is None else cov[:, 0, 1],
    }


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
    places = [one for field in place if (one := values[field]) is not None]
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
        None if geographic else np.column_stack(places),
        np.column_stack(places) if geographic else None,
        velocity,
        _covariance(table, {field: values[field] for field in SPREAD}),
    )


def estimates_of_asterix(content: bytes) -> Estimates:
    """The system tracks of ASTERIX, CAT062; an address from F00000 hex on says the draw, as `export --asterix` has it.

    Raises ``ValueError`` in one sentence for what cannot be read.
    """
    read = read_asterix(content)
    place, local = np.column_stack((read.latitude, read.longitude)), np.column_stack((read.y, read.x))
    told = [np.isfinite(one).all(axis=1) for one in (place, local)]
    if not (told[0].all() or told[1].all()):
        raise ValueError("has records without I062/105 or I062/100, which say where")
    velocity = np.column_stack((read.velocity_y, read.velocity_x))
    draw = np.where(read.address >= ADDRESS, read.address - ADDRESS, 0)
    cov = read.position_cov[:, ::-1, ::-1]
    return Estimates(
        Stamps(False, read.time),
        np.where(np.isfinite(draw), draw, 0).astype(int),
        read.number.astype(str),
        local if told[1].all() else None,
        place if told[0].all() else None,
        velocity if np.isfinite(velocity).all() else None,
        cov if np.isfinite(cov).any() else None,
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
