"""Why a flight on an estimate failed: lags and errors that were put in by hand are found again."""

from __future__ import annotations

import dataclasses
import math
from types import SimpleNamespace

import numpy as np
import pytest

from autopilot.design import Designed, lateral_law
from autopilot.route import Leg, Route
from sim.metrics.navigation import beside, navigation_quality
from sim.scenario.tables import Runway
from tracking.motion import CARTESIAN

GRAVITY = 9.80665
LAW = lateral_law(2.3, 72.0, math.radians(15.0))
LIMITS = (LAW.bank_limit, LAW.cross_track_limit, LAW.cross_track_rate_limit)
DESIGNED = Designed((), 2.3, 6.9, 0.0, LAW.k1, LAW.k2, *LIMITS)
SCENARIO = SimpleNamespace(autopilot=SimpleNamespace(navigation="mine"), runway=Runway())
PREPARED = SimpleNamespace(scenario=SCENARIO, law=LAW, designed=DESIGNED, stall_speed=None)
TIME = np.arange(0.0, 200.0, 1 / 30)
SWING, PERIOD = 80.0, 36.0  # m, s


@pytest.fixture
def swinging(make_flight):
    """Northwards, swinging across the line; the bank is what that takes."""
    w = 2 * np.pi / PERIOD
    rate, acceleration = SWING * w * np.cos(w * TIME), -SWING * w**2 * np.sin(w * TIME)
    flight = make_flight(
        TIME, ["final"] * len(TIME), route=Route((Leg((-50_000.0, 0.0), (60_000.0, 0.0), 70.0, 400.0),)),
        north=70.0 * TIME, east=SWING * np.sin(w * TIME), velocity_north=np.full(len(TIME), 70.0), velocity_east=rate,
        bank=np.arctan(acceleration / GRAVITY), command_bank=np.full(len(TIME), LAW.bank_limit),
    )  # fmt: skip
    return dataclasses.replace(flight, outcome="go_around", reason="went around")


def track(flight, late=0.0, aside=0.0):
    """An estimate each second whose rate is late (s) and whose place is aside (m)."""
    time = np.arange(20.0, 20.0 + 4 * PERIOD)  # whole periods
    s = flight.state
    rate = np.interp(time - late, s.time, s.velocity_east)
    place = np.interp(time, s.time, s.east) + aside
    mean = np.stack((70.0 * time, np.full(len(time), 70.0), place, rate), axis=1)[..., None]
    cov = np.tile(np.diag((100.0, 1.0, 100.0, 1.0)), (len(time), 1, 1))
    return SimpleNamespace(channels=CARTESIAN, time=time, mean=mean, cov=cov)


def test_a_flight_on_the_truth_has_nothing_to_explain(swinging):
    prepared = SimpleNamespace(scenario=SimpleNamespace(autopilot=SimpleNamespace(navigation="truth")))
    assert navigation_quality(prepared, swinging, None, {}) is None
    assert beside({"navigated": None, "outcome": "landed"}) == []


@pytest.mark.parametrize("late", [0.0, 2.0, 5.0])
def test_the_lag_of_the_rate_is_found(swinging, late):
    """Least squares over a sine: sin(w tau) / w for a lag of tau."""
    found = navigation_quality(PREPARED, swinging, track(swinging, late), {"lost_time_s": None})
    w = 2 * np.pi / PERIOD
    assert found["rate_lag_s"] == pytest.approx(math.sin(w * late) / w, abs=0.05)
    assert found["error_rms_m"] == pytest.approx(0.0, abs=0.1)
    assert 3.0 < found["rate_lag_stood_s"] < 4.5


def test_a_late_rate_is_the_reason(swinging):
    why = navigation_quality(PREPARED, swinging, track(swinging, 5.0), {"lost_time_s": None})["why"]
    assert "the cross-track rate of mine, on which it was flown, came 4.4 s late and the law tolerates 3.7 s" in why
    assert "at the bank limit for 100% of the time" in why


def test_a_lost_track_is_the_reason(swinging):
    why = navigation_quality(PREPARED, swinging, track(swinging, aside=2000.0), {"lost_time_s": 14.0})["why"]
    assert "was lost after 14 s" in why
    assert "the estimate wrong by 2000 m across, where it stated 14 m" in why


def test_what_landed_needs_no_reason(swinging):
    landed = dataclasses.replace(swinging, outcome="landed")
    assert navigation_quality(PREPARED, landed, track(landed, 5.0), {"lost_time_s": None})["why"] is None


def test_a_tracker_that_saw_nothing_is_the_reason(swinging):
    assert navigation_quality(PREPARED, swinging, None, {})["why"] == "tracker 'mine' never saw the aircraft"


def test_the_twin_on_the_truth_stands_beside():
    twin = {"outcome": "landed", "touchdown": {"sink_mps": 0.5}}
    figures = {"outcome": "go_around", "touchdown": None, "navigated": {"on_truth": twin}}
    rows = {name: values for name, *values in beside(figures)}
    assert rows["outcome"] == ["go_around", "landed"]
    assert rows["touchdown.sink_mps"] == [None, 0.5]
