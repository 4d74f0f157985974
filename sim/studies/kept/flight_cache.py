"""Flights of a study kept in its folder, so that cells that differ in sensors, trackers or checks share them.

The file of a flight is named by a hash of all that decides it and contains its own digest: a damaged or foreign file
counts as absent, and so does one whose record is none that such a flight can leave. The cache is optional: on a full
disk flights are not kept, and nothing else changes.
"""

from __future__ import annotations

import contextlib
import dataclasses
import functools
import hashlib
import io
import json
import math
import os
import shutil
from pathlib import Path
from typing import Any

import numpy as np

from aircraft.identity import identity
from aircraft.state import AircraftState, Command
from sim.files import DAMAGED, read_bytes
from sim.flight.preparation import Prepared
from sim.flight.record import Event, Flight
from sim.versions import program, versions

# of a scenario, but not of its flights
WITHOUT = ("name", "flights", "draws", "sensors", "trackers", "contrasts", "checks", "study")
LARGEST_CACHE = 1 << 30  # bytes in one study folder
RESERVE = 1 << 30  # bytes of the disk that are left to others
ENDING = ".flight"
_model = functools.lru_cache(maxsize=4)(identity)  # a study flies one version of it
TIME = AircraftState._fields.index("time")


def shared(prepared: Prepared) -> bool:
    """Whether cells can share this flight: it is flown, has trackers, and none of them navigates it."""
    if prepared.recording is not None:  # a file of its own already
        return False
    return bool(prepared.scenario.trackers) and prepared.scenario.autopilot.navigation == "truth"


def key(prepared: Prepared, number: int) -> str:
    """Hash of all that decides a flight: resolved tables, seed, number, aircraft, versions, our own code and others'.

    Parts from outside count even if they are only sensors or trackers: importing their file may change anything.
    """
    scenario = prepared.scenario
    tables = {name: table for name, table in scenario.tables.items() if name not in WITHOUT}
    parts = {part.address: part.digest for part in scenario.parts}
    decides = [tables, number, versions(parts), program(), _model(scenario.aircraft.model), prepared.rate]
    return hashlib.sha256(json.dumps(decides, sort_keys=True).encode()).hexdigest()


def load(cache: Path, name: str, prepared: Prepared) -> Flight | None:
    """The kept flight of this name; None where there is none, or the file is not a whole record of it."""
    path = cache / f"{name}{ENDING}"
    try:
        digest, payload = _parted(read_bytes(path))
        if hashlib.sha256(payload).digest() != digest:
            raise ValueError("damaged")
        with np.load(io.BytesIO(payload)) as arrays:
            told = json.loads(str(arrays["told"]))
            if told["name"] != name:
                raise ValueError("another flight")
            found = _unpacked(prepared, arrays, told, "")
            if told["rollout"] is not None:
                rollout = _unpacked(prepared, arrays, told["rollout"], "rollout_")
                found = dataclasses.replace(found, rollout=rollout)
        os.utime(path, follow_symlinks=False)  # still of use
    except FileNotFoundError:
        return None
    except DAMAGED:
        with contextlib.suppress(OSError):
            path.unlink()
        return None
    return found


def _parted(content: bytes) -> tuple[bytes, bytes]:
    size = hashlib.sha256().digest_size
    return content[:size], content[size:]


def store(cache: Path, name: str, flight: Flight) -> None:
    """Keep a flight, where there is a cache with room for it."""
    rollout = flight.rollout
    told = {"name": name, **_told(flight), "rollout": None if rollout is None else _told(rollout)}
    arrays = _arrays(flight, "") | ({} if rollout is None else _arrays(rollout, "rollout_"))
    buffer = io.BytesIO()
    np.savez(buffer, told=np.array(json.dumps(told)), **arrays)
    payload = buffer.getvalue()
    partial = cache / f".{name}.{os.getpid()}.partial"
    try:
        if not _has_room(cache, len(payload)):
            return
        with partial.open("xb") as file:  # follows no link that somebody puts there
            file.write(hashlib.sha256(payload).digest() + payload)
        os.replace(partial, cache / f"{name}{ENDING}")
    except OSError:
        with contextlib.suppress(OSError):
            partial.unlink()


def _told(flight: Flight) -> dict[str, Any]:
    """What of a record is words."""
    return {"phases": flight.phases, "events": flight.events, "outcome": flight.outcome, "reason": flight.reason}


def _arrays(flight: Flight, prefix: str) -> dict[str, Any]:
    """What of a record is numbers."""
    return {
        f"{prefix}state": _as_recorded(flight.state),
        f"{prefix}command": _as_recorded(flight.command),
        f"{prefix}leg": flight.leg,
        f"{prefix}phase": flight.phase,
    }


def _unpacked(prepared: Prepared, arrays: Any, told: dict[str, Any], prefix: str) -> Flight:
    """The record of these words and numbers; raises ``ValueError`` for what no flight leaves."""
    state, command, leg, phase = (arrays[f"{prefix}{name}"] for name in ("state", "command", "leg", "phase"))
    phases, events = tuple(told["phases"]), tuple(Event(*event) for event in told["events"])
    count = len(state)
    if (state.shape, command.shape) != ((count, len(AircraftState._fields)), (count, len(Command._fields))):
        raise ValueError("signals are missing")
    if not (leg.shape == phase.shape == (count,) and leg.dtype.kind == phase.dtype.kind == "i"):
        raise ValueError("a leg or a phase is missing")
    if not (count and _within(leg, len(prepared.route.legs)) and _within(phase, len(phases))):
        raise ValueError("a leg or a phase that there is not")
    known = np.isfinite(state).all() and not np.isinf(command).any()  # NaN: a height or speed that is not held
    if not (known and (np.diff(state[:, TIME]) > 0).all()):
        raise ValueError("numbers that no flight has")
    words = (*phases, *(word for event in events for word in event[1:]), told["outcome"], told["reason"])
    if not all(isinstance(word, str) for word in words) or not all(math.isfinite(event.time) for event in events):
        raise ValueError("words that no flight has")
    return Flight(
        prepared.route,
        AircraftState(*state.T),
        Command(*command.T),
        leg,
        phase,
        phases,
        events,
        told["outcome"],
        told["reason"],
        prepared.gate_height,
    )


def _within(index: np.ndarray, count: int) -> bool:
    """Whether every index is one of so many."""
    return bool(index.min() >= 0 and index.max() < count)


def _as_recorded(columns: Any) -> np.ndarray:
    """(k, n) in the order of memory in which fly() leaves a record: sums depend on it."""
    return np.ascontiguousarray(np.array(columns).T)


def _has_room(cache: Path, size: int) -> bool:
    taken = sum(entry.stat().st_size for entry in os.scandir(cache))
    return taken + size <= LARGEST_CACHE and shutil.disk_usage(cache).free - size >= RESERVE


def prune(cache: Path, since: float) -> None:
    """Delete files not used since ``since`` (s of the file system), and files that a crash left half written."""
    for path in cache.iterdir() if cache.is_dir() else ():
        with contextlib.suppress(OSError):
            if path.suffix == ".partial" or path.lstat().st_mtime < since:
                path.unlink()
