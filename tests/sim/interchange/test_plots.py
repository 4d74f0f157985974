"""Files of recorded plots: columns by name and unit, stamps of every form, and a sentence for each damage."""

from __future__ import annotations

import math
import re

import numpy as np
import pytest

from sim.interchange.clocks import Stamps, in_words
from sim.interchange.plots import read_parquet_plots, read_plots

FIELDS = ("range", "azimuth", "height", "pressure_altitude", "latitude", "longitude")


def read(*lines, target=None):
    return read_plots("\n".join(lines).encode(), target)


@pytest.mark.parametrize(
    ("head", "row", "field", "value"),
    [
        ("time,RHO,THETA", "1,2,90", "range", 2 * 1852.0),
        ("time,RHO,THETA", "1,2,90", "azimuth", math.pi / 2),
        ("TIME;Range (m);Theta [rad]", "1;250;0.5", "range", 250.0),
        ("TIME;Range (m);Theta [rad]", "1;250;0.5", "azimuth", 0.5),
        ("t\trho_km\tazimuth_deg", "1\t3\t180", "range", 3000.0),
        ("time,rho,theta,flight_level", "1,2,3,35", "pressure_altitude", 3500 * 0.3048),
        ("time,rho,theta,altitude", "1,2,3,3500", "pressure_altitude", 3500 * 0.3048),
        ("time,rho,theta,height_ft", "1,2,3,100", "height", 30.48),
        ("time,lat,lon", "1,50,30", "latitude", math.radians(50)),
        ("time,latitude_rad,longitude_rad", "1,0.5,-0.25", "longitude", -0.25),
        ("time,rho,theta,rho_sigma_m", "1,2,3,60", "range_sigma", 60.0),
        ("time,rho,theta,azimuth_sigma_deg", "1,2,3,0.1", "azimuth_sigma", math.radians(0.1)),
    ],
)
def test_a_column_is_known_by_its_name_and_unit(head, row, field, value):
    assert getattr(read(head, row), field) == pytest.approx([value], rel=1e-12)


def test_an_empty_cell_is_a_missed_channel_and_an_empty_line_nothing():
    plots = read("time,rho,theta,fl", "1,2,3,", "", "2,3,4,10")
    assert np.isnan(plots.pressure_altitude).tolist() == [True, False]
    assert len(plots.stamps.time) == 2


@pytest.mark.parametrize(
    ("cells", "dated", "time"),
    [
        (("4", "8.5"), False, (4.0, 8.5)),
        (("86398", "2"), False, (86398.0, 86402.0)),
        (("10:00:00.25", "10:00:04"), False, (36000.25, 36004.0)),
        (("1700000000", "1700000004.5"), True, (1.7e9, 1.7e9 + 4.5)),
        (("1700000000000", "1700000004500"), True, (1.7e9, 1.7e9 + 4.5)),
        (("2023-11-14T22:13:20Z", "2023-11-14 22:13:24.500"), True, (1.7e9, 1.7e9 + 4.5)),
        (("2023-11-15T00:13:20+02:00", "2023-11-14T22:13:24.5"), True, (1.7e9, 1.7e9 + 4.5)),
    ],
)
def test_stamps_of_every_form_are_seconds_that_rise(cells, dated, time):
    stamps = read("time,rho,theta", *(f"{cell},1,1" for cell in cells)).stamps
    assert stamps.dated is dated
    assert stamps.time == pytest.approx(time, abs=1e-6)


def test_a_time_of_day_is_that_of_the_flight_s_day_also_about_midnight():
    midnight = 86400.0 * 19000
    seen = Stamps(False, np.array((86390.0, 86410.0)))  # ten seconds before and after it
    assert seen.in_flight(midnight - 20.0).tolist() == [10.0, 30.0]
    assert Stamps(False, np.array((5.0, 9.0))).in_flight(midnight - 20.0).tolist() == [25.0, 29.0]
    assert seen.in_flight(None).tolist() == [86390.0, 86410.0]
    assert Stamps(True, np.array((midnight,))).in_flight(midnight - 20.0).tolist() == [20.0]
    assert in_words(midnight, True) == "2022-01-08 00:00:00 UTC"


