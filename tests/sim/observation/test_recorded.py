"""The sensor that has its looks from a file: what it reads off it, when, and what it refuses."""

from __future__ import annotations

import math
import re

import numpy as np
import pytest

from aircraft.air import Air
from aircraft.runway import Runway as Place
from aircraft.state import AircraftState
from sim.errors import ScenarioError
from sim.flight.record import Flight
from sim.observation.record import observe
from sim.observation.recordings import remarks
from sim.observation.sensors.recorded import Recorded
from sim.scenario.tables import Runway
from tests.asterix_blocks import FORMS, MARKER, PLOT, TRACK

RUNWAY = Runway(math.radians(50.0), math.radians(30.0), heading=math.radians(80.0))
RADAR = {"position": (0.0, 2000.0, 10.0), "range_sigma": 60.0, "azimuth_sigma": 0.002}


@pytest.fixture
def sensor(tmp_path):
    """A sensor of a file of these lines."""

    def make(*lines, **fields):
        path = tmp_path / "plots.csv"
        path.write_text("\n".join(lines) + "\n")
        return Recorded(str(path), runway=RUNWAY, **fields)

    return make


@pytest.fixture
def flight(make_flight):
    """Half a minute at no date."""
    time = np.arange(0.0, 30.0, 1 / 30)
    return make_flight(time, ["final"] * len(time), north=70.0 * time)


def dated(flight: Flight, utc: float) -> Flight:
    return Flight(**{**vars(flight), "utc": utc})


def test_every_draw_sees_what_the_file_says_when_it_says_so(sensor, flight):
    seen = observe(flight, {"x": sensor("time,range_m,theta", "4,5000,10", "8.03,,20", **RADAR)}, 1, draws=3)["x"]
    assert seen.channels == ("range", "azimuth")
    assert seen.time.tolist() == seen.arrival.tolist() == [4.0, 8.03]
    np.testing.assert_allclose(seen.z[0].T, [[5000.0, math.radians(10.0)]] * 3)
    assert np.isnan(seen.z[1, 0]).all()  # a missed channel
    np.testing.assert_allclose(seen.R, np.broadcast_to(np.diag((3600.0, 4e-6)), (2, 2, 2)))


def test_accuracy_is_stated_by_the_file_or_by_the_scenario_and_the_scenario_is_right(sensor):
    lines = "time,range_m,theta,range_sigma_m,azimuth_sigma_deg", "4,5000,10,30,0.1", "8,5000,10,90,0.2"
    own = sensor(*lines, position=(0.0, 0.0, 0.0), azimuth_sigma=0.002)
    np.testing.assert_allclose(own._R[:, 0, 0], [900.0, 8100.0])
    np.testing.assert_allclose(own._R[:, 1, 1], 4e-6)


def test_azimuths_count_from_true_north_at_the_antenna(sensor):
    """A target due north of an antenna, on its own meridian, is at azimuth 0, wherever the threshold lies."""
    radar = sensor("time,range_m,theta", "4,5000,0", position=(30_000.0, 0.0, 0.0), range_sigma=1.0, azimuth_sigma=1.0)
    place = Place(RUNWAY.latitude, RUNWAY.longitude)
    latitude, longitude = place.geodetic(*radar.antenna[:2])
    north, east = place.local(latitude + 0.002, longitude)  # 13 km on along the meridian
    target = AircraftState(*[0.0] * len(AircraftState._fields))._replace(north=north, east=east)
    # the sine of the latitude of the threshold stands for that of the antenna, a few km away: 1e-3 of 5.5e-3 rad
    assert radar.truth(target)[1] == pytest.approx(0.0, abs=1e-5)
    assert abs(radar.zero_azimuth) > 5e-3  # which it would not be by the north of the threshold


def test_a_magnetic_zero_is_told(sensor):
    fields = {**RADAR, "azimuth_zero": math.radians(7.0)}
    true, magnetic = (sensor("time,range_m,theta", "4,5000,0", **one) for one in (RADAR, fields))
    assert magnetic.zero_azimuth - true.zero_azimuth == pytest.approx(math.radians(7.0))


def test_a_flight_level_becomes_a_height_by_the_qnh(sensor):
    """30 hPa above the standard: some 820 ft less is told than the aircraft has."""
    air = Air(0.0, None, 104325.0)
    high = sensor("time,range_m,theta,fl", "4,5000,0,30", **RADAR, height_sigma=50.0, air=air)
    assert high.channels == ("range", "azimuth", "height")
    (height,) = high._measured_height
    assert air.pressure_altitude(height) == pytest.approx(3000 * 0.3048, abs=0.1)
    assert height == pytest.approx((3000 + 820) * 0.3048, abs=10.0)
    assert len(high.recording.remarks) == 1  # of its azimuths
    (_, remark) = sensor("time,range_m,theta,fl", "4,5000,0,30", **RADAR, height_sigma=50.0).recording.remarks
    assert "pressure altitudes are taken at 1013.25 hPa" in remark


