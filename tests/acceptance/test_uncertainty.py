"""The An-26 as nobody knows it: 256 aircraft of the bundled study flown with the gains of the nominal one."""

from __future__ import annotations

import json
import math
from functools import cache

import numpy as np
import pytest

from aircraft.actuators import actuator_bandwidth
from aircraft.airframe import load
from aircraft.errors import TrimError
from aircraft.model_files import read as read_model
from autopilot.design import lateral_gains, longitudinal_gains
from autopilot.disk_margin import lateral_margin, longitudinal_margin
from sim.flight.vehicles import operating_point
from sim.scenario.axes import samples
from sim.scenario.reading import read
from sim.studies import study
from sim.workers.executors import LocalExecutor

pytestmark = pytest.mark.acceptance
NAME, SAMPLES, SEED = "an26_uncertainty", 256, 1001
FLIGHTS = 200  # asked for; Sobol points come in powers of two
OVERRIDES = {"study.samples": SAMPLES, "seed": SEED}


def test_flights(row, tmp_path):
    study.study(NAME, tmp_path / "study", LocalExecutor(1), OVERRIDES)
    records = [json.loads(line) for line in (tmp_path / "study" / "flights.jsonl").read_text().splitlines()]
    flown = [record for record in records if "outcome" in str(record)]
    assert len(flown) >= FLIGHTS
    metrics = [record["metrics"] for record in sorted(records, key=lambda record: record["sample"])]
    landed = [m for m in metrics if m["outcome"] == "landed"]
    share = len(landed) / len(metrics)
    row(f"{len(metrics)} uncertain An-26: landed in the box", ">= 95 %", f"{100 * share:.1f} %", share >= 0.95)
    for figure, name, worst in (
        ("touchdown past the threshold, m", "past_threshold_m", max),
        ("touchdown sink, m/s", "sink_mps", max),
        ("touchdown off the centreline, m", "cross_track_m", lambda values: max(values, key=abs)),
    ):
        values = [m["touchdown"][name] for m in landed]
        low, middle, high = np.percentile(values, [5, 50, 95])
        told = f"{low:.2f}, {middle:.2f}, {high:.2f}; worst {worst(values):.2f}"
        row(f"uncertain An-26: {figure}: 5, 50, 95 % of the flights", "reported", told, True)
    nose = [m["touchdown"]["pitch_deg"] for m in landed]
    row("uncertain An-26: lowest pitch at touchdown, deg", "> 0", f"{min(nose):.2f}", min(nose) > 0)
    overshoot = max(m["overshoot_m"] for m in metrics)
    row("uncertain An-26: largest overshoot onto final, m", "reported", f"{overshoot:.1f}", True)
    for number, m in enumerate(metrics):
        if m["outcome"] != "landed":
            row(f"uncertain An-26: flight {number}", "explained", f"{m['outcome']}: {m['reason']}", True)
    assert share >= 0.95
    assert min(nose) > 0


@cache
def points(speed: float, flaps: float, gear: float):
    """The nominal aircraft and every sampled one at one condition; None where it has no trim there."""
    scenario = read(NAME, OVERRIDES)
    drawn = samples(scenario.study.varied, SAMPLES, SEED)

    def at(mass, balance, factors):
        try:
            return operating_point(load("an26", mass, balance, factors), speed, 300.0, math.radians(flaps), gear)
        except TrimError:
            return None

    place, name = "aircraft.factors.", "aircraft.mass_kg"
    nominal = at(scenario.aircraft.mass, scenario.aircraft.centre_of_gravity_mac, {})
    return nominal, [
        at(
            one[name],
            one["aircraft.centre_of_gravity_mac"],
            {key.removeprefix(place): value for key, value in one.items() if key.startswith(place)},
        )
        for one in drawn
    ]


@pytest.mark.parametrize(("speed", "flaps", "gear"), [(69.0, 15.0, 0.0), (58.0, 38.0, 1.0)])
def test_disk_margins(row, speed, flaps, gear):
    model = read_model("an26")
    lags = {name: actuator_bandwidth(model, name) for name in ("power", "elevator", "aileron", "rudder")}
    nominal, others = points(speed, flaps, gear)
    trimmed = [one for one in others if one is not None]
    for title, margin, gains, channels in (
        ("throttle and elevator", longitudinal_margin, longitudinal_gains(nominal), ("power", "elevator")),
        ("aileron and rudder", lateral_margin, lateral_gains(nominal), ("aileron", "rudder")),
    ):
        behind = [lags[name] for name in channels]
        own = margin(nominal, gains, behind)
        worst = min((margin(one, gains, behind) for one in trimmed), key=lambda found: found.disk)
        told = (
            f"{own.disk:.2f} (gain {own.gain:.2f}, phase {math.degrees(own.phase):.0f} deg), worst of {len(trimmed)} "
            f"{worst.disk:.2f} (gain {worst.gain:.2f}, phase {math.degrees(worst.phase):.0f} deg)"
        )
        row(f"An-26 at {speed:.0f} m/s: disk margin of {title} at once", "reported", told, True)
        assert worst.disk > 0.0
