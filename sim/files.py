"""Run folders: written whole or not at all, and never over what something else wrote."""

from __future__ import annotations

import contextlib
import json
import math
import os
import shutil
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np

from sim.errors import OutputError

MARK = ".shortfinal"
WRITTEN_BY = "written by shortfinal"
KINDS = {"run": "a run", "study": "a study", "claims": "the claims"}


def claim(folder: Path, what: str) -> None:
    """Make ``folder`` ours: new, empty, or written for the same of ``KINDS``; raises ``OutputError`` otherwise."""
    refuse_foreign(folder, what)
    try:
        folder.mkdir(parents=True, exist_ok=True)
        (folder / MARK).write_text(f"{WRITTEN_BY} {what}\n")
    except OSError as error:
        raise OutputError(f"{folder}: cannot be written: {error.strerror}") from None


def refuse_foreign(folder: Path, what: str) -> None:
    """Raise ``OutputError`` for a folder that something else wrote, without touching it."""
    try:
        if folder.exists() and not folder.is_dir():
            raise OutputError(f"{folder}: is a file; name a folder with -o")
        if folder.is_dir() and any(folder.iterdir()):
            if (folder / MARK).is_symlink() or not (folder / MARK).is_file():
                raise OutputError(f"{folder}: holds files that shortfinal did not write; choose another folder with -o")
            holds = (folder / MARK).read_text(errors="replace").removeprefix(WRITTEN_BY).strip()
            if holds in KINDS and holds != what:
                raise OutputError(f"{folder}: holds {KINDS[holds]}, not {KINDS[what]}; choose another folder with -o")
    except OSError as error:
        raise OutputError(f"{folder}: cannot be read: {error.strerror}") from None


@contextlib.contextmanager
def staged(folder: Path) -> Iterator[Path]:
    """A folder inside ``folder`` whose files replace those of ``folder`` together, once all are written."""
    staging = folder / ".partial"
    try:
        shutil.rmtree(staging, ignore_errors=True)
        staging.mkdir()
        yield staging
        for file in sorted(staging.iterdir()):
            os.replace(file, folder / file.name)
    except OSError as error:
        kept = "; the files of the last run are kept" if any(folder.glob("[!.]*")) else ""
        raise OutputError(f"{folder}: cannot be written: {error.strerror}{kept}") from None
    finally:
        shutil.rmtree(staging, ignore_errors=True)


def write_json(path: Path, content: Any) -> None:
    """JSON with sorted keys; what is not finite is null."""
    path.write_text(json.dumps(plain(content), sort_keys=True, indent=1, allow_nan=False) + "\n")


def plain(value: Any) -> Any:
    """The value as JSON can hold it: plain numbers, null for what is not finite."""
    if isinstance(value, dict):
        return {str(key): plain(item) for key, item in value.items()}
    if isinstance(value, list | tuple):
        return [plain(item) for item in value]
    if isinstance(value, np.generic):
        value = value.item()
    if isinstance(value, float) and not math.isfinite(value):
        return None
    return value


def write_npz(path: Path, arrays: dict[str, Any]) -> None:
    """A file of named arrays; the name of each carries its unit. Noise does not compress, so nothing is compressed.

    Raises ``ValueError`` for arrays of objects, which only a pickle could hold.
    """
    with path.open("wb") as file:
        np.savez(file, allow_pickle=False, **{name: np.asarray(array) for name, array in arrays.items()})


def replace(path: Path, text: str) -> None:
    """Write a file so that it is whole or the old one, whatever happens."""
    partial = path.with_name(f".{path.name}.partial")
    try:
        with partial.open("w") as file:
            file.write(text)
            file.flush()
            os.fsync(file.fileno())
        os.replace(partial, path)
        _sync(path.parent)
    finally:
        partial.unlink(missing_ok=True)


def replace_json(path: Path, content: Any) -> None:
    """A JSON file with sorted keys, whole or not at all."""
    replace(path, json.dumps(plain(content), sort_keys=True, indent=1, allow_nan=False) + "\n")


def _sync(folder: Path) -> None:
    """A new name is safe once its folder is on the disk."""
    handle = os.open(folder, os.O_RDONLY)
    try:
        os.fsync(handle)
    finally:
        os.close(handle)
