"""Scenario files near one that is not there: what a user may have meant."""

from __future__ import annotations

import difflib
from pathlib import Path

MOST_FILES = 1000  # of a folder that are looked at


def files_in(folder: Path) -> list[str]:
    """Scenario files of a folder, by their paths; none of one that cannot be read."""
    try:
        found = [path for path, _ in zip(folder.iterdir(), range(MOST_FILES), strict=False)]
        return sorted(str(path) for path in found if path.suffix == ".toml" and path.is_file())
    except OSError:
        return []


def near_files(path: Path) -> list[str]:
    """Scenario files beside it that are called nearly as it is, the nearest first."""
    there = {Path(file).name: file for file in files_in(path.parent)}
    same = [there[name] for name in (f"{path.name}.toml", f"{path.stem}.toml") if path.stem and name in there]
    return [*same, *(there[name] for name in difflib.get_close_matches(path.name, there, n=1, cutoff=0.7))]
