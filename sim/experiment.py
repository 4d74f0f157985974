"""The verbs of a run in order: fly, observe, track, report; and ``run``, which does them all.

``evaluate`` is what every door does with a flight, and ``record_of`` what is kept of it; the verdict over the records
of all flights is given by ``sim.metrics.ensemble.verdict``.
"""

from __future__ import annotations

import dataclasses
import functools
import json
import time
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any, NamedTuple

from sim.errors import ScenarioError
from sim.estimation import assumed_height
from sim.estimation.navigation_errors import erring_navigator
from sim.estimation.navigator import navigator
from sim.estimation.own_trackers import OwnTrackers, check_own, packed, unpacked
from sim.estimation.setup import check, height_profile
from sim.estimation.tracked.outcome import Tracked
from sim.estimation.tracking_run import track
from sim.files import claim, plain, refuse_foreign, staged, write_json
from sim.flight import loop as flights
from sim.flight.departures import with_departure_events
from sim.flight.preparation import Prepared, prepare
from sim.flight.record import Flight
from sim.metrics.checks import evaluate_checks, unknown_names
from sim.metrics.contrasts.pairing import contrasts_of_flight
from sim.metrics.ensemble.contrasts import contrasts_over_flights
from sim.metrics.ensemble.spread import summary
from sim.metrics.ensemble.trackers import over_flights
from sim.metrics.ensemble.verdict import CRASHED, refuse_unfit, verdicts, worst_first
from sim.metrics.flight import flight_metrics
from sim.metrics.navigation import navigation_quality
from sim.observation import recordings
from sim.observation.faults import with_fault_events
from sim.observation.record import SensorRecord, observe
from sim.reporting.text.warnings import contrast_warnings, skipped_looks, unjudged, warnings
from sim.results.result import Result, timed
from sim.results.saving import TIMING, write_files
from sim.scenario import reading
from sim.scenario.axes import samples
from sim.scenario.budget import TOGETHER, refuse_too_much, refuse_workers
from sim.scenario.model import Scenario
from sim.scenario.plugins import Catalogue, Part, Plugins, catalogue_with, digests, load_parts, said
from sim.scenario.reading import Source
from sim.scenario.tables import Check
from sim.versions import versions
from sim.workers.executors import FLIGHT_TIME_LIMIT, LocalExecutor, Lost, refuse_small_limit
from sim.workers.isolation import run_isolated
from sim.workers.sharing import helper

if TYPE_CHECKING:
    from sim.reporting.run_page import Seen

FEW = 4  # trackers are done before a helper process has got ready
SHOWN = 3  # flights that a report draws


def read(source: Source, overrides: Mapping[str, Any] | None = None, *, plugins: Plugins = ()) -> Scenario:
    """A scenario from a file, a bundled name or a dict of tables, with ``{"table.key": value}`` overrides.

    ``plugins`` bring kinds that are not bundled: paths of files, or imported modules, with a table ``SHORTFINAL``.

    Raises ``ScenarioError`` with one line for each fault, metrics and phases of checks that no flight has among them.
    """
    return reading.read(source, overrides, plugins=plugins, checks=unknown_names)


def fly(prepared: Prepared | Scenario | str, flight: int = 0) -> Flight:
    """Fly one flight of a prepared scenario; ``flight`` addresses its turbulence."""
    if not isinstance(prepared, Prepared):
        prepared = prepare(prepared if isinstance(prepared, Scenario) else read(prepared))
    return run_isolated(prepared.scenario, FLIGHT_TIME_LIMIT, _fly, prepared, flight)


def _fly(prepared: Prepared, number: int) -> Flight:
    scenario = prepared.scenario
    if prepared.recording is not None:
        return with_fault_events(prepared.recording, scenario.sensor_faults)
    try:
        flight = flights.fly(
            prepared.vehicle,
            prepared.controller,
            prepared.initial,
            prepared.wind(number),
            prepared.limits,
            prepared.phases,
            navigator(prepared, number) or erring_navigator(prepared, number),
            prepared.gate_height,
        )
    except Exception as error:
        place = scenario.part_at_fault(error)
        if place is None:
            raise
        raise ScenarioError(f"{scenario.name}: {place} raises {said(error)} in flight") from None
    return with_fault_events(with_departure_events(flight, scenario.departures), scenario.sensor_faults)


