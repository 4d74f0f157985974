"""Studies: fly a scenario over the axes of its [study] table, crash-safe, and say what all flights show.

Lists and grids are choices, and the autopilot is designed for each of them; distributions are what a designer does not
know, and every sample flies with the gains of its cell's nominal scenario.
"""

from __future__ import annotations

import json
import shutil
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any

from sim.errors import OutputError
from sim.estimation.own_trackers import OwnTrackers, check_own, digests_of_own, packed
from sim.experiment import read
from sim.files import plain, replace, replace_json
from sim.flight.preparation import prepare
from sim.reporting.text.broken_checks import Again
from sim.scenario.budget import refuse_workers
from sim.scenario.plugins import Catalogue, Plugins, catalogue_with, digests
from sim.scenario.reading import Source
from sim.scenario.toml_writer import dumps
from sim.studies import folder as folders
from sim.studies.job import Job, fly, lost
from sim.studies.kept import finished, flight_cache, flight_log
from sim.studies.limits.answer import answer
from sim.studies.limits.maps import ratio_maps
from sim.studies.metrics import named, study_metrics
from sim.studies.plan import Study, designed_cells, plan, read_text
from sim.studies.theory import predicted_figures
from sim.versions import versions
from sim.workers.executors import Executor, Lost, refuse_small_limit

RECORD_SIZE = 20_000  # bytes of one flight in the log, at most about


def study(
    source: Source,
    folder: Path,
    executor: Executor,
    overrides: Mapping[str, Any] | None = None,
    *,
    trackers: OwnTrackers | None = None,
    plugins: Plugins = (),
    anew: bool = False,
    workers: int = 1,
    progress: Callable[..., Any] | None = None,
    remark: Callable[[str], None] | None = None,
) -> dict[str, Any]:
    """Fly a study into a folder, going on with what the folder already has of it; returns its metrics.

    ``trackers`` are the caller's own, on every flight. ``plugins`` bring kinds that are not bundled: paths of files, or
    imported modules, with a table ``SHORTFINAL``. ``remark`` is called with what is to be known, also of lines of the
    folder's log that had to be left out.

    Raises ``ScenarioError`` and ``OutputError`` before anything is written, ``OutputError`` when the disk fills.
    """
    catalogue = catalogue_with(plugins)
    scenario = read(source, overrides, plugins=catalogue)
    text = dumps(scenario.tables)
    done = None if anew or trackers else finished.metrics_of(folder, text, catalogue)
    if done is not None:
        _say(remark, folders.another_processor(folder))
        return done
    planned = plan(read_text(text.encode(), catalogue), catalogue, trackers or ())
    tables = designed_cells(planned)
    if trackers:
        check_own(prepare(read(tables[0], plugins=catalogue)), trackers)
    _refuse_too_much(planned, folder, workers)
    folders.open_study(folder, text, scenario.seed, anew, planned.parts, digests_of_own(trackers or {}))
    _say(remark, folders.another_processor(folder))
    return _fly_all(planned, tables, folder, executor, catalogue, progress, remark, trackers)


def resume(
    folder: Path,
    executor: Executor,
    *,
    plugins: Any = (),
    anyway: bool = False,
    workers: int = 1,
    progress: Callable[..., Any] | None = None,
    remark: Callable[[str], None] | None = None,
) -> dict[str, Any]:
    """Go on with the study of a folder; its metrics are those of a study that was never interrupted.

    ``plugins`` bring the same parts from outside again: a folder holds no code. ``remark`` is called with a sentence
    about lines of the folder's log that had to be left out.
    """
    text, catalogue = folders.read_scenario(folder), catalogue_with(plugins)
    folders.check_parts(folder, catalogue)
    scenario = read_text(text, catalogue)
    done = finished.metrics_of(folder, text.decode("utf-8-sig"), catalogue)
    if done is not None:
        _say(remark, folders.another_processor(folder))
        return done
    planned = plan(scenario, catalogue)
    folders.check_study(folder, planned.scenario.seed, anyway, planned.parts)
    _say(remark, folders.another_processor(folder))
    tables = designed_cells(planned)
    _refuse_too_much(planned, folder, workers)
    return _fly_all(planned, tables, folder, executor, catalogue, progress, remark)


