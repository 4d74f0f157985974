"""Columns of a table in a file, comma-separated values or Parquet, a part of the rows at a time."""

from __future__ import annotations

import contextlib
import csv
import io
import itertools
import os
from collections.abc import Callable, Iterator, Sequence
from pathlib import Path
from typing import Any, BinaryIO

import numpy as np

from sim.errors import ScenarioError
from sim.files import opened

LARGEST = 1 << 30  # bytes of a file
WIDEST, LONGEST = 256, 1000  # columns; characters of a cell
ROWS = 500  # of text at a time: so few stay in the processor's cache, ten thousand take twice as long
BATCH = 50_000  # rows of Parquet at a time
SEPARATORS = ",;\t|"
PARQUET = b"PAR1"  # how such a file begins
Cells = Sequence[Any] | np.ndarray
Chunks = Iterator[Sequence[Cells]]


@contextlib.contextmanager
def table_of(path: Path) -> Iterator[tuple[list[str], Callable[[list[str]], Chunks]]]:
    """The names of the columns of a file, and what reads some of them, a chunk of rows at a time, as columns of cells.

    A column of CSV is a sequence of texts; of Parquet an array of numbers, dates as seconds since 1970, or texts and
    None. Raises ``ScenarioError`` in one sentence for
    what is no plain file, no table, or too large.
    """
    try:
        with os.fdopen(opened(path, os.O_RDONLY), "rb") as file:
            size = os.fstat(file.fileno()).st_size
            if size > LARGEST:
                raise ScenarioError(f"{path}: larger than {LARGEST >> 20} MB; write the flights that are wanted only")
            if not size:
                raise ScenarioError(f"{path}: is empty")
            begins = file.read(4096)
            file.seek(0)
            with _parquet(path, file) if begins.startswith(PARQUET) else _csv(path, file, begins) as table:
                yield table
    except FileNotFoundError:
        raise ScenarioError(f"{path}: no such file") from None
    except OSError as error:
        raise ScenarioError(f"{path}: cannot be read: {error.strerror or error}") from None
    except ValueError as error:
        if isinstance(error, ScenarioError) or "null byte" not in str(error):
            raise
        raise ScenarioError(f"{path}: is no path of a file") from None


@contextlib.contextmanager
def _csv(path: Path, file: BinaryIO, begins: bytes) -> Iterator[tuple[list[str], Callable[[list[str]], Chunks]]]:
    if b"\0" in begins:
        raise ScenarioError(f"{path}: is neither comma-separated text in UTF-8 nor Parquet")
    head = begins.decode("utf-8-sig", errors="replace").partition("\n")[0]
    separator = max(SEPARATORS, key=head.count)
    text = io.TextIOWrapper(file, encoding="utf-8-sig", newline="")
    reader = csv.reader(text, delimiter=separator)

    def rows() -> Iterator[list[str]]:
        try:
            yield from reader
        except UnicodeDecodeError:
            raise ScenarioError(f"{path}: not UTF-8 text; save the file as UTF-8") from None
        except csv.Error as error:
            raise ScenarioError(f"{path}: line {reader.line_num} is no row of a table: {error}") from None

    every = rows()
    names = [name.strip() for name in next(every, [])]
    if len(names) > WIDEST or any(len(name) > LONGEST for name in names):
        raise ScenarioError(f"{path}: its first line names no columns of a table")
    if len(set(names)) < len(names):
        twice = next(name for name in names if names.count(name) > 1)
        raise ScenarioError(f"{path}: has two columns '{twice}'; keep one")

    def chunks(wanted: list[str]) -> Chunks:
        places = [names.index(name) for name in wanted]
        width = len(names)
        while some := list(itertools.islice(every, ROWS)):
            if any(len(row) != width for row in some):
                some = [row if len(row) == width else [*row, *[""] * width][:width] for row in some if row]
            columns = list(zip(*some, strict=True)) if some else [()] * width
            yield [columns[place] for place in places]

    try:
        yield names, chunks
    finally:
        text.detach()


@contextlib.contextmanager
def _parquet(path: Path, file: BinaryIO) -> Iterator[tuple[list[str], Callable[[list[str]], Chunks]]]:
    try:
        import pyarrow
        import pyarrow.parquet
    except ImportError:
        raise ScenarioError(f"{path}: Parquet needs pyarrow; pip install 'shortfinal[parquet]'") from None
    try:
        table = pyarrow.parquet.ParquetFile(file)
        names = list(table.schema_arrow.names)
    except (pyarrow.ArrowException, OSError, ValueError) as error:
        raise ScenarioError(f"{path}: damaged, or not Parquet: {_first_line(error)}") from None

    def chunks(wanted: list[str]) -> Chunks:
        try:
            for batch in table.iter_batches(BATCH, columns=wanted):
                yield [_plain(batch.column(name)) for name in wanted]
        except (pyarrow.ArrowException, OSError, ValueError) as error:
            raise ScenarioError(f"{path}: damaged: {_first_line(error)}") from None

    yield names, chunks


def _plain(column: Any) -> Cells:
    """A column of Parquet."""
    from pyarrow import types

    kind = column.type
    if types.is_timestamp(kind):
        ticks = {"s": 1.0, "ms": 1e3, "us": 1e6, "ns": 1e9}[kind.unit]
        count = column.cast("int64").to_numpy(zero_copy_only=False)
        return np.asarray(count, float) / ticks
    if types.is_floating(kind) or types.is_integer(kind):
        return np.asarray(column.to_numpy(zero_copy_only=False), float)
    return [None if one is None else str(one) for one in column.to_pylist()]


def _first_line(error: BaseException) -> str:
    return str(error).partition("\n")[0][:200]
