"""The verbs of a run in order: fly, observe, track, report; and ``run``, which does them all."""

from __future__ import annotations

import dataclasses
import functools
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any, NamedTuple

from sim.errors import ScenarioError
from sim.estimation import assumed_height
from sim.estimation.navigator import navigator
from sim.estimation.setup import check
from sim.estimation.tracking_run import Tracked, track
from sim.files import claim, refuse_foreign, staged, write_json, write_npz
from sim.flight import loop as flights
from sim.flight.departures import with_departure_events
from sim.flight.preparation import Prepared, prepare
from sim.flight.record import Flight
from sim.metrics.checks import evaluate_checks, unknown_names
from sim.metrics.flight import flight_metrics, summarise
from sim.metrics.navigation import navigation_quality
from sim.observation.record import SensorRecord, observe
from sim.reporting.run_files import flight_arrays, measurement_arrays, track_arrays
from sim.reporting.text.warnings import warnings
from sim.result import Result, timed
from sim.scenario import reading
from sim.scenario.budget import refuse_too_much
from sim.scenario.model import Scenario
from sim.scenario.plugins import Part, catalogue_with, digests, load_parts, said
from sim.scenario.toml_writer import dumps
from sim.versions import versions
from sim.workers.executors import FLIGHT_TIME_LIMIT
from sim.workers.isolation import run_isolated
from sim.workers.sharing import helper

FEW = 4  # trackers are done before a helper process has got ready


def read(
    source: str | Path | dict[str, Any], overrides: dict[str, Any] | None = None, *, plugins: Any = ()
) -> Scenario:
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
    try:
        flight = flights.fly(
            prepared.vehicle,
            prepared.controller,
            prepared.initial,
            prepared.wind(number),
            prepared.limits,
            prepared.phases,
            navigator(prepared, number),
            prepared.gate_height,
        )
    except Exception as error:
        place = scenario.part_at_fault(error)
        if place is None:
            raise
        raise ScenarioError(f"{scenario.name}: {place} raises {said(error)} in flight") from None
    return with_departure_events(flight, scenario.departures)


def run(
    source: str | Path | dict[str, Any] | Scenario,
    *,
    seed: int | None = None,
    flights: int | None = None,
    draws: int | None = None,
    overrides: dict[str, Any] | None = None,
    trackers: dict[str, Any] | None = None,
    plugins: Any = (),
    progress: Callable[..., Any] | None = None,
) -> Result:
    """Read, fly, observe, track and judge a scenario.

    Parameters
    ----------
    source : a file, a bundled name, a dict of tables or a scenario
    overrides : ``{"table.key": value}`` in the spelling of files
    trackers : further trackers by name, objects of the ``tracking.track.Tracker`` protocol
    plugins : what brings kinds that are not bundled: paths of files, or imported modules, with a table ``SHORTFINAL``

    Raises ``ScenarioError`` for anything that cannot be run.
    """
    timing: dict[str, float] = {}
    with timed(timing, "prepare_s"):
        given = {"seed": seed, "flights": flights, "draws": draws}
        changes = {**(overrides or {}), **{key: value for key, value in given.items() if value is not None}}
        catalogue = catalogue_with(plugins)
        if isinstance(source, Scenario):
            catalogue, source = catalogue.also(source.parts), source.tables
        scenario = read(source, changes, plugins=catalogue)
        refuse_too_much(scenario)
        prepared = prepare(scenario)
        check(prepared, trackers)
    with timed(timing, "fly_s"):
        numbers: Any = range(scenario.flights)
        if progress is not None and scenario.flights > 1:
            numbers = progress(numbers, scenario.flights, "flights")
        flown = tuple(fly(prepared, number) for number in numbers)

    found = evaluate(prepared, flown[0], own=trackers)
    if found.navigated is not None:
        found.navigated["on_truth"] = _on_truth(prepared)
    others = [flight_metrics(one, scenario.runway, prepared.law.bank_limit, prepared.stall_speed) for one in flown[1:]]
    metrics = {
        "scenario": scenario.name,
        "seed": scenario.seed,
        "flights": scenario.flights,
        "draws": scenario.draws,
        "versions": versions(digests(scenario.parts)),
        "flight": {**found.flight, "navigated": found.navigated},
        "flights_summary": summarise([found.flight, *others]),
        "trackers": found.trackers,
        "checks": found.checks,
        "warnings": [
            *prepared.warnings,
            *warnings(flown[0], found.flight, scenario.sensors, found.records, found.trackers),
            *assumed_height.remarks(prepared, flown[0], found.records),
        ],
    }
    return Result(prepared, flown, found.records, found.tracks, metrics, timing | found.timing)


