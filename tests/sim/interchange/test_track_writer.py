"""Files of tracks against their numbers by hand, in both formats, and names that say no format."""

from __future__ import annotations

import csv
from datetime import UTC, datetime
from pathlib import Path

import numpy as np
import pytest

from sim.errors import OutputError
from sim.interchange import track_writer
from sim.interchange.track_record import TrackRecord
from sim.interchange.track_writer import COLUMNS, refuse_format, write_tracks

TRACK = TrackRecord(
    "LH1",
    np.array((1767268800.25, 1767268801.25)),
    np.radians((50.0, 50.001)),
    np.radians((8.5, np.nan)),
    pressure_altitude=np.array((304.8, 300.0)),
    ground_speed=np.array((1852.0 / 36.0, np.nan)),
    course=np.radians((359.5, 0.0)),
)


def test_cells_are_in_the_units_of_the_format(tmp_path):
    assert write_tracks(tmp_path / "t.csv", [TRACK, TRACK._replace(name="LH2")]) == (2, 4)
    rows = list(csv.DictReader((tmp_path / "t.csv").read_text().splitlines()))
    assert tuple(rows[0]) == COLUMNS
    assert rows[0] == {
        "timestamp": "2026-01-01T12:00:00.250000Z", "icao24": "f00000", "callsign": "SIM0000", "flight_id": "LH1",
        "latitude": "50.000000000", "longitude": "8.500000000", "altitude": "1000.000", "geoaltitude": "",
        "groundspeed": "100.0000", "track": "359.50000", "vertical_rate": "",
    }  # fmt: skip
    assert (rows[1]["longitude"], rows[1]["groundspeed"], rows[1]["altitude"]) == ("", "", "984.252")
    assert [row["flight_id"] for row in rows] == ["LH1", "LH1", "LH2", "LH2"]
    assert rows[2]["icao24"] == "f00001"


def test_parquet_holds_the_same_and_null(tmp_path):
    parquet = pytest.importorskip("pyarrow.parquet")
    write_tracks(tmp_path / "partial", [TRACK], format_of=Path("t.parquet"))
    table = parquet.read_table(tmp_path / "partial").to_pydict()
    assert tuple(table) == COLUMNS
    assert table["timestamp"][0] == datetime(2026, 1, 1, 12, 0, 0, 250000, tzinfo=UTC)
    assert table["groundspeed"] == [pytest.approx(100.0), None]
    assert table["geoaltitude"] == [None, None]
    assert table["latitude"][1] == pytest.approx(50.001, abs=1e-12)


def test_a_name_that_says_no_format_is_refused(monkeypatch):
    with pytest.raises(OutputError, match=r"NAME.csv or NAME.parquet"):
        refuse_format(Path("tracks.txt"))
    monkeypatch.setattr(track_writer.importlib.util, "find_spec", lambda name: None)
    with pytest.raises(OutputError, match="needs pyarrow"):
        refuse_format(Path("tracks.parquet"))


def test_a_file_has_an_end(tmp_path, monkeypatch):
    monkeypatch.setattr(track_writer, "MOST", 2)
    with pytest.raises(OutputError, match="more than 2 flights"):
        write_tracks(tmp_path / "t.csv", [TRACK] * 3)
