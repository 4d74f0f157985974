"""The tables of a run that a person reads: degrees, one draw, truth and errors beside what was measured and estimated.

Positions and angles come from the files of the run, the truth from its flight, so a table holds what the run has found
and no other number.
"""

from __future__ import annotations

import functools
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from sim.cli.exporting.formats import write_csv
from sim.cli.exporting.records import arrays, contrasts, flights, is_study, undamaged
from sim.errors import OutputError, did_you_mean
from sim.files import claim, refuse_unwritten, staged
from sim.flight.interpolation import Truth, truth_at
from sim.metrics.comparison import compare
from sim.observation.sensor import quantity_of
from sim.reporting.columns import Columns, groups, table_of
from sim.reporting.run_files import flight_arrays, with_unit
from sim.reporting.tracker_figures.model_probabilities import mode_names
from sim.results.estimates import refuse_draw
from sim.results.result import Result
from tracking.measurement import wrap

MOST_ROWS = 1_048_576  # that a sheet of Excel or LibreOffice has
DEGREES = {"_rad": "_deg", "_radps": "_degps", "_radps2": "_degps2"}
EXACT = {  # component of an estimate -> what of the state is its truth
    "north": "north",
    "east": "east",
    "height": "height",
    "north_rate": "velocity_north",
    "east_rate": "velocity_east",
    "height_rate": "velocity_up",
}
ERRORS = {"position_m": "position_error_m", "cross_track_m": "cross_track_error_m"}
Tables = dict[str, Callable[[], Columns]]  # each is made when it is written


class Exported(NamedTuple):
    """What was written."""

    files: tuple[Path, ...]
    remarks: tuple[str, ...]  # sentences


def export_spreadsheet(
    folder: Path,
    out: Path | None = None,
    draw: int | None = None,
    every_draw: bool = False,
    wanted: list[str] | None = None,
    plugins: Any = (),
) -> Exported:
    """Write the tables of a run, or of a study the row of each flight, as comma-separated values.

    Parameters
    ----------
    out : folder to write, which is made; None = the folder itself
    draw : of the noise, that looks and estimates are of; None = the first, or all where ``every_draw`` is said
    wanted : names of tables, ``tracks.imm``, or of all that begin so, ``tracks``; None = all

    Raises ``OutputError`` in one sentence, before anything is written, for a folder that is of neither or damaged, a
    draw or a table that it has not, and a target that holds something else.
    """
    refuse_unwritten(folder)
    if is_study(folder):
        if draw is not None or every_draw:
            raise OutputError(f"{folder}: is of a study, which keeps no draws; --draw and --draws are for a run")
        tables: Tables = {"flights": functools.partial(flights, folder)}
    else:
        tables = _tables(folder, draw, every_draw, plugins)
    chosen = _chosen(tables, wanted)
    made = {name: make() for name, make in chosen.items()}
    target = folder if out is None else out
    if target.resolve() != folder.resolve():
        claim(target, "tables")
    with staged(target) as place:
        for name, table in made.items():
            write_csv(place / f"{name}.csv", table)
    rows = {name: len(next(iter(table.values()))) for name, table in made.items()}
    long = [name for name, count in rows.items() if count > MOST_ROWS]
    remarks = [f"{name}.csv has {rows[name]} rows, and a sheet shows {MOST_ROWS}: say --draw K" for name in long]
    return Exported(tuple(target / f"{name}.csv" for name in made), tuple(remarks))


def _chosen(tables: Tables, wanted: list[str] | None) -> Tables:
    """The tables of these names, and those that begin so."""
    if wanted is None:
        return tables
    found: Tables = {}
    for name in wanted:
        own = {key: make for key, make in tables.items() if key == name or key.startswith(f"{name}.")}
        if not own:
            known = [*tables, *(key.partition(".")[0] for key in tables)]
            raise OutputError(f"--tables {name}: there is no such table; {did_you_mean(name, {*known})}")
        found |= own
    return found


def _tables(folder: Path, draw: int | None, every_draw: bool, plugins: Any) -> Tables:
    from sim.results.loading import load

    result = load(folder, plugins=plugins)
    refuse_draw(draw or 0, result.scenario.draws)
    of_file: dict[str, dict[str, Columns]] = {}
    for record in ("measurements", "tracks"):
        with undamaged(folder / f"{record}.npz") as file:
            of_file[record] = groups(arrays(file))
    pick = slice(None) if every_draw else slice(draw or 0, (draw or 0) + 1)
    tables: Tables = {"flight": lambda: in_degrees(table_of(flight_arrays(result.flight.whole)))}
    for record, make in (("measurements", _measured), ("tracks", _estimated)):
        for name, own in of_file[record].items():
            tables[f"{record}.{name}"] = functools.partial(_of_file, make, result, name, own, pick, folder / record)
    return tables | {name: functools.partial(dict, table) for name, table in contrasts(folder).items()}


def _of_file(make: Any, result: Result, name: str, own: Columns, pick: slice, record: Path) -> Columns:
    with undamaged(record.with_suffix(".npz")):
        return in_degrees(make(result, name, own, pick))


