"""The law of the medians and the axes of a study over all of them, as the tables of a scenario."""

from __future__ import annotations

import math
from typing import Any

from aircraft.units import preferred
from autopilot.identification import ROLL_RATE_LIMIT
from sim.scenario.toml_writer import dumps
from sim.studies.identification.spread import SHARES, Spread
from sim.studies.identification.survey import KEYS, Survey, scaled

FIGURES = 4  # of a number in the file
SAMPLES = 100  # of the study, to be changed
PLACES = {  # where a scenario has them; the lag is the aircraft's own
    "bank_limit": "autopilot",
    "k1": "autopilot.law",
    "k2": "autopilot.law",
    "cross_track_limit": "autopilot.law",
}


def law_text(found: Survey) -> str | None:
    """Text of law.toml; None where a number of the law is known from no capture."""
    middle = {name: spread.quantiles[SHARES.index(0.5)] for name, spread in found.spread.items()}
    if not all(math.isfinite(_known(found.spread[name], middle[name])) for name in PLACES):
        return None
    key, factor = preferred("roll_rate_limit", "rad/s")
    tables: dict[str, Any] = {
        "autopilot": {"kind": "lateral_navigation", key: _rounded(ROLL_RATE_LIMIT / factor), "law": {}},
        "study": {"samples": SAMPLES, "axes": {}},
    }
    for name, place in PLACES.items():
        spelled = KEYS[name][0]
        table = tables["autopilot"]["law"] if place.endswith("law") else tables["autopilot"]
        table[spelled] = _rounded(scaled(name, _known(found.spread[name], middle[name])))
        points = _points(name, found.spread[name])
        if points is not None:
            tables["study"]["axes"][f"{place}.{spelled}"] = {"quantiles": points}
    if not tables["study"]["axes"]:
        del tables["study"]
    return "".join(f"# {line}\n" for line in _remarks(found)) + "\n" + dumps(tables)


def _remarks(found: Survey) -> list[str]:
    lag = found.spread["lag"].quantiles[SHARES.index(0.5)]
    return [
        f"Law (4) as {found.explained} of {len(found.fits)} captures of {found.source} show it, by its medians.",
        f"The bank follows its command by {lag:.1f} s in the median; in a scenario that is the aircraft's own.",
        "Limits that a capture never met are taken as lower bounds (Kaplan and Meier); an upper end that only bounds",
        "reach is the largest number that was seen. Each axis is drawn by itself: what hangs together in one aircraft",
        "(k1 with k2) does not in a study. identification.json has the correlations.",
    ]


def _known(spread: Spread, value: float) -> float:
    """A quantile, or the largest estimate where only bounds lie that high."""
    return value if math.isfinite(value) else spread.highest


def _points(name: str, spread: Spread) -> list[list[float]] | None:
    """Points of a quantiles axis; None where all captures say the same."""
    if not spread.lowest < spread.highest:
        return None
    inner = [[share, _known(spread, value)] for share, value in zip(SHARES, spread.quantiles, strict=True)]
    points = [[0.0, spread.lowest], *inner, [1.0, spread.highest]]
    return [[share, _rounded(scaled(name, value))] for share, value in points]


def _rounded(value: float) -> float:
    return float(f"{value:.{FIGURES}g}")
