"""What a ``[record]`` brings along and what cannot stand beside it; works on the tables of a file as they stand."""

from __future__ import annotations

import functools
import hashlib
import os
import re
from collections.abc import Callable
from pathlib import Path
from typing import Any

from sim.errors import ScenarioError
from sim.files import opened
from sim.scenario.messages import stem

# Who watches where the scenario names nobody: a radar with Mode C, and trackers of an airliner under vectors. Their
# values are the choices of docs/arrival-densities.md, on made-up arrivals; the bank of `imm` follows the bank limit.
SENSORS = {"radar": {"kind": "surveillance_radar", "height": "mode_c"}}
TRACKERS: dict[str, dict[str, Any]] = {
    "kalman": {"kind": "kalman", "acceleration_density_m2ps3": 3.0},
    "imm": {"kind": "imm"},
    "intent_imm": {
        "kind": "intent_imm",
        "vectored": True,
        "limit_factors": [0.4, 1.0, 2.4],
        "mean_stay_s": 45.0,
        "law_density_m2ps3": 0.1,
    },
    "saturated_control": {"kind": "saturated_control", "begins": "engaged", "acceleration_density_m2ps3": 3.0},
}
LONGEST_NAME = 50  # characters of a scenario's name that a flight gives it
Parser = Callable[[str, bytes], dict[str, Any]]

FLOWN = ("aircraft", "start", "wind", "designed", "departures", "until_s")  # what only a flight that is flown has
FLOWN_BY = {"navigation": "truth", "estimate_lag": 0.0, "allow_orbit": False, "frequency_share": None}
FIELD = ("runway", "air")  # tables that the file of a runway may have
NEEDED = {"latitude": "latitude_deg", "longitude": "longitude_deg", "heading": "heading_deg, its true course,"}
BLOCK = 1 << 20  # bytes that are hashed at a time

# The law that trackers assume where none is told: medians of the laws that fit the captures of 87 recorded approaches
# of jets to three airports; half of the flights have a k1 of .04 to .08 deg/m and a k2 of .7 to 1.1 deg/(m/s).
BANK_LIMIT = {"bank_limit_deg": 25.0}
LAW = {"k1_deg_per_m": 0.055, "k2_deg_per_mps": 0.88, "cross_track_limit_m": 976.0}


def scenario_of(tracks: Path, runway: Path, flight: str | None) -> dict[str, Any]:
    """The tables of a scenario for a recorded flight, called by it, else by its file; who watches is not said."""
    plain = re.sub(r"[^A-Za-z0-9_-]", "_", tracks.stem if flight is None else flight)[:LONGEST_NAME]
    named = {} if flight is None else {"flight": flight}
    return {
        "name": plain if plain[:1].isascii() and plain[:1].isalpha() else f"flight_{plain}",
        "record": {"file": str(tracks), "runway": str(runway), **named},
    }


def beside_file(tables: dict[str, Any], folder: Path) -> dict[str, Any]:
    """The tables with the files of ``[record]`` counted from the folder of the scenario's own file."""
    record = tables.get("record")
    if not isinstance(record, dict):
        return tables
    files = {key: str(folder / record[key]) for key in ("file", "runway") if isinstance(record.get(key), str)}
    return {**tables, "record": {**record, **files}}


def completed_record(tables: dict[str, Any], parsed: Parser) -> dict[str, Any]:
    """The tables with all that ``[record]`` brings along: runway, absolute path, digest, the law that is assumed, and
    sensors and trackers where none are named.

    ``parsed`` gives the tables of a TOML file from its name and its content.

    Raises ``ScenarioError`` for a file that cannot be read, or is not the one that the scenario was written with.
    """
    record = tables.get("record")
    if not isinstance(record, dict) or not isinstance(record.get("file", "none"), str):
        return tables  # a fault that is told by the model of the file
    if record.get("file", "none") == "":
        raise ScenarioError("[record] file: is empty; name a file of recorded tracks")
    if isinstance(record.get("runway"), str):
        if "runway" in tables:
            raise ScenarioError("[record] runway: there is a table [runway] already; keep one of the two")
        tables = {**runway_file(Path(record["runway"]), parsed), **tables}
        record = {key: value for key, value in record.items() if key != "runway"}
    tables = {**tables, "record": record, "autopilot": _told(tables)}
    if not isinstance(record.get("file"), str):  # nothing is known of it but plots
        return tables
    path = Path(record["file"]).absolute()
    found = sha256(path)
    if record.get("sha256") not in (None, found):
        raise ScenarioError(
            f"[record] file: {path} is not the recording that this scenario was written with, its content is another: "
            "take sha256 out to use it as it is"
        )
    watched = {"sensors": SENSORS, "trackers": TRACKERS}
    return {**watched, **tables, "record": {**record, "file": str(path), "sha256": found}}


