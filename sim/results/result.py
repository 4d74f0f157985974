"""What a run found out, as a value that shows itself."""

from __future__ import annotations

import time
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any, Literal

from sim.estimation.tracked.outcome import Tracked
from sim.files import claim, staged, write_json
from sim.flight.preparation import Prepared
from sim.flight.record import Flight
from sim.observation.record import SensorRecord
from sim.reporting.frames import data_frame
from sim.reporting.notebook import as_html, in_short
from sim.reporting.run_figures import Run, figures_of
from sim.reporting.text.broken_checks import broken_checks
from sim.reporting.text.contrast_sentence import contrast_sentences
from sim.reporting.text.reasons import Flown
from sim.results.saving import TIMING, write_files
from sim.scenario.model import Scenario

if TYPE_CHECKING:
    import pandas
    from matplotlib.figure import Figure

Table = Literal["flight", "measurements", "trackers", "errors"]


@dataclass(frozen=True)
class Result:
    """What a run found out: figures and verdicts of all flights, everything of one."""

    prepared: Prepared
    number: int  # of the flight that is here as a whole: the first, or the only one
    flight: Flight
    records: Mapping[str, SensorRecord]  # of that flight
    tracks: Mapping[str, Tracked]  # of that flight
    metrics: dict[str, Any]
    timing: dict[str, float]
    own: dict[str, Any]  # trackers that the caller brought

    @property
    def scenario(self) -> Scenario:
        """The scenario that was run."""
        return self.prepared.scenario

    @property
    def contrasted(self) -> list[str]:
        """Sentences about each pair of trackers that are set against each other, over all flights: how far apart they
        are, which is lost; and why, on the flight that is here."""
        each = {one["flight"]: one["metrics"].get("trackers", {}) for one in self.metrics.get("each_flight", ())}
        flown = Flown(self.scenario, self.prepared.law, self.flight, dict(self.tracks))
        return contrast_sentences(self.metrics, flown, each.get(self.number))

    @property
    def broken(self) -> list[str]:
        """A sentence for each check that failed, over all flights; empty where all passed."""
        return broken_checks(self.metrics, lambda flight, _: f"sim.run(..., flight={flight})")

    @property
    def _run(self) -> Run:
        return Run(self.prepared, self.number, self.flight, self.records, self.tracks, self.metrics)

    def plot(self, name: str = "plan") -> Figure:
        """A figure of the report as one of matplotlib; `sim.figures` has the names.

        Raises ``ValueError`` for a name that this result has no figure of.
        """
        from sim.reporting.drawing.matplotlib_backend import figure

        charts = figures_of(self._run)
        if name not in charts:
            raise ValueError(f"no figure '{name}'; this result has {', '.join(charts)}")
        return figure(charts[name].figure)

    def to_dataframe(self, table: Table) -> pandas.DataFrame:
        """A table of the flight that is here, its columns named with their units as in the files.

        ``flight`` has a row for each instant; ``measurements``, ``trackers`` and ``errors`` one for each sensor or
        tracker, epoch and noise draw. Errors are those of metrics.json, channel by channel: estimate minus truth, and
        of a position the distance. Raises ``OutputError`` where pandas is missing.
        """
        return data_frame(self._run, table)

    def save(self, folder: str | Path) -> Path:
        """Write the files that `sim.load` reads into a folder, which is made; `sim.report` writes the page as well.

        Raises ``OutputError`` for a folder that holds what something else wrote.
        """
        folder = Path(folder)
        claim(folder, "run")
        with staged(folder) as place:
            write_files(self, place)
            write_json(place / TIMING, self.timing)
        return folder

    def __repr__(self) -> str:
        """A few lines, also of a result of many flights."""
        return in_short(self.scenario, self.metrics)

    def _repr_html_(self) -> str:
        """What a notebook shows: the first screen of the report and its figure."""
        return as_html(self._run)


def figures(result: Result) -> dict[str, str]:
    """The figures that a result has, in the order of its report: short name, as `Result.plot` takes it, and title."""
    return {name: chart.title for name, chart in figures_of(result._run).items()}


@contextmanager
def timed(timing: dict[str, float], name: str) -> Iterator[None]:
    """Write down how long a part of the work takes, s."""
    started = time.perf_counter()
    yield
    timing[name] = time.perf_counter() - started
