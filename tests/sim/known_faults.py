"""Scenario files of a few short flights each, some with a fault that only one flight after the first has.

What every flight does is measured here on its record, by numpy and without the checks; a limit between the two largest
values is then kept by all flights but one, and a limit above them by all.
"""

from __future__ import annotations

import json
from collections.abc import Iterator
from typing import Any, NamedTuple

import numpy as np

import sim
from sim.flight.preparation import prepare

FLIGHTS = 6
TABLES = {
    "until_s": 36.0,
    "draws": 3,
    "route": {
        "kind": "legs",
        "legs": [
            {"from_m": [0, 0], "to_m": [1800, 0], "speed_mps": 72, "height_m": 600},
            {"from_m": [1800, 0], "to_m": [9000, 3000], "speed_mps": 72, "height_m": 600},
        ],
    },
    "start": {"leg": 0, "cross_track_m": 100.0},
    "wind": {"turbulence": "moderate"},
    "sensors": {"radar": {"kind": "surveillance_radar"}},
    "trackers": {"plain": {"kind": "kalman"}},
}
TRACKER = "trackers.plain.overall.position_m.rmse"
ASKED = (  # metric and phase; other phases of the same flights are far beyond the limit
    ("bank_deg", "base"),
    ("cross_track_m", "final"),
    (TRACKER, "all"),
    ("bank_max_deg", "all"),
)


class File(NamedTuple):
    """A scenario file, and what is known of it."""

    name: str
    text: str
    check: dict[str, Any]
    faulty: int | None  # the one flight that breaks the check


def measured(seed: int, flights: int, metric: str, phase: str) -> list[float]:
    """The figure of each flight, from its record."""
    prepared = prepare(sim.read({"name": "known", "seed": seed, **TABLES}))
    found = []
    for number in range(flights):
        flight = sim.fly(prepared, number)
        if metric == TRACKER:
            found.append(position_error(prepared, flight, number))
            continue
        values = flight.deviation.cross_track if metric == "cross_track_m" else np.degrees(flight.state.bank)
        during = flight.phase >= 0 if phase == "all" else flight.phase == flight.phases.index(phase)
        found.append(float(np.abs(values[during]).max()))
    return found


def position_error(prepared: Any, flight: Any, number: int) -> float:
    """Root mean square distance of the estimates, over epochs and draws."""
    scenario = prepared.scenario
    records = sim.observe(flight, scenario.sensors, scenario.seed, number, scenario.draws)
    track = sim.track(prepared, flight, records, {}, number)[0]["plain"].track
    true = [np.interp(track.time, flight.time, path) for path in (flight.state.north, flight.state.east)]
    rows = [track.channels.index(name) for name in ("north", "east")]
    squares = sum((track.mean[:, row] - path[:, None]) ** 2 for row, path in zip(rows, true, strict=True))
    return float(np.sqrt(np.mean(squares)))


def files(count: int, flights: int = FLIGHTS) -> Iterator[File]:
    """``count`` files with a fault in a flight after the first, and as many without any."""
    found = {True: 0, False: 0}
    for seed in range(1, 100 * count):
        metric, phase = ASKED[seed % len(ASKED)]
        values = measured(seed, flights, metric, phase)
        *_, second, worst = sorted(values)
        wanted = found[True] <= found[False]
        if wanted and (values[0] == worst or worst - second < 1e-3 * worst):
            continue  # the fault must be in a flight after the first, and be one
        limit = (second + worst) / 2 if wanted else 1.01 * worst
        found[wanted] += 1
        check = {"metric": metric, "during": phase, "max": limit, "source": "known"}
        name = f"{'bad' if wanted else 'good'}_{found[wanted]}"
        repeat = f"[study]\nsamples = {flights}" if seed % 3 else ""
        text = written({"name": name, "seed": seed, "flights": 1 if repeat else flights, **TABLES}, check) + repeat
        yield File(name, text, check, values.index(worst) if wanted else None)
        if min(found.values()) == count:
            return


def written(tables: dict[str, Any], check: dict[str, Any]) -> str:
    """The text of a file."""
    from sim.scenario.toml_writer import dumps

    assert json.loads(json.dumps(tables)) == tables
    return dumps({**tables, "checks": [check]}) + "\n"
