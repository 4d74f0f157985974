"""A KMZ of tracks: where each was at which time, and how it lay in the air [KML 2.2 with gx:Track]."""

from __future__ import annotations

import io
import struct
import zipfile
import zlib
from collections.abc import Iterator, Sequence
from datetime import UTC, datetime, timedelta
from typing import NamedTuple
from xml.sax.saxutils import escape

import numpy as np

KML, ICON = "doc.kml", "arrow.png"
EPOCH = datetime(1970, 1, 1, tzinfo=UTC)
EARLIEST = (1980, 1, 1, 0, 0, 0)  # date of what is in the archive: the same bytes whenever it is made
SIDE = 32  # pixels of the icon
HEAD = (
    '<?xml version="1.0" encoding="UTF-8"?>\n'
    '<kml xmlns="http://www.opengis.net/kml/2.2" xmlns:gx="http://www.google.com/kml/ext/2.2">\n<Document>'
)
FOOT = "</Document>\n</kml>\n"


class Track(NamedTuple):
    """One aircraft, or what somebody took for it, at k times."""

    name: str
    colour: str  # #RRGGBB
    width: float  # pixels of its line
    description: str
    time: np.ndarray  # (k,) s since 1970
    place: np.ndarray  # (3, k) latitude and longitude, rad on WGS 84, and m above the sea
    attitude: np.ndarray  # (3, k) rad: heading, pitch + up, bank + right; NaN = not known, shown as 0


class Strip(NamedTuple):
    """A runway as a line on the ground."""

    name: str
    latitude: tuple[float, float]  # rad, of the threshold and the far end
    longitude: tuple[float, float]


def kmz_of(title: str, strip: Strip, tracks: Sequence[Track]) -> bytes:
    """The archive that Google Earth and others open: a document, and the arrow that shows where a track heads.

    The same tracks give the same bytes. Places are written to 1e-9 deg and a millimetre, times to a millisecond, angles
    to a hundredth of a degree.
    """
    lines = [HEAD, f"<name>{escape(title)}</name>", "<open>1</open>"]
    for number, track in enumerate(tracks):
        lines += _style(number, track)
    lines += _strip(strip)
    for number, track in enumerate(tracks):
        lines += _placemark(number, track)
    return _archive({KML: "\n".join([*lines, FOOT]).encode(), ICON: _arrow()})


def _style(number: int, track: Track) -> Iterator[str]:
    colour = _colour(track.colour)
    yield f'<Style id="track{number}">'
    yield f"<IconStyle><color>{colour}</color><scale>0.8</scale><Icon><href>{ICON}</href></Icon></IconStyle>"
    yield f"<LabelStyle><color>{colour}</color></LabelStyle>"
    yield f"<LineStyle><color>{colour}</color><width>{track.width:g}</width></LineStyle>"
    yield "</Style>"


def _colour(told: str) -> str:
    """aabbggrr of #RRGGBB."""
    return f"ff{told[5:7]}{told[3:5]}{told[1:3]}".lower()


def _strip(strip: Strip) -> Iterator[str]:
    ends = zip(np.degrees(strip.longitude), np.degrees(strip.latitude), strict=True)
    yield f"<Placemark><name>{escape(strip.name)}</name>"
    yield "<Style><LineStyle><color>ffffffff</color><width>6</width></LineStyle></Style>"
    yield "<LineString><tessellate>1</tessellate><altitudeMode>clampToGround</altitudeMode>"
    coordinates = " ".join(f"{longitude:.9f},{latitude:.9f},0" for longitude, latitude in ends)
    yield f"<coordinates>{coordinates}</coordinates></LineString></Placemark>"


def _placemark(number: int, track: Track) -> Iterator[str]:
    latitude, longitude, altitude = track.place
    places = zip(np.degrees(longitude).tolist(), np.degrees(latitude).tolist(), altitude.tolist(), strict=True)
    yield f"<Placemark><name>{escape(track.name)}</name>"
    yield f"<description>{escape(track.description)}</description>"
    yield f"<styleUrl>#track{number}</styleUrl>"
    yield "<gx:Track><altitudeMode>absolute</altitudeMode>"
    yield from (f"<when>{_instant(stamp)}</when>" for stamp in track.time.tolist())
    yield from (f"<gx:coord>{east:.9f} {north:.9f} {up:.3f}</gx:coord>" for east, north, up in places)
    for heading, tilt, roll in _angles(track.attitude).T.tolist():
        yield f"<gx:angles>{heading:.2f} {tilt:.2f} {roll:.2f}</gx:angles>"
    yield "</gx:Track></Placemark>"


def _instant(stamp: float) -> str:
    """ISO 8601 of s since 1970, in UTC."""
    found = EPOCH + timedelta(milliseconds=round(1e3 * stamp))
    return found.isoformat(timespec="milliseconds").replace("+00:00", "Z")


def _angles(attitude: np.ndarray) -> np.ndarray:
    """(3, k) deg: heading, tilt and roll of (heading, pitch, bank), rad.

    All three turn clockwise seen against the axes up, right and forward [KML 2.2, Orientation], as a heading does: so a
    nose that goes up and a wing that goes down to the right count as negative.
    """
    heading, pitch, bank = np.degrees(np.nan_to_num(attitude))
    return np.array((np.mod(np.round(heading, 2), 360.0), -pitch, -bank)) + 0.0  # no minus before a zero


def _archive(files: dict[str, bytes]) -> bytes:
    """A zip of these files; nothing in it depends on when and where it is made."""
    content = io.BytesIO()
    with zipfile.ZipFile(content, "w") as archive:
        for name, octets in files.items():
            info = zipfile.ZipInfo(name, EARLIEST)
            info.compress_type, info.create_system = zipfile.ZIP_DEFLATED, 0
            archive.writestr(info, octets)
    return content.getvalue()


def _arrow() -> bytes:
    """A white arrow to the north as PNG, which a viewer tints and turns."""
    down, across = np.indices((SIDE, SIDE)) + 0.5
    off = np.abs(across - SIDE / 2)
    inside = (off < 0.4 * down) & (down < SIDE - 8.0 * (1.0 - off / (0.4 * SIDE)))
    pixels = np.full((SIDE, SIDE, 2), 255, np.uint8)  # grey and opacity
    pixels[..., 1] = np.where(inside, 255, 0)
    rows = b"".join(b"\0" + row.tobytes() for row in pixels)
    head = struct.pack(">IIBBBBB", SIDE, SIDE, 8, 4, 0, 0, 0)
    chunks = ((b"IHDR", head), (b"IDAT", zlib.compress(rows, 9)), (b"IEND", b""))
    return b"\x89PNG\r\n\x1a\n" + b"".join(map(_chunk, *zip(*chunks, strict=True)))


def _chunk(kind: bytes, octets: bytes) -> bytes:
    return struct.pack(">I", len(octets)) + kind + octets + struct.pack(">I", zlib.crc32(kind + octets))