def run(
    source: Source | Scenario,
    *,
    seed: int | None = None,
    flights: int | None = None,
    draws: int | None = None,
    flight: int | None = None,
    workers: int = 1,
    overrides: Mapping[str, Any] | None = None,
    trackers: OwnTrackers | None = None,
    plugins: Plugins = (),
    progress: Callable[..., Any] | None = None,
    remark: Callable[[str], None] | None = None,
) -> Result:
    """Read, fly, observe, track and judge a scenario.

    Parameters
    ----------
    source : a file, a bundled name, a dict of tables or a scenario
    flight : the number of one flight, to fly it alone; of a study with what is drawn for it
    workers : processes that share the flights beside the first; the numbers do not depend on it
    overrides : ``{"table.key": value}`` in the spelling of files
    trackers : further trackers by name: objects of the ``tracking.track.Tracker`` protocol, which listen to all sensors
        that they can read, or what `sim.tracker` makes of them
    plugins : what brings kinds that are not bundled: paths of files, or imported modules, with a table ``SHORTFINAL``
    remark : called with each warning that is known before anything flies

    Raises ``ScenarioError`` for anything that cannot be run.
    """
    if workers < 1:
        raise ScenarioError(f"workers must be at least 1, not {workers}")
    timing: dict[str, float] = {}
    with timed(timing, "prepare_s"):
        given = {"seed": seed, "flights": flights, "draws": draws}
        changes = {**(overrides or {}), **{key: value for key, value in given.items() if value is not None}}
        catalogue = catalogue_with(plugins)
        if isinstance(source, Scenario):
            catalogue, source = catalogue.also(source.parts), source.tables
        scenario = read(source, changes, plugins=catalogue)
        if flight is None:
            refuse_too_much(scenario)
            refuse_workers(workers if workers > 1 else 0)
            refuse_unfit_run(scenario, trackers or {})
        else:
            scenario = drawn_for(scenario, flight, catalogue)
            known = (*scenario.trackers, *(trackers or {}))
            refuse_unfit(scenario.name, (), 1, known, contrasts=scenario.contrasts)
        prepared = prepare(scenario)
        check(prepared)
        check_own(prepared, trackers)
    if remark is not None:
        for sentence in prepared.warnings:
            remark(sentence)
    checks = scenario.checks if flight is None else tuple(map(of_one_flight, scenario.checks))
    numbers = range(scenario.repetitions) if flight is None else (flight,)
    crashes, number, flown, found = _first(prepared, numbers, trackers, timing)
    if found.navigated is not None:
        found.navigated["on_truth"] = _on_truth(prepared, number)
    records = [*crashes, record_of(number, found)]
    with timed(timing, "other_flights_s"):
        records += _others(prepared, numbers[len(records) :], trackers, workers, progress)
    before = _until(flown, found.records)
    trackers_found = found.trackers if len(records) == 1 else over_flights(records)
    contrasts = contrasts_over_flights(scenario.contrasts, records)
    told = [
        *prepared.warnings,
        *warnings(flown, found.flight, scenario.sensors, before, found.trackers),
        *unjudged(flown, checks, found.checks),
        *skipped_looks(records),
        *contrast_warnings(contrasts, trackers_found),
        *(assumed_height.remarks(prepared, flown, before) if flown.known else ()),
        *recordings.remarks(flown, scenario.sensors, found.records),
    ]
    metrics = {
        "scenario": scenario.name,
        "seed": scenario.seed,
        "flights": len(records),
        "draws": scenario.draws,
        "versions": versions(digests(scenario.parts)),
        "flight": {**found.flight, "navigated": found.navigated},
        "flights_summary": summary(records),
        "trackers": trackers_found,
        "contrasts": contrasts,
        "checks": verdicts(checks, records),
        "warnings": [*told, *_about_study(scenario)] if flight is None else told,
    }
    if len(records) > 1:
        metrics["each_flight"] = records
    own = dict(trackers or {})
    return Result(prepared, number, flown, found.records, found.tracks, metrics, timing | found.timing, own)


