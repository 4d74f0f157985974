"""Run folders: written whole or not at all, and never over what something else wrote.

A folder may come from somebody else. The folder itself is where its user says, links on the way included, but within it
no link is followed and nothing but a regular file is opened, so nothing outside is read, written or deleted.
"""

from __future__ import annotations

import contextlib
import errno
import fcntl
import json
import math
import os
import shutil
import signal
import stat
import threading
import time
import zipfile
import zlib
from collections.abc import Iterable, Iterator, Mapping
from pathlib import Path
from typing import Any

import numpy as np

from sim.errors import OutputError

LARGEST = 1 << 28  # bytes of a file that is read whole
WAIT = 60.0  # s, for another process that writes the same folder
MARK = ".shortfinal"
WRITTEN_BY = "written by shortfinal"
DAMAGED = (
    *(OSError, ValueError, LookupError, TypeError, AttributeError, EOFError, RuntimeError, MemoryError),
    *(zipfile.BadZipFile, zlib.error),
)  # what reading a file that is not what it should be may raise
KINDS = {
    **{"run": "a run", "study": "a study", "claims": "the claims", "identification": "identified laws"},
    "jsbsim": "a root of JSBSim",
    "tables": "tables of a run",
}


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
            refuse_links(folder)
            holds = read_bytes(folder / MARK).decode(errors="replace").removeprefix(WRITTEN_BY).strip()
            if holds in KINDS and holds != what:
                raise OutputError(f"{folder}: holds {KINDS[holds]}, not {KINDS[what]}; choose another folder with -o")
    except OSError as error:
        raise OutputError(f"{folder}: cannot be read: {error.strerror}") from None


def refuse_unwritten(folder: Path) -> None:
    """Raise ``OutputError`` for a folder that is not of a run or a study, or holds links."""
    if not folder.is_dir():
        raise OutputError(f"{folder}: no such folder; name the folder that 'shortfinal run' or 'study' wrote")
    if not (folder / MARK).is_file():
        raise OutputError(f"{folder}: not a run folder; name one that 'shortfinal run' or 'study' wrote")
    refuse_links(folder)


def refuse_links(folder: Path) -> None:
    """Raise ``OutputError`` for a folder that holds, at any depth, anything but folders and regular files."""
    waiting = [folder] if folder.is_dir() else []
    try:
        while waiting:
            with os.scandir(waiting.pop()) as entries:
                for entry in entries:
                    if entry.is_dir(follow_symlinks=False):
                        waiting.append(Path(entry.path))
                    elif not entry.is_file(follow_symlinks=False):
                        what = "a link" if entry.is_symlink() else "neither a file nor a folder"
                        name = Path(entry.path).relative_to(folder)
                        raise OutputError(f"{folder}: {name} in it is {what}, which shortfinal never writes; remove it")
    except OSError as error:
        raise OutputError(f"{folder}: cannot be read: {error.strerror}") from None


def opened(path: Path, flags: int) -> int:
    """A descriptor of a regular file, by flags of ``os.open``; raises ``OSError`` for anything else, and never waits.

    A file that is changed in place must have no second name, under which it may be somebody else's.
    """
    try:
        handle = os.open(path, flags | os.O_NOFOLLOW | os.O_NONBLOCK | os.O_CLOEXEC, 0o644)
    except OSError as error:
        if error.errno in (errno.ELOOP, errno.ENXIO):  # a link, a pipe that nobody reads
            raise OSError(error.errno, f"{path.name} is no regular file", str(path)) from None
        raise
    found = os.fstat(handle)
    if stat.S_ISREG(found.st_mode) and (found.st_nlink == 1 or not flags & os.O_APPEND):
        return handle
    os.close(handle)
    what = "has a second name" if stat.S_ISREG(found.st_mode) else "is no regular file"
    raise OSError(errno.EINVAL, f"{path.name} {what}", str(path))


def read_bytes(path: Path) -> bytes:
    """The content of a regular file; raises ``OSError`` for anything else, and for what is too large."""
    with os.fdopen(opened(path, os.O_RDONLY), "rb") as file:
        content = file.read(LARGEST + 1)
    if len(content) > LARGEST:
        raise OSError(errno.EFBIG, f"{path.name} is larger than {LARGEST >> 20} MB", str(path))
    return content


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
                files = sorted(staging.iterdir())
                for file in files:
                    if (folder / file.name).is_dir():
                        raise OSError(errno.EISDIR, f"{file.name} in it is a folder")
                with unstopped():
                    for file in files:
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
    """Within, signals that stop the process wait, also those that nobody handles: what is begun is done whole.

    Only the main thread gets signals.
    """
    if threading.current_thread() is not threading.main_thread():
        yield
        return
    came: list[int] = []
    before = {number: signal.getsignal(number) for number in (signal.SIGINT, signal.SIGTERM, signal.SIGHUP)}
    for number, handler in before.items():
        if handler not in (signal.SIG_IGN, None):  # None: set by other than Python, which could not set it back
            signal.signal(number, lambda number, frame: came.append(number))
    try:
        yield
    finally:
        for number, handler in before.items():
            if handler is not None:
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


def write_npz(path: Path, arrays: Mapping[str, Any] | Iterable[tuple[str, Any]]) -> None:
    """A file of named arrays; the name of each carries its unit. Noise does not compress, so nothing is compressed.

    They are taken and written one by one, the bytes are those of ``numpy.savez``. Raises ``ValueError`` for arrays of
    objects, which only a pickle could hold.
    """
    with path.open("wb") as file, zipfile.ZipFile(file, "w") as archive:
        for name, array in arrays.items() if isinstance(arrays, Mapping) else arrays:
            with archive.open(f"{name}.npy", mode="w", force_zip64=True) as member:
                np.lib.format.write_array(member, np.asarray(array), allow_pickle=False)


@contextlib.contextmanager
def whole(path: Path) -> Iterator[Path]:
    """A file to be written under another name, which takes the place of ``path`` once it is done, and else is deleted.

    Raises ``OutputError`` where that cannot be.
    """
    partial = path.with_name(f".{path.name}.{os.getpid()}.partial")
    try:
        try:
            partial.unlink(missing_ok=True)
            yield partial
            with unstopped():
                os.replace(partial, path)
        finally:
            partial.unlink(missing_ok=True)
    except OSError as error:
        raise OutputError(f"{path}: cannot be written: {error.strerror}") from None


def replace(path: Path, text: str) -> None:
    """Write a file so that it is whole or the old one, whatever happens."""
    partial = path.with_name(f".{path.name}.partial")
    try:
        partial.unlink(missing_ok=True)
        with partial.open("x", encoding="utf-8") as file:  # follows no link that somebody puts there
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
