"""What is compared: the records of all flights of a run, of a study, or of a result that is at hand."""

from __future__ import annotations

import json
import re
from collections.abc import Iterator
from pathlib import Path
from typing import Any, NamedTuple

from sim.errors import OutputError
from sim.files import DAMAGED, read_bytes, refuse_unwritten
from sim.metrics import table
from sim.metrics.ensemble.spread import scalars
from sim.results.result import Result
from sim.studies.folder import IDENTITY, stamp
from sim.studies.kept import flight_log

METRICS = "metrics.json"
OF_PARTS = re.compile(r"trackers\..+\.overall\.[^.]+(\.[^.]+)?\.rmse|contrasts\..+\.overall\.[^.]+(\.[^.]+)?\.ratio")
Place = tuple[int, int, int]  # cell, sample, flight


class Side(NamedTuple):
    """One of the two."""

    name: str
    kind: str  # "run" or "study"
    noise: tuple[Any, ...]  # where it is the same, the same flight has the same noise
    axes: dict[str, Any]
    versions: dict[str, Any]
    flights: dict[Place, dict[str, float]]  # metrics of each by their dotted names


def is_compared(metric: str) -> bool:
    """Whether a figure of a flight is compared: those of the metric table, RMSE and ratios of whole flights."""
    return metric in table.names() or OF_PARTS.fullmatch(metric) is not None


def side_of(what: Any) -> Side:
    """The side of a folder or a ``Result``; raises ``OutputError`` in one sentence for anything else."""
    if isinstance(what, Result):
        return _run(what.scenario.name, what.metrics)
    folder = Path(what)
    refuse_unwritten(folder)
    try:
        metrics = json.loads(read_bytes(folder / METRICS))
    except FileNotFoundError:
        raise OutputError(
            f"{folder}: half written, {METRICS} missing; run the scenario again, or go on with a study by 'resume'"
        ) from None
    except DAMAGED:
        raise OutputError(f"{folder}: its {METRICS} is damaged") from None
    try:
        return _study(folder, metrics) if (folder / IDENTITY).is_file() else _run(str(folder), metrics)
    except OutputError:
        raise
    except DAMAGED:
        raise OutputError(f"{folder}: its {METRICS} is not that of this version, or damaged: run it again") from None


def _run(name: str, metrics: dict[str, Any]) -> Side:
    own = {**metrics["flight"], "trackers": metrics["trackers"], "contrasts": metrics["contrasts"]}
    alone = {"flight": 0, "metrics": own}
    flights = {(0, 0, one["flight"]): _figures(one) for one in metrics.get("each_flight", [alone])}
    return Side(name, "run", (metrics["seed"], metrics["draws"]), {}, metrics["versions"], flights)


def _study(folder: Path, metrics: dict[str, Any]) -> Side:
    log = flight_log.read(folder, stamp(folder))
    if log.faults or len(log.records) != metrics["flights"]:
        raise OutputError(f"{folder}: not all of its flights are there; 'shortfinal resume {folder}' flies them")
    flights = {place: _figures(record) for place, record in log.records.items()}
    return Side(str(folder), "study", (metrics["seed"],), metrics["axes"], metrics["versions"], flights)


def _figures(record: dict[str, Any]) -> dict[str, float]:
    return dict(_compared(record["metrics"]))


def _compared(metrics: dict[str, Any]) -> Iterator[tuple[str, float]]:
    return ((name, value) for name, value in scalars(metrics) if is_compared(name))
