"""The flights of a run or a study as recordings of traffic: a file of tracks, and a file of their runway beside it."""

from __future__ import annotations

import json
import os
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from aircraft.state import AircraftState
from sim import experiment
from sim.errors import OutputError, ScenarioError
from sim.files import DAMAGED, opened, read_bytes, refuse_unwritten, whole
from sim.interchange.track_record import TrackRecord
from sim.interchange.track_writer import MOST, refuse_format, write_tracks
from sim.metrics.ensemble.verdict import CRASHED
from sim.observation.as_recorded import as_seen, exact, records_traffic
from sim.observation.record import SensorRecord, observe
from sim.reporting.run_files import state_of
from sim.scenario.model import Scenario
from sim.scenario.plugins import Part, catalogue_with
from sim.scenario.reading import read as read_tables
from sim.scenario.toml_writer import dumps
from sim.studies import folder as folders
from sim.studies.job import with_values
from sim.studies.kept import flight_cache
from sim.studies.plan import designed_cells, plan, read_text
from sim.workers.executors import LocalExecutor, Lost, refuse_small_limit

DATE = 1767268800.0  # s since 1970: 2026-01-01, 12 h UTC, when the first flight begins unless told
APART = 1800.0  # s between the beginnings of two flights: none lasts longer
RUNWAY, TRACKS = "runway.toml", "recordings.csv"
PLACED = ("runway", "air")  # tables that the reader of a recording needs
Progress = Callable[..., Any] | None


class Wanted(NamedTuple):
    """One flight that is to be flown again, by what decides it."""

    name: str
    tables: dict[str, Any]
    number: int
    begins: float
    cache: str | None = None
    parts: tuple[Part, ...] = ()


class Written(NamedTuple):
    """What was written."""

    files: tuple[Path, Path]
    flights: int
    rows: int
    lost: tuple[str, ...]  # flights that are not there, each with its reason


def write_recordings(
    folder: Path,
    out: Path | None = None,
    *,
    date: float = DATE,
    workers: int = 1,
    plugins: Any = (),
    progress: Progress = None,
) -> Written:
    """Write the flights of a folder as recordings, ``recordings.csv`` in it unless told; the runway's file beside it.

    The flight that a run has kept is taken from it; all others are flown again, those of a study unless its folder has
    kept them. With a sensor that says what traffic does (``kind = "adsb"``) they have the errors of its first draw,
    else they are exact, a row each second. The flights begin half an hour after one another, the first at ``date`` (s
    since 1970).

    Raises ``OutputError`` and ``ScenarioError`` in a sentence, before anything is written.
    """
    path = folder / TRACKS if out is None else out
    refuse_format(path)
    refuse_unwritten(folder)
    if not path.parent.is_dir():
        raise OutputError(f"{path.parent}: no such folder to write into")
    source = _of_study if (folder / folders.IDENTITY).is_file() else _of_run
    scenario, kept, wanted = source(folder, date, catalogue_with(plugins))
    if len(kept) + len(wanted) > MOST:
        raise OutputError(f"{folder}: its {len(kept) + len(wanted)} flights are more than the {MOST} of one file")
    place = path.parent / RUNWAY
    text = dumps({name: scenario.tables[name] for name in PLACED if scenario.tables.get(name)})
    _refuse_other(path, place, text, folder)
    lost: list[str] = []
    with whole(path) as partial:
        tracks = _all(kept, wanted, workers, lost, progress)
        flights, rows = write_tracks(partial, tracks, format_of=path)
        if not flights:
            raise OutputError(f"{folder}: none of its flights could be flown: {lost[0]}")
    with whole(place) as partial:
        partial.write_text(text, encoding="utf-8")
    return Written((path, place), flights, rows, tuple(lost))


def _refuse_other(path: Path, place: Path, text: str, folder: Path) -> None:
    """Raise ``OutputError`` where a file is that is not of this folder, or the runway of other tracks."""
    if path.parent.resolve() == folder.resolve():
        return
    if path.exists() or path.is_symlink():
        raise OutputError(f"{path}: exists already; choose another name with -o")
    if place.is_symlink() or (place.exists() and read_bytes(place) != text.encode()):
        raise OutputError(f"{place}: exists already and is another runway; choose another folder with -o")


Source = tuple[Scenario, list[TrackRecord], list[Wanted]]


