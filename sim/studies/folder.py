"""The folder of a study: its identity, its append-only log of flights, and files that are whole or absent."""

from __future__ import annotations

import contextlib
import fcntl
import hashlib
import json
import os
from collections.abc import Callable, Iterable, Iterator
from pathlib import Path
from typing import Any

from sim.errors import OutputError
from sim.files import claim, plain, replace
from sim.reporting.text.broken_checks import Again, run_again
from sim.scenario.plugins import FAMILIES, Catalogue, Part, digests
from sim.versions import processor, rows, versions

LOG, SCENARIO, IDENTITY = "flights.jsonl", "scenario.toml", "cache/identity.json"
RESULTS = ("metrics.json", "report.html")
PROCESSOR = "processor"  # of the identity: another is a remark, because it moves last digits only


def identity(text: str, seed: int, parts: Iterable[Part] = ()) -> dict[str, Any]:
    """What decides the numbers of a study: its scenario file, its seed and the versions of all that computes."""
    scenario = hashlib.sha256(text.encode()).hexdigest()
    return {"seed": seed, "scenario": scenario, "versions": versions(digests(parts)), PROCESSOR: processor()}


def open_study(folder: Path, text: str, seed: int, anew: bool = False, parts: Iterable[Part] = ()) -> None:
    """Make a folder that of this study: new, or the same study's; ``anew`` throws another study away.

    Raises ``OutputError`` with one sentence.
    """
    mine = identity(text, seed, parts)
    begun = (folder / IDENTITY).is_file() and not anew
    if begun and _deciding(theirs := _identity_of(folder)) != _deciding(mine):
        raise OutputError(f"{folder}: holds {_difference(theirs, mine)}; choose another folder with -o, or --anew")
    claim(folder, "study")
    with _write_errors(folder):
        flights_of(folder).mkdir(parents=True, exist_ok=True)
    with locked(folder), _write_errors(folder):
        if not begun:
            for name in (LOG, *RESULTS):
                (folder / name).unlink(missing_ok=True)
        replace(folder / SCENARIO, text)
        if not begun:
            replace(folder / IDENTITY, json.dumps(mine, sort_keys=True, indent=1) + "\n")


def run_again_there(parts: Iterable[Part]) -> Again:
    """How a flight of a study is flown again from its folder; files with kinds from outside are called by their name.

    A folder holds no code, and where a file lies may differ from one machine to the next.
    """
    return run_again(SCENARIO, sorted({Path(part.origin).name for part in parts if part.text is not None}))


def flights_of(folder: Path) -> Path:
    """The folder of the flights that cells share."""
    return folder / "cache" / "flights"


def begun(folder: Path) -> float:
    """When the study of a folder was begun, by the clock of its file system."""
    return (folder / IDENTITY).stat().st_mtime


def check_parts(folder: Path, catalogue: Catalogue) -> None:
    """Refuse to go on with a study whose parts from outside are missing or have changed: a folder holds no code."""
    for address, digest in _identity_of(folder).get("versions", {}).get("parts", {}).items():
        try:
            part = catalogue.named(*address.split(".", 1))
        except KeyError:
            part = None
        if part is None:
            raise OutputError(f"{folder}: was begun with {address} from outside; bring it again with --plugin FILE")
        if (now := digests([part])[address]) != digest:
            raise OutputError(f"{folder}: was begun with {address} {digest}, not {now}; bring the one that began it")


def check_study(folder: Path, seed: int, anyway: bool = False, parts: Iterable[Part] = ()) -> None:
    """Refuse to go on with a study begun with other versions, unless ``anyway``."""
    theirs, mine = _identity_of(folder), identity(read_scenario(folder), seed, parts)
    if _deciding(theirs) != _deciding(mine) and not anyway:
        raise OutputError(f"{folder}: holds {_difference(theirs, mine)}; resume it with --anyway to go on all the same")


def another_processor(folder: Path) -> str | None:
    """What to know of a study that was begun on another kind of processor; None = nothing."""
    theirs = _identity_of(folder).get(PROCESSOR, processor())
    if theirs == processor():
        return None
    return (
        f"{folder}: was begun on another kind of processor ({theirs}; here {processor()}): "
        "its flights and those flown here may differ in their last digits"
    )


def _deciding(identity: dict[str, Any]) -> dict[str, Any]:
    """What of an identity must be the same to go on."""
    return {name: value for name, value in identity.items() if name != PROCESSOR}


