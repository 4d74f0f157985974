"""Tables as files: comma-separated values, or Parquet."""

from __future__ import annotations

import csv
import importlib.util
import itertools
from collections.abc import Callable, Iterator
from pathlib import Path

import numpy as np

from sim.errors import OutputError
from sim.reporting.columns import Columns

FORMULA = ("=", "+", "-", "@", "\t", "\r")  # what a text begins with that a spreadsheet takes for a formula [OWASP]
WARD = "'"  # before it, a spreadsheet takes it for a text


def write_csv(path: Path, columns: Columns) -> None:
    """Numbers in full, an empty cell for NaN; a text that a spreadsheet would run as a formula begins with `WARD`."""
    with path.open("w", newline="", encoding="utf-8") as file:
        writer = csv.writer(file, lineterminator="\n")
        writer.writerow(map(harmless, columns))
        writer.writerows(zip(*(_cells(column) for column in columns.values()), strict=True))


def harmless(text: str) -> str:
    """A text that no spreadsheet runs, on one line."""
    return (f"{WARD}{text}" if text.startswith(FORMULA) else text).replace("\r", " ").replace("\n", " ")


def _cells(column: np.ndarray) -> Iterator[object]:
    """Plain Python values, an empty cell for NaN."""
    values = column.tolist()
    if column.dtype.kind in "UO":
        return (harmless(value) if isinstance(value, str) else value for value in values)
    if column.dtype.kind != "f":
        return iter(values)
    absent = np.isnan(column)
    return itertools.chain("" if gone else value for value, gone in zip(values, absent.tolist(), strict=True))


def write_parquet(path: Path, columns: Columns) -> None:
    """Numbers with their types, null for NaN; raises ``OutputError`` where pyarrow is missing."""
    require_pyarrow()
    import pyarrow
    from pyarrow import parquet

    arrays = {name: pyarrow.array(column, from_pandas=True) for name, column in columns.items()}  # NaN is null
    parquet.write_table(pyarrow.table(arrays), path)


def require_pyarrow() -> None:
    """Raise ``OutputError`` where pyarrow is missing."""
    if importlib.util.find_spec("pyarrow") is None:
        raise OutputError("--parquet needs pyarrow: pip install 'shortfinal[parquet]'")


WRITERS: dict[str, Callable[[Path, Columns], None]] = {"csv": write_csv, "parquet": write_parquet}
