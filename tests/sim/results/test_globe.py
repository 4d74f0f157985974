"""A run on a globe: what is shown of whom, where, in which colour; and what cannot be shown."""

from __future__ import annotations

import dataclasses
import io
import re
import shutil
import zipfile
from xml.etree import ElementTree

import numpy as np
import pytest

from aircraft.runway import Runway as Place
from sim.cli.exporting.others import export_kmz
from sim.errors import OutputError
from sim.files import MARK
from sim.reporting.figures import style
from sim.results.globe import globe
from sim.results.loading import load

KML, GX = "{http://www.opengis.net/kml/2.2}", "{http://www.google.com/kml/ext/2.2}"
BEGINS = 1767225600.0


def placemarks(kmz):
    """Name -> (times s, longitude deg, latitude deg, altitude m, heading, tilt, roll deg) of each track, (k, 7)."""
    document = ElementTree.fromstring(zipfile.ZipFile(io.BytesIO(kmz)).read("doc.kml"))
    found = {}
    for mark in document.iter(f"{KML}Placemark"):
        track = mark.find(f"{GX}Track")
        if track is not None:
            stamps = np.array([one.text.removesuffix("Z") for one in track.iter(f"{KML}when")], "M8[ms]")
            columns = [[one.text.split() for one in track.iter(f"{GX}{tag}")] for tag in ("coord", "angles")]
            time = stamps.astype(float) / 1e3 - BEGINS
            found[mark.find(f"{KML}name").text] = np.column_stack((time, *np.array(columns, float)))
    return found


@pytest.fixture(scope="module")
def shown(short_flown):
    return globe(short_flown, begins=BEGINS, draw=2)


def threshold(short_flown):
    runway = short_flown.scenario.runway
    return Place(runway.latitude, runway.longitude, runway.elevation)


def test_the_flight_is_where_it_was_flown_and_lies_as_it_lay(short_flown, shown):
    time, longitude, latitude, altitude, heading, tilt, roll = placemarks(shown.kmz)["truth"].T
    state = short_flown.flight.state
    assert (time[0], time[-1]) == pytest.approx((state.time[0], state.time[-1]), abs=1e-3)
    assert np.diff(time).max() < 0.3
    rows = np.argmin(np.abs(state.time - time[:, None]), axis=1)
    north, east = threshold(short_flown).local(np.radians(latitude), np.radians(longitude), altitude - 120.0)
    np.testing.assert_allclose(north, state.north[rows], atol=1e-3)
    np.testing.assert_allclose(east, state.east[rows], atol=1e-3)
    np.testing.assert_allclose(altitude, 120.0 + state.height[rows], atol=1e-3)
    for angle, own in ((heading, state.heading), (tilt, -state.pitch), (roll, -state.bank)):
        off = np.mod(angle - np.degrees(own[rows]) + 180.0, 360.0) - 180.0
        assert np.abs(off).max() < 0.0051
    assert np.abs(roll).max() > 1.0


def test_a_tracker_is_where_it_took_the_aircraft_to_be_at_the_height_of_the_flight(short_flown, shown):
    time, longitude, latitude, altitude, heading, *_ = placemarks(shown.kmz)["kalman"].T
    track, state = short_flown.tracks["kalman"].track, short_flown.flight.state
    np.testing.assert_allclose(time, track.time, atol=1e-3)
    north, east = threshold(short_flown).local(np.radians(latitude), np.radians(longitude), altitude - 120.0)
    np.testing.assert_allclose(north, track.mean[:, 0, 2], atol=1e-3)
    np.testing.assert_allclose(east, track.mean[:, 2, 2], atol=1e-3)
    np.testing.assert_allclose(altitude - 120.0, np.interp(time, state.time, state.height), atol=2e-3)
    course = np.degrees(np.arctan2(track.mean[:, 3, 2], track.mean[:, 1, 2]))
    assert np.abs(np.mod(heading - course + 180.0, 360.0) - 180.0).max() < 0.0051


def test_colours_are_those_of_the_report_and_what_has_no_place_is_left_out(short_flown, shown):
    assert shown.shown == ("truth", "kalman", "imm")
    assert shown.left == ("tracker 'angle' estimates no place on the ground plane",)
    text = zipfile.ZipFile(io.BytesIO(shown.kmz)).read("doc.kml").decode()
    colours = re.findall(r"<LabelStyle><color>ff(..)(..)(..)", text)
    told = [f"#{red}{green}{blue}".upper() for blue, green, red in colours]
    assert told == [colour.upper() for colour in (style.BLACK, *style.TRACKERS[:2])]


def test_a_height_that_is_estimated_is_shown(short_flown):
    """Range and elevation of a radar say how high: a track in its own coordinates, turned into one by hand."""
    one = short_flown.tracks["kalman"]
    channels = ("approach.range", "approach.azimuth", "approach.elevation")
    mean = np.tile(np.array((1000.0, 0.0, np.pi / 6))[:, None], (1, 1, 3))
    track = one.track._replace(channels=channels, time=np.array([5.0]), mean=mean, cov=np.zeros((1, 3, 3, 1)))
    result = dataclasses.replace(short_flown, tracks={"polar": one._replace(track=track)})
    _, longitude, latitude, altitude, *_ = placemarks(globe(result, begins=BEGINS).kmz)["polar"][0]
    radar = short_flown.scenario.sensors["approach"]
    up = radar.antenna[2] + 500.0
    assert altitude == pytest.approx(120.0 + up, abs=1e-3)
    north, east = threshold(short_flown).local(np.radians(latitude), np.radians(longitude), up)
    ground = 1000.0 * np.cos(np.pi / 6)
    expected = radar.antenna[:2] + ground * np.array((np.cos(radar.zero_azimuth), np.sin(radar.zero_azimuth)))
    np.testing.assert_allclose((north, east), expected, atol=1e-3)


