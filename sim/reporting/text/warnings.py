"""What a reader of a run should know, one sentence each: a final flown too slowly, who saw nothing, and why."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from typing import Any

import numpy as np

from autopilot.landing import REFERENCE_MARGIN
from sim.flight.outcomes import STOPPED
from sim.flight.record import Flight
from sim.observation.record import SensorRecord
from sim.scenario.tables import Check
from tracking.track import FARTHEST

CLOSE = 50.0  # m from an antenna: there the noise of a range is a good part of it, and its angles mean little


def warnings(
    flight: Flight,
    figures: dict[str, Any],
    sensors: dict[str, Any],
    records: dict[str, SensorRecord],
    trackers: dict[str, dict[str, Any]],
) -> list[str]:
    """Sentences about a final flown too slowly, sensors that measured nothing or are on the flight path.

    ``figures`` and ``trackers`` are as in metrics.json.
    """
    slowest = figures.get("final_over_stall")
    found: list[str | None] = [
        f"the glide path was flown at {slowest:.2f} of the stall speed (mean of the equivalent airspeed over 5 s), "
        f"below {REFERENCE_MARGIN}"
        if slowest is not None and slowest < REFERENCE_MARGIN
        else None
    ]
    rollout = flight.rollout
    if rollout is not None and not flight.is_recorded and rollout.outcome != STOPPED:
        found.append(f"the roll-out after the landing was not a stop on the runway: {rollout.reason}")
    found += [_sensor(flight, name, sensors[name], record) for name, record in records.items()]
    found += [
        f"tracker '{name}' got no measurement of the aircraft: it has no figures"
        for name, its in trackers.items()
        if "look_ahead" not in its
    ]
    found += [
        f"tracker '{name}' gives estimates that are no numbers"
        for name, its in trackers.items()
        if any(figure["rmse"] is None or not np.isfinite(figure["rmse"]) for figure in its["overall"].values())
    ]
    return [sentence for sentence in found if sentence]


def unjudged(flight: Flight, checks: Iterable[Check], found: Iterable[dict[str, Any]]) -> list[str]:
    """Sentences about checks of what a recorded flight does not know; ``found`` is what each check found on it."""
    return [
        f"the check of '{asked.metric}' is not judged: the recording does not know it, or has no such phase"
        for asked, one in zip(checks, found, strict=True)
        if flight.is_recorded and one["passed"] is None
    ]


def skipped_looks(records: Sequence[dict[str, Any]]) -> list[str]:
    """Sentences about looks that trackers could not use in any flight; ``records`` as they are kept of flights."""
    found: dict[str, list[tuple[int, dict[str, Any]]]] = {}
    for record in records:
        for name, its in record["metrics"].get("trackers", {}).items():
            if "skipped" in its:
                found.setdefault(name, []).append((record["flight"], its["skipped"]))
    return [_skipped(name, flights, len(records)) for name, flights in found.items()]


def _skipped(name: str, flights: Sequence[tuple[int, dict[str, Any]]], flown: int) -> str:
    looks, of_looks = (sum(skipped[key] for _, skipped in flights) for key in ("looks", "of_looks"))
    number, first = flights[0]
    where = f" in {len(flights)} of {flown} flights, the first in flight {number}" if flown > 1 else ", the first"
    return (
        f"tracker '{name}' could not use {looks} of {of_looks} looks{where} at {first['first_s']:.1f} s: "
        f"what they measured is beyond {FARTHEST:g} m, or leaves no estimate"
    )


def contrast_warnings(contrasts: list[dict[str, Any]], trackers: dict[str, dict[str, Any]]) -> list[str]:
    """Sentences about contrasts, as in metrics.json, that have nothing to compare, or no ratio."""
    return [sentence for one in contrasts for sentence in _contrast(one, trackers)]


def _contrast(contrast: dict[str, Any], trackers: dict[str, dict[str, Any]]) -> list[str]:
    pair = (contrast["of"], contrast["against"])
    place = f"contrast of '{pair[0]}' against '{pair[1]}'"
    absent = [name for name in pair if not trackers.get(name, {}).get("overall")]
    if absent:
        return [f"{place}: '{absent[0]}' never tracked the aircraft, so there is nothing to compare"]
    if not contrast["overall"]:
        return [
            f"{place}: at no epoch are both measured in a channel that both estimate, so there is nothing to compare"
        ]
    lost = [contrast[side] for side in ("of", "against") if any(f[side] is None for f in contrast["overall"].values())]
    return [f"{place}: errors of '{name}' are not finite, so there is no ratio" for name in lost]


def _sensor(flight: Flight, name: str, sensor: Any, record: SensorRecord) -> str | None:
    if not len(record.time) or not np.isfinite(record.z).any():
        return f"sensor '{name}' never saw the aircraft"
    end = float(flight.time[-1])
    if record.arrival.min() > end:
        return f"sensor '{name}' delivers nothing before the flight of {end:.0f} s is over: its latency is longer"
    if sensor.antenna is None or "azimuth" not in record.channels or not flight.known:
        return None
    state = flight.state
    antenna = np.array(sensor.antenna)[:, None]
    distance = np.linalg.norm(np.array((state.north, state.east, state.height)) - antenna, axis=0)
    nearest = int(np.argmin(distance))
    if distance[nearest] > CLOSE:
        return None
    return (
        f"sensor '{name}' is on the flight path: at {state.time[nearest]:.0f} s the aircraft passed its antenna "
        f"at {distance[nearest]:.0f} m, where an azimuth says nothing"
    )
