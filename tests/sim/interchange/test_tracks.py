"""Files of recorded tracks: known columns, told columns, units, stamps, and the flights among the rows."""

from __future__ import annotations

import math

import numpy as np
import pytest

from sim.errors import ScenarioError
from sim.interchange.tracks import read_tracks

FOOT, KNOT = 0.3048, 1852.0 / 3600.0
NOON = 1772366400.0  # 2026-03-01 12:00 UTC

TRAFFIC = """timestamp,icao24,callsign,flight_id,latitude,longitude,altitude,geoaltitude,groundspeed,track,vertical_rate
2026-03-01 12:00:00.250+00:00,3c0001,A,A_1,48,11,1000,1100,100,90,-600
2026-03-01T12:00:01.500Z,3c0001,A,A_1,48.5,11.25,,1200,200,180,
"""


def written(tmp_path, text):
    path = tmp_path / "tracks.csv"
    path.write_text(text)
    return path


def test_columns_of_the_traffic_library_stand_in_feet_knots_and_degrees(tmp_path):
    ((name, track),) = read_tracks(written(tmp_path, TRAFFIC)).items()
    assert name == track.name == "A_1"
    np.testing.assert_allclose(track.time, [NOON + 0.25, NOON + 1.5], atol=1e-6)
    np.testing.assert_allclose(np.degrees((track.latitude, track.longitude)), [[48.0, 48.5], [11.0, 11.25]])
    np.testing.assert_allclose(track.pressure_altitude, [1000 * FOOT, np.nan])
    np.testing.assert_allclose(track.height, [1100 * FOOT, 1200 * FOOT])
    np.testing.assert_allclose(track.ground_speed, [100 * KNOT, 200 * KNOT])
    np.testing.assert_allclose(track.course, [math.pi / 2, math.pi])
    np.testing.assert_allclose(track.vertical_rate, [-600 * FOOT / 60, np.nan])


def test_state_vectors_stand_in_metres(tmp_path):
    text = (
        "time,icao24,lat,lon,velocity,heading,vertrate,callsign,baroaltitude,geoaltitude\n"
        f"{NOON:.0f},3c,48,11,70,270,-3.5,X ,900,950\n"
    )
    (track,) = read_tracks(written(tmp_path, text)).values()
    assert (track.name, track.time[0], track.ground_speed[0], track.vertical_rate[0]) == ("X", NOON, 70.0, -3.5)
    assert (track.pressure_altitude[0], track.height[0]) == (900.0, 950.0)


def test_other_columns_are_told_with_their_units(tmp_path):
    path = written(tmp_path, f"t;y;x;z;v\n{NOON * 1000:.0f};0.8;0.2;10;20\n")
    told = {
        "time": "t",
        "latitude_rad": "y",
        "longitude_rad": "x",
        "pressure_altitude_ft": "z",
        "ground_speed_kmh": "v",
    }
    (track,) = read_tracks(path, told).values()
    assert track.name == "tracks"
    found = track.time[0], track.latitude[0], track.longitude[0], track.pressure_altitude[0], track.ground_speed[0]
    assert found == pytest.approx((NOON, 0.8, 0.2, 10 * FOOT, 20 / 3.6))


@pytest.mark.parametrize(
    "stamp",
    [f"{NOON:.3f}", f"{NOON * 1e3:.0f}", f"{NOON * 1e6:.0f}", "2026-03-01 12:00:00", "2026-03-01T14:00:00+02:00"],
)
def test_stamps_are_dates_or_numbers_since_1970(tmp_path, stamp):
    (track,) = read_tracks(written(tmp_path, f"timestamp,latitude,longitude\n{stamp},48,11\n")).values()
    assert track.time[0] == pytest.approx(NOON, abs=1e-3)


def flights(rows, ids="icao24,callsign"):
    """The file of rows of (seconds after noon, names...)."""
    body = "".join(f"{NOON + time},{','.join(names)},48,11\n" for time, *names in rows)
    return f"timestamp,{ids},latitude,longitude\n{body}"


