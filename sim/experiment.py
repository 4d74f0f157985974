"""The verbs of a run in order: fly, observe, track, report; and ``run``, which does them all."""

from __future__ import annotations

import dataclasses
import time
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from sim.cli.doctor import versions
from sim.cli.export import with_unit
from sim.estimation.navigator import navigator
from sim.estimation.setup import build, check
from sim.estimation.tracking_run import Tracked, track
from sim.files import claim, refuse_foreign, staged, write_json, write_npz
from sim.flight import loop as flights
from sim.flight.departures import noted
from sim.flight.loop import Flight
from sim.flight.preparation import Prepared, prepare
from sim.metrics.checks import judge
from sim.metrics.flight import flight_metrics, summarise
from sim.metrics.navigation import navigated
from sim.metrics.warnings import remarks
from sim.observation.record import SensorRecord, observe
from sim.scenario.budget import refuse_too_much
from sim.scenario.reading import Scenario, read
from sim.scenario.toml_writer import dumps
from sim.workers.executors import TIME_LIMIT
from sim.workers.helper_process import ALONE, SecondProcess, second_process
from sim.workers.isolation import apart

FEW = 4  # trackers are done before a second process has got ready


@dataclass(frozen=True)
class Result:
    """What a run found out."""

    prepared: Prepared
    flights: tuple[Flight, ...]
    records: dict[str, SensorRecord]  # of flight 0
    tracks: dict[str, Tracked]  # of flight 0
    metrics: dict[str, Any]
    timing: dict[str, float]

    @property
    def scenario(self) -> Scenario:
        """The scenario that was run."""
        return self.prepared.scenario

    @property
    def flight(self) -> Flight:
        """Flight 0, which figures and trackers are about."""
        return self.flights[0]


def fly(prepared: Prepared | Scenario | str, flight: int = 0) -> Flight:
    """Fly one flight of a prepared scenario; ``flight`` addresses its turbulence."""
    if not isinstance(prepared, Prepared):
        prepared = prepare(prepared if isinstance(prepared, Scenario) else read(prepared))
    return apart(prepared.scenario, TIME_LIMIT, _fly, prepared, flight)


def _fly(prepared: Prepared, number: int) -> Flight:
    flight = flights.fly(
        prepared.vehicle,
        prepared.pilot,
        prepared.initial,
        prepared.wind(number),
        prepared.limits,
        prepared.phases,
        navigator(prepared, number),
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
    check(prepared)
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
        "warnings": [*prepared.warnings, *remarks(first, scenario.sensors, records, tracker_metrics)],
    }
    metrics["checks"] = judge(scenario.checks, first, scenario.runway, {**each[0], "trackers": tracker_metrics})
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
    from sim.reporting.figures.style import get_ready
    from sim.reporting.run_page import charts  # noqa: F401

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


def flight_arrays(flight: Flight) -> dict[str, np.ndarray]:
    """The record of a flight by names that carry their unit."""
    state = {_with_unit(name): getattr(flight.state, name) for name in flight.state._fields}
    command = {f"command_{_with_unit(name)}": getattr(flight.command, name) for name in flight.command._fields}
    deviation = flight.deviation
    return {
        **state,
        **command,
        "cross_track_m": deviation.cross_track,
        "cross_track_rate_mps": deviation.cross_track_rate,
        "distance_to_go_m": deviation.distance_to_go,
        "leg": flight.leg,
        "phase": flight.phase,
        "phases": np.array(flight.phases),
    }


SUFFIX_OF = {
    "s": ("time",),
    "m": ("north", "east", "height"),
    "mps": ("velocity_north", "velocity_east", "velocity_up", "airspeed"),
    "rad": ("bank", "pitch", "heading", "angle_of_attack", "sideslip", "flaps", "flight_path_angle"),
    "radps": ("roll_rate", "pitch_rate", "yaw_rate"),
    "mps2": ("specific_force_forward", "specific_force_right", "specific_force_down"),
}


def _with_unit(name: str) -> str:
    return next((f"{name}_{suffix}" for suffix, names in SUFFIX_OF.items() if name in names), name)


def measurement_arrays(records: dict[str, SensorRecord]) -> dict[str, np.ndarray]:
    """The looks of all sensors: ``SENSOR.z`` in SI and radians with its channels beside it."""
    arrays: dict[str, np.ndarray] = {}
    for name, record in records.items():
        arrays[f"{name}.time_s"] = record.time
        arrays[f"{name}.arrival_s"] = record.arrival
        arrays[f"{name}.channels"] = np.array(record.channels)
        arrays[f"{name}.z"] = record.z
        # sensors' errors are independent: R is diagonal
        R = record.R if record.R.ndim == 4 else record.R[..., None]
        arrays[f"{name}.sigma"] = np.sqrt(np.einsum("kiin->kin", R))
        if record.candidates is not None:
            arrays |= {f"{name}.plots.{column}": values for column, values in plot_columns(record).items()}
    return arrays


def plot_columns(record: SensorRecord) -> dict[str, np.ndarray]:
    """All plots of a sensor with clutter, one row each: when, in which draw, whether the target's own, and where."""
    plots = np.moveaxis(record.candidates, 2, -1)  # (k, c, draws, m)
    epoch, plot, draw = np.nonzero(np.isfinite(plots).all(axis=-1))
    places = plots[epoch, plot, draw].T
    return {
        "time_s": record.time[epoch],
        "arrival_s": record.arrival[epoch],
        "draw": draw,
        "target": (plot == 0).astype(int),
        **{with_unit(channel): values for channel, values in zip(record.channels, places, strict=True)},
    }


def _lap(timing: dict[str, float], name: str, since: float) -> None:
    timing[name] = time.perf_counter() - since
