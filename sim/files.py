"""Run folders: written whole or not at all, and never over what something else wrote."""

from __future__ import annotations

import contextlib
import fcntl
import json
import math
import os
import shutil
import signal
import threading
import time
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np

from sim.errors import OutputError

WAIT = 60.0  # s, for another process that writes the same folder
MARK = ".shortfinal"
WRITTEN_BY = "written by shortfinal"
KINDS = {"run": "a run", "study": "a study", "claims": "the claims"}


def claim(folder: Path, what: str) -> None:
    """Make ``folder`` ours: new, empty, or written for the same of ``KINDS``; raises ``OutputError`` otherwise."""
    refuse_foreign(folder, what)
    try:
        folder.mkdir(parents=True, exist_ok=True)
        with (folder / MARK).open("x", encoding="utf-8") as mark:
            mark.write(f"{WRITTEN_BY} {what}\n")
    except FileExistsError:
        refuse_foreign(folder, what)  # somebody may have been quicker
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
            holds = (folder / MARK).read_text(encoding="utf-8", errors="replace").removeprefix(WRITTEN_BY).strip()
            if holds in KINDS and holds != what:
                raise OutputError(f"{folder}: holds {KINDS[holds]}, not {KINDS[what]}; choose another folder with -o")
    except OSError as error:
        raise OutputError(f"{folder}: cannot be read: {error.strerror}") from None


@contextlib.contextmanager
def staged(folder: Path) -> Iterator[Path]:
    """A folder inside ``folder`` whose files replace those of ``folder`` together, once all are written.

    Where another process does the same at that time this one waits for it, so the files that stay are all of one.
    """
    staging = folder / ".partial"
    try:
        with only_writer(folder, WAIT):
            try:
                shutil.rmtree(staging, ignore_errors=True)
                staging.mkdir()
                yield staging
                with unstopped():
                    for file in sorted(staging.iterdir()):
                        os.replace(file, folder / file.name)
            finally:
                shutil.rmtree(staging, ignore_errors=True)
    except OSError as error:
        kept = "; the files of the last run are kept" if any(folder.glob("[!.]*")) else ""
        raise OutputError(f"{folder}: cannot be written: {error.strerror}{kept}") from None


@contextlib.contextmanager
def only_writer(folder: Path, wait: float = 0.0) -> Iterator[None]:
    """Within, no other process writes into the folder; the lock dies with its holder.

    Raises ``OutputError`` where another one still does after ``wait`` seconds.
    """
    handle = os.open(folder, os.O_RDONLY)
    until = time.monotonic() + wait
    try:
        while not _locked(handle):
            if time.monotonic() >= until:
                raise OutputError(
                    f"{folder}: another process is writing into it; wait for it, or choose another with -o"
                )
            time.sleep(0.05)
        yield
    finally:
        os.close(handle)


def _locked(handle: int) -> bool:
    """Whether a folder could be locked; one on a file system that knows no locks counts as locked."""
    try:
        fcntl.flock(handle, fcntl.LOCK_EX | fcntl.LOCK_NB)
    except BlockingIOError:
        return False
    except OSError:
        return True
    return True


@contextlib.contextmanager
def unstopped() -> Iterator[None]:
    """Within, signals that stop the process wait: what is begun is done whole. Only the main thread gets signals."""
    if threading.current_thread() is not threading.main_thread():
        yield
        return
    came: list[int] = []
    before = {number: signal.getsignal(number) for number in (signal.SIGINT, signal.SIGTERM, signal.SIGHUP)}
    for number, handler in before.items():
        if callable(handler):
            signal.signal(number, lambda number, frame: came.append(number))
    try:
        yield
    finally:
        for number, handler in before.items():
            signal.signal(number, handler)
        for first in came[:1]:
            signal.raise_signal(first)


def write_json(path: Path, content: Any) -> None:
    """JSON with sorted keys; what is not finite is null."""
    path.write_text(json.dumps(plain(content), sort_keys=True, indent=1, allow_nan=False) + "\n", encoding="utf-8")


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
        with partial.open("w", encoding="utf-8") as file:
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
