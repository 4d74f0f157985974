"""Rows that are measured already, so that an interrupted ledger goes on where it was stopped.

The folder may come from somebody else: a line that is not what this program writes counts as absent.
"""

from __future__ import annotations

import hashlib
import json
import os
from pathlib import Path
from typing import Any

from sim.claims.ledger import Measured, Row
from sim.errors import OutputError
from sim.files import opened, read_bytes
from sim.versions import program

FILE = "rows.jsonl"  # one line for each row; gone once the pages are written


def stamp(seed: int, quick: bool) -> str:
    """What rows must have in common to stand in one ledger."""
    return f"{program()[:16]} seed {seed}{' quick' if quick else ''}"


def add_row(folder: Path, mark: str, row: Row) -> None:
    """Append one row; raises ``OutputError`` where that is impossible."""
    line = {"stamp": mark, "paper": row.paper, "claim": row.claim.name, "measured": row.measured}
    try:
        with os.fdopen(opened(folder / FILE, os.O_WRONLY | os.O_CREAT | os.O_APPEND), "wb") as file:
            file.write(f"\n{json.dumps({**line, 'digest': _digest(line)})}\n".encode())  # the line before may be torn
    except OSError as error:
        raise OutputError(f"{folder}: cannot be written: {error.strerror}; what was measured before is kept") from None


def load_rows(folder: Path, mark: str) -> dict[tuple[str, str], tuple[Measured, ...]]:
    """What an interrupted command of the same stamp has measured, by paper and claim."""
    found: dict[tuple[str, str], tuple[Measured, ...]] = {}
    try:
        lines = read_bytes(folder / FILE).splitlines()
    except FileNotFoundError:
        return found
    except OSError as error:
        raise OutputError(f"{folder}: cannot be read: {error.strerror}") from None
    for text in lines:
        try:
            line = json.loads(text)
            if line.pop("digest") == _digest(line) and line["stamp"] == mark:
                found[line["paper"], line["claim"]] = tuple(map(_measured, line["measured"]))
        except (ValueError, TypeError, LookupError, AttributeError, RecursionError):  # torn, or nothing of ours
            continue
    return found


def _digest(line: dict[str, Any]) -> str:
    return hashlib.sha256(json.dumps(line, sort_keys=True).encode()).hexdigest()[:16]


def _measured(values: Any) -> Measured:
    """A reading as it was written; raises ``TypeError`` for values of other types."""
    found = Measured(*values)
    numbers = (found.value, found.low, found.high)
    if type(found.reading) is not str or type(found.runs) is not int or {*map(type, numbers)} - {int, float}:
        raise TypeError("no reading")
    return found