def test_flights_are_told_apart_by_callsign_and_by_silence(tmp_path):
    rows = [
        (0, "a", ""),
        (1, "b", "B"),
        (2, "a", "A1"),
        (3, "a", ""),
        (9, "a", "A2"),
        (4000, "a", "A2"),
        (4001, "c", "B"),
    ]
    found = read_tracks(written(tmp_path, flights(rows)))
    assert {name: (track.time - NOON).tolist() for name, track in found.items()} == {
        "A1": [0, 2, 3],
        "A2": [9],
        "A2_2": [4000],
        "B": [1],
        "B_2": [4001],
    }


def test_a_flight_id_counts_before_all_other_names(tmp_path):
    rows = [(0, "x", "A"), (9000, "x", "B"), (1, "y", "A"), (2, "", "A")]
    found = read_tracks(written(tmp_path, flights(rows, "flight_id,callsign")))
    assert {name: len(track.time) for name, track in found.items()} == {"x": 2, "y": 1}
    assert found["x"].remarks == ("1 rows of the file name no flight and belong to no flight",)


def test_rows_are_sorted_and_it_is_told(tmp_path):
    (track,) = read_tracks(written(tmp_path, flights([(2, "a", "A"), (0, "a", "A"), (1, "a", "A")]))).values()
    assert (track.time - NOON).tolist() == [0, 1, 2]
    assert track.remarks == ("1 of 3 rows came out of order and are sorted",)


def test_one_flight_is_read_alone_and_another_one_is_refused(tmp_path):
    path = written(tmp_path, flights([(0, "a", "LOT12"), (1, "b", "DLH4")]))
    assert list(read_tracks(path, flight="DLH4")) == ["DLH4"]
    with pytest.raises(ScenarioError, match="no flight 'DLH5'; did you mean 'DLH4'"):
        read_tracks(path, flight="DLH5")


def test_parquet_says_the_same_as_text(tmp_path):
    pyarrow = pytest.importorskip("pyarrow")
    parquet, csv = pytest.importorskip("pyarrow.parquet"), pytest.importorskip("pyarrow.csv")
    path = written(tmp_path, TRAFFIC)
    table = csv.read_csv(path)
    stamps = pyarrow.array(
        [int(NOON * 1e9) + 250_000_001, int(NOON * 1e9) + 1_500_000_000], pyarrow.timestamp("ns", "UTC")
    )
    parquet.write_table(table.set_column(0, "timestamp", stamps), tmp_path / "tracks.parquet")
    ((ours,), (theirs,)) = (read_tracks(file).values() for file in (path, tmp_path / "tracks.parquet"))
    for one, other in zip(ours[1:-1], theirs[1:-1], strict=True):
        np.testing.assert_allclose(one, other, atol=1e-6)


@pytest.mark.parametrize(
    ("text", "told"),
    [
        ("", "is empty"),
        ("a,b\n1,2\n", r"has no time and no latitude and no longitude among its columns \(a, b\)"),
        ("timestamp,latitude,longitude\n", "has no rows"),
        ("timestamp,latitude,longitude\n43200,48,11\n", "time of day"),
        ("timestamp,latitude,longitude\n1772366400,48000000,11\n", "reaches 4.8e.07, which is no latitude"),
    ],
)
def test_what_is_no_table_of_tracks_is_one_sentence(tmp_path, text, told):
    with pytest.raises(ScenarioError, match=told) as caught:
        read_tracks(written(tmp_path, text))
    assert "\n" not in str(caught.value)


def test_only_a_plain_file_is_opened(tmp_path):
    (tmp_path / "link.csv").symlink_to(written(tmp_path, TRAFFIC))
    for path, told in (
        (tmp_path, "no regular file"),
        (tmp_path / "link.csv", "no regular file"),
        (tmp_path / "no", "no such"),
    ):
        with pytest.raises(ScenarioError, match=told):
            read_tracks(path)
