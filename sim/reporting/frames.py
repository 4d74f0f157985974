"""The tables of a result for pandas, which is optional: the only place that knows it."""

from __future__ import annotations

import importlib.util
from collections.abc import Callable, Iterator
from typing import TYPE_CHECKING

import numpy as np

from sim.errors import OutputError
from sim.metrics.tracker import tracker_errors
from sim.reporting.columns import Columns, groups, table_of
from sim.reporting.run_figures import Run
from sim.reporting.run_files import flight_arrays, measurement_arrays, track_arrays

if TYPE_CHECKING:
    import pandas


def data_frame(run: Run, table: str) -> pandas.DataFrame:
    """One of `TABLES`; the tables of several sensors or trackers stand below each other, NaN where one has no column.

    Raises ``OutputError`` where pandas is missing, ``ValueError`` for another name.
    """
    if table not in TABLES:
        raise ValueError(f"no table '{table}'; there are {', '.join(TABLES)}")
    if importlib.util.find_spec("pandas") is None:
        raise OutputError("to_dataframe needs pandas: pip install 'shortfinal[pandas]'")
    import pandas

    parts = [pandas.DataFrame(columns) for columns in TABLES[table](run)]
    return pandas.concat(parts, ignore_index=True) if parts else pandas.DataFrame()


def _flight(run: Run) -> Iterator[Columns]:
    yield table_of(flight_arrays(run.flight.whole))


def _measurements(run: Run) -> Iterator[Columns]:
    yield from _named("sensor", groups(measurement_arrays(run.records)))


def _trackers(run: Run) -> Iterator[Columns]:
    yield from _named("tracker", groups(dict(track_arrays(run.tracks))))


def _named(what: str, arrays: dict[str, Columns]) -> Iterator[Columns]:
    """The tables of what has looks or estimates; the false plots of a sensor are no table of their own here."""
    for name, one in arrays.items():
        if "channels" in one:
            columns = table_of(one)
            yield {what: np.full(len(columns["time_s"]), name), **columns}


def _errors(run: Run) -> Iterator[Columns]:
    """Estimate minus truth of every tracker after every update, of each draw."""
    flight, known = run.flight, run.prepared.scenario.sensors
    if not flight.known:
        raise OutputError("there are no errors: of a flight that only plots tell of no truth is known")
    for name, one in run.tracks.items():
        sensors = {sensor: known[sensor] for sensor in known if sensor in one.curves.sensors}
        found = tracker_errors(flight, sensors, one.track, {})
        count, draws = len(one.track.time), one.track.mean.shape[2]
        columns: Columns = {
            "tracker": np.full(count * draws, name),
            "time_s": np.repeat(one.track.time, draws),
            "phase": np.repeat(np.array(flight.phases)[found.truth.phase], draws),
            "draw": np.tile(np.arange(draws), count),
        }
        for channel, compared in found.estimates.items():
            error = compared.error
            columns[channel] = (np.linalg.norm(error, axis=1) if error.shape[1] > 1 else error[:, 0]).ravel()
        yield columns


TABLES: dict[str, Callable[[Run], Iterator[Columns]]] = {
    "flight": _flight,
    "measurements": _measurements,
    "trackers": _trackers,
    "errors": _errors,
}
