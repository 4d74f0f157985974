"""load(): the folder of a run as the result that it was written from.

Figures, verdicts, scenario and flight are read from the files, to the last bit. Looks and tracks are in the files
without what correlates their errors, so both are made again, from the flight and the seed, when they are first looked
at, and held against the files: what differs is an error, never a silent other number.
"""

from __future__ import annotations

import contextlib
import io
import json
from collections.abc import Callable, Iterator, Mapping
from pathlib import Path
from typing import Any, TypeVar

import numpy as np

from aircraft.state import AircraftState, Command
from sim.errors import OutputError, ScenarioError
from sim.estimation.tracked.outcome import Tracked
from sim.estimation.tracking_run import track
from sim.files import DAMAGED, read_bytes, refuse_unwritten
from sim.flight.preparation import Prepared, prepare
from sim.flight.record import Event, Flight
from sim.metrics.checks import unknown_names
from sim.observation.record import SensorRecord, observe
from sim.reporting.run_files import measurement_arrays, state_name, state_of, track_arrays
from sim.results.result import Result
from sim.results.saving import FILES, FLIGHT, MEASUREMENTS, METRICS, SCENARIO, TIMING, TRACKS, WORDS
from sim.scenario import reading
from sim.scenario.plugins import Plugins
from sim.versions import versions

Value = TypeVar("Value")
AGAIN = "run its scenario.toml again"


def load(folder: str | Path, *, plugins: Plugins = (), trackers: Mapping[str, Any] | None = None) -> Result:
    """The result of a run from its folder.

    ``plugins`` bring the kinds from outside that the scenario names, and ``trackers`` the caller's own trackers again:
    a folder holds no code. Own trackers that are not brought are absent from ``tracks``; their figures are there.

    Raises ``OutputError`` in one sentence for a folder that is not of a run, is half written or damaged, or was written
    by another version.
    """
    place = Path(folder)
    _refuse_other(place)
    with _blamed(place / METRICS):
        metrics = _json(place / METRICS)
        _refuse_version(place, metrics)
        judged = {*metrics["trackers"]}
    try:
        scenario = reading.read(place / SCENARIO, plugins=plugins, checks=unknown_names)
        prepared = prepare(scenario)
    except ScenarioError as error:
        raise OutputError(f"{place}: its scenario cannot be read: {error}") from None
    with _blamed(place / FLIGHT):
        arrays = _arrays(place / FLIGHT)
        words = json.loads(str(arrays[WORDS]))
        flight, number = _flight(prepared, arrays, words), int(words["number"])
    own = dict(trackers or {})

    def looked() -> dict[str, SensorRecord]:
        found = observe(flight, scenario.sensors, scenario.seed, number, scenario.draws, scenario.sensor_faults)
        _hold(place / MEASUREMENTS, measurement_arrays(found))
        return found

    def tracked() -> dict[str, Tracked]:
        found = track(prepared, flight, dict(records), own, number)[0]
        _hold(place / TRACKS, dict(track_arrays(found)))
        return found

    records = Again(scenario.sensors, looked)
    known = [name for name in (*scenario.trackers, *own) if name in judged]
    tracks = Again(known, tracked) if known else {}
    with _blamed(place / TIMING):
        timing = _json(place / TIMING) if (place / TIMING).is_file() else {}
    return Result(prepared, number, flight, records, tracks, metrics, timing, own)


class Again(Mapping[str, Value]):
    """What is made when it is first looked at."""

    def __init__(self, names: Any, make: Callable[[], dict[str, Value]]) -> None:
        self._names, self._make = tuple(names), make
        self._made: dict[str, Value] | None = None

    def _all(self) -> dict[str, Value]:
        if self._made is None:
            self._made = self._make()
        return self._made

    def __getitem__(self, name: str) -> Value:
        return self._all()[name]

    def __iter__(self) -> Iterator[str]:
        return iter(self._all())

    def __len__(self) -> int:
        return len(self._all())

    def __repr__(self) -> str:
        state = "not made yet" if self._made is None else "made again"
        return f"<{', '.join(self._names)}: {state}>"


def _refuse_other(place: Path) -> None:
    """Raise ``OutputError`` for a folder that is not the whole folder of a run."""
    refuse_unwritten(place)
    if (place / "cache").is_dir():
        raise OutputError(f"{place}: holds a study, not a run; sim.run(..., flight=K) flies one flight of it")
    missing = [name for name in FILES if not (place / name).is_file()]
    if missing:
        raise OutputError(f"{place}: half written, {' and '.join(missing)} missing; run the scenario again")


def _refuse_version(place: Path, metrics: dict[str, Any]) -> None:
    wrote, here = metrics.get("versions", {}).get("shortfinal"), versions()["shortfinal"]
    if wrote != here:
        raise OutputError(f"{place}: written by shortfinal {wrote}, and this is {here}; {AGAIN}")


@contextlib.contextmanager
def _blamed(path: Path) -> Iterator[None]:
    """Whatever fails within is the fault of this file, which may come from anywhere."""
    try:
        yield
    except OutputError:
        raise
    except DAMAGED:
        raise OutputError(f"{path}: damaged, or of another version; {AGAIN}") from None


def _json(path: Path) -> dict[str, Any]:
    found = json.loads(read_bytes(path))
    if not isinstance(found, dict):
        raise ValueError("no table")
    return found


def _arrays(path: Path) -> dict[str, np.ndarray]:
    with np.load(io.BytesIO(read_bytes(path))) as arrays:
        return dict(arrays.items())


def _flight(prepared: Prepared, arrays: dict[str, np.ndarray], words: dict[str, Any]) -> Flight:
    """The record of these arrays and words."""
    states = state_of(arrays)
    commands = Command(*(arrays[f"command_{state_name(name)}"] for name in Command._fields))
    count, rolled = int(words["instants"]), words["rollout"]
    if len(states.time) != count + (0 if rolled is None else int(rolled["instants"])):
        raise ValueError("instants are missing")

    def part(told: dict[str, Any], rows: slice, rollout: Flight | None) -> Flight:
        return Flight(
            prepared.route,
            AircraftState(*_as_flown(states, rows)),
            Command(*_as_flown(commands, rows)),
            arrays["leg"][rows],
            arrays["phase"][rows],
            tuple(told["phases"]),
            tuple(Event(*event) for event in told["events"]),
            told["outcome"],
            told["reason"],
            told["gate_height_m"],
            rollout,
            told["utc_s"],
        )

    return part(words, slice(count), None if rolled is None else part(rolled, slice(count, None), None))


def _as_flown(columns: Any, rows: slice) -> np.ndarray:
    """(n, k) in the order of memory in which a flight leaves its record: sums depend on it."""
    return np.ascontiguousarray(np.array([column[rows] for column in columns]).T).T


def _hold(path: Path, made: dict[str, np.ndarray]) -> None:
    """Raise ``OutputError`` where arrays that were made again are not those of a file, which may hold more."""
    with _blamed(path):
        kept = _arrays(path)
        for name, array in made.items():
            if name not in kept or not np.array_equal(kept[name], array, equal_nan=array.dtype.kind == "f"):
                raise OutputError(f"{path}: holds another {name} than its scenario gives here; {AGAIN}")
