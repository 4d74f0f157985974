"""Tables of the report as rows of text: checks, events, figures, the law."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np

from sim.flight.record import Flight
from sim.metrics import signals, table
from sim.metrics.ensemble.verdict import worst_first
from sim.metrics.flight import NAVIGATED, figure
from sim.metrics.navigation import beside
from sim.reporting.text.labels import ABSENT, decimals, named, number, split, unit, words
from sim.reporting.text.outcome_sentence import first_clause
from sim.scenario.parameters import dump
from sim.scenario.tables import Check

MOST_EVENTS = 60  # before the last, which says how the flight ended
LANDED = "landed"  # the figure that the outcome says in words


def check_row(asked: Check, check: dict[str, Any]) -> dict[str, Any]:
    """A check as text; value, limit and margin with the same decimals, enough to tell value and limit apart."""
    value, limit, margin = check["value"], check["limit"], check["margin"]
    places = decimals(value, limit)
    while margin and abs(margin) < 0.5 * 10**-places and places < 6:
        places += 1
    during = check["during"] if isinstance(check["during"], str) else ", ".join(check["during"])
    over_time = signals.find(check["metric"]) is not None
    return {
        "name": check_name(check),
        "when": (words(during) if during != "all" else "whole flight") if over_time else ABSENT,
        "how": _statistic(check["statistic"], check["for_s"]) if over_time else "once",
        "limit": _limits(asked, places),
        "value": number(None if value is None else float(value), places),
        "margin": number(None if margin is None else float(margin), places),
        "unit": unit(check["unit"]),
        "time": number(None if check["time_s"] is None else float(check["time_s"]), 1),
        "passed": check["passed"],
        "kept": kept_by(check),
        "flight": str(check["flight"]),
        "source": check["source"] or ABSENT,
    }


def kept_by(check: dict[str, Any]) -> str:
    """How many of the flights in which it could be judged kept a check, and what that shows where a share is asked."""
    kept = f"{check['within']} of {check['flights'] - check['not_flown']}"
    if check["share_low"] is None:
        return kept
    shown, asked, confidence = (100.0 * check[key] for key in ("share_low", "share", "confidence"))
    return f"{kept}: shows {shown:.3g} %, asked {asked:g} %, with {confidence:g} % confidence"


def every_flight(records: Sequence[dict[str, Any]], names: Sequence[str]) -> list[dict[str, Any]]:
    """All flights of a run, the worst first: how each ended, which checks it broke, and how near it came to a limit.

    ``names`` are those of the checks. The nearest is told as the margin over the size of the limit.
    """
    rows = []
    for record in worst_first(records):
        results = [*zip(names, record["checks"], strict=False)]
        margins = [(one["margin"] / abs(one["limit"]), name) for name, one in results if one["margin"] and one["limit"]]
        nearest = min(margins, default=None)
        rows.append(
            {
                "flight": record["flight"],
                "outcome": words(record["metrics"]["outcome"]),
                "broken": ", ".join(name for name, one in results if one["passed"] is False) or ABSENT,
                "nearest": ABSENT if nearest is None else f"{number(100.0 * nearest[0], 1)} % ({nearest[1]})",
            }
        )
    return rows


def flights_of(metrics: dict[str, Any]) -> str:
    """How many flights a study has, and in how many cells where there are several."""
    flights, cells = metrics["flights"], len(metrics["rows"])
    told = f"{flights} flight{'s' if flights > 1 else ''}"
    return f"{told} in {cells} cells" if cells > 1 else told


def _limits(asked: Check, places: int) -> str:
    """What was allowed, as a relation or a range."""
    low, high = (None if bound is None else number(float(bound), places) for bound in (asked.min, asked.max))
    if low is not None and high is not None:
        return f"{low} … {high}"
    return f"≤ {high}" if low is None else f"≥ {low}"


def check_name(check: dict[str, Any]) -> str:
    """The user's name of a check, or the label of its metric; the unit has a column of its own."""
    return words(check["name"]) if check["name"] != check["metric"] else named(check["metric"])[0]


