"""One self-contained HTML page about one run: what happened, how it looked, what it was checked against."""

from __future__ import annotations

from importlib import resources
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from sim import catalogue
from sim.flight import Flight
from sim.parameters import dump
from sim.reporting import style
from sim.reporting.histories import airframe_history, bank_history, error_history, final_errors, speed_history
from sim.reporting.phase_portrait import phase_portrait
from sim.reporting.plan_view import plan_view
from sim.reporting.quantities import ABSENT, decimals, number, split, unit, words
from sim.reporting.sentence import what_happened
from sim.reporting.sources import sources
from sim.reporting.tracker_tables import tracker_tables
from sim.reporting.vertical_profile import touchdown_view, vertical_profile
from sim.signals import SIGNALS
from sim.tables import Check
from sim.toml import dumps

MOST_EVENTS = 60


class Chart(NamedTuple):
    """A figure with what the reader should see in it."""

    title: str
    image: str  # data URI
    caption: str


def write(
    path: Path,
    *,
    scenario: Any,
    flight: Flight,
    law: Any,
    metrics: dict[str, Any],
    versions: dict[str, str],
    timing: dict[str, float],
    tracks: dict[str, Any] | None = None,
) -> Path:
    """Write the report of one run; the file needs nothing but a browser.

    Parameters
    ----------
    scenario : the resolved Scenario        flight : the first flight        law : the law that flew
    metrics : as in metrics.json            versions, timing : name -> version, name -> s
    tracks : name -> summary of a tracker, as in metrics.json under "trackers"; None = no trackers ran
    """
    page = _template().render(
        **_first_screen(scenario, flight, metrics),
        charts=charts(flight, scenario, law),
        checks=[_check_row(*pair) for pair in zip(scenario.checks, metrics["checks"], strict=True)],
        events=_event_rows(flight),
        outcome=words(metrics["flight"]["outcome"]),
        reason=metrics["flight"].get("reason", ""),
        flight_rows=_halves(_scalar_rows(metrics["flight"])),
        spread=_spread_rows(metrics.get("flights_summary")),
        trackers=tracker_tables(tracks) if tracks else [],
        draws=metrics.get("draws"),
        scenario_text=dumps(scenario.tables),
        law_rows=_law_rows(law),
        versions=sorted(versions.items()),
        timing=[(words(name.removesuffix("_s")), number(float(value), 2)) for name, value in timing.items()],
        **dict(zip(("equations", "papers", "errata"), sources(_what_ran(scenario, law)), strict=True)),
    )
    path.write_text(page, encoding="utf-8")
    return path


def _template() -> Any:
    import jinja2

    environment = jinja2.Environment(
        autoescape=True, undefined=jinja2.StrictUndefined, trim_blocks=True, lstrip_blocks=True
    )
    return environment.from_string((resources.files("sim.reporting") / "report.html").read_text(encoding="utf-8"))


def charts(flight: Flight, scenario: Any, law: Any) -> list[Chart]:
    """All figures of a flight that has something to show in them."""
    bank_limit = scenario.autopilot.bank_limit
    drawn: list[Chart] = []

    def add(title: str, figure: Any, caption: str) -> None:
        drawn.append(Chart(title, style.data_uri(figure), caption))

    with style.drawing(), np.errstate(invalid="ignore"):
        add(
            "Plan view",
            plan_view(flight, scenario.runway),
            "Equal scales; turned so that the final course runs to the right, north as the arrow shows. The runway's "
            "length is drawn, not modelled.",
        )
        add("Vertical profile", vertical_profile(flight, scenario.runway), "Heights are exaggerated against distances.")
        touchdown = touchdown_view(flight, scenario.runway)
        if touchdown is not None:
            add(
                "Flare and touchdown",
                touchdown,
                "Height of the aircraft's reference point; it stays above the ground when the wheels touch.",
            )
        add(
            "Bank and its limits",
            bank_history(flight, law, bank_limit),
            "Shaded: the command stands at the bank limit. Bars below: when the command, and when each input of the "
            "law as flown, was at or beyond its limit.",
        )
        add(
            "Phase portrait of the law",
            phase_portrait(flight, law),
            "Coloured line: the flown deviations, by phase, each leg begun at a circle. Shaded: the law asks for its "
            "bank limit. Between the dotted lines an input is passed on as it is, beyond them it is cut off; where "
            "the first input is cut off, the law settles on the line of wings level: the intercept.",
        )
        add(
            "Speed and configuration",
            speed_history(flight),
            "True airspeed against its schedule; flaps and gear as they moved.",
        )
        airframe = airframe_history(flight)
        if airframe is not None:
            add(
                "Airframe",
                airframe,
                "Attitude, path and controls of the six-degree-of-freedom aircraft.",
            )
        add(
            "Deviations",
            error_history(flight, scenario.runway),
            "Cross-track from the leg then active; height from the height of the leg, on the glide path from the path.",
        )
        last = final_errors(flight, scenario.runway)
        if last is not None:
            add(
                last[0],
                last[1],
                "The last stretch enlarged; the aircraft flies to the right. Scaled to what follows the capture.",
            )
    return drawn


