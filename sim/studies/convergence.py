"""The rate of an aircraft's equations of motion: the lowest one at which what users read has converged.

The same approaches are flown at each rate with the same gains, in the same air: turbulence is one path, made in steps
of the finest rate and met in steps of each. A rate is good enough when no figure differs from that of the finest rate
by more than ``SHARE`` of the limit that checks set it: a hundredth is less than the digits in which limits are stated.
Where neither 60 nor 120 Hz is that good it is 120 Hz, and how far that is off stands beside it: 240 Hz would cost twice
as much and move single flights in turbulence only. There is one rate for a whole flight, because actuators keep the
step with which they were loaded.
"""

from __future__ import annotations

import math
from typing import Any, NamedTuple

from aircraft.data import RATES
from sim.experiment import read
from sim.flight.loop import fly
from sim.flight.preparation import Prepared, prepare
from sim.flight.vehicles import JsbsimVehicle
from sim.flight.weather import air
from sim.metrics.flight import flight_metrics
from sim.randomness import Streams

USUAL, FINEST = 120.0, max(RATES)  # Hz
SHARE = 0.01
LIMITS = {  # of the bundled scenarios' checks; the width of a band counts from end to end
    "bank_max_deg": 16.1,
    "overshoot_m": 30.0,
    "height_error_rms_final_m": 7.5,  # at the decision height of a radar talk-down
    "touchdown.sink_mps": 3.05,
    "touchdown.past_threshold_m": 763.0,
    "touchdown.cross_track_m": 34.0,
    "touchdown.bank_deg": 10.0,  # about where a tip or an engine touches
    "touchdown.pitch_deg": 10.0,  # about where a tail touches
}
ASIDE = 200.0  # m, from which the centreline is captured
TURBULENT = {"turbulence": "moderate", "speed_mps": 5.0, "from_deg": 60.0}
GUST = {
    "kind": "gust",
    "up_mps": -4.0,
    "speed_mps": 4.0,
    "from_deg": 90.0,
    "past_threshold_m": 100.0,
    "length_m": 300.0,
}
AIRS: dict[str, dict[str, Any]] = {
    "calm": {},
    "gust": {"wind": {"events": {"gust": GUST}}},  # where the aircraft flares
    **{f"turbulence_{seed}": {"wind": TURBULENT, "seed": seed} for seed in range(1, 9)},
}


class Convergence(NamedTuple):
    """How far the figures at a rate are from those at the finest one."""

    rate: float  # Hz
    difference: float  # largest, as a share of the limit of its figure
    figure: str  # whose that is
    air: str  # in which that is

    @property
    def good(self) -> bool:
        """Whether the rate is good enough."""
        return self.difference <= SHARE


def converged_rate(tables: dict[str, Any]) -> tuple[float, list[Convergence]]:
    """The rate, Hz, of an aircraft that flies a straight-in approach, and how far each lower rate is from the finest.

    ``tables`` are those of the approach in calm air. Raises ``ScenarioError`` where it cannot be flown.
    """
    aside = {**tables, "start": {**tables["start"], "cross_track_m": ASIDE}}
    prepared = {name: prepare(read({**aside, **changes})) for name, changes in AIRS.items()}
    finest = {name: figures(one, FINEST) for name, one in prepared.items()}
    found = []
    for rate in sorted(RATES)[:-1]:
        differences = [
            (_difference(figures(one, rate).get(figure), value, LIMITS[figure]), figure, name)
            for name, one in prepared.items()
            for figure, value in finest[name].items()
        ]
        found.append(Convergence(rate, *max(differences)))
    return next((one.rate for one in found if one.good), USUAL), found


def figures(prepared: Prepared, rate: float) -> dict[str, float]:
    """Those of ``LIMITS`` of a flight at a rate, Hz, in the air of the finest one."""
    scenario = prepared.scenario
    noise = Streams(scenario.seed, 0, 1, "wind").generator("turbulence")
    flight = fly(
        JsbsimVehicle(prepared.designed, prepared.airframe._replace(rate=rate)),
        prepared.controller,
        prepared.initial,
        air(scenario.wind, scenario.runway, noise, FINEST),
        prepared.limits,
        prepared.phases,
        gate_height=prepared.gate_height,
    )
    metrics = flight_metrics(flight, scenario.runway, prepared.law.bank_limit)
    every = metrics | {f"touchdown.{name}": value for name, value in (metrics["touchdown"] or {}).items()}
    return {name: float(every[name]) for name in LIMITS if every.get(name) is not None}


def _difference(value: float | None, finest: float, limit: float) -> float:
    return math.inf if value is None else abs(value - finest) / limit
