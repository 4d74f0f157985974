"""Rows that are measured already, so that an interrupted ledger goes on where it was stopped."""

from __future__ import annotations

import hashlib
import json
from functools import lru_cache
from pathlib import Path

from sim.claims.ledger import Measured, Row
from sim.errors import OutputError

FILE = "rows.jsonl"  # one line for each row; gone once the pages are written
SOURCES = ("sim", "autopilot", "tracking", "aircraft")


@lru_cache(maxsize=1)
def program() -> str:
    """Digest of the program: what another one measured is measured again."""
    home, digest = Path(__file__).resolve().parents[2], hashlib.sha256()
    for package in SOURCES:
        for file in sorted((home / package).rglob("*.py")):
            digest.update(file.read_bytes())
    return digest.hexdigest()[:16]


def stamp(seed: int, quick: bool) -> str:
    """What rows must have in common to stand in one ledger."""
    return f"{program()} seed {seed}{' quick' if quick else ''}"


def add_row(folder: Path, mark: str, row: Row) -> None:
    """Append one row; raises ``OutputError`` where that is impossible."""
    line = {"stamp": mark, "paper": row.paper, "claim": row.claim.name, "measured": row.measured}
    try:
        with (folder / FILE).open("a", encoding="utf-8") as file:
            file.write(f"\n{json.dumps(line)}\n")  # the line before may be torn
    except OSError as error:
        raise OutputError(f"{folder}: cannot be written: {error.strerror}; what was measured before is kept") from None


def load_rows(folder: Path, mark: str) -> dict[tuple[str, str], tuple[Measured, ...]]:
    """What an interrupted command of the same stamp has measured, by paper and claim."""
    found: dict[tuple[str, str], tuple[Measured, ...]] = {}
    file = folder / FILE
    if not file.exists():
        return found
    for text in file.read_text(encoding="utf-8", errors="replace").splitlines():
        try:
            line = json.loads(text)
            if line["stamp"] == mark:
                found[line["paper"], line["claim"]] = tuple(Measured(*values) for values in line["measured"])
        except (ValueError, TypeError, KeyError):  # torn by the interruption
            continue
    return found
