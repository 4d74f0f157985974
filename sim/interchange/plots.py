"""Plots of a radar as somebody recorded them: a table with a line for each plot, its columns known by their names."""

from __future__ import annotations

import csv
import math
import re
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from aircraft.units import SUFFIXES
from sim.interchange.clocks import Stamps, read_stamps
from sim.interchange.tables import table_of

TURN = 2.0 * math.pi


class Column(NamedTuple):
    """What a column may be called, and its unit where its name does not end in one."""

    names: tuple[str, ...]
    si: str = ""
    usual: str | None = None  # suffix of aircraft.units; None = the name has to say the unit


TIME = ("time", "timestamp", "time_s", "t", "utc", "datetime", "epoch", "unix", "time_of_day", "time_of_day_s", "tod")
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
OTHER_SUFFIXES = {"nm": "nmi", "degrees": "deg", "radians": "rad", "feet": "ft", "metres": "m", "meters": "m"}


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
    return _of_cells(*_rows(content), target)


def read_parquet_plots(path: Path, target: str | None = None) -> Plots:
    """As `read_plots`, of a Parquet file; a line is a row of it.

    Raises ``ValueError`` also where pyarrow is missing.
    """
    with table_of(path) as (header, chunks):
        rows = [[*map(_text, row)] for columns in chunks(header) for row in zip(*columns, strict=True)]
    if not rows:
        raise ValueError("has no plots, only the names of columns")
    return _of_cells(header, [*range(1, len(rows) + 1)], rows, target)


def _text(cell: Any) -> str:
    """A cell of Parquet as it would stand in a text."""
    if cell is None or cell != cell:
        return ""
    return str(cell) if isinstance(cell, str) else f"{cell:.0f}" if float(cell).is_integer() else repr(float(cell))


def _of_cells(header: list[str], lines: list[int], cells: list[list[str]], target: str | None) -> Plots:
    """The plots of a table of texts."""
    names = [_plain(name) for name in header]
    if target is not None or any(name in TARGET for name in names):
        lines, cells = _of_target(names, lines, cells, target)
    table = _Table(names, lines, cells)
    time_column = table.only("time", [i for i, name in enumerate(names) if name in TIME])
    if time_column is None:
        raise ValueError(f"no column says the time; call it {' or '.join(TIME[:2])} (columns: {_listed(header)})")
    stamps = read_stamps([cell.strip() for cell in table.columns[time_column]], table.lines, names[time_column])
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
        raise ValueError(f"no columns say a place; it takes {wanted} (columns: {_listed(header)})")
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


def _doubts(table: _Table, azimuth: np.ndarray | None) -> list[str]:
    """What may be meant otherwise than it is read."""
    if azimuth is None or not np.isfinite(azimuth).any() or table.suffixes["azimuth"] != "deg":
        return []
    largest = float(np.degrees(np.nanmax(np.abs(azimuth))))
    if largest > TURN:
        return []
    return [f"all azimuths are within {largest:.2f} degrees: if they are radians, call their column theta_rad"]


def _plain(name: str) -> str:
    """A column's name in small letters, its words and its unit joined by an underscore."""
    return re.sub(r"[^a-z0-9]+", "_", name.strip().lower()).strip("_")


def _listed(header: list[str]) -> str:
    shown = ", ".join(name.strip()[:30] for name in header[:20])
    return shown + (", ..." if len(header) > 20 else "")


