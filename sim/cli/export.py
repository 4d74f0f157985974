"""The records of a run or a study as tables for other programs: comma-separated values, or Parquet."""

from __future__ import annotations

import contextlib
import csv
import importlib.util
import itertools
import json
import math
import os
import shlex
from collections.abc import Iterator
from datetime import UTC, datetime
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from sim.errors import OutputError
from sim.files import DAMAGED, opened, read_bytes, refuse_unwritten, staged
from sim.metrics.contrasts.pairing import TABLES
from sim.reporting.columns import Columns, groups, table_of
from sim.studies.folder import IDENTITY, stamp
from sim.studies.kept import flight_log

if TYPE_CHECKING:
    from sim.studies.recordings import Written

RECORDS = ("flight", "measurements", "tracks")
METRICS = "metrics.json"
MIDNIGHT = 1767225600.0  # s since 1970: 2026-01-01, 0 h UTC
FIGURE = ("ratio", "low", "high", "of", "against", "n")  # of a contrast


def export(folder: Path, kind: str) -> list[Path]:
    """Write the records of a folder into the same folder, ``kind`` csv or parquet; returns the files written.

    A run gives one file for the flight, each sensor and each tracker, and one for contrasts if it has any; sensors and
    trackers have one row for each epoch and noise draw. A study gives one file with a row for each flight. Numbers are
    written in full; what is absent is an empty cell, or null. Raises ``OutputError`` in one sentence for a folder that
    holds neither, or a record that is missing or damaged.
    """
    write = WRITERS[kind]
    if kind == "parquet":
        _require_pyarrow()
    tables = {f"{name}.{kind}": table for name, table in _tables(folder).items()}
    with staged(folder) as place:
        for name, table in tables.items():
            write(place / name, table)
    return [folder / name for name in tables]


def export_tracks(
    folder: Path, out: Path | None, date: str | None, workers: int, plugins: Any, progress: Any
) -> Written:
    """Write the flights of a folder as recordings of traffic.

    ``date`` is when the first flight begins, ISO 8601, in UTC where it names no zone.
    """
    from sim.studies.recordings import DATE, write_recordings

    begins = _begins(date, DATE)
    return write_recordings(folder, out, date=begins, workers=workers, plugins=plugins, progress=progress)


def export_jsbsim(scenario: str, folder: Path, overrides: dict[str, Any], plugins: Any) -> list[str]:
    """Write a scenario as a root of JSBSim that flies it alone; what was written and how to fly it, in lines."""
    from sim.experiment import read
    from sim.flight.jsbsim_root.folder import SCRIPT, write_jsbsim_root
    from sim.flight.preparation import prepare

    root = write_jsbsim_root(prepare(read(scenario, overrides, plugins=plugins)), folder)
    fly = f"jsbsim --root={shlex.quote(str(folder))} --script={SCRIPT} --simulation-rate={root.rate:g}"
    return [f"wrote {folder}: {len(root.files)} files, {root.components} components of its autopilot", f"fly it: {fly}"]


def export_asterix(
    folder: Path, date: str | None, draw: int | None, capture: bool, plugins: Any
) -> tuple[list[str], list[str]]:
    """Write the plots and tracks of a run into its folder as ASTERIX; what was written and what was left out, in words.

    Without ``date`` the flight begins at midnight, so that times of day are its own. Raises ``OutputError`` in one
    sentence for a folder that is not of a run, before anything is written.
    """
    from sim.results.asterix.files import write_asterix
    from sim.results.loading import load

    refuse_unwritten(folder)
    if (folder / IDENTITY).is_file():
        raise OutputError(f"{folder}: is of a study, which keeps no plots and tracks; name the folder of a run")
    begins = _begins(date, MIDNIGHT)
    result = load(folder, plugins=plugins)
    with staged(folder) as place:
        return write_asterix(result, place, begins=begins, draw=draw, capture=capture)


