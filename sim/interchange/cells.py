"""Cells of comma-separated values, or of Parquet, by column: names with units, numbers, and the line of each fault."""

from __future__ import annotations

import csv
import re
from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from aircraft.units import SUFFIXES
from sim.interchange.clocks import Stamps, read_stamps
from sim.interchange.tables import table_of

TIME = ("time", "timestamp", "time_s", "t", "utc", "datetime", "epoch", "unix", "time_of_day", "time_of_day_s", "tod")
OTHER_SUFFIXES = {"nm": "nmi", "degrees": "deg", "radians": "rad", "feet": "ft", "metres": "m", "meters": "m"}


class Column(NamedTuple):
    """What a column may be called, and its unit where its name does not end in one."""

    names: tuple[str, ...]
    si: str = ""
    usual: str | None = None  # suffix of aircraft.units; None = the name has to say the unit


class Columns(NamedTuple):
    """A file as texts: the names of its columns as they stand, the line of each row, and its cells."""

    header: list[str]
    lines: list[int]
    cells: list[list[str]]


def parquet_columns(path: Path, what: str) -> Columns:
    """The texts of a Parquet file; a line is a row of it. ``what`` is what its rows should be, for sentences.

    Raises ``ValueError`` also where pyarrow is missing.
    """
    with table_of(path) as (header, chunks):
        cells = [[*map(_text, row)] for columns in chunks(header) for row in zip(*columns, strict=True)]
    return _not_empty(Columns(header, [*range(1, len(cells) + 1)], cells), what)


def _not_empty(found: Columns, what: str) -> Columns:
    if not found.cells:
        raise ValueError(f"has no {what}, only the names of columns")
    return found


def _text(cell: Any) -> str:
    """A cell of Parquet as it would stand in a text."""
    if cell is None or cell != cell:
        return ""
    return str(cell) if isinstance(cell, str) else f"{cell:.0f}" if float(cell).is_integer() else repr(float(cell))


def plain_name(name: str) -> str:
    """A column's name in small letters, its words and its unit joined by an underscore."""
    return re.sub(r"[^a-z0-9]+", "_", name.strip().lower()).strip("_")


def listed(header: list[str]) -> str:
    """Names of columns for a sentence."""
    shown = ", ".join(name.strip()[:30] for name in header[:20])
    return shown + (", ..." if len(header) > 20 else "")


def text_columns(content: bytes, what: str) -> Columns:
    """The texts of comma-separated values. ``what`` is what its rows should be, for sentences.

    Raises ``ValueError`` in one sentence, with the line, for what cannot be read.
    """
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
    return _not_empty(Columns(header, lines, cells), what)


class CellTable:
    """Cells of a file by column, with the lines that they come from."""

    def __init__(self, found: Columns, known: Mapping[str, tuple[Column, ...]]) -> None:
        self.header, self.lines, cells = found
        self.known = known  # quantities, and what their columns may be called
        self.names = [*map(plain_name, self.header)]
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
        known = [
            (i, found) for i, name in enumerate(self.names) if (found := _unit(name, self.known[field])) is not None
        ]
        column = self.only(field.replace("_", " "), [i for i, _ in known])
        if column is None:
            return None
        self.suffixes[field] = suffix = known[0][1]
        return SUFFIXES[suffix][1] * self.numbers(column)

    def stamps(self, rising: bool = True) -> Stamps:
        """The stamps of the column of the time, which must rise unless ``rising`` is false."""
        column = self.only("time", [i for i, name in enumerate(self.names) if name in TIME])
        if column is None:
            raise ValueError(
                f"no column says the time; call it {' or '.join(TIME[:2])} (columns: {listed(self.header)})"
            )
        return read_stamps([cell.strip() for cell in self.columns[column]], self.lines, self.names[column], rising)

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