def _first_screen(scenario: Any, flight: Flight, metrics: dict[str, Any]) -> dict[str, Any]:
    checks = metrics.get("checks", [])
    failed = [_check_name(check) for check in checks if check["passed"] is False]
    return {
        "name": scenario.name,
        "subtitle": _subtitle(scenario, metrics),
        "sentence": what_happened(flight, metrics["flight"], checks),
        "good": not failed and metrics["flight"]["outcome"] in ("landed", "completed"),
        "failed": failed,
        "warnings": metrics.get("warnings", []),
        "key_figures": _key_figures(metrics["flight"]),
    }


def _subtitle(scenario: Any, metrics: dict[str, Any]) -> list[str]:
    aircraft, wind = scenario.aircraft, scenario.wind
    parts = [f"aircraft {words(aircraft.model)}"]
    if aircraft.mass is not None:
        parts.append(f"{aircraft.mass / 1000:.1f} t")
    parts.append(f"law {words(scenario.mode)}, bank limit {np.degrees(scenario.autopilot.bank_limit):.0f} deg")
    if wind.speed > 0:
        parts.append(f"wind from {np.degrees(wind.from_) % 360:03.0f} deg at {wind.speed:.1f} m/s")
    else:
        parts.append("no steady wind")
    if wind.intensity > 0:
        parts.append(
            f"turbulence {wind.turbulence if wind.turbulence != 'none' else ''} (W20 {wind.intensity:.1f} m/s)"
        )
    parts.append(f"seed {metrics.get('seed', scenario.seed)}")
    if metrics.get("flights", 1) > 1:
        parts.append(f"first of {metrics['flights']} flights")
    return parts


KEY_FIGURES = (
    ("duration_s", "flight time"),
    ("bank_max_deg", "greatest bank"),
    ("time_saturated_s", "at the bank limit"),
    ("base_overshoot_m", "overshoot of base"),
    ("overshoot_m", "overshoot of the last leg"),
    ("settling_s", "settled after"),
    ("cross_track_rms_final_m", "cross-track RMS, final"),
    ("height_error_rms_final_m", "height error RMS, glide path"),
    ("touchdown.past_threshold_m", "touchdown past the threshold"),
    ("touchdown.cross_track_m", "touchdown right of centreline"),
    ("touchdown.sink_mps", "sink at touchdown"),
    ("touchdown.crab_deg", "crab at touchdown"),
)
TENTHS = ("duration_s", "time_saturated_s", "settling_s")


def _key_figures(flight: dict[str, Any]) -> list[tuple[str, str, str]]:
    """(label, number, unit) of the figures that this flight has."""
    shown = []
    for key, label in KEY_FIGURES:
        value: Any = flight
        for part in key.split("."):
            value = value.get(part) if isinstance(value, dict) else None
        if value is not None:
            places = 1 if key in TENTHS else min(decimals(value), 2)
            shown.append((label, number(float(value), places), split(key)[1]))
    return shown


