"""Plots and tracks of a run as ASTERIX: read again they are what the run has, as near as the items hold it."""

from __future__ import annotations

import dataclasses
import math
import re

import numpy as np
import pytest

import sim
from aircraft.runway import Runway as Place
from sim.cli.exporting.others import export_asterix
from sim.errors import OutputError
from sim.interchange.asterix.plots import read_plots
from sim.interchange.asterix.reading import feed_of
from sim.interchange.asterix.tracks import read_estimates
from sim.interchange.tracks import read_tracks
from sim.observation.sensors.recorded import Recorded
from sim.results.asterix.files import write_asterix
from tests.capture import capture_tables

NM, FOOT, STEP = 1852.0, 0.3048, 2.0 * math.pi / 65536.0
RADAR = {"kind": "surveillance_radar", "period_s": 2.0, "position_m": [-3000, 2000, 10], "course_deg": 30.0}
SENSORS = {
    "terminal": {**RADAR, "height": "mode_c"},
    "approach": {"kind": "precision_radar", "sector_deg": 360.0, "clutter": 2.0, "detection": 0.8},
    "traffic": {"kind": "adsb", "gap_share": 0.3},
    "needle": {"kind": "localiser"},
}
PLACE = {"latitude_deg": 52.0, "longitude_deg": 10.0, "heading_deg": 80.0, "elevation_m": 120.0}


@pytest.fixture(scope="module")
def flown():
    return sim.run(
        {
            **capture_tables(name="short", until_s=30.0, draws=3),
            "runway": PLACE,
            "air": {"qnh_hpa": 1000.0},
            "aircraft": {"model": "point_mass"},
            "sensors": SENSORS,
            "trackers": {"kalman": {"kind": "kalman", "sensors": ["terminal"]}},
        }
    )


@pytest.fixture(scope="module")
def folder(flown, tmp_path_factory):
    place = flown.save(str(tmp_path_factory.mktemp("asterix") / "run"))
    files, left = export_asterix(place, None, None, False, ())
    assert [file.partition(":")[0] for file in files] == [
        "measurements.terminal.ast", "measurements.approach.ast", "measurements.traffic.ast", "tracks.kalman.ast",
    ]  # fmt: skip
    assert left == ["sensor 'needle' measures azimuth, which no category here has"]
    return place


def content(folder, name):
    return (folder / f"{name}.ast").read_bytes()


def about(angle):
    return np.abs((angle + math.pi) % (2.0 * math.pi) - math.pi)


def test_a_radar_with_mode_c_is_read_again_within_half_a_bit(flown, folder):
    record, own = flown.records["terminal"], flown.scenario.sensors["terminal"]
    path = folder / "measurements.terminal.ast"
    again = Recorded(
        str(path), target="f00001", position=own.position, runway=own.runway, air=own.air,
        range_sigma=60.0, azimuth_sigma=0.002, height_sigma=30.0,
    )  # fmt: skip
    assert again._seconds.tolist() == record.time.tolist()
    assert np.abs(again.plots.range - record.z[:, 0, 1]).max() <= NM / 512
    course = again._z[:, 1] + again.zero_azimuth
    assert about(course - record.z[:, 1, 1] - own.zero_azimuth).max() <= STEP / 2
    # what the transponder answered, in its own steps: read back exactly, and to the height by the air of the day
    np.testing.assert_allclose(
        again.plots.pressure_altitude, record.z[:, 2, 1] + own.air.pressure_altitude(0.0), atol=1e-6
    )
    assert np.abs(own.air.pressure_altitude(again._z[:, 2]) - again.plots.pressure_altitude).max() < 0.01


def test_the_antenna_stands_in_the_file_too(flown, folder):
    own = flown.scenario.sensors["terminal"]
    again = Recorded(
        str(folder / "measurements.terminal.ast"), target="f00001", runway=own.runway, air=own.air,
        range_sigma=60.0, azimuth_sigma=0.002, height_sigma=30.0,
    )  # fmt: skip
    assert np.abs(np.subtract(again.antenna, own.antenna)).max() < 1.2  # half of 180 / 2^23 deg, 1 m in height
    assert "its antenna stands where the file says, within 2 m" in again.recording.remarks


