"""Plots of a radar as somebody recorded them: a table with a line for each plot, its columns known by their names."""

from __future__ import annotations

import math
from pathlib import Path
from typing import NamedTuple

import numpy as np

from aircraft.units import SUFFIXES
from sim.interchange.cells import CellTable, Column, Columns, listed, parquet_columns, plain_name, text_columns
from sim.interchange.clocks import Stamps

TURN = 2.0 * math.pi


TARGET = ("target", "icao24", "aircraft_address", "address", "mode_s", "track_number", "track_id", "callsign")
LEVEL = ("flight_level", "fl")  # in hundreds of feet
COLUMNS = {
    "range": (Column(("rho",), "m", "nmi"), Column(("range", "slant_range"), "m")),
    "azimuth": (Column(("theta",), "rad", "deg"), Column(("azimuth",), "rad")),
    "height": (Column(("height",), "m"),),
    "pressure_altitude": (Column(("altitude", "pressure_altitude", "mode_c"), "m", "ft"),),
    "latitude": (Column(("latitude", "lat"), "rad", "deg"),),
    "longitude": (Column(("longitude", "lon", "long"), "rad", "deg"),),
    "range_sigma": (Column(("range_sigma", "rho_sigma", "sigma_range", "sigma_rho"), "m"),),
    "azimuth_sigma": (Column(("azimuth_sigma", "theta_sigma", "sigma_azimuth", "sigma_theta"), "rad"),),
    "height_sigma": (Column(("height_sigma", "sigma_height", "altitude_sigma"), "m"),),
    "position_sigma": (Column(("position_sigma", "sigma_position"), "m"),),
}


class Plots(NamedTuple):
    """k plots of one aircraft, in the order of their stamps; SI, NaN = not in that plot, None = no such column."""

    stamps: Stamps  # of (k,) seconds
    range: np.ndarray | None  # (k,) m, slant
    azimuth: np.ndarray | None  # (k,) rad, clockwise from where the antenna has its zero
    height: np.ndarray | None  # (k,) m above the threshold
    pressure_altitude: np.ndarray | None  # (k,) m above 1013.25 hPa, as a transponder tells it
    latitude: np.ndarray | None  # (k,) rad, WGS 84
    longitude: np.ndarray | None  # (k,) rad
    range_sigma: np.ndarray | None  # (k,) m, as the file states it; so the others
    azimuth_sigma: np.ndarray | None  # (k,) rad
    height_sigma: np.ndarray | None  # (k,) m
    position_sigma: np.ndarray | None  # (k,) m, north and east alike
    remarks: tuple[str, ...] = ()  # what may be meant otherwise
    sea_level_height: np.ndarray | None = None  # (k,) m above the sea, as a radar measures it
    antenna: tuple[float, float, float] | None = None  # where the file says that it stands: rad, rad, m above the sea


def read_plots(content: bytes, target: str | None = None) -> Plots:
    """The plots of comma-separated values; ``target`` chooses the aircraft where the file names several.

    Raises ``ValueError`` in one sentence, with the line, for what cannot be read as plots.
    """
    return _of_cells(text_columns(content, "plots"), target)


def read_parquet_plots(path: Path, target: str | None = None) -> Plots:
    """As `read_plots`, of a Parquet file; a line is a row of it.

    Raises ``ValueError`` also where pyarrow is missing.
    """
    return _of_cells(parquet_columns(path, "plots"), target)


def _of_cells(found: Columns, target: str | None) -> Plots:
    """The plots of a table of texts."""
    header, lines, cells = found
    names = [plain_name(name) for name in header]
    if target is not None or any(name in TARGET for name in names):
        lines, cells = _of_target(names, lines, cells, target)
    table = CellTable(Columns(header, lines, cells), COLUMNS)
    stamps = table.stamps()
    values = {field: table.quantity(field) for field in COLUMNS}
    level = table.only("flight level", [i for i, name in enumerate(names) if name in LEVEL])
    if values["pressure_altitude"] is None and level is not None:
        values["pressure_altitude"] = 100.0 * SUFFIXES["ft"][1] * table.numbers(level)
    polar, geographic = (
        [field for field in pair if values[field] is not None]
        for pair in (("range", "azimuth"), ("latitude", "longitude"))
    )
    if len(polar) < 2 and len(geographic) < 2:
        wanted = "rho and theta, range and azimuth with their units, or latitude and longitude"
        raise ValueError(f"no columns say a place; it takes {wanted} (columns: {listed(header)})")
    if len(polar) == 2 and len(geographic) == 2:
        raise ValueError("it has range and azimuth, and latitude and longitude too: take one pair out")
    table.refuse("range", values["range"], lambda v: v < 0.0, "is a range below 0")
    table.refuse("azimuth", values["azimuth"], lambda v: np.abs(v) > 1.001 * TURN, "is more than a turn")
    table.refuse("latitude", values["latitude"], lambda v: np.abs(v) > 0.25 * TURN, "is no latitude")
    table.refuse("longitude", values["longitude"], lambda v: np.abs(v) > TURN, "is no longitude")
    for field in ("range_sigma", "azimuth_sigma", "height_sigma", "position_sigma"):
        table.refuse(field, values[field], lambda v: v <= 0.0, "is a standard deviation that is not above 0")
    remarks = tuple(_doubts(table, values["azimuth"]))
    return Plots(stamps, **values, remarks=remarks, antenna=None)


def _doubts(table: CellTable, azimuth: np.ndarray | None) -> list[str]:
    """What may be meant otherwise than it is read."""
    if azimuth is None or not np.isfinite(azimuth).any() or table.suffixes["azimuth"] != "deg":
        return []
    largest = float(np.degrees(np.nanmax(np.abs(azimuth))))
    if largest > TURN:
        return []
    return [f"all azimuths are within {largest:.2f} degrees: if they are radians, call their column theta_rad"]


def _of_target(
    names: list[str], lines: list[int], cells: list[list[str]], target: str | None
) -> tuple[list[int], list[list[str]]]:
    """The lines of one aircraft."""
    column = next((names.index(name) for name in TARGET if name in names), None)
    if column is None:
        raise ValueError(f"no column says whose plots they are, so there is no target '{target}'")
    found = list(dict.fromkeys(row[column].strip() for row in cells))
    if target is None:
        if len(found) > 1:
            raise ValueError(f'has plots of {len(found)} aircraft; say target = "{found[0]}", or another')
        return lines, cells
    kept = [(line, row) for line, row in zip(lines, cells, strict=True) if row[column].strip() == target]
    if not kept:
        raise ValueError(f"has no plots of target '{target}'; it has {listed(found)}")
    return [line for line, _ in kept], [row for _, row in kept]
