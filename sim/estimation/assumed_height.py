"""What the height cost by which a range was read: found afterwards on the flight, which no tracker sees."""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np

from sim.estimation.setup import height_profile, uses_places
from sim.flight.interpolation import truth_at
from sim.flight.preparation import Prepared
from sim.flight.record import Flight
from sim.observation.record import SensorRecord
from tracking.height_profile import Charted, ChartHeight

TOLD = 0.5  # of a standard deviation of the range: from there on it is worth a word


class HeightCost(NamedTuple):
    """Errors of heights at the looks of a sensor that count, k in number."""

    time: np.ndarray  # (k,) s
    height_error: np.ndarray  # (k,) m, less the true one
    cost: np.ndarray  # (k,) error of the range that is put down to it, in standard deviations of the range


def remarks(prepared: Prepared, flight: Flight, records: dict[str, SensorRecord]) -> list[str]:
    """One sentence for each sensor whose heights, assumed or answered, cost a tracker on the ground plane over `TOLD`.

    A transponder answers a pressure altitude: its height is wrong in air that is colder or hotter than the standard.
    """
    scenario = prepared.scenario
    used = {name for choice in scenario.trackers.values() if uses_places(choice.cls) for name in choice.sensors}
    found = []
    for name, record in records.items():
        if "range" not in record.channels or "elevation" in record.channels or name not in used:
            continue
        if not np.isfinite(record.z[:, record.channels.index("range")]).any():
            continue
        cost = height_cost(flight, height_profile(prepared), scenario.sensors[name], record)
        if cost.cost.size and cost.cost.max() > TOLD:
            worst = int(cost.cost.argmax())
            answered = "height" in record.channels
            says, was = ("is told the height", "answered") if answered else ("measures no height", "assumed")
            found.append(
                f"sensor '{name}' {says}: at {cost.time[worst]:.0f} s the height that was {was} was "
                f"{abs(cost.height_error[worst]):.0f} m too {'high' if cost.height_error[worst] > 0 else 'low'}, which "
                f"costs {cost.cost[worst]:.2g} standard deviations of its range; more than {TOLD:g} in "
                f"{np.mean(cost.cost > TOLD):.0%} of its looks"
            )
    return found


def height_cost(flight: Flight, chart: Charted, sensor: Any, record: SensorRecord) -> HeightCost:
    """How far the chart's height, or the answered one, is off where the aircraft was, and what that does to a range.

    An answered height is the mean over the draws. Looks from so nearly above the antenna that no tracker uses them are
    left out.
    """
    row = record.channels.index("range")
    seen = np.isfinite(record.z[:, row]).any(axis=1)
    truth = truth_at(flight, record.time[seen])
    variance = record.R[seen, row, row].reshape(int(seen.sum()), -1).mean(axis=1)
    answered = _answered(record, seen)
    assumed = chart.at(*truth.position[:2], *truth.velocity[:2]) if answered is None else answered
    off_north, off_east, up = truth.position - np.array(sensor.antenna)[:, None]
    square = off_north**2 + off_east**2
    slant, error = np.sqrt(square + up**2), assumed.height - truth.position[2]
    usable = square**2 > 9.0 * (slant**2 * variance + up**2 * assumed.variance)
    cost = np.abs(np.sqrt(square + (up + error) ** 2) - slant) / np.sqrt(variance)
    return HeightCost(record.time[seen][usable], error[usable], cost[usable])


def _answered(record: SensorRecord, seen: np.ndarray) -> ChartHeight | None:
    """Heights of a transponder at the looks that count, mean over the draws; None where it is not asked."""
    if "height" not in record.channels:
        return None
    row = record.channels.index("height")
    variance = record.R[seen, row, row].reshape(int(seen.sum()), -1).mean(axis=1)
    return ChartHeight(np.nanmean(record.z[seen, row], axis=1), variance)
