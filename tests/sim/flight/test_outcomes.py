"""How flights end: the touchdown box, by states made by hand and by a flight that comes down beside its runway."""

from __future__ import annotations

import math

import pytest

import sim
from aircraft.state import AircraftState
from autopilot.route import Leg, Route
from sim.flight.outcomes import Limits, OutcomeMonitor
from sim.scenario.tables import Runway

RUNWAY = Runway(heading=math.radians(80.0))
ROUTE = Route((Leg(RUNWAY.to_local(-20_000.0, 0.0), RUNWAY.to_local(300.0, 0.0), 60.0, 400.0),))
FLYING = AircraftState(*(0.0 for _ in AircraftState._fields))._replace(airspeed=60.0)


def touchdown(past, across, sink=0.6):
    """The verdict on a straight flight along the runway whose wheels touch at a place."""
    monitor = OutcomeMonitor(Limits(None, RUNWAY), ROUTE)
    ahead = math.cos(RUNWAY.heading), math.sin(RUNWAY.heading)
    for wheels in (0.0, 2.0):
        north, east = RUNWAY.to_local(past, across)
        state = FLYING._replace(
            north=north, east=east, height=1.0, velocity_north=60.0 * ahead[0], velocity_east=60.0 * ahead[1],
            velocity_up=-sink, main_wheels=wheels,
        )  # fmt: skip
        verdict = monitor(state, 0, "")
    return verdict


@pytest.mark.parametrize(
    ("past", "across", "sink", "outcome"),
    [
        (430.0, 0.0, 0.6, "landed"),
        (430.0, 20.9, 0.6, "landed"),
        (430.0, -20.9, 0.6, "landed"),
        (430.0, 21.1, 0.6, "ground"),
        (430.0, -2030.0, 0.6, "ground"),
        (61.0, 0.0, 0.6, "landed"),
        (59.0, 0.0, 0.6, "ground"),
        (824.0, 0.0, 0.6, "ground"),
        (430.0, 0.0, 3.1, "ground"),
    ],
)
def test_landed_is_a_soft_touchdown_in_the_box(past, across, sink, outcome):
    assert touchdown(past, across, sink)[0] == outcome


def test_the_reason_says_where():
    assert touchdown(430.0, -2030.0)[1] == (
        "touched the ground 430 m past the threshold, 2030.0 m off the centreline, sink 0.60 m/s"
    )
    assert "411 m before the threshold" in touchdown(-411.0, 0.0)[1]


def test_an_aircraft_that_comes_down_beside_its_runway_has_not_landed():
    """The law flies a line 40 m beside it: within half scale of the localiser, and not on the runway."""
    low = {"route.height_m": 150.0, "route.downwind_speed_mps": 60.0, "route.turn_speed_mps": 60.0, "checks": []}
    place = {"start.phase": "final", "start.distance_m": 3000.0, "trackers": {}, "sensors": {}}
    beside = [{"at_s": 10.0, "flies": "offset", "offset_m": 40.0}]
    result = sim.run("an26_pattern", overrides={**low, **place, "departures": beside})
    figures = result.metrics["flight"]
    assert figures["touchdown"]["cross_track_m"] == pytest.approx(40.0, abs=10.0)
    assert figures["outcome"] == "ground"
    assert figures["landed"] == 0.0