class Evaluation(NamedTuple):
    """What is found out about one flight; figures as in metrics.json."""

    records: dict[str, SensorRecord]
    tracks: dict[str, Tracked]
    flight: dict[str, Any]
    trackers: dict[str, Any]
    navigated: dict[str, Any] | None
    checks: list[dict[str, Any]]
    timing: dict[str, float]


def evaluate(prepared: Prepared, flight: Flight, number: int = 0, own: dict[str, Any] | None = None) -> Evaluation:
    """Let the sensors of a scenario see a flight and its trackers follow it, and judge both.

    Parameters
    ----------
    number : of the flight; it addresses the noise
    own : further trackers of the caller, by name
    """
    scenario = prepared.scenario
    timing: dict[str, float] = {}
    with timed(timing, "observe_s"):
        records = observe(flight, scenario.sensors, scenario.seed, number, scenario.draws)
    with timed(timing, "track_s"):
        tracks, trackers = track(prepared, flight, records, own or {}, number)
    name = scenario.autopilot.navigation
    followed = tracks[name].track if name in tracks else None
    navigated = navigation_quality(prepared, flight, followed, trackers.get(name, {}))
    figures = flight_metrics(flight, scenario.runway, prepared.law.bank_limit, prepared.stall_speed)
    every = {**figures, "navigated": navigated, "trackers": trackers}
    checks = evaluate_checks(scenario.checks, flight, scenario.runway, every)
    return Evaluation(records, tracks, figures, trackers, navigated, checks, timing)


def _on_truth(prepared: Prepared) -> dict[str, Any]:
    """Figures of flight 0 as it goes when the autopilot sees the truth."""
    autopilot = dataclasses.replace(prepared.scenario.autopilot, navigation="truth")
    twin = dataclasses.replace(prepared, scenario=dataclasses.replace(prepared.scenario, autopilot=autopilot))
    return flight_metrics(fly(twin), prepared.scenario.runway, prepared.law.bank_limit, prepared.stall_speed)


def run_to_folder(
    source: str,
    overrides: dict[str, Any],
    out: Path | None,
    progress: Callable[..., Any] | None = None,
    plugins: Any = (),
) -> tuple[Path, Result]:
    """Run a scenario into a folder, ``out/NAME`` unless told otherwise."""
    started = time.perf_counter()
    scenario = read(source, overrides, plugins=plugins)
    folder = out if out is not None else Path("out") / scenario.name
    refuse_foreign(folder, "run")
    with helper(len(scenario.trackers) >= FEW, functools.partial(_get_ready, scenario.parts)):
        result = run(scenario, progress=progress)
        claim(folder, "run")
        with staged(folder) as place:
            report(result, place)
            result.timing["total_s"] = time.perf_counter() - started
            write_json(place / "timing.json", result.timing)
    return folder, result


def _get_ready(parts: tuple[Part, ...]) -> None:
    """In the helper process: parts whose values will come, and what takes long to import, while the aircraft flies."""
    load_parts(parts)
    from sim.reporting.figures.flight import charts  # noqa: F401
    from sim.reporting.figures.style import get_ready

    get_ready()


def report(result: Result, folder: Path) -> None:
    """Write the files of a run into an existing folder."""
    from sim.reporting.run_page import write

    with timed(result.timing, "report_s"):
        scenario, first = result.scenario, result.flight
        resolved = {**scenario.tables, "designed": result.prepared.designed.to_table()}
        (folder / "scenario.toml").write_text(dumps(resolved))
        write_json(folder / "metrics.json", result.metrics)
        write_npz(folder / "flight.npz", flight_arrays(first))
        write_npz(folder / "measurements.npz", measurement_arrays(result.records))
        write_npz(folder / "tracks.npz", track_arrays(result.tracks))
        write(
            folder / "report.html",
            scenario=scenario,
            flight=first,
            law=result.prepared.law,
            metrics=result.metrics,
            versions=result.metrics["versions"],
            timing=result.timing,
            tracked=result.tracks,
            records=result.records,
        )