def _check_row(asked: Check, check: dict[str, Any]) -> dict[str, Any]:
    """A check as text; value, limit and margin with the same decimals, enough to tell value and limit apart."""
    value, limit, margin = check["value"], check["limit"], check["margin"]
    places = decimals(value, limit)
    while margin and abs(margin) < 0.5 * 10**-places and places < 6:
        places += 1
    during = check["during"] if isinstance(check["during"], str) else ", ".join(check["during"])
    return {
        "name": _check_name(check),
        "when": (words(during) if during != "all" else "whole flight") if check["metric"] in SIGNALS else ABSENT,
        "how": _statistic(check["statistic"], check["for_s"]) if check["metric"] in SIGNALS else "once",
        "limit": _limits(asked, places),
        "value": number(None if value is None else float(value), places),
        "margin": number(None if margin is None else float(margin), places),
        "unit": unit(check["unit"]),
        "time": number(None if check["time_s"] is None else float(check["time_s"]), 1),
        "passed": check["passed"],
        "source": check["source"] or ABSENT,
    }


def _limits(asked: Check, places: int) -> str:
    """What was allowed, as a relation or a range."""
    low, high = (None if bound is None else number(float(bound), places) for bound in (asked.min, asked.max))
    if low is not None and high is not None:
        return f"{low} … {high}"
    return f"≤ {high}" if low is None else f"≥ {low}"


def _check_name(check: dict[str, Any]) -> str:
    """The user's name of a check, or its metric in words; the unit has a column of its own."""
    return words(check["name"]) if check["name"] != check["metric"] else split(check["metric"])[0]


def _statistic(name: str, lasting: float) -> str:
    told = {"max": "", "mean_5_s": "mean over 5 s", "rms": "RMS", "p95": "95th percentile"}.get(name, words(name))
    held = f"for {lasting:g} s" if lasting else ""
    return ", ".join(part for part in (told, held) if part) or "at any time"


def _event_rows(flight: Flight) -> list[tuple[str, ...]]:
    """(time, event, height, airspeed, bank, detail) of everything that happened once."""
    rows = []
    for event in flight.events[:MOST_EVENTS]:
        at = min(int(np.searchsorted(flight.time, event.time)), len(flight.time) - 1)
        s = flight.state
        rows.append(
            (
                number(float(event.time), 1),
                words(event.name),
                number(float(s.height[at]), 1),
                number(float(s.airspeed[at]), 1),
                number(float(np.degrees(s.bank[at])), 1),
                event.detail.partition("; last state")[0],
            )
        )
    return rows


def _scalar_rows(figures: dict[str, Any], prefix: str = "") -> list[tuple[str, str, str]]:
    """(name, value, unit) of every number; nested tables are written out."""
    rows: list[tuple[str, str, str]] = []
    for key, value in figures.items():
        if isinstance(value, dict):
            rows += _scalar_rows(value, f"{prefix}{words(key)}: ")
        elif not isinstance(value, str) and key != "landed":  # the outcome says it
            name, suffix = split(key)
            rows.append((prefix + name, number(value), suffix if value is not None else ""))
    return rows


def _halves(rows: list[Any]) -> list[list[Any]]:
    """Two tables of nearly the same length, to stand beside each other."""
    middle = -(-len(rows) // 2)
    return [rows[:middle], rows[middle:]]


def _spread_rows(summary: dict[str, Any] | None) -> dict[str, Any] | None:
    """Outcome counts and percentiles over several flights."""
    if not summary or sum(summary.get("outcomes", {}).values()) < 2:
        return None
    rows = []
    for key, figures in summary.items():
        if key != "outcomes":
            name, suffix = split(key)
            values = [figures["p5"], figures["p50"], figures["p95"]]
            places = decimals(*values)
            rows.append((name, suffix, *(number(float(v), places) for v in values)))
    return {"outcomes": [(words(name), count) for name, count in summary["outcomes"].items()], "rows": rows}


def _law_rows(law: Any) -> list[tuple[str, str, str]]:
    """(field, value, unit) of the law that flew, as it would stand in a file."""
    return [
        (*split(key), f"{value:.5g}" if isinstance(value, float) else str(value)) for key, value in dump(law).items()
    ]


def _what_ran(scenario: Any, law: Any) -> list[Any]:
    """Everything whose docstrings name the sources of this run."""
    kinds = dict.fromkeys(tracker.kind for tracker in scenario.trackers.values())
    trackers = [catalogue.load("trackers", kind) for kind in kinds]
    return [law, scenario.route, scenario.wind, *scenario.sensors.values(), *trackers]
