"""Files that a scenario names, by their absolute paths."""

from __future__ import annotations

import os
from pathlib import Path
from typing import Any

FILES = ("file", "runway")  # keys that name one


def located(tables: dict[str, Any], folder: Path) -> dict[str, Any]:
    """The tables with the files of ``[record]`` and of sensors taken from a folder, where they are not absolute."""
    found = dict(tables)
    if isinstance(tables.get("record"), dict):
        found["record"] = _absolute(tables["record"], folder)
    if isinstance(tables.get("sensors"), dict):
        found["sensors"] = {
            name: _absolute(table, folder) if isinstance(table, dict) else table
            for name, table in tables["sensors"].items()
        }
    return found


def _absolute(table: dict[str, Any], folder: Path) -> dict[str, Any]:
    return {
        key: os.path.abspath(folder / value) if key in FILES and isinstance(value, str) and value else value
        for key, value in table.items()
    }
