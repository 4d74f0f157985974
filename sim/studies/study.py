"""Studies: fly a scenario over the axes of its [study] table, crash-safe, and say what all flights show.

Lists and grids are choices, and the autopilot is designed for each of them; distributions are what a designer does not
know, and every sample flies with the gains of its cell's nominal scenario.
"""

from __future__ import annotations

import functools
import json
import shutil
import tomllib
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from sim.cli.doctor import versions
from sim.errors import OutputError, ScenarioError, did_you_mean
from sim.flight.preparation import prepare
from sim.metrics.checks import SCALARS
from sim.scenario.axes import Axis, Listed, cells, samples
from sim.scenario.budget import available_memory
from sim.scenario.reading import Scenario, read
from sim.scenario.tables import StudyCheck, StudyTable
from sim.scenario.toml_writer import dumps
from sim.studies import flight_cache
from sim.studies import folder as folders
from sim.studies import job as ensemble
from sim.studies.job import Job, with_values
from sim.studies.metrics import fewest_flights, study_metrics
from sim.studies.theory import THEORIES
from sim.workers.executors import Executor, Lost

LARGEST_STUDY = 100_000  # flights
RECORD_SIZE = 20_000  # bytes of one flight in the log, at most about
WORKER_SIZE = 350 << 20  # bytes of one worker, measured below this
UNDESIGNED = ("name", "seed", "flights", "draws", "until_s", "start", "wind", "sensors", "trackers", "checks")


@dataclass(frozen=True)
class Study:
    """Everything that is to be flown: all axes, every cell's resolved tables, the samples that all cells share."""

    scenario: Scenario
    table: StudyTable
    axes: tuple[Axis, ...]
    cells: tuple[dict[str, Any], ...]  # chosen values
    samples: tuple[dict[str, float], ...]  # drawn values

    @property
    def flights(self) -> int:
        """Number of flights."""
        return len(self.cells) * len(self.samples) * self.scenario.flights

    def numbers(self) -> Iterator[tuple[int, int, int]]:
        """(cell, sample, flight) of every flight, in order; a flight's number is the same in every cell."""
        each = self.scenario.flights
        for cell in range(len(self.cells)):
            for sample in range(len(self.samples)):
                for repeat in range(each):
                    yield cell, sample, sample * each + repeat


def plan(scenario: Scenario) -> Study:
    """What a study flies; raises ``ScenarioError`` for axes and checks that no flight has, before anything is flown."""
    table = scenario.study
    if table is None:
        raise ScenarioError(f"{scenario.name}: has no [study.axes]; say what is to be varied, or use 'run'")
    axes = table.varied
    faults = _faults(scenario, table, axes)
    if faults:
        raise ScenarioError("\n".join(f"{scenario.name}: {fault}" for fault in faults))
    planned = Study(scenario, table, axes, cells(axes), samples(axes, table.samples, scenario.seed))
    _refuse_too_few(planned)
    return planned


def _faults(scenario: Scenario, table: StudyTable, axes: tuple[Axis, ...]) -> list[str]:
    size = scenario.flights * table.samples
    for one in axes:
        size *= len(one.values) if isinstance(one, Listed) else 1
    if size > LARGEST_STUDY:
        return [f"[study] {size} flights are more than the budget of {LARGEST_STUDY}; take fewer values or samples"]
    faults = []
    for one in axes:
        for value in one.values if isinstance(one, Listed) else (one.first,):
            try:
                read(with_values(_flown_tables(scenario), {one.address: value}))
            except ScenarioError as error:
                faults += [f'[study] axes "{one.address}": {_said(line)}' for line in str(error).splitlines()]
                break
    if table.theory is not None:
        theory, chosen = THEORIES[table.theory], [one.address for one in axes if isinstance(one, Listed)]
        if chosen[:2] != [theory.x, theory.y]:
            faults.append(
                f'[study] theory "{table.theory}" is about the axes "{theory.x}" and "{theory.y}", in this order'
            )
    for one in table.checks:
        if one.metric not in SCALARS and not one.metric.startswith("trackers."):
            faults.append(f"[[study.checks]] no metric '{one.metric}'; {did_you_mean(one.metric, SCALARS)}")
    return faults


def _said(line: str) -> str:
    """A fault without the name of the file that nobody wrote."""
    return line.removeprefix("scenario: ").removeprefix("--set ")


def _refuse_too_few(planned: Study) -> None:
    for one in planned.table.checks:
        needed = fewest_flights(one.share, one.confidence)
        if planned.flights < needed:
            raise ScenarioError(
                f"{planned.scenario.name}: [[study.checks]] '{_name(one)}': {100 * one.share:g} % with "
                f"{100 * one.confidence:g} % confidence needs at least {needed} flights, "
                f"the study has {planned.flights}"
            )


def _name(check: StudyCheck) -> str:
    return check.name or check.metric


def _flown_tables(scenario: Scenario) -> dict[str, Any]:
    """The resolved tables of one flight."""
    return {key: value for key, value in scenario.tables.items() if key != "study" and value is not None}


def designed_cells(planned: Study) -> tuple[dict[str, Any], ...]:
    """The tables of every cell with its gains, designed once for all cells that share a design."""
    base = _flown_tables(planned.scenario)
    design = functools.cache(_designed)
    found = []
    for values in planned.cells:
        tables = with_values(base, values)
        if "designed" not in tables:
            kept = {name: value for name, value in tables.items() if name not in UNDESIGNED}
            quickness = {"autopilot": {k: v for k, v in kept.get("autopilot", {}).items() if k != "frequency_share"}}
            key = json.dumps({**kept, **quickness})  # how quick the law is changes no gain of the inner loops
            try:
                tables = {**tables, "designed": design(key)}
            except ScenarioError as error:
                where = ", ".join(f"{address} = {value}" for address, value in values.items())
                raise ScenarioError(f"{planned.scenario.name}: with {where or 'these values'}: {error}") from None
        found.append(tables)
    return tuple(found)


