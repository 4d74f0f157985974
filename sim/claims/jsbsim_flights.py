"""Flights of the bundled scenarios: six degrees of freedom under the measures of the ledger.

`flown` is one flight as a scenario has it. A row of the ledger speaks of more than one: `flights` draws the start and
a steady wind of each by the seed, within the ranges that it is given, and its interval is over flights. Noise is drawn
within each flight, and a flight counts once, however many draws it has: `per_flight` gives the samples of
`tracking.intervals.gain` and its like, whose Student's intervals hold for few, and `root_mean` that of one filter.
"""

from __future__ import annotations

from collections.abc import Sequence
from functools import lru_cache
from typing import Any, NamedTuple

import numpy as np

from aircraft.state import AircraftState
from sim.flight.interpolation import truth_at
from sim.flight.record import RECORD_STEP, Flight
from sim.randomness import stream
from sim.scenario.tables import Runway
from tracking.intervals import Interval, gain

Ranges = tuple[tuple[str, float, float], ...]  # "table.key" and the ends between which it is drawn, uniformly
WIND: Ranges = (("wind.from_deg", 0.0, 360.0), ("wind.speed_mps", 0.0, 10.0))  # steady
KEPT = 96  # flights, of 1 to 3 MB


class Flown(NamedTuple):
    """One flight, seen from the threshold: "north" is past it along the runway, "east" right of the centreline."""

    flight: Flight
    state: AircraftState
    runway: Runway
    law: Any
    route: Any  # as its chart shows it, in the local frame of ``flight``: what trackers are told

    def rows(self, period: float) -> Any:
        """Rows of the record, one every ``period`` (s) after the start; a period is a number of records."""
        stride = round(period / RECORD_STEP)
        return np.arange(stride, len(self.flight.time), stride)

    def during(self, *phases: str) -> Any:
        """(k,) bool: where one of the phases is flown."""
        return self.flight.during(phases)

    def elevation(self, time: Any) -> Any:
        """Elevation (rad) and distance (m) of the aircraft, seen from the aiming point, at any times (s)."""
        north, east, height = truth_at(self.flight, time).position
        distance = self.runway.aiming_point - self.runway.from_local(north, east)[0]
        return np.arctan2(height, distance), distance


def flights(scenario: str, seed: int, count: int, ranges: Ranges, *changes: tuple[str, Any]) -> tuple[Flown, ...]:
    """The first ``count`` flights of a scenario whose values are drawn within ``ranges``.

    A flight hangs on the seed, its number and the ranges alone: more of them leave the first as they are, rows of any
    paper share them, and the same flight under other ``changes`` has the same draws.
    """
    return tuple(
        flown(scenario, *changes, *((key, _drawn(scenario, seed, number, key, low, high)) for key, low, high in ranges))
        for number in range(count)
    )


def _drawn(scenario: str, seed: int, number: int, key: str, low: float, high: float) -> float:
    return float(stream(seed, number, 0, f"claims.{scenario}.{key}").uniform(low, high))


def side_by_side(records: Sequence[Any]) -> Any:
    """Records (k, ...) of flights as one array (longest k, ..., flights), NaN behind the end of the shorter ones."""
    longest = max(map(len, records))
    out = np.full((longest, *np.shape(records[0])[1:], len(records)), np.nan)
    for number, record in enumerate(records):
        out[: len(record), ..., number] = record
    return out


def per_flight(values: Any, count: int) -> Any:
    """Means (..., count) over the draws of each flight, of values (..., runs) that have the draws of a flight together.

    NaN is a draw that has no value.
    """
    values = np.asarray(values, dtype=float)
    return np.nanmean(values.reshape(*values.shape[:-1], count, -1), axis=-1)


def root_mean(squares: Any, count: int) -> Interval:
    """Root of the mean of squares (runs,) over flights, with Student's interval on its logarithm.

    The chi-square interval of `tracking.intervals.rmse` trusts its own degrees of freedom, which a few flights do not
    tell.
    """
    squares = per_flight(squares, count)
    return gain(squares, np.ones_like(squares))


@lru_cache(maxsize=KEPT)
def flown(name: str, *changes: tuple[str, Any]) -> Flown:
    """A bundled scenario flown once, without its sensors and trackers; ``changes`` are ("table.key", value)."""
    from sim.estimation.setup import charted_route
    from sim.experiment import fly, read
    from sim.flight.preparation import prepare

    prepared = prepare(read(name, {"trackers": {}, "checks": [], **dict(changes)}))
    if prepared.scenario.flights != 1:
        raise ValueError(f"'{name}' is several flights; the ledger takes scenarios of one")
    flight, runway = fly(prepared), prepared.scenario.runway
    state = flight.state
    north, east = runway.from_local(state.north, state.east)
    velocity_north, velocity_east = runway.from_local(state.velocity_north, state.velocity_east)
    turned = state._replace(
        north=north,
        east=east,
        velocity_north=velocity_north,
        velocity_east=velocity_east,
        heading=(state.heading - runway.heading) % (2.0 * np.pi),
    )
    return Flown(flight, turned, runway, prepared.law, charted_route(prepared))