def test_a_primary_radar_leaves_all_its_plots_and_says_of_none_whose_it_is(flown, folder):
    record, own = flown.records["approach"], flown.scenario.sensors["approach"]
    feed = feed_of(content(folder, "measurements.approach"), (48,))
    reports = feed.records(48).columns
    made = np.isfinite(record.candidates[:, :, 0])  # (k, c, draws)
    assert feed.records(48).total == made.sum()
    assert "220.address" not in reports
    assert {*reports["020.typ"]} == {1.0}
    epoch, plot, draw = np.nonzero(made)
    place = record.candidates[epoch, plot, :, draw]
    np.testing.assert_array_equal(reports["161.number"], draw)
    assert np.abs(reports["140.time"] - record.time[epoch]).max() <= 1 / 256
    above_the_sea = 120.0 + own.antenna[2] + place[:, 0] * np.sin(place[:, 2])
    assert np.abs(reports["110.height"] - above_the_sea).max() <= 12.5 * FOOT
    assert np.abs(reports["040.rho"] - place[:, 0]).max() <= NM / 512


def test_reports_of_adsb_are_read_again_as_a_recording_of_traffic(flown, folder):
    record = flown.records["traffic"]
    (folder / "copy.ast").write_bytes(content(folder, "measurements.traffic"))
    flights = read_tracks(folder / "copy.ast")
    assert len(flights) == 3
    one = flights["SIM0001"]
    heard = np.isfinite(record.z[:, 0, 1])
    assert 0 < heard.sum() < len(heard)
    assert np.abs(one.time - record.time[heard]).max() <= 1 / 256
    z = dict(zip(record.channels, record.z[heard, :, 1].T, strict=True))
    np.testing.assert_allclose(one.pressure_altitude, z["pressure_altitude"], atol=1e-6)  # steps of 25 ft
    assert np.abs(one.ground_speed - z["ground_speed"]).max() <= NM / 2**15
    assert np.abs(one.vertical_rate - z["vertical_rate"]).max() <= 3.125 * FOOT / 60
    plots = read_plots(content(folder, "measurements.traffic"), "f00001")
    again = Recorded(
        str(folder / "copy.ast"), target="f00001", runway=flown.scenario.runway, air=flown.scenario.air,
        position_sigma=3.0, height_sigma=30.0,
    )  # fmt: skip
    assert np.hypot(*(again._z[:, :2] - record.z[heard, :2, 1]).T).max() < 0.02  # 1.9 cm north, 1.2 cm east at 52 deg
    assert plots.stamps.time.tolist() == one.time.tolist()


def test_tracks_are_read_again_within_half_a_bit(flown, folder):
    track = flown.tracks["kalman"].track
    found = read_estimates(content(folder, "tracks.kalman"))
    own = found.number == 2
    assert len(found.time) == 3 * len(track.time)
    assert {*found.sic} == {5.0}  # after four sensors
    assert np.abs(found.time[own] - track.time).max() <= 1 / 256
    north, north_rate, east, east_rate = track.mean[:, :, 2].T
    assert np.abs(found.x[own] - east).max() <= 0.25
    assert np.abs(found.y[own] - north).max() <= 0.25
    assert np.abs(found.velocity_x[own] - east_rate).max() <= 0.125
    assert np.abs(found.velocity_y[own] - north_rate).max() <= 0.125
    cov = track.cov if track.cov.ndim == 4 else track.cov[..., None]
    cov = cov[..., 2 if cov.shape[3] > 1 else 0]
    assert np.abs(np.sqrt(found.position_cov[own, 0, 0]) - np.sqrt(cov[:, 2, 2])).max() <= 0.25
    root = np.sqrt(np.abs(found.position_cov[own, 0, 1])) * np.sign(found.position_cov[own, 0, 1])
    assert np.abs(root - np.sign(cov[:, 0, 2]) * np.sqrt(np.abs(cov[:, 0, 2]))).max() <= 0.25
    # latitude and longitude are those of the aircraft's own height: brought back with it, they are the same place
    threshold = Place(math.radians(52.0), math.radians(10.0), 120.0)
    height = np.interp(track.time, flown.flight.time, flown.flight.state.height)
    back = threshold.local(found.latitude[own], found.longitude[own], height)
    half = math.radians(90.0 / 2**25) * 6.39e6  # m
    assert np.abs(back[0] - north).max() <= half
    assert np.abs(back[1] - east).max() <= half


