"""The folder of a study: whose it is, and that only one process at a time works in it."""

from __future__ import annotations

import contextlib
import fcntl
import hashlib
import json
import os
from collections.abc import Iterable, Iterator, Mapping
from pathlib import Path
from typing import Any

from sim.errors import OutputError
from sim.estimation.own_trackers import OWN
from sim.files import claim, opened, read_bytes, refuse_links, replace
from sim.reporting.text.broken_checks import Again, run_again
from sim.scenario.plugins import FAMILIES, Catalogue, Part, digests
from sim.studies.kept.flight_log import LOG, write_errors
from sim.versions import processor, rows, versions

SCENARIO, IDENTITY = "scenario.toml", "cache/identity.json"
RESULTS = ("metrics.json", "report.html")
PROCESSOR = "processor"  # of the identity: another is a remark, because it moves last digits only


def identity(text: str, seed: int, parts: Iterable[Part] = (), own: Mapping[str, str] | None = None) -> dict[str, Any]:
    """What decides the numbers of a study: its scenario file, its seed and the versions of all that computes.

    ``own`` are digests of the caller's trackers by their address.
    """
    scenario = hashlib.sha256(text.encode()).hexdigest()
    return {
        "seed": seed,
        "scenario": scenario,
        "versions": versions(digests(parts) | dict(own or {})),
        PROCESSOR: processor(),
    }


def open_study(
    folder: Path,
    text: str,
    seed: int,
    anew: bool = False,
    parts: Iterable[Part] = (),
    own: Mapping[str, str] | None = None,
) -> None:
    """Make a folder that of this study: new, or the same study's; ``anew`` throws another study away.

    Raises ``OutputError`` with one sentence.
    """
    mine = identity(text, seed, parts, own)
    claim(folder, "study")
    begun = (folder / IDENTITY).is_file() and not anew
    if begun and _deciding(theirs := identity_of(folder)) != _deciding(mine):
        raise OutputError(f"{folder}: holds {_difference(theirs, mine)}; choose another folder with -o, or --anew")
    with write_errors(folder):
        flights_of(folder).mkdir(parents=True, exist_ok=True)
    with locked(folder), write_errors(folder):
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
    for address, digest in identity_of(folder).get("versions", {}).get("parts", {}).items():
        if address.partition(".")[0] == OWN:
            name = address.partition(".")[2]
            raise OutputError(f"{folder}: was begun from Python with a tracker '{name}'; go on there: sim.study")
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
    theirs, mine = identity_of(folder), identity(read_scenario(folder).decode(), seed, parts)
    if _deciding(theirs) != _deciding(mine) and not anyway:
        raise OutputError(f"{folder}: holds {_difference(theirs, mine)}; resume it with --anyway to go on all the same")


def another_processor(folder: Path) -> str | None:
    """What to know of a study that was begun on another kind of processor; None = nothing."""
    theirs = identity_of(folder).get(PROCESSOR, processor())
    if theirs == processor():
        return None
    return (
        f"{folder}: was begun on another kind of processor ({theirs}; here {processor()}): "
        "its flights and those flown here may differ in their last digits"
    )


def _deciding(identity: dict[str, Any]) -> dict[str, Any]:
    """What of an identity must be the same to go on."""
    return {name: value for name, value in identity.items() if name != PROCESSOR}


def read_scenario(folder: Path) -> bytes:
    """The resolved scenario file of a study folder, which may come from somebody else."""
    refuse_links(folder)
    try:
        return read_bytes(folder / SCENARIO)
    except OSError as error:
        why = f"it has no {SCENARIO}" if isinstance(error, FileNotFoundError | NotADirectoryError) else error.strerror
        raise OutputError(f"{folder}: is no study folder: {why}") from None


def stamp(folder: Path) -> str:
    """What the lines of a folder's log must belong to."""
    return hashlib.sha256(json.dumps(_deciding(identity_of(folder)), sort_keys=True).encode()).hexdigest()


def identity_of(folder: Path) -> dict[str, Any]:
    """What a folder says of its study; raises ``OutputError`` where it says nothing that `identity` gives."""
    try:
        found = json.loads(read_bytes(folder / IDENTITY))
        if not _is_identity(found):
            raise ValueError("another thing")
    except (OSError, ValueError, RecursionError) as error:
        why = f"it has no {IDENTITY}" if isinstance(error, FileNotFoundError) else f"its {IDENTITY} is damaged"
        raise OutputError(f"{folder}: is no study folder: {why}") from None
    identity: dict[str, Any] = found
    return identity


def _is_identity(found: Any) -> bool:
    """Whether this is what `identity` gives, of whatever release."""
    if not isinstance(found, dict) or not {"seed", "scenario", "versions"} <= set(found):
        return False
    versions = found["versions"]
    parts = versions.get("parts", {}) if isinstance(versions, dict) else None
    if type(found["seed"]) is not int or not isinstance(parts, dict):
        return False
    words = [found["scenario"], *(version for name, version in versions.items() if name != "parts"), *parts.values()]
    known = all(address.partition(".")[0] in (*FAMILIES, OWN) and "." in address for address in parts)
    return known and all(isinstance(word, str) and word.isprintable() for word in (*words, *versions, *parts))


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
    with write_errors(folder):
        handle = opened(folder / "cache" / "lock", os.O_RDWR | os.O_CREAT)
    try:
        try:
            fcntl.flock(handle, fcntl.LOCK_EX | fcntl.LOCK_NB)
        except BlockingIOError:
            raise OutputError(f"{folder}: another process is working on this study; wait for it") from None
        yield
    finally:
        os.close(handle)