def read_scenario(folder: Path) -> str:
    """The resolved scenario file of a study folder."""
    try:
        return (folder / SCENARIO).read_text(encoding="utf-8")
    except (OSError, UnicodeDecodeError):
        raise OutputError(f"{folder}: is no study folder: it has no {SCENARIO}") from None


def _identity_of(folder: Path) -> dict[str, Any]:
    try:
        found = json.loads((folder / IDENTITY).read_text(encoding="utf-8"))
    except (OSError, ValueError):
        found = None
    if not isinstance(found, dict) or not _are_versions(found.get("versions", {})):
        raise OutputError(f"{folder}: is no study folder: it has no {IDENTITY}")
    return found


def _are_versions(found: Any) -> bool:
    """Whether this is what `versions` gives, of whatever release."""
    starts = [(family, ".") for family in FAMILIES]
    parts = found.get("parts", {}) if isinstance(found, dict) else None
    return isinstance(parts, dict) and all(address.partition(".")[:2] in starts for address in parts)


def _difference(theirs: dict[str, Any], mine: dict[str, Any]) -> str:
    """How the study in the folder differs, in words."""
    if theirs.get("seed") != mine["seed"]:
        return f"a study with seed {theirs.get('seed')}, not {mine['seed']}"
    if theirs.get("scenario") != mine["scenario"]:
        return "a study of another scenario"
    old, new = dict(rows(theirs.get("versions", {}))), dict(rows(mine["versions"]))
    names = sorted({*new, *(name for name in old if "." in name)})  # a part has a dot, and it may be one less
    changed = [f"{name} {old.get(name)}, not {new.get(name)}" for name in names if old.get(name) != new.get(name)]
    return f"a study begun with {'; '.join(changed)}"


@contextlib.contextmanager
def locked(folder: Path) -> Iterator[None]:
    """Only one process at a time works in a study folder; the lock dies with its holder."""
    with _write_errors(folder):
        handle = os.open(folder / "cache" / "lock", os.O_RDWR | os.O_CREAT, 0o644)
    try:
        try:
            fcntl.flock(handle, fcntl.LOCK_EX | fcntl.LOCK_NB)
        except BlockingIOError:
            raise OutputError(f"{folder}: another process is working on this study; wait for it") from None
        yield
    finally:
        os.close(handle)


def line(record: dict[str, Any]) -> str:
    """One record as a line of the log."""
    return json.dumps(plain(record), sort_keys=True, allow_nan=False, separators=(",", ":")) + "\n"


def read_log(folder: Path) -> list[dict[str, Any]]:
    """The records of finished flights; an incomplete last line, from a crash or still being written, is left out."""
    path = folder / LOG
    try:
        return [json.loads(text) for text in _whole_lines(path).split(b"\n") if text]
    except ValueError:
        raise OutputError(f"{path}: is damaged; take out the line that is no JSON, or start the study --anew") from None


def mend_log(folder: Path) -> None:
    """Cut off a last line that a crash left incomplete; the caller must hold the lock."""
    path = folder / LOG
    with _write_errors(folder):
        if path.exists():
            os.truncate(path, len(_whole_lines(path)))


def _whole_lines(path: Path) -> bytes:
    with _write_errors(path.parent):
        whole, newline, _ = path.read_bytes().rpartition(b"\n") if path.exists() else (b"", b"", b"")
    return whole + newline


@contextlib.contextmanager
def appending(folder: Path) -> Iterator[Callable[[dict[str, Any]], None]]:
    """A function that adds a record to the log; what it wrote is on the disk when it returns."""
    with _write_errors(folder):
        handle = os.open(folder / LOG, os.O_WRONLY | os.O_CREAT | os.O_APPEND, 0o644)
    try:

        def append(record: dict[str, Any]) -> None:
            with _write_errors(folder):
                data = line(record).encode()
                while data:
                    data = data[os.write(handle, data) :]
                os.fsync(handle)

        yield append
    finally:
        os.close(handle)


@contextlib.contextmanager
def _write_errors(folder: Path) -> Iterator[None]:
    """Report a full or read-only disk in one sentence; finished flights stay."""
    try:
        yield
    except OSError as error:
        raise OutputError(f"{folder}: cannot be written: {error.strerror}; finished flights are kept") from None