def _designed(text: str) -> dict[str, Any]:
    tables = json.loads(text)
    truth = {"autopilot": {**tables["autopilot"], "navigation": "truth"}}  # gains do not depend on who navigates
    return prepare(read({"name": "design", **tables, **truth})).designed.to_table()


def study(
    source: str | Path | dict[str, Any],
    folder: Path,
    executor: Executor,
    overrides: dict[str, Any] | None = None,
    *,
    anew: bool = False,
    workers: int = 1,
    progress: Callable[..., Any] | None = None,
) -> dict[str, Any]:
    """Fly a study into a folder, going on with what the folder already has of it; returns its metrics.

    Raises ``ScenarioError`` and ``OutputError`` before anything is written, ``OutputError`` when the disk fills.
    """
    scenario = read(source, overrides)
    text = dumps(scenario.tables)
    planned = plan(read_text(text))
    tables = designed_cells(planned)
    _refuse_too_much(planned, folder, workers)
    folders.open_study(folder, text, scenario.seed, anew)
    return _fly_all(planned, tables, folder, executor, progress)


def resume(
    folder: Path,
    executor: Executor,
    *,
    anyway: bool = False,
    workers: int = 1,
    progress: Callable[..., Any] | None = None,
) -> dict[str, Any]:
    """Go on with the study of a folder; its metrics are those of a study that was never interrupted."""
    planned = plan(read_text(folders.read_scenario(folder)))
    folders.check_study(folder, planned.scenario.seed, anyway)
    tables = designed_cells(planned)
    _refuse_too_much(planned, folder, workers)
    return _fly_all(planned, tables, folder, executor, progress)


def read_text(text: str) -> Scenario:
    """The scenario of a resolved file, so that a study and its resumption start from the same bytes."""
    try:
        return read(tomllib.loads(text))
    except tomllib.TOMLDecodeError as error:
        raise ScenarioError(f"{folders.SCENARIO}: not TOML: {error}") from None


def _refuse_too_much(planned: Study, folder: Path, workers: int) -> None:
    """Memory and disk that the study needs, before it starts."""
    available = available_memory()
    if available is not None and workers * WORKER_SIZE > available:
        fitting = max(1, available // WORKER_SIZE)
        raise OutputError(
            f"{workers} workers need {workers * WORKER_SIZE >> 20} MB of memory and {available >> 20} MB are free; "
            f"use -j {fitting}"
        )
    place = next((path for path in (folder, *folder.absolute().parents) if path.is_dir()), Path("."))
    free, needed = shutil.disk_usage(place).free, planned.flights * RECORD_SIZE
    if needed > free:
        raise OutputError(
            f"{folder}: {planned.flights} flights need up to {needed / 1e6:.3g} MB of disk, "
            f"and {free / 1e6:.3g} MB are free"
        )


def _fly_all(
    planned: Study,
    tables: tuple[dict[str, Any], ...],
    folder: Path,
    executor: Executor,
    progress: Callable[..., Any] | None,
) -> dict[str, Any]:
    with folders.locked(folder):
        folders.mend_log(folder)
        records = {_key(record): record for record in folders.read_log(folder)}
        cache = str(folders.flights_of(folder).resolve())
        waiting = [
            Job(cell, sample, flight, {**planned.cells[cell], **planned.samples[sample]}, tables[cell], drawn, cache)
            for cell, sample, flight in planned.numbers()
            for drawn in (planned.samples[sample],)
            if (cell, sample, flight) not in records
        ]
        for number, job in enumerate(waiting):
            executor.submit(number, ensemble.fly, job)
        ended: Any = executor.finished()
        if progress is not None and waiting:
            ended = progress(ended, len(waiting), "flights")
        try:
            with folders.appending(folder) as append:
                for number, result in ended:
                    job = waiting[number]
                    record = ensemble.lost(job, result.reason) if isinstance(result, Lost) else result
                    append(record)
                    records[_key(record)] = record
        finally:
            executor.close()
        metrics = _finish(planned, folder, records)
        flight_cache.prune(folders.flights_of(folder), folders.begun(folder))
        return metrics


def _key(record: dict[str, Any]) -> tuple[int, int, int]:
    return record["cell"], record["sample"], record["flight"]


def _finish(planned: Study, folder: Path, records: dict[tuple[int, int, int], dict[str, Any]]) -> dict[str, Any]:
    """Sort the log and write what all flights show; every file is whole or the old one."""
    from sim.studies.page import page

    lines = [folders.line(records[key]) for key in sorted(records)]
    ordered = [json.loads(line) for line in lines]  # as a resumed study reads them
    scenario = planned.scenario
    metrics = {
        "scenario": scenario.name,
        "seed": scenario.seed,
        "flights": len(ordered),
        "samples": planned.table.samples,
        "versions": versions(),
        **study_metrics(planned.axes, ordered, scenario.checks, planned.table.checks),
    }
    try:
        folders.replace(folder / folders.LOG, "".join(lines))
        folders.replace(folder / "report.html", page(scenario, metrics, ordered))
        folders.replace_json(folder / "metrics.json", metrics)
    except OSError as error:
        raise OutputError(f"{folder}: cannot be written: {error.strerror}; finished flights are kept") from None
    return metrics