def test_latitude_and_longitude_are_places(sensor, flight):
    place = Place(RUNWAY.latitude, RUNWAY.longitude)
    latitude, longitude = np.degrees(place.geodetic(12_000.0, -3_000.0)).tolist()
    seen = sensor("time,lat,lon", f"4,{latitude!r},{longitude!r}", position_sigma=30.0)
    record = observe(flight, {"x": seen}, 1)["x"]
    assert record.channels == ("north", "east")
    np.testing.assert_allclose(record.z[0, :, 0], [12_000.0, -3_000.0], atol=1e-3)
    assert seen.antenna is None


def test_stamps_are_brought_to_the_date_of_the_flight(sensor, flight):
    utc = 1.7e9 - 10.0  # 22:13:10
    for stamp in ("1700000000", "2023-11-14T22:13:20Z", "22:13:20", "80000"):
        radar = sensor("time,range_m,theta", f"{stamp},5000,0", **RADAR)
        assert observe(dated(flight, utc), {"x": radar}, 1)["x"].time == pytest.approx([10.0], abs=1e-6)


def test_plots_of_another_day_are_refused_with_both_spans(sensor, flight):
    radar = sensor("time,range_m,theta", "1700000000,5000,0", "1700000004,5000,0", **RADAR)
    with pytest.raises(ScenarioError) as error:
        observe(dated(flight, 1.7e9 - 86400.0), {"radar": radar}, 1)
    said = "[sensors.radar] none of its 2 plots, from 2023-11-14 22:13:20 UTC to 2023-11-14 22:13:24 UTC, falls into"
    assert str(error.value) == f"{said} the flight, from 2023-11-13 22:13:20 UTC to 2023-11-13 22:13:49 UTC"
    with pytest.raises(ScenarioError, match=r"falls into the flight at no date, from 0\.0 s to 30\.0 s"):
        observe(flight, {"radar": radar}, 1)


def test_plots_beside_the_flight_are_left_out_with_a_word(sensor, flight):
    radar = sensor("time,range_m,theta", *(f"{stamp},5000,0" for stamp in (-4, 0, 4, 8, 90)), **RADAR)
    seen = observe(flight, {"radar": radar}, 1, draws=2)
    assert seen["radar"].time.tolist() == [4.0, 8.0]
    assert remarks(flight, {"radar": radar}, seen) == [
        "sensor 'radar': all azimuths are within 0.00 degrees: if they are radians, call their column theta_rad",
        "sensor 'radar' is recorded: all 2 draws see the same plots of it",
        "sensor 'radar': 3 of its 5 plots lie outside the flight and are left out: "
        "they are from -4.0 s to 90.0 s of it",
    ]


@pytest.mark.parametrize(
    ("lines", "fields", "said"),
    [
        (("time,range_m,theta", "4,5000,0"), {"range_sigma": 1.0, "azimuth_sigma": 1.0}, "position_m is missing"),
        (("time,range_m,theta", "4,9,0"), {"position": (0, 0, 0), "range_sigma": 1.0}, "azimuth_sigma_deg is missing"),
        (("time,lat,lon", "4,50,30"), {}, "position_sigma_m is missing, and the file has no such column"),
        (("time,range_m,theta,fl", "4,5000,0,30"), RADAR, "height_sigma_m is missing"),
        (
            ("time,lat,lon,position_sigma_m", "4,50,30,9", "5,50,30,"), {},
            "column of position_sigma has gaps: say position_sigma_m",
        ),
        (("time,range_m,theta", "4,x,0"), RADAR, "file 'plots.csv' line 2: 'x' in column 'range_m' is no number"),
        (("time,range_m,theta", "4,5000,0"), {**RADAR, "range_sigma": 0.0}, "range_sigma must be above 0"),
        (("time,range_m,theta", "4,5000,0"), {**RADAR, "sha256": "ab"}, "has changed since: its SHA-256 is not ab"),
    ],
)  # fmt: skip
def test_what_cannot_be_taken_is_said_in_a_sentence(lines, fields, said, sensor):
    with pytest.raises(ValueError, match=re.escape(said)):
        sensor(*lines, **fields)


