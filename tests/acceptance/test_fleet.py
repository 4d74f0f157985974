"""JSBSim's aircraft through the one recipe: how many capture a line from 3 km and land; the papers' profile."""

from __future__ import annotations

import tomllib

import numpy as np
import pytest

from aircraft.model_files import available
from sim.cli import fleet
from sim.experiment import fly
from sim.flight.preparation import prepare
from sim.flight.truths.mls_profile import MlsProfile
from sim.scenario.reading import read

pytestmark = pytest.mark.acceptance
TRANSPORT = 20000.0  # kg, from which an aircraft is one here
BANK = 17.0  # deg: the limit of 15 deg and 2 deg


@pytest.fixture(scope="module")
def answers():
    """Every stock aircraft flown anew, each in its worker process."""
    table = tomllib.loads(fleet.TABLE.read_text())["aircraft"]
    flyable = [name for name, row in table.items() if "route_capture" in row]
    flown = dict(fleet.answers(fleet.flown, flyable))
    return {name: row | flown.get(name, {}) for name, row in table.items()}


def test_capture(row, answers):
    stock = [name for name, origin in available().items() if origin.startswith("stock")]
    told = [name for name in stock if answers[name].get("reason") or "route_capture" in answers[name]]
    row("stock aircraft answered", f"all {len(stock)}", str(len(told)), len(told) == len(stock))
    captures = {name: one for name, one in answers.items() if "overshoot_m" in one.get("route_capture", {})}
    good, transports = [], []
    for name, one in captures.items():
        capture = one["route_capture"]
        limit = 3.0 if one["mass_kg"] >= TRANSPORT else 10.0
        met = capture["outcome"] == "completed" and capture["overshoot_m"] <= limit and capture["bank_max_deg"] <= BANK
        good += [name] if met else []
        transports += [capture["overshoot_m"]] if one["mass_kg"] >= TRANSPORT else []
        figures = f"{capture['overshoot_m']:.2f} m, bank {capture['bank_max_deg']:.2f} deg at {one['speed_mps']} m/s"
        row(f"{name}: overshoot of a capture from 3 km", f"<= {limit:.0f} m, bank <= {BANK:.0f} deg", figures, met)
    row("stock aircraft that capture within their limits", ">= 24", str(len(good)), len(good) >= 24)
    row(
        "worst overshoot of a transport, m", "<= 3", f"{max(transports):.2f} of {len(transports)}", max(transports) <= 3
    )
    landed = [name for name, one in answers.items() if one.get("straight_in", {}).get("outcome") == "landed"]
    row("stock aircraft that land from a straight final", "reported", str(len(landed)), True)
    assert len(told) == len(stock)
    assert len(good) >= 24


def test_profile_of_the_microwave_landing_system(row):
    prepared = prepare(read("mls_profile"))
    flight = fly(prepared, 0)
    state, to_go = flight.state, flight.deviation.distance_to_go
    wanted = MlsProfile().fly().state
    speed = np.hypot(wanted.velocity_north, wanted.velocity_up)
    for name, near, far in (("level leg", 5000.0, 15000.0), ("glide path", 750.0, 5000.0)):
        part = (to_go >= near) & (to_go <= far)
        height = np.abs(state.height - np.interp(-to_go, wanted.north, wanted.height))[part].max()
        error = np.abs(state.airspeed - np.interp(-to_go, wanted.north, speed))[part].max()
        row(f"mls_profile, {name}: height off the profile, m", "<= 5", f"{height:.2f}", height <= 5.0)
        row(f"mls_profile, {name}: airspeed off its schedule, m/s", "<= 3", f"{error:.2f}", error <= 3.0)
        assert height <= 5.0
        assert error <= 3.0
    row("mls_profile: how it ends", "landed", flight.reason, flight.outcome == "landed")