def _statistic(name: str, lasting: float) -> str:
    told = {"max": "", "mean_5_s": "mean over 5 s", "rms": "RMS", "p95": "95th percentile"}.get(name, words(name))
    held = f"for {lasting:g} s" if lasting else ""
    return ", ".join(part for part in (told, held) if part) or "at any time"


def event_rows(flight: Flight) -> list[tuple[str, ...]]:
    """(time, event, height, true airspeed, bank, detail) of everything that happened once."""
    rows: list[tuple[str, ...]] = []
    for event in (*flight.events[:-1][:MOST_EVENTS], *flight.events[-1:]):
        at = min(int(np.searchsorted(flight.time, event.time)), len(flight.time) - 1)
        s = flight.state
        rows.append(
            (
                number(float(event.time), 1),
                words(event.name),
                number(float(s.height[at]), 1),
                number(float(s.airspeed[at]), 1),
                number(float(np.degrees(s.bank[at])), 1),
                first_clause(event.detail),
            )
        )
    return rows


def last_state(flight: Flight) -> list[tuple[str, str, str]]:
    """(name, value, unit) of the motion at the end of the record."""
    s = flight.state
    shown = (
        ("time", s.time, "s"), ("north", s.north, "m"), ("east", s.east, "m"), ("height", s.height, "m"),
        ("velocity north", s.velocity_north, "m/s"), ("east", s.velocity_east, "m/s"), ("up", s.velocity_up, "m/s"),
        ("bank", np.degrees(s.bank), "deg"), ("pitch", np.degrees(s.pitch), "deg"),
        ("heading", np.degrees(s.heading) % 360, "deg"), ("true airspeed", s.airspeed, "m/s"),
        ("equivalent airspeed", s.equivalent_airspeed, "m/s"),
        ("angle of attack", np.degrees(s.angle_of_attack), "deg"), ("sideslip", np.degrees(s.sideslip), "deg"),
    )  # fmt: skip
    return [(name, number(float(values[-1]), 2), unit) for name, values, unit in shown]


def scalar_rows(figures: dict[str, Any]) -> list[tuple[str, str, str]]:
    """(label, value, unit) of every row of the metric table; those of a nested table only where the flight has it."""
    rows: list[tuple[str, str, str]] = []
    for row in table.METRICS:
        nested = row.name.rpartition(".")[0]
        if row.name == LANDED or nested == NAVIGATED or (nested and not figures.get(nested)):
            continue
        value = figure(figures, row.name)
        rows.append((row.label, number(value, row.digits), unit(row.unit) if value is not None else ""))
    return rows


def beside_rows(figures: dict[str, Any]) -> list[tuple[str, str, str, str]]:
    """(figure, on the estimate, on the truth, unit) of a flight that a tracker navigated; empty for others."""
    rows = []
    for key, flown, truth in beside(figures):
        name, suffix = named(key)
        row = table.find(key)
        places = None if row is None else row.digits
        ours, theirs = (words(it) if isinstance(it, str) else number(it, places) for it in (flown, truth))
        rows.append((name, ours, theirs, suffix))
    return rows


def halves(rows: list[Any]) -> list[list[Any]]:
    """Two tables of nearly the same length, to be shown side by side."""
    middle = -(-len(rows) // 2)
    return [rows[:middle], rows[middle:]]


def spread_rows(summary: dict[str, Any]) -> list[tuple[str, ...]]:
    """(label, unit, 5th, 50th, 95th percentile) over several flights; empty for one."""
    if sum(summary.get("outcomes", {}).values()) < 2:
        return []
    return [
        (row.label, unit(row.unit), *(number(float(summary[row.name][p]), row.digits) for p in ("p5", "p50", "p95")))
        for row in table.METRICS
        if row.name in summary and row.name != LANDED
    ]


def law_rows(law: Any) -> list[tuple[str, str, str]]:
    """(field, value, unit) of the law that flew, in the spelling of scenario files."""
    return [
        (*split(key), f"{value:.5g}" if isinstance(value, float) else str(value)) for key, value in dump(law).items()
    ]