def test_only_a_plain_file_is_read(tmp_path):
    (tmp_path / "link.csv").symlink_to("/etc/hostname")
    for name, said in (("no.csv", "No such file"), ("link.csv", "cannot be read"), (".", "cannot be read")):
        with pytest.raises(ValueError, match=said):
            Recorded(str(tmp_path / name))


def test_a_file_that_changes_under_its_digest_is_refused(sensor, tmp_path):
    radar = sensor("time,range_m,theta", "4,5000,0", **RADAR)
    assert Recorded(radar.file, radar.sha256, runway=RUNWAY, **RADAR).plots is radar.plots
    (tmp_path / "plots.csv").write_text("time,range_m,theta\n4,5001,0\n")
    assert radar.plots.range.tolist() == [5000.0]  # the run that has read it goes on
    with pytest.raises(ValueError, match="take sha256 out to use it"):
        Recorded(radar.file, radar.sha256, runway=RUNWAY, **RADAR)
    assert Recorded(radar.file, runway=RUNWAY, **RADAR).plots.range.tolist() == [5001.0]


# ---- ASTERIX -------------------------------------------------------------------------------------------------------
def asterix(tmp_path, content, **fields):
    path = tmp_path / "plots.ast"
    path.write_bytes(content)
    return Recorded(str(path), runway=RUNWAY, **fields)


def test_plots_of_a_radar_are_read_from_asterix(tmp_path, flight):
    own = asterix(tmp_path, PLOT, **RADAR, height_sigma=30.0)
    assert own.channels == ("range", "azimuth", "height")
    at = observe(dated(flight, 86400.0 + 36000.0), {"x": own}, 1)["x"]
    assert at.time.tolist() == [0.25]  # of the day at 36000.25 s
    assert at.z[0, :2, 0] == pytest.approx((10.5 * 1852.0, math.pi / 2))
    assert Air().pressure_altitude(at.z[0, 2, 0]) == pytest.approx(3525 * 0.3048, abs=0.01)


def test_the_height_of_a_radar_counts_from_the_sea(tmp_path):
    own = asterix(tmp_path, FORMS, **RADAR, height_sigma=30.0)
    high = Recorded(
        own.file, runway=Runway(RUNWAY.latitude, RUNWAY.longitude, elevation=62.0), **RADAR, height_sigma=30
    )
    assert own._z[0, 2] == pytest.approx(2500 * 0.3048)
    assert high._z[0, 2] == pytest.approx(2500 * 0.3048 - 62.0)


def test_an_antenna_that_the_file_places_need_not_be_told(tmp_path):
    there = Runway(math.radians(45.0), math.radians(-90.0), elevation=300.0)
    marker = MARKER[:6] + b"\x01" + MARKER[7:]  # of the radar of the plot: 45 deg north, 90 deg west, 310 m
    path = tmp_path / "plots.ast"
    path.write_bytes(marker + PLOT)
    own = Recorded(str(path), runway=there, range_sigma=60.0, azimuth_sigma=0.002, height_sigma=30.0)
    assert own.antenna == pytest.approx((0.0, 0.0, 10.0), abs=1e-6)
    told = Recorded(str(path), runway=there, **RADAR, height_sigma=30.0)
    assert told.antenna == pytest.approx((0.0, 2000.0, 10.0))  # what the scenario says is right


@pytest.mark.parametrize(
    ("content", "fields", "said"),
    [
        (PLOT, {"range_sigma": 60.0, "azimuth_sigma": 0.002}, "position_m is missing"),
        (PLOT, RADAR, "height_sigma_m is missing"),
        (PLOT[:-1], RADAR, "file 'plots.ast' at octet 0: a block of 24 octets is cut off after 23"),
        (TRACK, RADAR, "file 'plots.ast' has no blocks of the categories that are read here, 048, 021: it has 062"),
        (PLOT, {**RADAR, "target": "abc"}, "file 'plots.ast' has no plots of the target 'abc'; it has f00003"),
        (PLOT, {**RADAR, "source": "9/9"}, "file 'plots.ast' has no plots of the source '9/9'; it has 0/1"),
    ],
)
def test_asterix_that_cannot_be_taken_is_said_in_a_sentence(content, fields, said, tmp_path):
    with pytest.raises(ValueError, match=re.escape(said)):
        asterix(tmp_path, content, **fields)


def test_a_source_is_chosen_of_asterix_alone(sensor):
    with pytest.raises(ValueError, match="is no ASTERIX, so source = '0/1' chooses nothing"):
        sensor("time,range_m,theta", "4,5000,0", source="0/1", **RADAR)
