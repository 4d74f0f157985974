"""The append-only log of a study: one line for each finished flight.

A folder may come from somebody else, and a disk may fail. So every line carries a digest of what it says and of the
study that it belongs to, and what is read is held against the plan: a line that is not what a flight of this study
leaves counts as absent, and its flight is flown again.
"""

from __future__ import annotations

import contextlib
import hashlib
import json
import os
from collections.abc import Callable, Iterator, Mapping
from pathlib import Path
from typing import Any, NamedTuple

from sim.errors import OutputError
from sim.files import opened, plain, replace
from sim.metrics.ensemble.verdict import CRASHED, LOST, REFUSED
from sim.scenario.axes import LARGEST_NUMBER

LOG = "flights.jsonl"
DIGEST = "digest"
KEYS = {"cell", "sample", "flight", "values", "metrics", "checks", "again"}
DEEPEST = 12  # tables within tables of figures
Place = tuple[int, int, int]  # cell, sample, flight


class Planned(NamedTuple):
    """What a study expects of its lines."""

    values: Mapping[Place, dict[str, Any]]  # of the axes, of every flight
    checks: int  # of each flight that came to an end


class Log(NamedTuple):
    """What a log says."""

    records: dict[Place, dict[str, Any]]
    faults: list[str]  # of lines that count as absent, in order


def place_of(record: dict[str, Any]) -> Place:
    """Where in its study a record stands."""
    return record["cell"], record["sample"], record["flight"]


def line(record: dict[str, Any], study: str) -> str:
    """One record as a line of the log of a study, which is named by its digest."""
    content = plain(record)
    return _text({**content, DIGEST: _digest(content, study)}) + "\n"


def _text(content: dict[str, Any]) -> str:
    return json.dumps(content, sort_keys=True, allow_nan=False, separators=(",", ":"))


def _digest(content: dict[str, Any], study: str) -> str:
    return hashlib.sha256(f"{study}\n{_text(content)}".encode()).hexdigest()[:16]


def read(folder: Path, study: str, planned: Planned | None = None) -> Log:
    """The records of finished flights, by their place; raises ``OutputError`` where the log cannot be read.

    Without what is ``planned`` the lines are not held against it.
    """
    records: dict[Place, dict[str, Any]] = {}
    faults: list[str] = []
    try:
        with os.fdopen(opened(folder / LOG, os.O_RDONLY), "rb") as file:
            for number, text in enumerate(file, 1):
                if text == b"\n" or not text.endswith(b"\n"):  # torn by a crash, or still being written
                    continue
                try:
                    record = _record(text, study, planned)
                    records[place_of(record)] = record
                except (ValueError, RecursionError) as error:  # RecursionError: lists in lists in lists
                    why = "is no JSON" if isinstance(error, RecursionError | json.JSONDecodeError) else str(error)
                    faults.append(f"line {number} {why}")
    except FileNotFoundError:
        pass
    except OSError as error:
        raise OutputError(f"{folder}: cannot be read: {error.strerror}") from None
    return Log(records, faults)


def _record(text: bytes, study: str, planned: Planned | None) -> dict[str, Any]:
    """The record of a line; raises ``ValueError`` with what is wrong with it."""
    found = json.loads(text)
    if not isinstance(found, dict) or not isinstance(found.get("metrics"), dict) or set(found) != {*KEYS, DIGEST}:
        raise ValueError("is no record of a flight")
    digest = found.pop(DIGEST)
    if not _is_plain(found):
        raise ValueError("has what no flight has")
    if digest != _digest(found, study):
        raise ValueError("was changed, or belongs to another study")
    place, values = place_of(found), found["values"]
    if not all(type(number) is int for number in place) or not isinstance(values, dict):
        raise ValueError("is no record of a flight")
    if planned is not None and (place not in planned.values or values != plain(planned.values[place])):
        raise ValueError("is of a flight that the study does not have")
    outcome, checks = found["metrics"].get("outcome"), found["checks"]
    if not isinstance(outcome, str) or not isinstance(found["metrics"].get("reason"), str):
        raise ValueError("does not say how its flight ended")
    none_at_all = checks == [] and outcome in (CRASHED, REFUSED)
    wanted = planned is None or none_at_all or (isinstance(checks, list) and len(checks) == planned.checks)
    if not wanted or not isinstance(checks, list) or not all(map(_is_result, checks)):
        raise ValueError("has other checks than the study")
    return found


def _is_plain(value: Any, depth: int = 0) -> bool:
    """Whether a record can hold this: words, truth values, finite numbers, and tables and lists of them."""
    if isinstance(value, dict):
        return depth < DEEPEST and all(_is_plain(one, depth + 1) for pair in value.items() for one in pair)
    if isinstance(value, list):
        return depth < DEEPEST and all(_is_plain(one, depth + 1) for one in value)
    if isinstance(value, str):
        return not any("\ud800" <= letter <= "\udfff" for letter in value)  # half a letter, which no file can hold
    return value is None or bool(abs(value) <= LARGEST_NUMBER)  # not of NaN


def _is_result(found: Any) -> bool:
    """Whether this is what a check finds on a flight."""
    return (
        isinstance(found, dict)
        and set(found) == set(LOST)
        and (found["passed"] is None or isinstance(found["passed"], bool))
        and all(found[key] is None or type(found[key]) in (int, float) for key in LOST if key != "passed")
    )


def rewrite(folder: Path, study: str, records: Mapping[Place, dict[str, Any]]) -> None:
    """The log anew, sorted, whole or not at all; the caller must hold the lock."""
    replace(folder / LOG, "".join(line(records[place], study) for place in sorted(records)))


@contextlib.contextmanager
def appending(folder: Path, study: str) -> Iterator[Callable[[dict[str, Any]], None]]:
    """A function that adds a record to the log; what it wrote is on the disk when it returns."""
    with write_errors(folder):
        handle = opened(folder / LOG, os.O_WRONLY | os.O_CREAT | os.O_APPEND)
    try:

        def append(record: dict[str, Any]) -> None:
            with write_errors(folder):
                data = line(record, study).encode()
                while data:
                    data = data[os.write(handle, data) :]
                os.fsync(handle)

        yield append
    finally:
        os.close(handle)


@contextlib.contextmanager
def write_errors(folder: Path) -> Iterator[None]:
    """Report a full or read-only disk in one sentence; finished flights stay."""
    try:
        yield
    except OSError as error:
        raise OutputError(f"{folder}: cannot be written: {error.strerror}; finished flights are kept") from None
