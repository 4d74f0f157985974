"""Flights of the bundled scenarios: six degrees of freedom under the measures of the ledger.

The air is still or steady, so a scenario is one flight, whatever the seed: the runs of a row are draws of noise.
"""

from __future__ import annotations

from functools import lru_cache
from typing import Any, NamedTuple

import numpy as np

from aircraft.state import AircraftState
from sim.flight.interpolation import truth_at
from sim.flight.record import RECORD_STEP, Flight
from sim.scenario.tables import Runway


class Flown(NamedTuple):
    """One flight, seen from the threshold: "north" is past it along the runway, "east" right of the centreline."""

    flight: Flight
    state: AircraftState
    runway: Runway
    law: Any

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


@lru_cache(maxsize=12)
def flown(name: str, *changes: tuple[str, Any]) -> Flown:
    """A bundled scenario flown once, without its sensors and trackers; ``changes`` are ("table.key", value)."""
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
    return Flown(flight, turned, runway, prepared.law)