def _of_run(folder: Path, date: float, catalogue: Any) -> Source:
    """The flight that a run has kept, and those that are to be flown again."""
    scenario = experiment.read(str(folder / folders.SCENARIO), plugins=catalogue)
    try:
        metrics = json.loads(read_bytes(folder / "metrics.json"))
        each = [one["flight"] for one in metrics.get("each_flight", ()) if one["metrics"]["outcome"] != CRASHED]
        state = state_of(_arrays(folder / "flight.npz"))
        kept = [_kept(scenario, state, _arrays(folder / "measurements.npz"), date)]
    except FileNotFoundError as error:
        raise OutputError(f"{error.filename}: missing; run the scenario again") from None
    except DAMAGED:
        raise OutputError(f"{folder}: damaged; run the scenario again") from None
    tables = {**scenario.tables, "study": None}
    wanted = [
        Wanted(f"{scenario.name}_{number}", tables, number, date + APART * (place + 1), parts=scenario.parts)
        for place, number in enumerate(each[1:])
    ]
    return scenario, kept, wanted


def _arrays(path: Path) -> dict[str, np.ndarray]:
    with os.fdopen(opened(path, os.O_RDONLY), "rb") as file, np.load(file) as arrays:
        return dict(arrays.items())


def _kept(scenario: Scenario, state: AircraftState, measured: dict[str, np.ndarray], begins: float) -> TrackRecord:
    """The flight of a run's folder, as its sensor saw it where it has one for that."""
    name = _recorder(scenario)
    if name is None:
        return exact(scenario.name, state, scenario.runway, scenario.air, begins)
    time, z = measured[f"{name}.time_s"], measured[f"{name}.z"]
    seen = SensorRecord(scenario.sensors[name].channels, time, time, z, np.empty(0))
    return as_seen(scenario.name, seen, scenario.runway, scenario.air, begins)


def _recorder(scenario: Scenario) -> str | None:
    """The first sensor that measures what recordings hold."""
    return next((name for name, sensor in scenario.sensors.items() if records_traffic(sensor)), None)


def _of_study(folder: Path, date: float, catalogue: Any) -> Source:
    """The flights of a study, each with what decides it."""
    folders.check_parts(folder, catalogue)
    planned = plan(read_text(folders.read_scenario(folder), catalogue), catalogue)
    folders.check_study(folder, planned.scenario.seed, False, planned.parts)
    if moved := [axis.address for axis in planned.axes if axis.address.split(".")[0] in PLACED]:
        raise OutputError(
            f"{folder}: its flights differ in {moved[0]}; a file of recordings has one runway and one air"
        )
    tables, name = designed_cells(planned), planned.scenario.name
    cache = str(folders.flights_of(folder).resolve())
    wanted = []
    for place, (cell, sample, number) in enumerate(planned.numbers()):
        own = name + (f"_{cell}" if len(planned.cells) > 1 else "") + f"_{number}"
        flown = with_values(tables[cell], planned.samples[sample])
        wanted.append(Wanted(own, flown, number, date + APART * place, cache, planned.parts))
    return planned.scenario, [], wanted


def _all(
    kept: list[TrackRecord], wanted: list[Wanted], workers: int, lost: list[str], progress: Progress
) -> Iterator[TrackRecord]:
    """The tracks in the order in which they are wanted, as workers end them; ``lost`` is told which are not there."""
    yield from kept
    if not wanted:
        return
    refuse_small_limit()
    executor = LocalExecutor(min(workers, len(wanted)))
    try:
        for place, one in enumerate(wanted):
            executor.submit(place, _flown, one)
        ended: Any = executor.finished()
        ended = progress(ended, len(wanted), "flights") if progress is not None else ended
        waiting: dict[int, Any] = {}
        following = 0
        for place, found in ended:
            waiting[place] = found
            while following in waiting:
                done = waiting.pop(following)
                if isinstance(done, Lost):
                    lost.append(f"{wanted[following].name}: {done.reason}")
                else:
                    yield done
                following += 1
    finally:
        executor.close()


def _flown(wanted: Wanted) -> TrackRecord | Lost:
    """In a worker: a flight that was kept, or is flown again, as a recording."""
    text = json.dumps(wanted.tables)
    try:
        prepared = experiment.prepared_from(text, wanted.parts)
        flight = None
        if wanted.cache is not None and flight_cache.shared(prepared):
            key = flight_cache.key(prepared, wanted.number)
            flight = flight_cache.load(Path(wanted.cache), key, prepared)
        if flight is None:
            flight = experiment.fly(prepared, wanted.number)
    except ScenarioError as error:
        return Lost(str(error))
    scenario = read_tables(json.loads(text), plugins=wanted.parts)
    name = _recorder(scenario)
    begins = wanted.begins if flight.utc is None else flight.utc
    where = scenario.runway, scenario.air, begins
    if name is None:
        return exact(wanted.name, flight.whole.state, *where)
    sensors = {name: scenario.sensors[name]}
    seen = observe(flight, sensors, scenario.seed, wanted.number, 1, scenario.sensor_faults)[name]
    return as_seen(wanted.name, seen, *where)
