"""The files of a run that programs read: its scenario, its figures and its arrays."""

from __future__ import annotations

import json
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from sim.files import write_json, write_npz
from sim.flight.record import Flight
from sim.reporting.run_files import flight_arrays, measurement_arrays, track_arrays
from sim.scenario.toml_writer import dumps

if TYPE_CHECKING:
    from sim.results.result import Result

SCENARIO, METRICS, TIMING = "scenario.toml", "metrics.json", "timing.json"
FLIGHT, MEASUREMENTS, TRACKS = "flight.npz", "measurements.npz", "tracks.npz"
FILES = (SCENARIO, METRICS, FLIGHT, MEASUREMENTS, TRACKS)  # without which a folder is none of a run
WORDS = "words"  # of flight.npz, what of a flight is no array


def write_files(result: Result, place: Path) -> None:
    """Write the files into an existing folder; the arrays are those of the flight that the result has as a whole."""
    resolved = {**result.scenario.tables, "designed": result.prepared.design}
    (place / SCENARIO).write_text(dumps(resolved), encoding="utf-8")
    write_json(place / METRICS, result.metrics)
    words = {"number": result.number, **_words(result.flight)}
    write_npz(place / FLIGHT, {**flight_arrays(result.flight.whole), WORDS: np.array(json.dumps(words))})
    write_npz(place / MEASUREMENTS, measurement_arrays(result.records))
    write_npz(place / TRACKS, track_arrays(result.tracks))


def _words(flight: Flight) -> dict[str, Any]:
    """What of a flight and its roll-out no array holds."""
    return {
        "instants": len(flight.time),
        "phases": flight.phases,
        "events": flight.events,
        "outcome": flight.outcome,
        "reason": flight.reason,
        "gate_height_m": flight.gate_height,
        "utc_s": flight.utc,
        "rollout": None if flight.rollout is None else _words(flight.rollout),
    }
