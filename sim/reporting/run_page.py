"""One self-contained HTML page about one run: what happened, how it looked, what it was checked against."""

from __future__ import annotations

import itertools
import json
from collections.abc import Iterable, Iterator
from pathlib import Path
from typing import Any, NamedTuple

from sim.flight.record import Flight
from sim.metrics.conformance import conformance_sentence, foremost
from sim.reporting.figures.flight import charts
from sim.reporting.figures.measurements import measurement_charts
from sim.reporting.page import Picture, picture, rendered
from sim.reporting.replay import replay
from sim.reporting.text.best_tracker import leading
from sim.reporting.text.contrast_sentence import contrast_sentences, first_contrast, losses
from sim.reporting.text.header import first_screen
from sim.reporting.text.labels import words
from sim.reporting.text.outcome_sentence import first_clause
from sim.reporting.text.reasons import Flown, apart
from sim.reporting.text.references import FLIGHT_DYNAMICS, aircraft_sources, sources, what_ran
from sim.reporting.text.rows import (
    beside_rows,
    check_name,
    check_row,
    event_rows,
    every_flight,
    halves,
    last_state,
    law_rows,
    scalar_rows,
    spread_rows,
)
from sim.reporting.text.tracker_tables import tracker_tables
from sim.reporting.tracker_figures.charts import alarm_charts, belief_charts, contrast_chart, error_charts, story_chart
from sim.reporting.tracker_figures.error_curves import Shown, shown_trackers
from sim.reporting.tracker_figures.model_probabilities import mode_names
from sim.reporting.without_truth.figures import plot_charts
from sim.reporting.without_truth.tables import plot_tables
from sim.scenario.toml_writer import dumps
from sim.versions import rows
from tracking.height_profile import Charted

LARGEST = 1_800_000  # bytes of the figures of a page, about; a page is to stay below 2 MB
ROOM = 200_000  # bytes, below which no further flight is worth drawing
MOST_ROWS = 200  # of the table of all flights; metrics.json has them all


class Seen(NamedTuple):
    """One flight with all that watched it; figures as in metrics.json."""

    number: int
    flight: Flight
    records: dict[str, Any]  # name -> SensorRecord
    tracked: dict[str, Any]  # name -> Tracked
    figures: dict[str, Any]
    trackers: dict[str, Any]
    chart: Charted | None = None  # of the heights by which its plots are drawn


