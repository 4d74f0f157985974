"""write_tracks(): recorded tracks as files in the columns of the traffic library, CSV or Parquet."""

from __future__ import annotations

import csv
import importlib.util
import math
from collections.abc import Callable, Iterable
from datetime import UTC, datetime, timedelta
from pathlib import Path
from typing import Any

import numpy as np

from aircraft.units import SUFFIXES
from sim.errors import OutputError
from sim.interchange.track_record import TrackRecord

FOOT, KNOT, FEET_PER_MINUTE = (SUFFIXES[unit][1] for unit in ("ft", "kt", "fpm"))
DEGREE = math.pi / 180.0
NUMBERS = {  # column -> what of a track it holds, its unit in SI, and decimals that are written
    "latitude": ("latitude", DEGREE, 9),  # a tenth of a millimetre
    "longitude": ("longitude", DEGREE, 9),
    "altitude": ("pressure_altitude", FOOT, 3),
    "geoaltitude": ("height", FOOT, 3),
    "groundspeed": ("ground_speed", KNOT, 4),
    "track": ("course", DEGREE, 5),
    "vertical_rate": ("vertical_rate", FEET_PER_MINUTE, 2),
}
TEXTS = ("icao24", "callsign", "flight_id")
COLUMNS = ("timestamp", *TEXTS, *NUMBERS)
EPOCH = datetime(1970, 1, 1, tzinfo=UTC)
MOST = 20_000  # flights of one file
FORMATS = (".csv", ".parquet")


def refuse_format(path: Path) -> None:
    """Raise ``OutputError`` for a file whose name does not say what it is to be, or that cannot be written here."""
    if path.suffix not in FORMATS:
        raise OutputError(f"{path}: name it NAME.csv or NAME.parquet: the ending says the format")
    if path.suffix == ".parquet" and importlib.util.find_spec("pyarrow") is None:
        raise OutputError(f"{path}: Parquet needs pyarrow: pip install 'shortfinal[parquet]', or name it NAME.csv")


def write_tracks(path: Path, tracks: Iterable[TrackRecord], format_of: Path | None = None) -> tuple[int, int]:
    """Write tracks one after another; gives how many flights and rows there are.

    A flight is addressed by its ``flight_id``; icao24 and callsign are made up from its place in the file. What a track
    does not know is an empty cell, or null.

    Parameters
    ----------
    format_of : its ending says the format, CSV or Parquet; by default that of ``path``

    Raises ``OutputError`` for more flights than one file may have.
    """
    kind = (path if format_of is None else format_of).suffix
    with _WRITERS[kind](path) as writer:
        flights = rows = 0
        for track in tracks:
            if flights == MOST:
                raise OutputError(f"{path.name}: more than {MOST} flights are too many for one file")
            writer(_columns(track, flights))
            flights, rows = flights + 1, rows + len(track.time)
    return flights, rows


def _columns(track: TrackRecord, number: int) -> dict[str, Any]:
    """The cells of a track by column: numbers in the unit of the file, stamps in microseconds since 1970."""
    count = len(track.time)
    found: dict[str, Any] = {"timestamp": np.round(np.asarray(track.time) * 1e6).astype(np.int64)}
    found |= dict(zip(TEXTS, (f"f{number:05x}", f"SIM{number:04d}", track.name), strict=True))
    for name, (field, unit, decimals) in NUMBERS.items():
        values = getattr(track, field)
        found[name] = np.full(count, np.nan) if values is None else np.round(np.asarray(values) / unit, decimals) + 0.0
    return found


class _Csv:
    """Rows of text."""

    def __init__(self, path: Path) -> None:
        self.path = path

    def __enter__(self) -> Callable[[dict[str, Any]], None]:
        self.file = self.path.open("x", newline="", encoding="utf-8")
        self.rows = csv.writer(self.file, lineterminator="\n")
        self.rows.writerow(COLUMNS)
        return self.write

    def write(self, columns: dict[str, Any]) -> None:
        """The rows of one flight."""
        stamps = [_stamp(micro) for micro in columns["timestamp"].tolist()]
        texts = [[columns[name]] * len(stamps) for name in TEXTS]
        numbers = [_cells(columns[name], decimals) for name, (_, _, decimals) in NUMBERS.items()]
        self.rows.writerows(zip(stamps, *texts, *numbers, strict=True))

    def __exit__(self, *error: object) -> None:
        self.file.close()


def _stamp(micro: int) -> str:
    """ISO 8601 in UTC of microseconds since 1970."""
    return (EPOCH + timedelta(microseconds=micro)).isoformat(timespec="microseconds").replace("+00:00", "Z")


def _cells(values: Any, decimals: int) -> list[str]:
    return ["" if math.isnan(value) else f"{value:.{decimals}f}" for value in values.tolist()]


class _Parquet:
    """Groups of rows, one for each flight."""

    def __init__(self, path: Path) -> None:
        self.path = path

    def __enter__(self) -> Callable[[dict[str, Any]], None]:
        import pyarrow
        from pyarrow import parquet

        kinds: dict[str, Any] = {"timestamp": pyarrow.timestamp("us", tz="UTC")}
        kinds |= dict.fromkeys(TEXTS, pyarrow.string()) | dict.fromkeys(NUMBERS, pyarrow.float64())
        self.schema = pyarrow.schema([(name, kinds[name]) for name in COLUMNS])
        self.writer = parquet.ParquetWriter(self.path, self.schema)
        return self.write

    def write(self, columns: dict[str, Any]) -> None:
        """The rows of one flight."""
        import pyarrow

        count = len(columns["timestamp"])
        columns |= {name: [columns[name]] * count for name in TEXTS}
        arrays = [pyarrow.array(columns[one.name], type=one.type, from_pandas=True) for one in self.schema]
        self.writer.write_table(pyarrow.Table.from_arrays(arrays, schema=self.schema))

    def __exit__(self, *error: object) -> None:
        self.writer.close()


_WRITERS: dict[str, Any] = {".csv": _Csv, ".parquet": _Parquet}