def test_one_draw_leaves_as_a_radar_would_send_it(folder):
    export_asterix(folder, "2026-01-01T23:59:50Z", 2, True, ())
    feed = feed_of((folder / "measurements.terminal.pcap").read_bytes(), (48,))
    reports = feed.records(48).columns
    assert "161.number" not in reports
    assert {*reports["220.address"]} == {0xF00002}
    assert reports["140.time"][:6].tolist() == [86392.0, 86394.0, 86396.0, 86398.0, 0.0, 2.0]
    plots = read_plots((folder / "measurements.terminal.pcap").read_bytes())
    assert np.diff(plots.stamps.time).tolist() == [2.0] * (len(plots.stamps.time) - 1)


def test_turns_begin_before_the_radar_looks_at_the_aircraft(folder):
    feed = feed_of(content(folder, "measurements.terminal"), (34, 48))
    turns, plots = feed.records(34).columns, feed.records(48).columns
    first = plots["161.number"] == 0.0
    since = plots["140.time"][first] - turns["030.time"]
    np.testing.assert_allclose(since / 2.0, plots["040.theta"][first] / (2.0 * math.pi), atol=1 / 128)
    assert [feed.blocks[0].category, feed.blocks[1].category] == [34, 48]


@pytest.mark.parametrize(
    ("date", "draw", "said"),
    [
        (None, 3, "--draw 3: the run has the draws 0 to 2"),
        (None, -1, "--draw -1: the run has the draws 0 to 2"),
        ("yesterday", None, "--date yesterday: write it as 2026-01-01T12:00:00Z"),
    ],
)
def test_what_cannot_leave_is_one_sentence_and_nothing_is_written(folder, date, draw, said):
    before = {path.name: path.stat().st_mtime_ns for path in folder.iterdir()}
    with pytest.raises(OutputError, match=re.escape(said)):
        export_asterix(folder, date, draw, False, ())
    assert {path.name: path.stat().st_mtime_ns for path in folder.iterdir()} == before


def test_a_plot_that_no_item_holds_is_one_sentence_and_nothing_is_written(flown, tmp_path):
    record = flown.records["terminal"]
    far = record._replace(z=record.z + np.array([5e5, 0.0, 0.0])[:, None])
    beyond = dataclasses.replace(flown, records={"terminal": far}, tracks={})
    with pytest.raises(
        OutputError, match=r"cannot leave as ASTERIX: I048/040 rho holds 0 to 474105, and 50.* is beyond"
    ):
        write_asterix(beyond, tmp_path, begins=0.0)
    assert [*tmp_path.iterdir()] == []


def test_a_run_of_which_nothing_can_leave_says_why(flown, tmp_path):
    deaf = dataclasses.replace(flown, records={"needle": flown.records["needle"]}, tracks={})
    with pytest.raises(OutputError, match="nothing can leave as ASTERIX: sensor 'needle' measures azimuth"):
        write_asterix(deaf, tmp_path, begins=0.0)


def test_a_place_beyond_all_is_left_out_and_counted(flown, tmp_path):
    one = flown.tracks["kalman"]
    mean = one.track.mean.copy()
    mean[3, 0, 1], mean[4, 1, 2] = 3e6, np.nan
    lost = {"kalman": one._replace(track=one.track._replace(mean=mean))}
    files, left = write_asterix(dataclasses.replace(flown, tracks=lost), tmp_path, begins=0.0)
    assert "tracker 'kalman': 2 estimates of places or speeds that no aircraft has" in left
    assert len(read_estimates((tmp_path / "tracks.kalman.ast").read_bytes()).time) == mean[:, 0].size - 2
    assert files[-1] == f"tracks.kalman.ast: {mean[:, 0].size - 2} estimates"


def test_a_sensor_that_saw_nothing_leaves_an_empty_file(flown, tmp_path):
    blind = {name: one.until(-1.0) for name, one in flown.records.items()}
    files, _ = write_asterix(dataclasses.replace(flown, records=blind, tracks={}), tmp_path, begins=0.0)
    assert [one.rpartition(": ")[2] for one in files] == ["0 looks"] * 3
    assert {path.stat().st_size for path in tmp_path.iterdir()} == {0}


def test_the_command_says_what_it_wrote_and_what_it_left_out(folder, command):
    told = command("export", folder, "--asterix", "--draw", 0)
    assert told.returncode == 0
    lines = told.stdout.splitlines()
    assert lines[0] == f"wrote {folder}/measurements.terminal.ast: 15 looks"
    assert lines[-1] == "left out: sensor 'needle' measures azimuth, which no category here has"
