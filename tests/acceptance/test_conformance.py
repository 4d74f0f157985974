"""The conformance alert of `intent_imm` on JSBSim: how often it is false, and how soon it is right.

The limit of the test follows from the stated rate of false alarms. That rate was chosen on seeds 51, 52 and 1000 to
1015; every flight here has a seed, a wind, a mass and a place of its own. Intervals are over flights, each of them the
mean over its noise draws.
"""

from __future__ import annotations

import math
from functools import cache

import numpy as np
import pytest

from sim.estimation.tracking_run import track
from sim.experiment import fly
from sim.flight.preparation import prepare
from sim.observation.record import observe
from sim.scenario.reading import read
from tracking.intervals import mean_interval

pytestmark = pytest.mark.acceptance
SEED, DRAWS = 4001, 40
CONFORMING, LEAVING = 30, 5  # flights, of each kind
ON_DOWNWIND, ON_FINAL = 60.0, 70.0  # s after the start
START = {"start.phase": "downwind"}, {"start.phase": "final", "start.distance_m": 13_000.0}


def hands(at, bank):
    """A bank that is held for 10 s, then wings level."""
    return [{"at_s": at, "flies": "bank", "bank_deg": bank}, {"at_s": at + 10.0, "flies": "bank", "bank_deg": 0.0}]


def offset(at, metres):
    return [{"at_s": at, "flies": "offset", "offset_m": metres}]


BEACON = [{"at_s": 0.0, "flies": "beacon"}]
WRONG = {"k1_factor": 1.3, "cross_track_limit_factor": 1.3}
CAPTURE = {"start.phase": "final", "start.distance_m": 20_000.0, "start.cross_track_m": 1500.0}
# what happens: (departures, changes, how long it is flown)
LEFT = {
    "10 deg of bank for 10 s on downwind, radar of 4 s": (hands(ON_DOWNWIND, -10.0), START[0], 150.0),
    "10 deg of bank for 10 s on final, radars of 4 and 1 s": (hands(ON_FINAL, -10.0), START[1], 150.0),
    "5 deg of bank for 10 s on final": (hands(ON_FINAL, -5.0), START[1], 150.0),
    "a line 300 m beside downwind": (offset(ON_DOWNWIND, 300.0), START[0], 150.0),
    "a line 100 m beside final": (offset(ON_FINAL, 100.0), START[1], 150.0),
    "autopilot off on base, 20 s before the turn to final that is missed": (
        [{"at_s": 20.0, "flies": "bank", "bank_deg": 0.0}],
        {"start.phase": "base"},
        160.0,
    ),
    "beacon law instead of route law from 1500 m beside final": (BEACON, CAPTURE, 190.0),
}


@cache
def conformance(kind, number):
    """What the alert says of one flight."""
    departures, changes, until = LEFT.get(kind, ([], START[0], None))
    rng = np.random.default_rng([SEED, number])
    overrides = {
        "seed": SEED + number,
        "aircraft.mass_kg": float(rng.uniform(18_000.0, 22_500.0)),
        "wind.speed_mps": float(rng.uniform(0.0, 10.0)),
        "wind.from_deg": float(rng.uniform(0.0, 360.0)),
        "wind.turbulence": ("none", "light", "moderate")[number % 3],
        "route.side": ("left", "right")[number % 2],
        "departures": departures,
        "checks": [],
        **changes,
    }
    if until is not None:
        overrides["until_s"] = until
    told = {"law": WRONG} if kind == "told wrong" else {}
    overrides["trackers"] = {"intent_imm": {"kind": "intent_imm", "sensors": ["terminal", "approach"], **told}}
    prepared = prepare(read("an26_departure", overrides))
    flight = fly(prepared)
    scenario = prepared.scenario
    records = observe(flight, scenario.sensors, scenario.seed, 0, DRAWS)
    found = track(prepared, flight, records, {})[1]["intent_imm"]["conformance"]
    return {**found, "looks": len(records["terminal"].time) + len(records["approach"].time)}


def told(interval, digits=1, scale=1.0):
    low, high = (max(0.0, scale * end) if math.isfinite(end) else end for end in (interval.low, interval.high))
    return f"{scale * interval.value:.{digits}f} ({low:.{digits}f} to {high:.{digits}f})"


@pytest.mark.parametrize("kind", ["told right", "told wrong"])
def test_false_alarms(row, kind):
    found = [conformance(kind, number) for number in range(CONFORMING)]
    share = mean_interval([one["false_alarm_fraction"] for one in found])
    looks = sum(one["looks"] for one in found) / max(sum(one["false_alarm_fraction"] for one in found), 1e-9)
    stated = found[0]["looks_between_false_alarms"]
    row(
        f"conformance, {CONFORMING} approaches on the law, {kind}: with a false alarm, %",
        f"rarer than one in {stated:.0f} looks" if kind == "told right" else "shown",
        f"{told(share, 2, 100.0)} % of the approaches, one in {looks:.0f} looks; to 10 m/s and moderate turbulence",
        kind == "told wrong" or looks >= stated,
    )
    if kind == "told right":
        assert looks >= stated


@pytest.mark.parametrize("kind", LEFT)
def test_delay(row, kind):
    found = [conformance(kind, number) for number in range(LEAVING)]
    detected = mean_interval([one["detected_fraction"] for one in found])
    medians = mean_interval([one["delay_s"]["p50"] for one in found if one["delay_s"]])
    late = max((one["delay_s"]["p95"] for one in found if one["delay_s"]), default=math.nan)
    intents = found[0]["believed_at_alarm"] or {}
    believed = {name: np.mean([one["believed_at_alarm"][name] for one in found]) for name in intents}
    row(
        f"conformance, {kind}: delay, s",
        "detected in >= 95 % of the draws",
        f"median {told(medians)}, 95 % within {late:.0f}; detected {told(detected, 0, 100.0)} %; at the alarm "
        + ", ".join(f"{name} {share:.2f}" for name, share in believed.items()),
        detected.value >= 0.95,
    )
    assert detected.value >= 0.8
