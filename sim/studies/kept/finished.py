"""A study that is done already: its figures as they lie in its folder, where all that decides them is unchanged.

That a folder is done is remembered in the cache of the user, never in the folder, which may come from somebody else.
What is remembered is named by the scenario, the seed in it, the parts from outside, the program, its versions and the
kind of processor, and by the content of every file that the scenario names (models of aircraft, recordings). It holds
digests of the log and of the files that the study wrote: where a byte of them has changed they are made again.
Fonts and settings of whatever draws the page do not count.
"""

from __future__ import annotations

import contextlib
import hashlib
import importlib.metadata
import json
import tomllib
from collections.abc import Iterator
from pathlib import Path
from typing import Any

from aircraft.errors import ModelError
from aircraft.model_files import digest, read
from sim.cache import user_cache
from sim.errors import OutputError
from sim.files import read_bytes
from sim.scenario.plugins import Catalogue, digests
from sim.studies import folder as folders
from sim.studies.folder import IDENTITY, RESULTS, SCENARIO
from sim.studies.kept.flight_log import LOG
from sim.versions import DISTRIBUTIONS, versions

FILES = (SCENARIO, IDENTITY, LOG, *RESULTS)
MOST_FILES = 1000  # of a folder that a scenario names; with more, nothing is remembered
WHAT = "study"


def metrics_of(folder: Path, text: str, catalogue: Catalogue) -> dict[str, Any] | None:
    """The figures of a study that is done, with nothing changed; None where it has to be done, or done again."""
    if not all((folder / name).is_file() for name in FILES):
        return None
    try:
        folders.check_parts(folder, catalogue)
        begun_with = {name: one for name, one in folders.identity_of(folder)["versions"].items() if name != "parts"}
        if begun_with != versions():  # whether it goes on with others is for its user to say
            return None
        if user_cache.load(WHAT, _decides(text, catalogue)) != _digests(folder):
            return None
        metrics: dict[str, Any] = json.loads(read_bytes(folder / RESULTS[0]))
    except (OSError, OutputError):
        return None
    return metrics


def remember(folder: Path, text: str, catalogue: Catalogue) -> None:
    """That the study of a folder is done, with the files that it has now; the caller holds its lock."""
    with contextlib.suppress(OSError):  # what cannot be read does not count as known
        user_cache.store(WHAT, _decides(text, catalogue), _digests(folder))


def _decides(text: str, catalogue: Catalogue) -> list[Any]:
    """All that decides a study but what every entry of the cache depends on."""
    drawn_by = {name: importlib.metadata.version(name) for name in DISTRIBUTIONS}
    tables = {name: table for name, table in tomllib.loads(text).items() if name != "name"}
    named = {word: _content(Path(word)) for word in sorted({*_words(tables)})}
    return [text, digests(catalogue.parts), drawn_by, {word: found for word, found in named.items() if found}]


def _digests(folder: Path) -> dict[str, str]:
    """Of each file of a study; raises ``OSError`` for what is no regular file."""
    return {name: hashlib.sha256(read_bytes(folder / name)).hexdigest() for name in FILES}


def _words(value: Any) -> Iterator[str]:
    """Every text in tables: each may name a file."""
    if isinstance(value, dict):
        for one in value.values():
            yield from _words(one)
    elif isinstance(value, list | tuple):
        for one in value:
            yield from _words(one)
    elif isinstance(value, str) and value:
        yield value


def _content(path: Path) -> str:
    """Digest of a file, or of all files of a folder; empty for a word that names neither.

    Raises ``OSError`` for what cannot be read, and for a folder of too many files.
    """
    try:
        if not path.exists():
            return ""
    except (OSError, ValueError):  # what no file can be called
        return ""
    found = hashlib.sha256()
    with contextlib.suppress(ModelError):  # of an aircraft also what it refers to beside its folder
        found.update(digest(read(path)).encode())
    for count, file in enumerate([path] if path.is_file() else sorted(path.rglob("*"))):
        if count == MOST_FILES:
            raise OSError(f"{path}: more than {MOST_FILES} files")
        if file.is_file():
            found.update(f"{file.relative_to(path)} ".encode() + hashlib.sha256(read_bytes(file)).digest())
    return found.hexdigest()
