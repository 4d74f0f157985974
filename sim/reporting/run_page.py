"""One self-contained HTML page about one run: what happened, how it looked, what it was checked against."""

from __future__ import annotations

import base64
import hashlib
from pathlib import Path
from typing import Any

from sim.flight.record import Flight
from sim.metrics.conformance import conformance_sentence, foremost
from sim.reporting.figures.flight import charts
from sim.reporting.figures.measurements import measurement_charts
from sim.reporting.page import rendered, text_of
from sim.reporting.replay import replay
from sim.reporting.text.header import first_screen
from sim.reporting.text.labels import words
from sim.reporting.text.outcome_sentence import first_clause
from sim.reporting.text.references import FLIGHT_DYNAMICS, aircraft_sources, sources, what_ran
from sim.reporting.text.rows import (
    beside_rows,
    check_row,
    event_rows,
    halves,
    last_state,
    law_rows,
    scalar_rows,
    spread_rows,
)
from sim.reporting.text.tracker_tables import tracker_tables
from sim.reporting.tracker_figures.charts import belief_charts, error_charts
from sim.reporting.tracker_figures.error_curves import shown_trackers
from sim.reporting.tracker_figures.model_probabilities import mode_names
from sim.scenario.toml_writer import dumps
from sim.versions import rows
from sim.workers.sharing import current


def write(
    path: Path,
    *,
    scenario: Any,
    flight: Flight,
    law: Any,
    metrics: dict[str, Any],
    versions: dict[str, Any],
    tracked: dict[str, Any] | None = None,
    records: dict[str, Any] | None = None,
) -> Path:
    """Write the report of one run; the file needs nothing but a browser.

    Parameters
    ----------
    scenario : the resolved Scenario        flight : the first flight        law : the law that flew
    metrics : as in metrics.json            versions : name -> version
    tracked, records : name -> Tracked, name -> SensorRecord of the first flight
    """
    whole = flight.whole
    flight_charts = current().later(charts, flight, scenario, law)
    trackers, tracked, records = metrics.get("trackers") or {}, tracked or {}, records or {}
    modes = {
        name: mode_names(one.tracker, one.track.model_probabilities.shape[1])
        for name, one in tracked.items()
        if one.track.model_probabilities is not None
    }
    alert = foremost(tracked)
    believing = {name: tracked[name] for name in modes}
    beliefs = current().later(belief_charts, scenario, flight, trackers, believing, modes, alert)
    shown = shown_trackers(scenario, tracked)
    airborne = {name: record.until(float(flight.time[-1])) for name, record in records.items()}
    errors = error_charts(scenario, flight, trackers, shown, airborne)
    script = text_of("replay.js")
    equations, papers, errata = sources(what_ran(scenario, law))
    page = rendered(
        "report.html",
        **first_screen(scenario, flight, metrics, shown),
        conformance=conformance_sentence(words(alert[0]), trackers[alert[0]]["conformance"]) if alert else "",
        charts=[*flight_charts(), *measurement_charts(whole, scenario.sensors, records)],
        checks=[check_row(*pair) for pair in zip(scenario.checks, metrics["checks"], strict=True)],
        events=event_rows(whole),
        outcome=words(metrics["flight"]["outcome"]),
        reason=first_clause(flight.reason),
        last_state=last_state(flight),
        flight_rows=halves(scalar_rows(metrics["flight"])),
        beside=beside_rows(metrics["flight"]),
        spread=spread_rows(metrics.get("flights_summary", {})),
        trackers=tracker_tables(trackers) if trackers else [],
        tracker_charts=[*errors, *beliefs()],
        replay=replay(whole, scenario, shown, records),
        script=script,
        script_hash=base64.b64encode(hashlib.sha256(script.encode()).digest()).decode(),
        draws=metrics.get("draws"),
        scenario_text=dumps({**scenario.tables, "designed": None}),
        law_rows=law_rows(law),
        law_text=law.explain(),
        versions=rows(versions),
        aircraft_sources=aircraft_sources(scenario.aircraft.model),
        equations=equations,
        papers=papers if scenario.aircraft.model == "point_mass" else [*papers, FLIGHT_DYNAMICS],
        errata=errata,
    )
    path.write_text(page, encoding="utf-8")
    return path
