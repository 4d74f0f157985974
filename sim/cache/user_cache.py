"""What one command leaves for the next, in the cache folder of the user: the one place outside a command's own folder.

An entry is named by a hash of all that decides it, the program and its versions among that, and carries a digest of
what it says, so that whoever finds it would have computed the same. The cache is optional: a folder that is not the
user's own, is open to others or cannot be written is passed over, a damaged entry counts as absent, and with
``SHORTFINAL_CACHE=off`` there is none. Worker processes inherit both from their parent.
"""

from __future__ import annotations

import contextlib
import hashlib
import json
import os
import stat
from collections.abc import Callable
from pathlib import Path
from typing import Any

from sim.files import read_bytes
from sim.versions import processor, program, versions

SWITCH, OFF = "SHORTFINAL_CACHE", "off"
NAME = "shortfinal"
MOST, KEPT = 4000, 2000  # entries before and after the oldest are deleted
LARGEST = 1 << 20  # bytes of an entry


def place() -> Path | None:
    """Where the cache is, or would be; None where it is off, or the user has no home [XDG base directories]."""
    if os.environ.get(SWITCH) == OFF:
        return None
    base = Path(os.environ.get("XDG_CACHE_HOME", ""))
    try:
        return (base if base.is_absolute() else Path.home() / ".cache") / NAME
    except RuntimeError:
        return None


def unfit(folder: Path) -> str:
    """Why a folder that is there is passed over; empty where it is not."""
    try:
        found = folder.lstat()
    except FileNotFoundError:
        return ""
    except OSError as error:
        return f"cannot be read: {error.strerror}"
    if not stat.S_ISDIR(found.st_mode):
        return "is no folder"
    if found.st_uid != os.geteuid():
        return "belongs to somebody else"
    if stat.S_IMODE(found.st_mode) & 0o077:
        return "is open to others; only its owner may read and write it (chmod 700)"
    return "" if os.access(folder, os.R_OK | os.W_OK | os.X_OK) else "cannot be written"


def remembered(what: str, decides: Any, make: Callable[[], Any]) -> Any:
    """What ``make`` gives, as JSON gives it back, computed once for all that ``decides`` it.

    An exception of ``make`` is raised each time.
    """
    kept = load(what, decides)
    if kept is None:
        kept = json.loads(json.dumps(make()))
        store(what, decides, kept)
    return kept


def load(what: str, decides: Any) -> Any:
    """The content that was stored under this name; None where there is none, or it is damaged."""
    folder = place()
    if folder is None or unfit(folder):
        return None
    name = _name(what, decides)
    try:
        digest, _, text = read_bytes(folder / name).partition(b"\n")
        if len(text) > LARGEST or hashlib.sha256(name.encode() + text).hexdigest().encode() != digest:
            return None
        content = json.loads(text)
        os.utime(folder / name, follow_symlinks=False)  # still of use
    except (OSError, ValueError, RecursionError):
        return None
    return content


def store(what: str, decides: Any, content: Any) -> None:
    """Keep a content that JSON can hold, where there is a cache that can be written."""
    folder = place()
    if folder is None:
        return
    name = _name(what, decides)
    text = json.dumps(content).encode()
    partial = folder / f".{name}.{os.getpid()}.partial"
    try:
        folder.mkdir(mode=0o700, parents=True, exist_ok=True)
        if unfit(folder) or len(text) > LARGEST:
            return
        _prune(folder)
        with open(os.open(partial, os.O_WRONLY | os.O_CREAT | os.O_EXCL | os.O_NOFOLLOW, 0o600), "wb") as file:
            file.write(hashlib.sha256(name.encode() + text).hexdigest().encode() + b"\n" + text)
        os.replace(partial, folder / name)
    except OSError:
        with contextlib.suppress(OSError):
            partial.unlink()


def _name(what: str, decides: Any) -> str:
    """Readable at its front, and a hash of everything that the content depends on."""
    every = json.dumps([what, decides, versions(), processor(), program()], sort_keys=True)
    return f"{what}-{hashlib.sha256(every.encode()).hexdigest()}"


def _prune(folder: Path) -> None:
    """Delete the entries that were longest of no use, and what a crash left half written, once there are too many."""
    entries = list(os.scandir(folder))
    if len(entries) <= MOST:
        return
    for entry in sorted(entries, key=lambda one: one.stat(follow_symlinks=False).st_mtime)[:-KEPT]:
        with contextlib.suppress(OSError):
            os.unlink(entry.path)