def write(
    path: Path,
    *,
    scenario: Any,
    law: Any,
    metrics: dict[str, Any],
    versions: dict[str, Any],
    flights: Iterable[Seen],
) -> Path:
    """Write the report of one run; the file needs nothing but a browser.

    Parameters
    ----------
    scenario : the resolved Scenario        law : the law that flew
    metrics : as in metrics.json            versions : name -> version
    flights : those that are drawn, the worst first; one after another, so that no two are held at a time
    """
    first, *others = _pages(scenario, law, metrics, flights)
    equations, papers, errata = sources(what_ran(scenario, law))
    several = metrics.get("flights", 1) > 1
    page = rendered(
        "report.html",
        ["replay.js"] if first["replay"] else [],
        **first,
        others=others,
        every=every_flight(metrics.get("each_flight", ()), [check_name(check) for check in metrics["checks"]])[
            :MOST_ROWS
        ],
        several=metrics["flights"] if several else 0,
        checks=[check_row(*pair) for pair in zip(scenario.checks, metrics["checks"], strict=True)],
        spread=spread_rows(metrics.get("flights_summary", {})),
        trackers=(plot_tables(metrics["trackers"]) or tracker_tables(metrics["trackers"]))
        if metrics.get("trackers")
        else [],
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


class Contrasted(NamedTuple):
    """What the first screen has of the trackers that are set against each other."""

    sentences: list[str]
    chart: Picture | None = None
    opens: str = ""  # what is said of where the replay opens
    parted: float | None = None  # s


NOTHING = Contrasted([])


def _contrast(metrics: dict[str, Any], flown: Flown, shown: list[Shown], trackers: dict[str, Any]) -> Contrasted:
    """Sentences of all contrasts, figure and replay of the first."""
    told, first = contrast_sentences(metrics, flown, trackers), first_contrast(metrics)
    if first is None:
        return Contrasted(told)
    found = apart(flown, first["of"], first["against"])
    stretch = None if found is None else found.stretch
    drawn = contrast_chart(flown.flight, first, shown, stretch)
    chart = None if drawn is None else picture(drawn)
    if stretch is None:
        return Contrasted(told, chart)
    opens = f"It opens shortly before {words(first['of'])} and {words(first['against'])} part."
    return Contrasted(told, chart, opens, stretch.start)


def _pages(scenario: Any, law: Any, metrics: dict[str, Any], flights: Iterable[Seen]) -> Iterator[dict[str, Any]]:
    """What the page says of each flight, while there is room; replay and head of the page are of the first."""
    room = LARGEST
    for place, seen in enumerate(flights):
        page = _page(scenario, law, metrics, seen, place == 0)
        if place > 0:
            every = len(page["charts"]) + len(page["tracker_charts"])
            page["charts"] = _fitting(page["charts"], room)
            page["tracker_charts"] = _fitting(page["tracker_charts"], room - _size(page["charts"]))
            page["left_out"] = every - len(page["charts"]) - len(page["tracker_charts"])
        room -= _size([*page["charts"], *page["tracker_charts"], *([page["story"]] if page["story"] else [])])
        room -= len(json.dumps(page["replay"]))
        yield page
        if room < ROOM or page.get("left_out"):
            return


def _size(charts: list[Picture]) -> int:
    return sum(len(chart.image) for chart in charts)


def _fitting(charts: list[Picture], room: int) -> list[Picture]:
    """The first charts that fit into so many bytes together."""
    sizes = itertools.accumulate(len(chart.image) for chart in charts)
    return [chart for chart, size in zip(charts, sizes, strict=True) if size <= room]


def _page(scenario: Any, law: Any, metrics: dict[str, Any], seen: Seen, is_first: bool) -> dict[str, Any]:
    """One flight; ``metrics`` are those of the run."""
    flight, whole, trackers, tracked = seen.flight, seen.flight.whole, seen.trackers, seen.tracked
    modes = {
        name: mode_names(one.tracker, one.track.model_probabilities.shape[1])
        for name, one in tracked.items()
        if one.track.model_probabilities is not None
    }
    alert = foremost(tracked)
    believing = {name: tracked[name] for name in modes}
    beliefs = belief_charts(scenario, flight, trackers, believing, modes, alert)
    shown = shown_trackers(scenario, tracked)
    whole, end = flight.whole, float(flight.time[-1])
    airborne = {name: record.until(end) for name, record in seen.records.items()}
    judged = error_charts if flight.known else plot_charts
    errors = judged(scenario, flight, trackers, shown, airborne, seen.chart)
    alarms = alarm_charts(flight, trackers, tracked, shown)
    flight_charts = charts(flight, scenario, law) if flight.known else []
    measured = measurement_charts(whole, scenario.sensors, seen.records) if flight.known else []
    flown = Flown(scenario, law, flight, tracked)
    contrast = _contrast(metrics, flown, shown, trackers) if is_first else NOTHING
    pictures = drawn = [*map(picture, (*flight_charts, *measured))]
    story = contrast.chart
    if is_first and story is None:  # the best of those that saw the flight, else the flight
        best = story_chart(flight, leading(flight, trackers, shown))
        if best is not None:
            story = picture(best)
        elif pictures:
            story, *pictures = pictures
    own = {**metrics, "flight": seen.figures, "trackers": trackers}
    return {
        **first_screen(scenario, flight, own, shown, seen.number, contrast.sentences),
        "story": story,
        "answered": bool(contrast.sentences) or story not in (None, *drawn),
        "lost": losses(metrics, flown, trackers) if is_first else [],
        "opens": contrast.opens,
        "conformance": conformance_sentence(words(alert[0]), trackers[alert[0]]["conformance"]) if alert else "",
        "replay": replay(whole, scenario, shown, seen.records, seen.chart, contrast.parted) if is_first else None,
        "known": flight.known,
        "charts": pictures,
        "events": event_rows(whole) if flight.known else [],
        "outcome": words(seen.figures["outcome"]),
        "reason": first_clause(flight.reason),
        "last_state": last_state(flight),
        "flight_rows": halves(scalar_rows(seen.figures)),
        "beside": beside_rows(seen.figures),
        "tracker_charts": [*map(picture, (*errors, *beliefs, *alarms))],
    }