def _told(tables: dict[str, Any]) -> Any:
    """The table [autopilot] with the law that trackers assume where it says none."""
    table = tables.get("autopilot", {})
    if not isinstance(table, dict):
        return table
    law = table.get("law", {})
    table = _with_defaults(table, BANK_LIMIT)
    if table.get("kind", "lateral_navigation") == "lateral_navigation" and isinstance(law, dict):
        table = {**table, "law": _with_defaults(law, LAW)}
    return table


def _with_defaults(table: dict[str, Any], defaults: dict[str, float]) -> dict[str, Any]:
    given = {stem(key) for key in table}
    return {**{key: value for key, value in defaults.items() if stem(key) not in given}, **table}


def runway_file(path: Path, parsed: Parser) -> dict[str, Any]:
    """The tables of a file about a runway."""
    try:
        with os.fdopen(opened(path, os.O_RDONLY), "rb") as file:
            tables = parsed(str(path), file.read(BLOCK))
    except FileNotFoundError:
        raise ScenarioError(f"[record] runway: {path}: no such file") from None
    except (OSError, ValueError) as error:
        if isinstance(error, ScenarioError):
            raise
        raise ScenarioError(f"[record] runway: {path}: cannot be read: {_why(error)}") from None
    if not isinstance(tables.get("runway"), dict):
        raise ScenarioError(f"[record] runway: {path}: has no table [runway]")
    found = {name: tables[name] for name in FIELD if name in tables}
    for lacking in _unplaced(found["runway"]):
        raise ScenarioError(f"[record] runway: {path}: {lacking}")
    return found


def sha256(path: Path) -> str:
    """The digest of a plain file; raises ``ScenarioError`` for what is none.

    It is worked out anew when the system says that the file has changed: a study asks for it in every cell.
    """
    try:
        with os.fdopen(opened(path, os.O_RDONLY), "rb") as file:
            now = os.fstat(file.fileno())
            return _digest(path, (now.st_dev, now.st_ino, now.st_size, now.st_mtime_ns, now.st_ctime_ns))
    except FileNotFoundError:
        raise ScenarioError(f"[record] file: {path}: no such file") from None
    except (OSError, ValueError) as error:  # a path may be none
        raise ScenarioError(f"[record] file: {path}: cannot be read: {_why(error)}") from None


@functools.lru_cache(maxsize=16)
def _digest(path: Path, _as_it_is: tuple[int, ...]) -> str:
    found = hashlib.sha256()
    with os.fdopen(opened(path, os.O_RDONLY), "rb") as file:
        while block := file.read(BLOCK):
            found.update(block)
    return found.hexdigest()


def _why(error: Exception) -> str:
    return (error.strerror if isinstance(error, OSError) else None) or str(error)


def strangers(tables: dict[str, Any]) -> list[str]:
    """Faults of the tables beside a ``[record]``: what only a flight has that is flown here, and what is not told."""
    faults = [
        f"[{name}] stands beside [record], whose flight is not flown here; take one of them out"
        for name in FLOWN
        if tables.get(name) is not None
    ]
    autopilot, route = tables.get("autopilot", {}), tables.get("route", {"kind": "legs"})
    faults += [
        f"[autopilot] {name} says how an aircraft is flown, and that of [record] is not flown here; take it out"
        for name, none in FLOWN_BY.items()
        if any(stem(key) == name and value not in (none, None) for key, value in autopilot.items())
    ]
    if route.get("kind", "pattern") != "legs":
        faults.append('[route] of a recording is told to trackers as kind = "legs", or not at all')
    if tables.get("flights", 1) != 1:
        faults.append("flights: a recording is one flight; ask for more 'draws' of the sensors' noise")
    study = tables.get("study") or {}
    if study.get("theory") is not None:
        faults.append("[study] theory: there is none of a flight that was flown elsewhere")
    if study.get("samples", 1) != 1 and not study.get("axes"):
        faults.append("[study] samples: a recording is one flight; vary something under [study.axes]")
    return faults + [f"[runway] {lacking}" for lacking in _unplaced(tables.get("runway", {}))]


def _unplaced(runway: dict[str, Any]) -> list[str]:
    """What a runway to which a recording is to be brought does not say."""
    given = {stem(key) for key in runway}
    return [f"{key} is missing: a recording is placed by it" for name, key in NEEDED.items() if name not in given]
