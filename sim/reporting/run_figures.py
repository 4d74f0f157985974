"""The figures of a run by short names, one chart each, as its page has them."""

from __future__ import annotations

import re
from collections.abc import Mapping
from typing import Any, NamedTuple

from sim.estimation.setup import height_profile
from sim.estimation.tracked.outcome import Tracked
from sim.flight.preparation import Prepared
from sim.flight.record import Flight
from sim.metrics.conformance import foremost
from sim.observation.record import SensorRecord
from sim.reporting.figures.flight import charts
from sim.reporting.figures.measurements import measurement_charts
from sim.reporting.figures.style import Chart
from sim.reporting.text.contrast_sentence import first_contrast
from sim.reporting.text.reasons import Flown, apart
from sim.reporting.tracker_figures.charts import alarm_charts, belief_charts, contrast_chart, error_charts
from sim.reporting.tracker_figures.error_curves import Shown, shown_trackers
from sim.reporting.tracker_figures.model_probabilities import mode_names
from sim.reporting.without_truth.figures import plot_charts

NAMES = {  # short ones; any other title becomes its own name
    "Plan view": "plan",
    "Vertical profile": "profile",
    "Flare and touchdown": "touchdown",
    "Bank and its limits": "bank",
    "Phase portrait of the law": "portrait",
    "Speed and configuration": "speed",
    "What the sensors measured": "measurements",
    "Error over time": "errors",
    "Does each tracker know how good it is?": "credibility",
    "Consistency over time": "consistency",
    "Estimates in plan": "estimates",
    "Tracks in plan": "estimates",
    "Containment against the radar's azimuth norm": "containment",
    "Who is flying?": "conformance",
    "Does each tracker still follow?": "monitor",
    "How soon, at which price": "delays",
}


class Run(NamedTuple):
    """One flight of a run, with the figures of metrics.json."""

    prepared: Prepared
    number: int
    flight: Flight
    records: Mapping[str, SensorRecord]
    tracks: Mapping[str, Tracked]
    metrics: Mapping[str, Any]

    @property
    def trackers(self) -> dict[str, Any]:
        """Figures of its trackers on this flight, where there are several that alone."""
        each = {one["flight"]: one["metrics"].get("trackers", {}) for one in self.metrics.get("each_flight", ())}
        found: dict[str, Any] = each.get(self.number, self.metrics["trackers"])
        return found


def figures_of(run: Run) -> dict[str, Chart]:
    """All figures of a run by name, in the order of its page: the contrast, the flight, its sensors, its trackers."""
    scenario, law, flight = run.prepared.scenario, run.prepared.law, run.flight
    tracked = dict(run.tracks)
    shown = shown_trackers(scenario, tracked)
    contrast = story(run, shown)
    found = [] if contrast is None else [("contrast", contrast)]
    drawn: list[Chart] = []
    if flight.known:
        drawn += charts(flight, scenario, law)
        drawn += measurement_charts(flight.whole, scenario.sensors, run.records)
    end = float(flight.time[-1])
    airborne = {name: record.until(end) for name, record in run.records.items()}
    judged = error_charts if flight.known else plot_charts
    drawn += judged(scenario, flight, run.trackers, shown, airborne, height_profile(run.prepared))
    modes = {
        name: mode_names(one.tracker, one.track.model_probabilities.shape[1])
        for name, one in tracked.items()
        if one.track.model_probabilities is not None
    }
    believing = {name: tracked[name] for name in modes}
    drawn += belief_charts(scenario, flight, run.trackers, believing, modes, foremost(tracked))
    drawn += alarm_charts(flight, run.trackers, tracked, shown)
    return dict([*found, *((name_of(chart.title), chart) for chart in drawn)])


def name_of(title: str) -> str:
    """The short name of a figure by its title."""
    return NAMES.get(title) or re.sub(r"[^a-z0-9]+", "_", title.lower()).strip("_")


def story(run: Run, shown: list[Shown]) -> Chart | None:
    """The first contrast of the scenario, where its two trackers part; None where there is none to draw."""
    first = first_contrast(dict(run.metrics))
    if first is None:
        return None
    flown = Flown(run.prepared.scenario, run.prepared.law, run.flight, dict(run.tracks))
    found = apart(flown, first["of"], first["against"])
    return contrast_chart(run.flight, first, shown, None if found is None else found.stretch)