def _say(remark: Callable[[str], None] | None, sentence: str | None) -> None:
    if remark is not None and sentence is not None:
        remark(sentence)


def _refuse_too_much(planned: Study, folder: Path, workers: int) -> None:
    """Memory and disk that the study needs, before it starts."""
    refuse_workers(workers)
    if workers:
        refuse_small_limit()
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
    catalogue: Catalogue,
    progress: Callable[..., Any] | None,
    remark: Callable[[str], None] | None,
    own: OwnTrackers | None = None,
) -> dict[str, Any]:
    with folders.locked(folder):
        stamp = folders.stamp(folder)
        again = folders.run_again_there(planned.parts)
        found = _finished(planned, folder, stamp, remark)
        records = {place: named(record, planned.axes, again) for place, record in found.items()}
        cache = str(folders.flights_of(folder).resolve())
        sent = packed(own) if own else None
        waiting = [
            Job(cell, sample, flight, {**planned.cells[cell], **drawn}, tables[cell], drawn, cache, planned.parts, sent)
            for cell, sample, flight in planned.numbers()
            for drawn in (planned.samples[sample],)
            if (cell, sample, flight) not in records
        ]
        for number, job in enumerate(waiting):
            executor.submit(number, fly, job)
        ended: Any = executor.finished()
        if progress is not None and waiting:
            ended = progress(ended, len(waiting), "flights")
        try:
            with flight_log.appending(folder, stamp) as append:
                for number, result in ended:
                    job = waiting[number]
                    record = lost(job, result.reason) if isinstance(result, Lost) else result
                    record = named(record, planned.axes, again)
                    append(record)
                    records[flight_log.place_of(record)] = record
        finally:
            executor.close()
        metrics = _finish(planned, folder, records, stamp, again)
        flight_cache.prune(folders.flights_of(folder), folders.begun(folder))
        if not own:  # of a tracker that the caller brings, the text of the scenario says nothing
            finished.remember(folder, folders.read_scenario(folder).decode("utf-8-sig"), catalogue)
        return metrics


def _finished(
    planned: Study, folder: Path, stamp: str, remark: Callable[[str], None] | None
) -> dict[flight_log.Place, dict[str, Any]]:
    """The records that the log has of flights of this study; what else it has is taken out, with a remark."""
    values = {
        (cell, sample, flight): {**planned.cells[cell], **planned.samples[sample]}
        for cell, sample, flight in planned.numbers()
    }
    log = flight_log.read(folder, stamp, flight_log.Planned(values, len(planned.scenario.checks)))
    with flight_log.write_errors(folder):
        if (folder / flight_log.LOG).exists():
            flight_log.rewrite(folder, stamp, log.records)  # a file of its own, whatever other names the old one has
    if log.faults and remark is not None:
        count = "one line is" if len(log.faults) == 1 else f"{len(log.faults)} lines are"
        remark(f"{folder / flight_log.LOG}: {count} left out ({log.faults[0]}); what is missing is flown again")
    return log.records


def _finish(
    planned: Study, folder: Path, records: dict[flight_log.Place, dict[str, Any]], stamp: str, again: Again
) -> dict[str, Any]:
    """Sort the log and write what all flights show; every file is whole or the old one."""
    from sim.studies.page import page

    ordered = [json.loads(json.dumps(plain(records[place]), sort_keys=True)) for place in sorted(records)]  # as resumed
    scenario = planned.scenario
    metrics = {
        "scenario": scenario.name,
        "seed": scenario.seed,
        "flights": len(ordered),
        "samples": planned.table.samples,
        "versions": versions(digests(planned.parts)),
        **study_metrics(planned.axes, ordered, scenario.checks, again, scenario.contrasts),
    }
    predicted, maps = predicted_figures(scenario, metrics["rows"]), ratio_maps(scenario, metrics)
    metrics |= {"predicted": predicted} if predicted else {}
    metrics |= {"answer": answer(scenario.contrasts[0], maps)} if scenario.contrasts else {}
    try:
        flight_log.rewrite(folder, stamp, records)
        replace_json(folder / "metrics.json", metrics)
        replace(folder / "report.html", page(scenario, metrics, ordered, again, maps))
    except OSError as error:
        raise OutputError(f"{folder}: cannot be written: {error.strerror}; finished flights are kept") from None
    return metrics
