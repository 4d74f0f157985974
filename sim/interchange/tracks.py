"""read_tracks(): the flights of a file of recorded tracks, as plain arrays in SI."""

from __future__ import annotations

import os
from collections.abc import Iterator, Mapping
from pathlib import Path

import numpy as np

from sim.errors import ScenarioError, did_you_mean
from sim.files import opened, read_bytes
from sim.interchange.asterix.reading import is_asterix
from sim.interchange.asterix.tracks import read_flights
from sim.interchange.columns import NEEDED, QUANTITIES, Column, recognised
from sim.interchange.stamps import numbers, since_1970, stamps
from sim.interchange.tables import Cells, table_of
from sim.interchange.track_record import TrackRecord

NEW_FLIGHT = 1800.0  # s; an aircraft without flight ids that is not seen for longer has landed and taken off again
MOST_FLIGHTS = 20_000  # of one file
FARTHEST = {"latitude": np.pi / 2.0, "longitude": 2.0 * np.pi}  # rad
FASTEST = {"ground_speed": 1000.0, "vertical_rate": 300.0}  # m/s
GROUPED = ("flight", "aircraft", "callsign")  # what tells flights apart, the first that a file has
TEXTS = tuple(name for name, unit in QUANTITIES.items() if unit == "")


def read_tracks(
    path: str | Path, columns: Mapping[str, str] | None = None, flight: str | None = None
) -> dict[str, TrackRecord]:
    """The flights of a file, in the order in which they begin there.

    Columns of the traffic library and of OpenSky's state vectors are recognised; others are told by ``columns``, our
    names with a unit and the names of the file: ``{"time": "t", "latitude_deg": "y", "height_ft": "alt"}``. A flight is
    what has one flight id; without ids, what one aircraft flies under one callsign without `NEW_FLIGHT` of silence;
    without either, the file.

    Parameters
    ----------
    path : CSV or Parquet, a plain file of at most 1 GB; or ASTERIX (CAT062, CAT021) as it stands or in a capture
    flight : the only one that is wanted

    Raises ``ScenarioError``, in one sentence, for what is no table of tracks, and for a flight that is not there.
    """
    path = Path(path)
    told: tuple[str, ...] = ()
    try:
        if asterix := _asterix(path):
            names, table, told = read_flights(asterix)
        else:
            names, table = _read(path, columns)
        tracks = dict(_flights(path.stem, names, table, told))
    except ValueError as error:
        raise error if isinstance(error, ScenarioError) else ScenarioError(f"{path}: {error}") from None
    if flight is None:
        return tracks
    if flight not in tracks:
        raise ScenarioError(f"{path}: no flight '{flight}'; {did_you_mean(flight, list(tracks)[:1000])}")
    return {flight: tracks[flight]}


def _asterix(path: Path) -> bytes:
    """The content of a file of ASTERIX; nothing of another one, or of one that cannot be opened."""
    try:
        with os.fdopen(opened(path, os.O_RDONLY), "rb") as file:
            begins = file.read(4)
    except (OSError, ValueError):
        return b""
    if not is_asterix(begins, path.name):
        return b""
    try:
        return read_bytes(path)
    except OSError as error:
        raise ValueError(f"cannot be read: {error.strerror}") from None


def _read(path: Path, told: Mapping[str, str] | None) -> tuple[dict[str, list[str]], dict[str, np.ndarray]]:
    """The texts of each column of texts, and every column: numbers in SI, or indices of texts with -1 for none."""
    texts: dict[str, dict[str, int]] = {}
    parts: dict[str, list[np.ndarray]] = {}
    with table_of(path) as (names, chunks):
        found = recognised(names, told)
        for cells in chunks([column.name for column in found.values()]):
            for (quantity, column), own in zip(found.items(), cells, strict=True):
                parts.setdefault(quantity, []).append(_column(quantity, column, own, texts))
    if not parts or not sum(map(len, parts["time"])):
        raise ValueError("has no rows")
    table = {quantity: np.concatenate(some) for quantity, some in parts.items()}
    table["time"] = since_1970(table["time"])
    for quantity, most in (FARTHEST | FASTEST).items():
        if quantity in table:
            _refuse_wild(quantity, found[quantity], table[quantity], most)
    return {quantity: [*known] for quantity, known in texts.items()}, table