def in_degrees(columns: Columns) -> Columns:
    """Columns with every angle in degrees, and its name with it."""
    found: Columns = {}
    for name, values in columns.items():
        stem, _, unit = name.rpartition("_")
        other = DEGREES.get(f"_{unit}")
        found[name if other is None else stem + other] = values if other is None else np.degrees(values)
    return found


def _measured(result: Result, name: str, own: Columns, pick: slice) -> Columns:
    """Looks of a sensor, each channel with its standard deviation, what is true, and by how much it is off."""
    if "channels" not in own:  # all plots of a sensor with clutter, in rows of their own
        rows = np.isin(own["draw"], np.arange(result.scenario.draws)[pick])
        return {column: values[rows] for column, values in own.items()}
    sensor = result.scenario.sensors[name]
    channels = [str(channel) for channel in own["channels"]]
    truth = truth_at(result.flight.whole, own["time_s"])
    exact = dict(zip(sensor.channels, sensor.truth(truth.state), strict=True))
    head = {"time_s": own["time_s"], "arrival_s": own["arrival_s"], "phase": _phases(result, truth)}
    units = [str(unit) for unit in own["units"]]
    return _rows(head, channels, units, own["z"], own["sigma"], exact, pick, result.scenario.draws)


def _estimated(result: Result, name: str, own: Columns, pick: slice) -> Columns:
    """Estimates of a tracker, each component with its standard deviation, what is true, and by how much it is off."""
    channels = tuple(str(channel) for channel in own["channels"])
    mean = own["mean"].astype(float)
    truth = truth_at(result.flight.whole, own["time_s"])
    head = {"time_s": own["time_s"], "phase": _phases(result, truth)}
    exact = {channel: found for channel in channels if (found := _exact(result, truth, channel)) is not None}
    columns = _rows(head, list(channels), None, mean, own["sigma"].astype(float), exact, pick, mean.shape[2])
    if result.flight.known:
        nothing = np.zeros((len(mean), len(channels), len(channels), 1))
        sensors = {name: sensor for name, sensor in result.scenario.sensors.items() if f"{name}.range" in channels}
        with np.errstate(all="ignore"):  # a lost track is a result
            errors = compare(result.flight, truth, channels, mean[..., pick], nothing, sensors)
        for channel, column in ERRORS.items():
            if channel in errors:
                error = errors[channel].error
                plain = error[:, 0] if error.shape[1] == 1 else np.linalg.norm(error, axis=1)
                columns[column] = plain.ravel()
    return columns | {column: values[..., pick].ravel() for column, values in _beliefs(result, name, own)}


def _exact(result: Result, truth: Truth, channel: str) -> np.ndarray | None:
    """(k,) what a component of an estimate should be; None where nothing says so."""
    if channel in EXACT:
        return np.asarray(getattr(truth.state, EXACT[channel]))
    name, _, quantity = channel.rpartition(".")
    sensor = result.scenario.sensors.get(name)
    if sensor is None or quantity not in sensor.channels:
        return None
    return np.asarray(sensor.truth(truth.state)[sensor.channels.index(quantity)])


def _beliefs(result: Result, name: str, own: Columns) -> Iterator[tuple[str, np.ndarray]]:
    """The probabilities (k, draws) of the models of a tracker by the names that it gives them."""
    if "model_probabilities" not in own:
        return
    probabilities = own["model_probabilities"]
    for number, mode in enumerate(mode_names(_tracker(result, name), probabilities.shape[1])):
        yield f"probability of {mode}", probabilities[:, number]


def _tracker(result: Result, name: str) -> Any:
    """A tracker of the scenario as it is set up; None for one that the caller of the run had brought."""
    from sim.estimation.setup import build

    choice = result.scenario.trackers.get(name)
    return None if choice is None else build(result.prepared, name, choice)[0]


def _phases(result: Result, truth: Truth) -> np.ndarray:
    """(k,) names of the phases that were flown."""
    return np.asarray(np.array(result.flight.whole.phases)[truth.phase])


def _rows(
    head: Columns,
    channels: list[str],
    units: list[str] | None,
    values: np.ndarray,
    sigma: np.ndarray,
    exact: dict[str, np.ndarray],
    pick: slice,
    draws: int,
) -> Columns:
    """A row for each epoch and draw: ``head`` (k,), then of each channel the value (k, m, draws), sigma, truth and
    error; what nobody knows has no column."""
    number = np.arange(draws)[pick]
    count = len(number)
    columns = {name: np.repeat(column, count) for name, column in head.items()}
    columns["draw"] = np.tile(number, len(values))
    shape = (*values.shape[:2], draws)
    values, sigma = (np.broadcast_to(array, shape)[..., pick] for array in (values, sigma))
    for row, channel in enumerate(channels):
        suffix = with_unit(channel, None if units is None else units[row]).removeprefix(channel)
        columns[f"{channel}{suffix}"] = values[:, row].ravel()
        columns[f"{channel}_sigma{suffix}"] = sigma[:, row].ravel()
        true = exact.get(channel)
        if true is not None and np.isfinite(true).any():
            error = values[:, row] - true[:, None]
            wraps = quantity_of(channel).wraps
            columns[f"{channel}_truth{suffix}"] = np.repeat(true, count)
            columns[f"{channel}_error{suffix}"] = (np.asarray(wrap(error)) if wraps else error).ravel()
    return columns
