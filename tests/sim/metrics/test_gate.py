"""Checks "during the gate" are about the gate that was flown, wherever a scenario puts it."""

from __future__ import annotations

import numpy as np

import sim
from sim.metrics.checks import evaluate_checks
from sim.scenario.tables import Check, Runway

FINAL = {"phase": "final", "distance_m": 9000.0}  # 419 m on the glide path of 2 deg 40'
PATTERN = {
    "name": "low_gate",
    "draws": 1,
    "aircraft": {"model": "point_mass"},
    "start": FINAL,
    "autopilot": {"gate_height_m": 150.0},
    "checks": [{"metric": "bank_deg", "max": 90.0, "during": "gate"}],
}


def test_a_gate_check_of_a_flown_scenario_begins_at_its_gate_height():
    result = sim.run(PATTERN)
    heights = result.flight.state.height[result.flight.during("gate")]
    assert 140.0 < heights.max() <= 150.0
    assert result.metrics["checks"][0]["passed"] is True
    early = sim.run({**PATTERN, "until_s": 60.0})  # 3.5 km further, still above 240 m
    assert early.flight.state.height.min() > 200.0
    assert early.metrics["checks"][0]["passed"] is None


def test_what_happens_between_the_heights_of_two_gates_counts_for_the_higher_only(make_flight):
    height = np.linspace(400.0, 0.0, 1201)
    bank = np.radians(np.where((height < 280.0) & (height > 200.0), 12.0, 1.0))
    time = np.arange(1201) / 30.0
    check = Check("bank_deg", max=5.0, during="gate")

    def passed(gate_height):
        flight = make_flight(time, ["glide"] * 1201, height=height, bank=bank, gate_height=gate_height)
        (result,) = evaluate_checks((check,), flight, Runway(), {})
        return result["passed"]

    assert [passed(gate) for gate in (300.0, 150.0, None)] == [False, True, None]


def test_the_gate_stands_beside_other_phases(make_flight):
    flight = make_flight(
        np.arange(4) / 30.0,
        ["final", "glide", "glide", "flare"],
        height=np.array([400.0, 350.0, 250.0, 10.0]),
        gate_height=300.0,
    )
    assert flight.during(("gate", "flare")).tolist() == [False, False, True, True]
