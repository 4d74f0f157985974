"""The records of a folder as tables: the arrays of a run as they are, or a row for each flight of a study."""

from __future__ import annotations

import contextlib
import json
import math
import os
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np

from sim.cli.exporting.formats import WRITERS, require_pyarrow
from sim.errors import OutputError
from sim.files import DAMAGED, opened, read_bytes, refuse_unwritten, staged
from sim.metrics.contrasts.pairing import TABLES
from sim.reporting.columns import Columns, groups, table_of
from sim.studies.folder import IDENTITY, stamp
from sim.studies.kept import flight_log

RECORDS = ("flight", "measurements", "tracks")
METRICS = "metrics.json"
FIGURE = ("ratio", "low", "high", "of", "against", "n")  # of a contrast


def export_records(folder: Path) -> list[Path]:
    """Write the arrays of a folder into it as Parquet, SI and radians, all draws; returns the files written.

    A run gives one file for the flight, each sensor and each tracker, and one for contrasts if it has any; sensors and
    trackers have one row for each epoch and noise draw. A study gives one file with a row for each flight. Numbers are
    written in full; what is absent is null. Raises ``OutputError`` in one sentence for a folder that holds neither, or
    a record that is missing or damaged.
    """
    require_pyarrow()
    refuse_unwritten(folder)
    tables = {"flights": flights(folder)} if is_study(folder) else _of_run(folder)
    with staged(folder) as place:
        for name, table in tables.items():
            WRITERS["parquet"](place / f"{name}.parquet", table)
    return [folder / f"{name}.parquet" for name in tables]


def is_study(folder: Path) -> bool:
    """Whether a folder is of a study."""
    return (folder / IDENTITY).is_file()


def _of_run(folder: Path) -> dict[str, Columns]:
    """Every table of the folder of a run by its name."""
    found: dict[str, Columns] = {}
    for record in RECORDS:
        with undamaged(folder / f"{record}.npz") as file:
            found |= {f"{record}.{name}" if name else record: table_of(of) for name, of in groups(arrays(file)).items()}
    return found | contrasts(folder)


@contextlib.contextmanager
def undamaged(path: Path) -> Iterator[Path]:
    """Whatever fails within is the fault of this file, which may come from anywhere."""
    try:
        yield path
    except FileNotFoundError:
        raise OutputError(f"{path}: missing; run the scenario again") from None
    except DAMAGED:
        raise OutputError(f"{path}: damaged; run the scenario again") from None


def arrays(path: Path) -> Columns:
    """The arrays of a file by name; raises one of `DAMAGED` for what is none."""
    with os.fdopen(opened(path, os.O_RDONLY), "rb") as file, np.load(file) as found:
        return dict(found.items())


def flights(folder: Path) -> Columns:
    """One row for each finished flight of a study: what was varied, how it ended, every figure."""
    from sim.metrics.ensemble.spread import scalars

    rows: list[dict[str, Any]] = [
        {
            **{name: record[name] for name in ("cell", "sample", "flight")},
            **record["values"],
            "outcome": record["metrics"]["outcome"],
            **dict(scalars(record["metrics"])),
        }
        for record in _logged(folder)
    ]
    if not rows:
        raise OutputError(f"{folder}: the study has no finished flight yet")
    names = dict.fromkeys(name for row in rows for name in row)
    return {name: np.array([row.get(name, np.nan) for row in rows]) for name in names}


def _logged(folder: Path) -> list[dict[str, Any]]:
    """What was found on the finished flights of a study, in order."""
    log = flight_log.read(folder, stamp(folder))
    if log.faults:
        where = f"{folder / flight_log.LOG}: {log.faults[0]}"
        raise OutputError(f"{where}; 'shortfinal resume {folder}' takes such lines out and flies what is missing")
    return [log.records[place] for place in sorted(log.records)]


def contrasts(folder: Path) -> dict[str, Columns]:
    """The table of contrasts of a run, over all its flights, a row for each figure; empty where it has none."""
    with undamaged(folder / METRICS) as file:
        told = json.loads(read_bytes(file)).get("contrasts", []) if file.is_file() else []
        rows: list[dict[str, Any]] = [
            {
                **{"tracker": one["of"], "other": one["against"], "name": one["name"] or ""},
                **{"table": table, "part": part, "channel": channel},
                **{key: math.nan if figure[key] is None else figure[key] for key in FIGURE},
            }
            for one in told
            for table in TABLES
            for part, by_channel in ({"": one[table]} if table == "overall" else one[table]).items()
            for channel, figure in by_channel.items()
        ]
        return {"contrasts": {name: np.array([row[name] for row in rows]) for name in rows[0]}} if rows else {}
