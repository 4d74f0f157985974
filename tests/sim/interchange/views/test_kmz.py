"""The archive for a globe, read again by a reader of XML and of zip: places, times, angles, colours, names."""

from __future__ import annotations

import io
import math
import struct
import zipfile
import zlib
from xml.etree import ElementTree

import numpy as np
import pytest

from sim.interchange.views.kmz import Strip, Track, kmz_of

KML, GX = "{http://www.opengis.net/kml/2.2}", "{http://www.google.com/kml/ext/2.2}"
STRIP = Strip("runway", (0.9, 0.9001), (-3.1, -3.1002))
RISE = Track(
    "<&> rise",
    "#0072B2",
    2.0,
    'said & "done"',
    np.array((86399.9996, 86400.5)),
    np.array(((0.9, -0.9), (3.14159, -3.14159), (12.3456, -1.0))),
    np.array(((math.radians(-0.001), 3.0), (0.1, math.nan), (0.2, -0.3))),
)


@pytest.fixture(scope="module")
def opened():
    archive = zipfile.ZipFile(io.BytesIO(kmz_of("title", STRIP, [RISE, RISE._replace(name="other")])))
    assert archive.testzip() is None
    return archive


@pytest.fixture(scope="module")
def document(opened):
    return ElementTree.fromstring(opened.read("doc.kml")).find(f"{KML}Document")


def texts(node, name):
    return [one.text for one in node.iter(name)]


def test_the_same_tracks_give_the_same_bytes_whenever_they_are_written(opened):
    once = kmz_of("title", STRIP, [RISE, RISE._replace(name="other")])
    assert once == opened.fp.getvalue()
    assert {info.date_time for info in opened.infolist()} == {(1980, 1, 1, 0, 0, 0)}
    assert opened.namelist()[0] == "doc.kml"  # the first is what a viewer opens


def test_names_are_labels_and_nothing_in_them_breaks_the_document(document):
    assert texts(document, f"{KML}name") == ["title", "runway", "<&> rise", "other"]
    assert texts(document, f"{KML}description")[0] == 'said & "done"'


def test_places_times_and_angles_stand_as_they_were_given(document):
    track = next(document.iter(f"{GX}Track"))
    assert texts(track, f"{KML}when") == ["1970-01-02T00:00:00.000Z", "1970-01-02T00:00:00.500Z"]
    places = np.array([text.split() for text in texts(track, f"{GX}coord")], float)
    np.testing.assert_allclose(places[:, :2], np.degrees(RISE.place[1::-1].T), atol=5e-10)
    assert places[:, 2].tolist() == [12.346, -1.0]
    # a nose that is up and a bank to the right turn against the axes right and forward; what is not known is 0
    assert [text.split() for text in texts(track, f"{GX}angles")] == [
        ["0.00", "-5.73", "-11.46"], ["171.89", "0.00", "17.19"],
    ]  # fmt: skip


def test_elements_stand_in_the_order_of_the_schema(document):
    track = next(document.iter(f"{GX}Track"))
    order = [f"{KML}altitudeMode", f"{KML}when", f"{GX}coord", f"{GX}angles"]
    assert [one.tag for one in track] == [tag for tag in order for _ in range(1 if "Mode" in tag else 2)]


def test_colours_are_those_that_were_asked_for(document):
    style = document.find(f"{KML}Style")
    assert {*texts(style, f"{KML}color")} == {"ffb27200"}  # opacity, blue, green, red
    used = [one.text for one in document.iter(f"{KML}styleUrl")]
    assert used == [f"#{one.get('id')}" for one in document.findall(f"{KML}Style")]


def test_the_runway_is_a_line_on_the_ground(document):
    line = next(document.iter(f"{KML}LineString"))
    assert line.find(f"{KML}altitudeMode").text == "clampToGround"
    ends = np.array([end.split(",")[:2] for end in line.find(f"{KML}coordinates").text.split()], float)
    np.testing.assert_allclose(ends, np.degrees([STRIP.longitude, STRIP.latitude]).T, atol=5e-10)


def test_the_icon_is_a_picture_of_an_arrow_to_the_north(opened):
    picture = opened.read("arrow.png")
    assert picture.startswith(b"\x89PNG\r\n\x1a\n")
    chunks, at = {}, 8
    while at < len(picture):
        (size,) = struct.unpack_from(">I", picture, at)
        kind, octets = picture[at + 4 : at + 8], picture[at + 8 : at + 8 + size]
        assert struct.unpack_from(">I", picture, at + 8 + size)[0] == zlib.crc32(kind + octets)
        chunks[kind], at = octets, at + 12 + size
    width, height = struct.unpack_from(">II", chunks[b"IHDR"])
    rows = np.frombuffer(zlib.decompress(chunks[b"IDAT"]), np.uint8).reshape(height, 1 + 2 * width)
    shown = rows[:, 2::2] > 0
    assert not rows[:, 0].any()
    np.testing.assert_array_equal(shown, shown[:, ::-1])  # as far to the left as to the right
    wide = shown.sum(axis=1)
    assert wide[2] < wide[12] < wide[22]