def refuse_unfit_run(scenario: Scenario, own: Iterable[str] = ()) -> None:
    """Raise ``ScenarioError`` for checks that the flights of a run cannot answer; ``own`` are the caller's trackers."""
    more = "" if scenario.study is None else "; 'study' flies its [study]"
    known = (*scenario.trackers, *own)
    refuse_unfit(scenario.name, scenario.checks, scenario.repetitions, known, more, scenario.contrasts)


def _about_study(scenario: Scenario) -> list[str]:
    """A run of a scenario whose study varies something says that it is not the study."""
    if scenario.study is None or not scenario.study.varied:
        return []
    return ["these verdicts are about the scenario as it stands, not about its [study]: 'study' flies that"]


def of_one_flight(asked: Check) -> Check:
    """A check as it is asked of one flight alone."""
    return dataclasses.replace(asked, share=None, confidence=None, probability_max=None)


def drawn_for(scenario: Scenario, flight: int, catalogue: Catalogue) -> Scenario:
    """The scenario of one flight: of a study with the values that are drawn for it, and gains designed without them.

    Raises ``ScenarioError`` for a flight that the scenario, or each cell of its study, does not have.
    """
    drawn = 1 if scenario.study is None else scenario.study.samples
    if not 0 <= flight < scenario.flights * drawn:
        last = scenario.flights * drawn - 1
        raise ScenarioError(f"{scenario.name}: flight: there are flights 0 to {last}, not {flight}")
    if scenario.study is None:
        return scenario
    values = samples(scenario.study.varied, drawn, scenario.seed)[flight // scenario.flights]
    if not values:
        return scenario
    if scenario.record is not None:  # nothing is designed for it
        return read(scenario.tables, values, plugins=catalogue)
    gains = prepare(scenario).gains.designed.to_table()
    return read({**scenario.tables, "designed": gains}, values, plugins=catalogue)


def _first(
    prepared: Prepared, numbers: Sequence[int], own: OwnTrackers | None, timing: dict[str, float]
) -> tuple[list[dict[str, Any]], int, Flight, Evaluation]:
    """The first flight that has an end, with its number, and records of those before; raises where none has."""
    crashes: list[dict[str, Any]] = []
    while True:
        number = numbers[len(crashes)]
        try:
            with timed(timing, "fly_s"):
                flight = fly(prepared, number)
            return crashes, number, flight, evaluate(prepared, flight, number, own)
        except ScenarioError as error:
            if number == numbers[-1]:
                raise
            crashes.append(lost_record(number, str(error)))


def _others(
    prepared: Prepared,
    numbers: Sequence[int],
    own: OwnTrackers | None,
    workers: int,
    progress: Callable[..., Any] | None,
) -> list[dict[str, Any]]:
    """Records of further flights, in their order."""
    if not numbers:
        return []
    found: dict[int, dict[str, Any]] = {}
    ended: Iterable[tuple[int, Any]] = _elsewhere(prepared, numbers, own, workers)
    if workers == 1:
        ended = ((number, recorded(prepared, number, own)) for number in numbers)
    for number, record in progress(ended, len(numbers), "flights") if progress is not None else ended:
        found[number] = lost_record(number, record.reason) if isinstance(record, Lost) else record
    return [found[number] for number in numbers]


def _elsewhere(
    prepared: Prepared, numbers: Sequence[int], own: OwnTrackers | None, workers: int
) -> Iterator[tuple[int, Any]]:
    """Number and record of flights, or ``Lost``, as worker processes end them."""
    tables = {**prepared.scenario.tables, "designed": prepared.design, "study": None}
    refuse_small_limit()
    executor = LocalExecutor(min(workers, len(numbers)))
    try:
        for number in numbers:
            executor.submit(number, _recorded_there, json.dumps(tables), prepared.scenario.parts, number, packed(own))
        for number, found in executor.finished():
            if isinstance(found, ScenarioError):
                raise found
            yield number, found
    finally:
        executor.close()


def _recorded_there(tables: str, parts: tuple[Part, ...], number: int, own: bytes) -> dict[str, Any] | ScenarioError:
    """In a worker: the record of a flight, or why there can be none of any."""
    try:
        brought = unpacked(own)
    except ScenarioError as error:
        return error
    return recorded(prepared_from(tables, parts, bool(brought)), number, brought)


@functools.lru_cache(maxsize=1)
def prepared_from(tables: str, parts: tuple[Part, ...], own: bool = False) -> Prepared:
    """The preparation of tables in JSON, shared by flights that come one after another in a worker.

    ``own`` says whether the caller has brought trackers.
    """
    scenario = read(json.loads(tables), plugins=parts)
    if not scenario.trackers and not own:
        scenario = dataclasses.replace(scenario, sensors={})  # nobody listens to them
    return prepare(scenario)


def recorded(prepared: Prepared, number: int, own: OwnTrackers | None = None) -> dict[str, Any]:
    """The record of one flight, flown, observed, tracked and judged; one that cannot be flown is a record too."""
    try:
        return record_of(number, evaluate(prepared, fly(prepared, number), number, own))
    except ScenarioError as error:
        return lost_record(number, str(error))


def record_of(number: int, found: Evaluation) -> dict[str, Any]:
    """What is kept of a flight, as JSON holds it: its number, its figures, and what each check found."""
    figures = found.flight | ({"trackers": found.trackers, "navigated": found.navigated} if found.trackers else {})
    figures |= {"contrasts": found.contrasts} if found.contrasts else {}
    if found.navigated is not None:  # the flight beside it is not its own
        figures["navigated"] = {key: value for key, value in found.navigated.items() if key != "on_truth"}
    record: dict[str, Any] = plain({"flight": number, "metrics": figures, "checks": found.checks})
    return record


def lost_record(number: int, reason: str, outcome: str = CRASHED) -> dict[str, Any]:
    """The record of a flight without a result."""
    return {"flight": number, "metrics": {"outcome": outcome, "reason": reason}, "checks": []}


class Evaluation(NamedTuple):
    """What is found out about one flight; figures as in metrics.json."""

    records: dict[str, SensorRecord]
    tracks: dict[str, Tracked]
    flight: dict[str, Any]
    trackers: dict[str, Any]
    contrasts: dict[str, Any]  # by pair
    navigated: dict[str, Any] | None
    checks: list[dict[str, Any]]
    timing: dict[str, float]


def evaluate(prepared: Prepared, flight: Flight, number: int = 0, own: OwnTrackers | None = None) -> Evaluation:
    """Let the sensors of a scenario see a flight and its trackers follow it, and judge both.

    Parameters
    ----------
    number : of the flight; it addresses the noise
    own : further trackers of the caller, by name
    """
    scenario = prepared.scenario
    timing: dict[str, float] = {}
    with timed(timing, "observe_s"):
        records = observe(flight, scenario.sensors, scenario.seed, number, scenario.draws, scenario.sensor_faults)
    with timed(timing, "track_s"):
        tracks, trackers = track(prepared, flight, records, own or {}, number)
    name = scenario.autopilot.navigation
    followed = tracks[name].track if name in tracks else None
    navigated = navigation_quality(prepared, flight, followed, trackers.get(name, {}))
    figures = flight_metrics(flight, scenario.runway, prepared.law.bank_limit, prepared.stall_speed)
    squares = {name: one.squares for name, one in tracks.items() if one.squares is not None}
    contrasts = contrasts_of_flight(scenario.contrasts, squares)
    every = {**figures, "navigated": navigated, "trackers": trackers, "contrasts": contrasts}
    checks = evaluate_checks(scenario.checks, flight, scenario.runway, every)
    return Evaluation(records, tracks, figures, trackers, contrasts, navigated, checks, timing)


def _until(flight: Flight, records: dict[str, SensorRecord]) -> dict[str, SensorRecord]:
    """What was measured before the roll-out."""
    end = float(flight.time[-1])
    return {name: record.until(end) for name, record in records.items()}


def _on_truth(prepared: Prepared, number: int) -> dict[str, Any]:
    """Figures of a flight as it goes when the autopilot sees the truth."""
    autopilot = dataclasses.replace(prepared.scenario.autopilot, navigation="truth")
    twin = dataclasses.replace(prepared, scenario=dataclasses.replace(prepared.scenario, autopilot=autopilot))
    return flight_metrics(fly(twin, number), prepared.scenario.runway, prepared.law.bank_limit, prepared.stall_speed)


def run_to_folder(
    source: str | dict[str, Any],
    overrides: dict[str, Any],
    out: Path | None,
    progress: Callable[..., Any] | None = None,
    plugins: Plugins = (),
    remark: Callable[[str], None] | None = None,
    flight: int | None = None,
    workers: int = 1,
) -> tuple[Path, Result]:
    """Run a scenario into a folder, ``out/NAME`` unless told otherwise; one flight alone into ``out/NAME_flight_K``."""
    started = time.perf_counter()
    scenario = read(source, overrides, plugins=plugins)
    name = scenario.name if flight is None else f"{scenario.name}_flight_{flight}"
    folder = out if out is not None else Path("out") / name
    refuse_foreign(folder, "run")
    shared = len(scenario.trackers) >= FEW and scenario.draws <= TOGETHER
    with helper(shared, functools.partial(_get_ready, scenario.parts)):
        result = run(scenario, flight=flight, workers=workers, progress=progress, remark=remark)
        report(result, folder, started)
    return folder, result


def _get_ready(parts: tuple[Part, ...]) -> None:
    """In the helper process: parts whose values will come; this module, and all it imports, came while one flies."""
    load_parts(parts)


def report(result: Result, folder: str | Path, started: float | None = None) -> Path:
    """Write the files of a run and its page into a folder, which is made; returns the page.

    ``started`` is when the run began, by ``time.perf_counter``. The arrays are those of the flight that the result has
    as a whole. Of several flights the page shows the worst first, and a few more, which are flown again: nothing else
    was kept of them.

    Raises ``OutputError`` for a folder that holds what something else wrote.
    """
    from sim.reporting.run_page import write

    folder = Path(folder)
    claim(folder, "run")
    with staged(folder) as place:
        with timed(result.timing, "report_s"):
            write_files(result, place)
            write(
                place / "report.html",
                scenario=result.scenario,
                law=result.prepared.law,
                metrics=result.metrics,
                versions=result.metrics["versions"],
                flights=_seen(result),
            )
        if started is not None:
            result.timing["total_s"] = time.perf_counter() - started
        write_json(place / TIMING, result.timing)
    return folder / "report.html"


def _seen(result: Result) -> Iterator[Seen]:
    """The flights of a report, the worst first, each seen whole before the next is flown."""
    from sim.reporting.run_page import Seen

    each = {one["flight"]: one for one in result.metrics.get("each_flight", ())}
    flown = [one["flight"] for one in worst_first([*each.values()]) if one["metrics"]["outcome"] != CRASHED]
    shown = flown[:SHOWN] or [result.number]
    if result.number not in shown:
        shown[-1] = result.number
    chart = height_profile(result.prepared)
    for number in shown:
        if number == result.number:
            trackers = each[number]["metrics"].get("trackers", {}) if each else result.metrics["trackers"]
            seen = dict(result.records), dict(result.tracks)
            yield Seen(number, result.flight, *seen, result.metrics["flight"], trackers, chart)
        else:
            flight = fly(result.prepared, number)
            found = evaluate(result.prepared, flight, number, result.own)
            if found.navigated is not None:
                found.navigated["on_truth"] = _on_truth(result.prepared, number)
            figures = {**found.flight, "navigated": found.navigated}
            yield Seen(number, flight, found.records, found.tracks, figures, found.trackers, chart)