def _begins(date: str | None, otherwise: float) -> float:
    """s since 1970 of a date as it is told, in UTC where it names no zone."""
    if date is None:
        return otherwise
    try:
        told = datetime.fromisoformat(date)
    except ValueError:
        raise OutputError(f"--date {date}: write it as 2026-01-01T12:00:00Z") from None
    return (told if told.tzinfo is not None else told.replace(tzinfo=UTC)).timestamp()


def _tables(folder: Path) -> dict[str, Columns]:
    """Every table of a folder by its name."""
    refuse_unwritten(folder)
    if (folder / IDENTITY).is_file():
        return {"flights": _flights(folder)}
    found: dict[str, Columns] = {}
    for record in RECORDS:
        with _undamaged(folder / f"{record}.npz") as file:
            found |= {f"{record}.{name}" if name else record: table_of(of) for name, of in groups(_load(file)).items()}
    with _undamaged(folder / METRICS) as file:
        rows = _contrasts(file) if file.is_file() else []
        return found | (
            {"contrasts": {name: np.array([row[name] for row in rows]) for name in rows[0]}} if rows else {}
        )


@contextlib.contextmanager
def _undamaged(path: Path) -> Iterator[Path]:
    """Whatever fails within is the fault of this file, which may come from anywhere."""
    try:
        yield path
    except FileNotFoundError:
        raise OutputError(f"{path}: missing; run the scenario again") from None
    except DAMAGED:
        raise OutputError(f"{path}: damaged; run the scenario again") from None


def _flights(folder: Path) -> Columns:
    """One row for each finished flight of a study: what was varied, how it ended, every figure."""
    from sim.metrics.ensemble.spread import scalars

    rows: list[dict[str, Any]] = [
        {
            **{name: record[name] for name in ("cell", "sample", "flight")},
            **record["values"],
            "outcome": record["metrics"]["outcome"],
            **dict(scalars(record["metrics"])),
        }
        for record in _records(folder)
    ]
    if not rows:
        raise OutputError(f"{folder}: the study has no finished flight yet")
    names = dict.fromkeys(name for row in rows for name in row)
    return {name: np.array([row.get(name, np.nan) for row in rows]) for name in names}


def _records(folder: Path) -> list[dict[str, Any]]:
    """What was found on the finished flights of a study, in order."""
    log = flight_log.read(folder, stamp(folder))
    if log.faults:
        where = f"{folder / flight_log.LOG}: {log.faults[0]}"
        raise OutputError(f"{where}; 'shortfinal resume {folder}' takes such lines out and flies what is missing")
    return [log.records[place] for place in sorted(log.records)]


def _contrasts(path: Path) -> list[dict[str, Any]]:
    """One row for each figure of the contrasts of a run, over all its flights."""
    contrasts = json.loads(read_bytes(path)).get("contrasts", [])
    return [
        {
            **{"tracker": one["of"], "other": one["against"], "name": one["name"] or ""},
            **{"table": table, "part": part, "channel": channel},
            **{key: math.nan if figure[key] is None else figure[key] for key in FIGURE},
        }
        for one in contrasts
        for table in TABLES
        for part, by_channel in ({"": one[table]} if table == "overall" else one[table]).items()
        for channel, figure in by_channel.items()
    ]


def _load(path: Path) -> Columns:
    with os.fdopen(opened(path, os.O_RDONLY), "rb") as file, np.load(file) as arrays:
        return dict(arrays.items())


def _write_csv(path: Path, columns: Columns) -> None:
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


def _require_pyarrow() -> None:
    if importlib.util.find_spec("pyarrow") is None:
        raise OutputError("--parquet needs pyarrow: pip install 'shortfinal[parquet]'")


def _write_parquet(path: Path, columns: Columns) -> None:
    import pyarrow
    from pyarrow import parquet

    arrays = {name: pyarrow.array(column, from_pandas=True) for name, column in columns.items()}  # NaN is null
    parquet.write_table(pyarrow.table(arrays), path)


WRITERS = {"csv": _write_csv, "parquet": _write_parquet}