def test_a_lost_track_is_shown_while_it_is_near_the_earth(short_flown):
    one = short_flown.tracks["kalman"]
    mean = one.track.mean.copy()
    mean[3:5, 0], mean[5, 0] = 1e9, np.nan
    result = dataclasses.replace(short_flown, tracks={"kalman": one._replace(track=one.track._replace(mean=mean))})
    found = globe(result, begins=BEGINS)
    assert len(placemarks(found.kmz)["kalman"]) == len(mean) - 3
    assert found.left == ("tracker 'kalman': 3 estimates of places where no aircraft is",)


def test_a_flight_with_a_date_keeps_it(short_flown):
    dated = dataclasses.replace(short_flown, flight=dataclasses.replace(short_flown.flight, utc=86400.0))
    assert placemarks(globe(dated, begins=BEGINS).kmz)["truth"][0, 0] + BEGINS == 86400.0


def test_a_run_without_trackers_shows_its_flight(short_flown):
    assert globe(dataclasses.replace(short_flown, tracks={}), begins=BEGINS).shown == ("truth",)


def test_where_nothing_is_known_nothing_is_shown(short_flown):
    unknown = dataclasses.replace(short_flown.flight, outcome="unknown", rollout=None)
    with pytest.raises(OutputError, match="there is nothing to show on a globe: the run has no tracker"):
        globe(dataclasses.replace(short_flown, flight=unknown, tracks={}), begins=BEGINS)
    blind = globe(dataclasses.replace(short_flown, flight=unknown), begins=BEGINS)
    assert blind.shown == ("kalman", "imm")


def test_the_command_writes_a_file_that_is_the_same_again(short_flown, short_folder, command, tmp_path):
    told = command("export", short_folder, "--kmz", "-o", tmp_path / "a.kmz", "--draw", 2)
    assert (told.returncode, told.stderr) == (0, "")
    first, second = told.stdout.splitlines()
    assert first == f"wrote {tmp_path}/a.kmz: truth, kalman, imm"
    assert second.startswith("left out: tracker 'angle'")
    assert (tmp_path / "a.kmz").read_bytes() == globe(short_flown, begins=BEGINS, draw=2).kmz
    dated = command("export", short_folder, "--kmz", "-o", tmp_path / "b.kmz", "--date", "2026-03-01T06:00:00Z")
    assert dated.returncode == 0
    assert b"2026-03-01T06:00:00.000Z" in zipfile.ZipFile(tmp_path / "b.kmz").read("doc.kml")


def test_bad_folders_draws_and_targets_are_one_sentence_each(short_folder, tmp_path):
    foreign, half = (shutil.copytree(short_folder, tmp_path / name) for name in ("foreign", "half"))
    (foreign / MARK).unlink()
    (half / "tracks.npz").unlink()
    (tmp_path / "theirs.kmz").write_text("theirs")
    for folder, out, draw, said in (
        (foreign, None, 0, "not a run folder"),
        (half, None, 0, r"half written, tracks\.npz missing"),
        (tmp_path / "none", None, 0, "no such folder"),
        (short_folder, tmp_path / "a.kmz", 3, "--draw 3: the run has the draws 0 to 2"),
        (short_folder, tmp_path / "a.kmz", -1, "--draw -1: the run has the draws 0 to 2"),
        (short_folder, tmp_path / "a.kml", 0, r"a\.kml: name it NAME\.kmz"),
        (short_folder, tmp_path / "none" / "a.kmz", 0, "no such folder to write into"),
        (short_folder, tmp_path / "theirs.kmz", 0, "exists already; choose another name with -o"),
    ):
        with pytest.raises(OutputError, match=said) as caught:
            export_kmz(folder, out, None, draw, ())
        assert "\n" not in str(caught.value)
    assert (tmp_path / "theirs.kmz").read_text() == "theirs"
    assert not [path for path in tmp_path.rglob("*.kmz") if path.name != "theirs.kmz"]
    with pytest.raises(OutputError, match="write it as 2026-01-01T12:00:00Z"):
        export_kmz(short_folder, tmp_path / "a.kmz", "noon", 0, ())


def test_a_full_disk_leaves_nothing_half_written(short_folder, tmp_path, monkeypatch):
    def full(path, octets):
        with path.open("wb") as file:
            file.write(octets[:10])
        raise OSError(28, "No space left on device")

    monkeypatch.setattr("pathlib.Path.write_bytes", full)
    with pytest.raises(OutputError, match=r"a\.kmz: cannot be written: No space left on device"):
        export_kmz(short_folder, tmp_path / "a.kmz", None, 0, ())
    assert [*tmp_path.iterdir()] == []


def test_a_run_is_the_same_from_its_folder(short_flown, short_folder):
    assert globe(load(short_folder), begins=BEGINS).kmz == globe(short_flown, begins=BEGINS).kmz