def _rows(content: bytes) -> tuple[list[str], list[int], list[list[str]]]:
    """The names of the columns, and of each plot its line and its cells."""
    try:
        text = content.decode("utf-8-sig")
    except UnicodeDecodeError:
        raise ValueError("is not UTF-8 text of comma-separated values") from None
    head = text.partition("\n")[0]
    delimiter = max(",;\t", key=head.count)
    reader = csv.reader(text.splitlines(), delimiter=delimiter)
    try:
        header = next(reader, [])
        if not any(map(str.strip, header)):
            raise ValueError("is empty: its first line has to name the columns")
        lines, cells = [], []
        for row in reader:
            if not any(row):
                continue
            if len(row) != len(header):
                raise ValueError(f"line {reader.line_num} has {len(row)} cells, and the first line {len(header)}")
            lines.append(reader.line_num)
            cells.append(row)
    except csv.Error as error:
        raise ValueError(f"line {reader.line_num} cannot be read: {error}") from None
    if not cells:
        raise ValueError("has no plots, only the names of columns")
    return header, lines, cells


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
        raise ValueError(f"has no plots of target '{target}'; it has {_listed(found)}")
    return [line for line, _ in kept], [row for _, row in kept]


class _Table:
    """Cells of a file by column, with the lines that they come from."""

    def __init__(self, names: list[str], lines: list[int], cells: list[list[str]]) -> None:
        self.names, self.lines = names, lines
        self.columns: list[tuple[str, ...]] = list(zip(*cells, strict=True))
        self.suffixes: dict[str, str] = {}  # of what was found, by field

    def only(self, what: str, columns: list[int]) -> int | None:
        """The one of these columns; None = there is none."""
        if len(columns) > 1:
            two = " and ".join(f"'{self.names[i]}'" for i in columns[:2])
            raise ValueError(f"columns {two} both say the {what}: take one out")
        return columns[0] if columns else None

    def quantity(self, field: str) -> np.ndarray | None:
        """(k,) values of a field in SI; None where no column has it."""
        known = [(i, found) for i, name in enumerate(self.names) if (found := _unit(name, COLUMNS[field])) is not None]
        column = self.only(field.replace("_", " "), [i for i, _ in known])
        if column is None:
            return None
        self.suffixes[field] = suffix = known[0][1]
        return SUFFIXES[suffix][1] * self.numbers(column)

    def numbers(self, column: int) -> np.ndarray:
        """(k,) numbers of a column, NaN where a cell is empty."""
        cells: Sequence[str] = self.columns[column]
        try:
            found = np.array(cells, float)
        except ValueError:
            cells = [cell.strip() or "nan" for cell in cells]
            found = np.array([self._number(line, column, cell) for line, cell in zip(self.lines, cells, strict=True)])
        if np.isinf(found).any():
            line = self.lines[int(np.argmax(np.isinf(found)))]
            raise ValueError(f"line {line}: a number in column '{self.names[column]}' is infinite")
        return found

    def _number(self, line: int, column: int, cell: str) -> float:
        try:
            return float(cell)
        except ValueError:
            raise ValueError(f"line {line}: '{cell[:40]}' in column '{self.names[column]}' is no number") from None

    def refuse(self, field: str, values: np.ndarray | None, wrong: Callable[[np.ndarray], Any], sentence: str) -> None:
        """Raise ``ValueError`` for the first of the values that is wrong."""
        bad = np.zeros(0, bool) if values is None else wrong(values)
        if bad.any():
            row = int(np.argmax(bad))
            suffix = self.suffixes[field]
            assert values is not None
            raise ValueError(f"line {self.lines[row]}: {values[row] / SUFFIXES[suffix][1]:.6g} {suffix} {sentence}")


def _unit(name: str, known: tuple[Column, ...]) -> str | None:
    """The suffix of the unit of a column's name where it is one of the known; None where it is not."""
    for column in known:
        for own in column.names:
            if name == own:
                if column.usual is None:
                    units = ", ".join(f"{own}_{suffix}" for suffix, (si, _) in SUFFIXES.items() if si == column.si)
                    raise ValueError(f"column '{own}' does not say its unit: call it one of {units}")
                return column.usual
            ending = name.removeprefix(f"{own}_")
            suffix = OTHER_SUFFIXES.get(ending, ending)
            if ending != name and suffix in SUFFIXES and SUFFIXES[suffix][0] == column.si:
                return suffix
    return None