def _column(quantity: str, column: Column, cells: Cells, texts: dict[str, dict[str, int]]) -> np.ndarray:
    if quantity == "time":
        return stamps(cells)
    if quantity not in TEXTS:
        return numbers(cells) * column.factor
    known = texts.setdefault(quantity, {})
    if isinstance(cells, np.ndarray):  # of numbers: a whole one is written without a point
        cells = [f"{cell:g}" if np.isfinite(cell) else "" for cell in cells.tolist()]
    return np.array([known.setdefault(name, len(known)) if (name := (cell or "").strip()) else -1 for cell in cells])


def _refuse_wild(quantity: str, column: Column, values: np.ndarray, most: float) -> None:
    """Raise ``ValueError`` where half of a column is nothing that the quantity can be; single rows become unknown."""
    with np.errstate(invalid="ignore"):
        wild = ~(np.abs(values) <= most) & ~np.isnan(values)
    known = int(np.sum(~np.isnan(values)))
    if quantity in NEEDED and not known:
        raise ValueError(f"has no number in the column '{column.name}', which is the {quantity.replace('_', ' ')}")
    if wild.sum() > 0.5 * known:
        extreme = float(np.max(np.abs(values[wild]))) / column.factor
        raise ValueError(
            f"its column '{column.name}' reaches {extreme:g}, which is no {quantity.replace('_', ' ')} in its unit; "
            "tell the unit in [record.columns]"
        )
    values[wild] = np.nan


def _flights(
    stem: str, names: dict[str, list[str]], table: dict[str, np.ndarray], told: tuple[str, ...]
) -> Iterator[tuple[str, TrackRecord]]:
    """Name and record of each flight."""
    by = next((quantity for quantity in GROUPED if quantity in table and (table[quantity] >= 0).any()), None)
    if by is None:
        yield stem, _record(stem, table, np.arange(len(table["time"])), told)
        return
    code = table[by]
    order = np.argsort(code, kind="stable")
    pieces = np.split(order, np.flatnonzero(np.diff(code[order])) + 1)
    nameless = len(pieces[0]) if code[order[0]] < 0 else 0
    pieces = pieces[1:] if nameless else pieces
    if len(pieces) > MOST_FLIGHTS:
        raise ValueError(f"names {len(pieces)} flights, more than the {MOST_FLIGHTS} of one file; split it")
    told += (f"{nameless} rows of the file name no {by} and belong to no flight",) if nameless else ()
    taken: dict[str, int] = {}
    for piece in sorted(pieces, key=lambda piece: int(piece[0])):
        own = names[by][code[piece[0]]]
        for name, rows in [(own, piece)] if by == "flight" else _parted(own, names, table, piece):
            taken[name] = taken.get(name, 0) + 1
            name = name if taken[name] == 1 else f"{name}_{taken[name]}"
            yield name, _record(name, table, rows, told)


def _parted(
    own: str, names: dict[str, list[str]], table: dict[str, np.ndarray], piece: np.ndarray
) -> Iterator[tuple[str, np.ndarray]]:
    """The flights of one aircraft: by callsign, and by how long it was not seen."""
    piece = piece[np.argsort(table["time"][piece], kind="stable")]
    cut = np.diff(table["time"][piece]) > NEW_FLIGHT
    called = np.full(len(piece), -1)
    if "callsign" in names:
        called = table["callsign"][piece]
        heard = np.maximum.accumulate(np.where(called >= 0, np.arange(len(piece)), -1))
        first = int(np.argmax(called >= 0))  # before the first callsign is heard it is that one
        called = np.where(heard >= 0, called[heard], called[first])
        cut |= np.diff(called) != 0
    for rows in np.split(np.arange(len(piece)), np.flatnonzero(cut) + 1):
        name = names["callsign"][called[rows[0]]] if called[rows[0]] >= 0 else own
        yield name, np.sort(piece[rows])  # in the order of the file


def _record(name: str, table: dict[str, np.ndarray], rows: np.ndarray, told: tuple[str, ...] = ()) -> TrackRecord:
    """One flight, by time."""
    time = table["time"][rows]
    late = int(np.sum(np.diff(time[np.isfinite(time)]) < 0.0))
    if late:
        told = (*told, f"{late} of {len(rows)} rows came out of order and are sorted")
    rows = rows[np.argsort(time, kind="stable")]
    numeric = {quantity: table[quantity][rows] for quantity in table if quantity not in TEXTS}
    return TrackRecord(name, **numeric, remarks=told)