def test_of_several_aircraft_one_is_chosen():
    lines = ("time,rho,theta,icao24", "1,2,3,abc", "2,9,9,def", "5,2.5,3,abc")
    assert len(read(*lines, target="abc").stamps.time) == 2
    with pytest.raises(ValueError, match='plots of 2 aircraft; say target = "abc", or another'):
        read(*lines)
    with pytest.raises(ValueError, match="no plots of target 'x'; it has abc, def"):
        read(*lines, target="x")
    with pytest.raises(ValueError, match="no column says whose plots they are"):
        read("time,rho,theta", "1,2,3", target="x")


@pytest.mark.parametrize(
    ("lines", "said"),
    [
        (("",), "its first line has to name the columns"),
        (("time,rho,theta",), "has no plots"),
        (("rho,theta", "1,2"), "no column says the time"),
        (("time,rho", "1,2"), "no columns say a place"),
        (("time,rho,theta,lat,lon", "1,2,3,4,5"), "take one pair out"),
        (("time,timestamp,rho,theta", "1,1,2,3"), "'time' and 'timestamp' both say the time"),
        (("time,range,theta", "1,2,3"), "'range' does not say its unit: call it one of range_m, range_km"),
        (("time,height,rho,theta", "1,2,3,4"), "'height' does not say its unit"),
        (("time,rho,theta", "1,2,3", "2,x,3"), "line 3: 'x' in column 'rho' is no number"),
        (("time,rho,theta", "1,2,3", "2,3"), "line 3 has 2 cells, and the first line 3"),
        (("time,rho,theta", "1,2,3", "2,inf,3"), "line 3: a number in column 'rho' is infinite"),
        (("time,rho,theta", "1,2,3", "5,-2,3"), "line 3: -2 nmi is a range below 0"),
        (("time,rho,theta", "1,2,400"), "line 2: 400 deg is more than a turn"),
        (("time,lat,lon", "1,95,3"), "line 2: 95 deg is no latitude"),
        (("time,rho,theta,rho_sigma_m", "1,2,3,0"), "line 2: 0 m is a standard deviation that is not above 0"),
        (("time,rho,theta", "1,2,3", "1,2,3"), "line 3: its stamp 1 is not after that of the line before"),
        (("time,rho,theta", "4,2,3", "2,2,3"), "line 3: its stamp 2 is not after"),
        (("time,rho,theta", "10:00:00,2,3", "11,2,3"), "line 3: '11' in column 'time' is no time of day"),
        (("time,rho,theta", "1,2,3", ",2,3"), "line 3: '' in column 'time' is no number of seconds"),
        (("time,rho,theta", "2023-13-01,2,3"), "line 2: '2023-13-01' in column 'time' is no date and time"),
        (("time,rho,theta", "25:00:00,2,3"), "line 2: '25:00:00' in column 'time' is no time of day"),
        (("time,rho,theta", "nan,2,3"), "line 2: the stamp in 'time' is not finite"),
    ],
)
def test_each_damage_is_one_sentence_with_its_line(lines, said):
    with pytest.raises(ValueError, match=re.escape(said)) as error:
        read(*lines)
    assert "\n" not in str(error.value)


def test_a_table_of_parquet_says_the_same(tmp_path):
    pyarrow, parquet = pytest.importorskip("pyarrow"), pytest.importorskip("pyarrow.parquet")
    when = pyarrow.array([1_700_000_000_000, 1_700_000_004_500], pyarrow.timestamp("ms"))
    columns = {"timestamp": when, "rho": [2.25, 3.0], "theta": [10.0, None], "target": ["abc", "abc"]}
    parquet.write_table(pyarrow.table(columns), tmp_path / "plots.parquet")
    found = read_parquet_plots(tmp_path / "plots.parquet", "abc")
    texts = read("time,rho,theta,target", "1700000000,2.25,10,abc", "1700000004.5,3,,abc", target="abc")
    for own, other in zip(
        (*found.stamps, found.range, found.azimuth), (*texts.stamps, texts.range, texts.azimuth), strict=True
    ):
        np.testing.assert_array_equal(own, other)


def test_bytes_that_are_no_text_are_refused():
    with pytest.raises(ValueError, match="is not UTF-8 text"):
        read_plots(b"time,rho,theta\n1,\xff,3\n")


def test_degrees_that_may_be_radians_are_remarked():
    (remark,) = read("time,rho,theta", "1,2,0.5", "2,2,6.1").remarks
    assert "within 6.10 degrees: if they are radians, call their column theta_rad" in remark
    assert read("time,rho,theta", "1,2,0.5", "2,2,6.4").remarks == ()
    assert read("time,rho,theta_rad", "1,2,0.5", "2,2,6.1").remarks == ()
