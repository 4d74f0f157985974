"""The verbs of a run in order: fly, observe, track, report; and ``run``, which does them all."""

from __future__ import annotations

import dataclasses
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

from sim.estimation.navigator import navigator
from sim.estimation.setup import build, check
from sim.estimation.tracking_run import track
from sim.files import claim, refuse_foreign, staged, write_json, write_npz
from sim.flight import loop as flights
from sim.flight.departures import noted
from sim.flight.preparation import Prepared, prepare
from sim.flight.record import Flight
from sim.metrics.checks import evaluate_checks, unknown_names
from sim.metrics.flight import flight_metrics, summarise
from sim.metrics.navigation import navigated
from sim.metrics.warnings import warnings
from sim.observation.record import observe
from sim.reporting.run_files import flight_arrays, measurement_arrays
from sim.result import Result, _lap
from sim.scenario import reading
from sim.scenario.budget import refuse_too_much
from sim.scenario.model import Scenario
from sim.scenario.toml_writer import dumps
from sim.versions import versions
from sim.workers.executors import TIME_LIMIT
from sim.workers.helper_process import ALONE, SecondProcess, second_process
from sim.workers.isolation import apart

FEW = 4  # trackers are done before a second process has got ready


def read(source: str | Path | dict[str, Any], overrides: dict[str, Any] | None = None) -> Scenario:
    """A scenario from a file, a bundled name or a dict of tables, with ``{"table.key": value}`` overrides.

    Raises ``ScenarioError`` with one line for each fault, metrics and phases of checks that no flight has among them.
    """
    return reading.read(source, overrides, checks=unknown_names)


def fly(prepared: Prepared | Scenario | str, flight: int = 0) -> Flight:
    """Fly one flight of a prepared scenario; ``flight`` addresses its turbulence."""
    if not isinstance(prepared, Prepared):
        prepared = prepare(prepared if isinstance(prepared, Scenario) else read(prepared))
    return apart(prepared.scenario, TIME_LIMIT, _fly, prepared, flight)


def _fly(prepared: Prepared, number: int) -> Flight:
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
    return noted(flight, prepared.scenario.departures)


def run(
    source: str | Path | dict[str, Any] | Scenario,
    *,
    seed: int | None = None,
    flights: int | None = None,
    draws: int | None = None,
    overrides: dict[str, Any] | None = None,
    trackers: dict[str, Any] | None = None,
    progress: Callable[..., Any] | None = None,
    second: SecondProcess = ALONE,
) -> Result:
    """Read, fly, observe, track and judge a scenario.

    Parameters
    ----------
    source : a file, a bundled name, a dict of tables or a scenario
    overrides : ``{"table.key": value}`` in the spelling of files
    trackers : further trackers by name, objects of the ``tracking.track.Tracker`` protocol
    second : another process that takes a part of the trackers

    Raises ``ScenarioError`` for anything that cannot be run.
    """
    started = time.perf_counter()
    given = {"seed": seed, "flights": flights, "draws": draws}
    changes = {**(overrides or {}), **{key: value for key, value in given.items() if value is not None}}
    if isinstance(source, Scenario):
        source = source.tables
    scenario = read(source, changes)
    refuse_too_much(scenario)
    timing: dict[str, float] = {}
    prepared = prepare(scenario)
    check(prepared, trackers)
    _lap(timing, "prepare_s", started)

    lap = time.perf_counter()
    numbers: Any = range(scenario.flights)
    if progress is not None and scenario.flights > 1:
        numbers = progress(numbers, scenario.flights, "flights")
    flown = tuple(fly(prepared, number) for number in numbers)
    _lap(timing, "fly_s", lap)

    lap = time.perf_counter()
    first = flown[0]
    records = observe(first, scenario.sensors, scenario.seed, 0, scenario.draws)
    _lap(timing, "observe_s", lap)
    lap = time.perf_counter()
    tracks, tracker_metrics = track(prepared, first, records, trackers or {}, 0, second)
    _lap(timing, "track_s", lap)

    each = [flight_metrics(one, scenario.runway, prepared.law.bank_limit) for one in flown]
    name = scenario.autopilot.navigation
    followed = tracks[name].track if name in tracks else None
    each[0]["navigated"] = navigated(prepared, first, followed, tracker_metrics.get(name, {}))
    if each[0]["navigated"] is not None:
        each[0]["navigated"]["on_truth"] = _on_truth(prepared)
    metrics = {
        "scenario": scenario.name,
        "seed": scenario.seed,
        "flights": scenario.flights,
        "draws": scenario.draws,
        "versions": versions(),
        "flight": each[0],
        "flights_summary": summarise(each),
        "trackers": tracker_metrics,
        "warnings": [*prepared.warnings, *warnings(first, scenario.sensors, records, tracker_metrics)],
    }
    metrics["checks"] = evaluate_checks(
        scenario.checks, first, scenario.runway, {**each[0], "trackers": tracker_metrics}
    )
    return Result(prepared, flown, records, tracks, metrics, timing)


def _on_truth(prepared: Prepared) -> dict[str, Any]:
    """Figures of flight 0 as it goes when the autopilot sees the truth."""
    autopilot = dataclasses.replace(prepared.scenario.autopilot, navigation="truth")
    twin = dataclasses.replace(prepared, scenario=dataclasses.replace(prepared.scenario, autopilot=autopilot))
    return flight_metrics(fly(twin), prepared.scenario.runway, prepared.law.bank_limit)


def run_to_folder(
    source: str, overrides: dict[str, Any], out: Path | None, progress: Callable[..., Any] | None = None
) -> tuple[Path, Result]:
    """Run a scenario into a folder, ``out/NAME`` unless told otherwise."""
    started = time.perf_counter()
    scenario = read(source, overrides)
    folder = out if out is not None else Path("out") / scenario.name
    refuse_foreign(folder, "run")
    with second_process(len(scenario.trackers) >= FEW, _get_ready) as second:
        result = run(scenario, progress=progress, second=second)
        claim(folder, "run")
        with staged(folder) as place:
            report(result, place, second)
            result.timing["total_s"] = time.perf_counter() - started
            write_json(place / "timing.json", result.timing)
    return folder, result


def _get_ready() -> None:
    """In the second process: what takes long to import, while the aircraft still flies."""
    from sim.reporting.figures.flight import charts  # noqa: F401
    from sim.reporting.figures.style import get_ready

    get_ready()


def report(result: Result, folder: Path, second: SecondProcess = ALONE) -> None:
    """Write the files of a run into an existing folder; a second process draws a part of its figures."""
    from sim.reporting.run_page import write

    lap = time.perf_counter()
    scenario, first = result.scenario, result.flight
    resolved = {**scenario.tables, "designed": result.prepared.designed.to_table()}
    (folder / "scenario.toml").write_text(dumps(resolved))
    write_json(folder / "metrics.json", result.metrics)
    write_npz(folder / "flight.npz", flight_arrays(first))
    write_npz(folder / "measurements.npz", measurement_arrays(result.records))
    write_npz(folder / "tracks.npz", {k: v for name, one in result.tracks.items() for k, v in one.arrays(name).items()})
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
        built={name: build(result.prepared, name, choice)[0] for name, choice in scenario.trackers.items()},
        second=second,
    )
    _lap(result.timing, "report_s", lap)
