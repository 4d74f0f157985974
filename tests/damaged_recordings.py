"""A hundred recordings with something wrong, and what the answer to each must say: in a sentence, or in a remark."""

from __future__ import annotations

import functools
import json
import random
from collections.abc import Callable
from pathlib import Path
from typing import Any

from tests.recordings import COLUMNS, RUNWAY_FILE, rows, stamp, text

Rows = list[dict[str, Any]]
Made = Callable[[Path, Path], tuple[str | None, dict[str, str] | None]]
ABSENT: Any = object()


@functools.cache
def _sound() -> str:
    return json.dumps(rows())


def sound() -> Rows:
    """The recording before it is damaged."""
    table: Rows = json.loads(_sound())
    return table


def written(
    told: str | None, content: Callable[[Rows], str | bytes], runway: str = RUNWAY_FILE, columns: Any = None
) -> Made:
    """``told`` is part of the sentence, or of a remark; None = a flight, whatever is said."""

    def make(path: Path, runway_path: Path) -> tuple[str | None, dict[str, str] | None]:
        made = content(sound())
        path.write_bytes(made if isinstance(made, bytes) else made.encode())
        runway_path.write_text(runway)
        return told, columns

    return make


def without(column: str, told: str | None) -> Made:
    return written(told, lambda table: text(table, [name for name in COLUMNS if name != column]))


def filled(column: str, value: Callable[[int, str], Any], told: str | None) -> Made:
    """One column anew: of the row's number and its cell."""

    def content(table: Rows) -> str:
        for number, one in enumerate(table):
            one[column] = value(number, one[column])
        return text(table)

    return written(told, content)


def here(column: str, value: Any, told: str | None, places: tuple[int, ...] = (100,)) -> Made:
    """One cell, or a few."""
    return filled(column, lambda number, cell: value if number in places else cell, told)


def arranged(change: Callable[[Rows], Rows], told: str | None) -> Made:
    return written(told, lambda table: text(change(table), COLUMNS))


def shifted(table: Rows, column: str, by: float, where: slice) -> Rows:
    for one in table[where]:
        one[column] = f"{float(one[column]) + by:.8f}"
    return table


def scaled(column: str, factor: float, told: str | None, where: slice = slice(None)) -> Made:
    def change(table: Rows) -> Rows:
        for one in table[where]:
            one[column] = f"{float(one[column]) * factor:.6f}"
        return table

    return arranged(change, told)


def several(count: int) -> Callable[[Rows], Rows]:
    """Rows of as many flights side by side."""
    return lambda table: [{**one, "flight_id": f"F{number}"} for one in table for number in range(count)]


def shuffled(table: Rows) -> Rows:
    random.Random(1).shuffle(table)
    return table


def cut(first: int, last: int) -> Callable[[Rows], Rows]:
    """Without the rows from one number to another."""
    return lambda table: table[:first] + table[last:]


def repeated(table: Rows, share: int) -> Rows:
    """Every so many-th row repeats the place of the row before."""
    for before, one in zip(table[::share], table[1::share], strict=False):
        one |= {name: before[name] for name in ("latitude", "longitude")}
    return table


def lines(change: Callable[[list[str]], list[str]], told: str | None) -> Made:
    return written(told, lambda table: "\n".join(change(text(table).splitlines())))


def opensky(table: Rows, time: Callable[[int], Any] = lambda number: 1772366400 + number) -> str:
    """The same as state vectors."""
    state = [
        {
            "time": time(number), "icao24": one["icao24"], "lat": one["latitude"], "lon": one["longitude"],
            "velocity": float(one["groundspeed"]) * 0.514444, "heading": one["track"],
            "vertrate": float(one["vertical_rate"]) * 0.00508, "callsign": one["callsign"],
            "baroaltitude": float(one["altitude"]) * 0.3048, "geoaltitude": float(one["geoaltitude"]) * 0.3048,
        }
        for number, one in enumerate(table)
    ]  # fmt: skip
    return text(state)


def elsewhere(**changes: Any) -> str:
    """A file of another runway."""
    values = {"latitude_deg": 48.0, "longitude_deg": 11.0, "elevation_m": 300.0, "heading_deg": 80.0} | changes
    return "[runway]\n" + "".join(f"{key} = {value}\n" for key, value in values.items() if value is not ABSENT)


def as_is(table: Rows) -> str:
    return text(table)


FREE = {"time": "t", "latitude_deg": "y", "longitude_deg": "x", "height_m": "z"}


def free(table: Rows) -> str:
    renamed = [
        {"t": one["timestamp"], "y": one["latitude"], "x": one["longitude"], "z": float(one["geoaltitude"]) * 0.3048}
        for one in table
    ]
    return text(renamed)


DAMAGED: dict[str, Made] = {
    # columns that are not there, or are called otherwise
    "no time": without("timestamp", "no time among its columns"),
    "no latitude": without("latitude", "no latitude among its columns"),
    "no longitude": without("longitude", "no longitude among its columns"),
    "no place": written("no latitude and no longitude", lambda t: text(t, [c for c in COLUMNS if "itude" not in c])),
    "no altitude, a geometric one": without("altitude", "ellipsoid"),
    "no geometric altitude": without("geoaltitude", None),
    "no altitude at all": written("no altitude", lambda t: text(t, [c for c in COLUMNS if "altitude" not in c])),
    "no speed": without("groundspeed", None),
    "no track": without("track", None),
    "no vertical rate": without("vertical_rate", None),
    "no flight id": without("flight_id", None),
    "no callsign": without("callsign", None),
    "no address": without("icao24", None),
    "no names": written(None, lambda t: text(t, [c for c in COLUMNS if c not in ("icao24", "callsign", "flight_id")])),
    "unknown columns": written("no time and no latitude", lambda t: text([{"a": 1, "b": 2}])),
    "free names, told": written("ellipsoid", free, columns=FREE),
    "free names, not told": written("[record.columns]", free),
    "free names, one is wrong": written("no column 'lat'", free, columns=FREE | {"latitude_deg": "lat"}),
    "free names, no unit": written("says no unit", free, columns={"time": "t", "latitude": "y", "longitude_deg": "x"}),
    "free names, a wrong unit": written("no quantity", free, columns=FREE | {"height_kt": "z"}),
    "free names, no longitude": written("longitude_deg is missing", free, columns={"time": "t", "latitude_deg": "y"}),
    "free names, twice": written("told twice", free, columns=FREE | {"latitude_rad": "y"}),
    "free names, nothing": written("no quantity 'altitude'", free, columns=FREE | {"altitude": "z"}),
    "a column twice": lines(lambda all_: [all_[0] + ",latitude", *(f"{one},1" for one in all_[1:])], "two columns"),
    "upper case": lines(lambda all_: [all_[0].upper(), *all_[1:]], None),
    "blanks about names": lines(lambda all_: [all_[0].replace(",", " , "), *all_[1:]], None),
    "columns in another order": written(None, lambda t: text(t, COLUMNS[::-1])),
    "further columns": written(None, lambda t: text([{**one, "squawk": 7000, "note": "a, b"} for one in t])),
    # units
    "altitude in metres": scaled("altitude", 0.3048, "as with m for ft"),
    "altitude in feet twice": scaled("altitude", 1 / 0.3048, "as with ft for m"),
    "speed in m/s": scaled("groundspeed", 0.514444, "as with m/s for kt"),
    "latitude in radians": scaled("latitude", 0.0174533, "another runway"),
    "latitude in microdegrees": scaled("latitude", 1e6, "is no latitude in its unit"),
    "longitude in microdegrees": scaled("longitude", 1e6, "is no longitude in its unit"),
    "latitude in microdegrees in a third": scaled("latitude", 1e6, "have no time or place", slice(0, 150)),
    "latitude in radians in a third": scaled("latitude", 0.0174533, "where nothing flies to", slice(0, 150)),
    "latitude and longitude exchanged": arranged(
        lambda t: [{**one, "latitude": one["longitude"], "longitude": one["latitude"]} for one in t], "another runway"
    ),
    "speed beyond anything": scaled("groundspeed", 1e6, "is no ground speed in its unit"),
    "longitudes beyond 360": filled("longitude", lambda n, cell: float(cell) + 360.0, "is no longitude"),
    # stamps
    "unix seconds": filled("timestamp", lambda n, cell: 1772366400 + n, None),
    "unix seconds with fractions": filled("timestamp", lambda n, cell: 1772366400.25 + n, None),
    "unix milliseconds": filled("timestamp", lambda n, cell: (1772366400 + n) * 1000, None),
    "unix nanoseconds": filled("timestamp", lambda n, cell: (1772366400 + n) * 10**9, None),
    "iso with T and Z": filled("timestamp", lambda n, cell: cell.replace(" ", "T").replace("+00:00", "Z"), None),
    "iso without a zone": filled("timestamp", lambda n, cell: cell.replace("+00:00", ""), None),
    "iso in another zone": filled("timestamp", lambda n, cell: cell.replace("+00:00", "+05:30"), None),
    "times of day": filled("timestamp", lambda n, cell: 43200 + n, "time of day"),
    "time of day in words": filled("timestamp", lambda n, cell: cell[11:19], "no row has a time"),
    "dates of a day": filled("timestamp", lambda n, cell: cell[:10], "are no flight"),
    "american dates": filled("timestamp", lambda n, cell: f"03/01/2026 12:00:{n % 60:02d}", "no row has a time"),
    "no date at all": filled("timestamp", lambda n, cell: "", "no row has a time"),
    "one stamp is no date": here("timestamp", "yesterday", "have no time or place"),
    "one stamp in another century": here("timestamp", "1870-01-01 00:00:00+00:00", "have no time or place"),
    "negative times": filled("timestamp", lambda n, cell: -1e9 - n, "no number of seconds"),
    "times of the far future": filled("timestamp", lambda n, cell: 1e25 + n, "no number of seconds"),
    "one stamp a day late": here("timestamp", "2026-03-02 12:01:40+00:00", "pieces"),
    "out of order": arranged(shuffled, "out of order"),
    "backwards": arranged(lambda t: t[::-1], "out of order"),
    "two rows exchanged": arranged(lambda t: [*t[:50], t[51], t[50], *t[52:]], "out of order"),
    "one stamp for all": filled("timestamp", lambda n, cell: stamp(0.0), "are no flight"),
    "every row twice": arranged(lambda t: [one for one in t for _ in range(2)], "repeat a time stamp"),
    "a few rows twice": arranged(lambda t: t + t[10:20], "repeat a time stamp"),
    # rows
    "no rows": written("has no rows", lambda t: text([], COLUMNS)),
    "one row": arranged(lambda t: t[:1], "are no flight"),
    "nine rows": arranged(lambda t: t[:9], "are no flight"),
    "ten seconds": arranged(lambda t: t[:10], "are no flight"),
    "a row in ten seconds": arranged(lambda t: t[::10], None),
    "a row in half a minute": arranged(lambda t: t[::30], "are no flight"),
    "a gap": arranged(cut(60, 90), "leave 2 pieces"),
    "short gaps": arranged(lambda t: [one for n, one in enumerate(t) if n % 20 > 8], None),
    "a gap before the end": arranged(cut(400, 430), "leave 2 pieces"),
    "stale rows": arranged(lambda t: repeated(t, 30), "are stale"),
    "half of the rows stale": arranged(lambda t: repeated(t, 2), "are stale"),
    "a place for all": arranged(lambda t: [{**one, "latitude": 48.0, "longitude": 11.0} for one in t], "are no flight"),
    "one place far off": here("latitude", "49.5", "where nothing flies to"),
    "one place a little off": here("latitude", "48.0", None),
    "three places far off": here("longitude", "-11", "where nothing flies to", (20, 21, 300)),
    "the first place far off": here("latitude", "10", "where nothing flies to", (0,)),
    "the last place far off": here("latitude", "10", "where nothing flies to", (459,)),
    "places at random": filled("latitude", lambda n, cell: 48 + 7 * random.Random(n).random(), "nothing flies to"),
    "a jump in the middle": arranged(lambda t: shifted(t, "latitude", 1.0, slice(230, None)), "nothing flies to"),
    "one latitude is no number": here("latitude", "n/a", "have no time or place"),
    "nan": here("latitude", "nan", "have no time or place", (5, 6, 7)),
    "infinity": here("longitude", "inf", "have no time or place", (5, 6, 7)),
    "null": here("latitude", "null", "have no time or place"),
    "all empty": filled("latitude", lambda n, cell: "", "has no number in the column 'latitude'"),
    "decimal commas": filled("latitude", lambda n, cell: cell.replace(".", ","), "has no number in the column"),
    "altitudes empty in a half": filled("altitude", lambda n, cell: cell if n % 2 else "", None),
    "altitudes empty": filled("altitude", lambda n, cell: "", "ellipsoid"),
    "one altitude wild": here("altitude", "38000", "nothing climbs to"),
    "one altitude below the sea": here("altitude", "-99999", None),
    "it never descends": filled("altitude", lambda n, cell: "4000", None),
    # bytes
    "an empty file": written("is empty", lambda t: b""),
    "only a first line": lines(lambda all_: all_[:1], "has no rows"),
    "no first line": lines(lambda all_: all_[1:], "no time and no latitude"),
    "binary": written("neither comma-separated text", lambda t: bytes(range(256)) * 20),
    "compressed": written("not UTF-8", lambda t: b"\x1f\x8b\x08" * 500),
    "utf-16": written("neither comma-separated text", lambda t: text(t).encode("utf-16")),
    "latin-1": written("not UTF-8", lambda t: text([{**o, "callsign": "FLÜG"} for o in t]).encode("latin-1")),
    "with a byte order mark": written(None, lambda t: text(t).encode("utf-8-sig")),
    "semicolons": written(None, lambda t: text(t, separator=";")),
    "tabs": written(None, lambda t: text(t, separator="\t")),
    "one column": written("no time and no latitude", lambda t: text(t).replace(",", " ")),
    "carriage returns": written(None, lambda t: text(t).replace("\r\n", "\r")),
    "a cell of a megabyte": here("callsign", "x" * 1_000_000, "is no row of a table"),
    "a first line of a megabyte": written("is no row of a table", lambda t: "x" * 1_000_000 + "\n" + text(t)),
    "a thousand columns": written("names no columns", lambda t: ",".join(map(str, range(1000))) + "\n" + text(t)),
    "rows that end early": lines(
        lambda all_: [*all_[:100], *(o[: len(o) // 2] for o in all_[100:120]), *all_[120:]], ""
    ),
    "rows that are too long": lines(lambda all_: [*all_[:100], *(f"{one},1,2" for one in all_[100:])], None),
    "blank lines": lines(lambda all_: [part for one in all_ for part in (one, "")], None),
    "a quote that never ends": lines(lambda all_: [*all_[:50], '"' + all_[50], *all_[51:]], ""),
    "cut in the middle of a row": written(None, lambda t: text(t)[:-40]),
    "half of Parquet": written("not Parquet", lambda t: b"PAR1" + bytes(500)),
    "a page of a web server": written("no time and no latitude", lambda t: "<html>\n<body>Not found</body>\n</html>\n"),
    # flights and runways
    "three flights": arranged(several(3), None),
    "rows of no flight": here("flight_id", "", "belong to no flight", (1, 2, 3)),
    "another runway far away": written("another runway", as_is, elsewhere(latitude_deg=-33.9, longitude_deg=151.2)),
    "another runway near by": written("never established", as_is, elsewhere(latitude_deg=48.2)),
    "the runway from the other end": written("never established", as_is, elsewhere(heading_deg=260.0)),
    "a course that is wrong": written("never established", as_is, elsewhere(heading_deg=100.0)),
    "a runway without a course": written("heading_deg", as_is, elsewhere(heading_deg=ABSENT)),
    "a runway without a place": written("latitude_deg", as_is, elsewhere(latitude_deg=ABSENT)),
    "an elevation that is wrong": written("below it", as_is, elsewhere(elevation_m=420.0)),
    "no runway": written("no table [runway]", as_is, "[air]\nqnh_hpa = 1013\n"),
    "a runway that is no TOML": written("not TOML", as_is, "runway: 1"),
    "a QNH of no day": written("QNH", as_is, RUNWAY_FILE + "[air]\nqnh_hpa = 500\n"),
    # state vectors
    "state vectors": written(None, opensky),
    "state vectors of a time of day": written("time of day", lambda t: opensky(t, lambda number: 43200 + number)),
    "state vectors without a callsign": written(None, lambda t: opensky([{**one, "callsign": ""} for one in t])),
    "state vectors and a column of traffic": written(None, lambda t: opensky(t).replace("baroaltitude", "altitude")),
}
