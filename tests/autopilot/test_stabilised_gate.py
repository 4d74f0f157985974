"""The gate of the stabilised approach against a plain moving mean."""

import numpy as np
import pytest

from autopilot.stabilised_gate import StabilisedGate

DT = 1.0 / 30.0
GATE = StabilisedGate()


def first_miss(gate, airspeed_error=0.0, sink=2.7, height_error=0.0, cross_track=0.0, distance=3000.0, seconds=30.0):
    """Time of the miss of a record whose signals are floats or functions of time, None without one."""
    signals = airspeed_error, sink, height_error, cross_track
    s = gate.begin()
    for k in range(round(seconds / DT)):
        values = [signal(k * DT) if callable(signal) else signal for signal in signals]
        s = gate.step(s, *values, distance, DT)
        if gate.missed(s):
            return (k + 1) * DT
    return None


def test_stabilised_approach_passes():
    assert first_miss(GATE) is None
    assert first_miss(GATE, airspeed_error=7.9, sink=5.0, height_error=-18.0, cross_track=52.0) is None


@pytest.mark.parametrize(
    "wrong",
    [
        {"airspeed_error": -4.4},
        {"airspeed_error": 8.1},
        {"sink": 5.2},
        {"height_error": 18.5},  # 0.35 deg at 3000 m is 18.3 m
        {"height_error": -18.5},
        {"cross_track": 53.0},
        {"cross_track": -53.0},
    ],
)
def test_each_limit_is_missed_three_seconds_after_its_window_is_full(wrong):
    assert first_miss(GATE, **wrong) == pytest.approx(5.0 + 3.0, abs=0.05)


def test_short_excess_is_forgiven():
    def burst(duration):
        return lambda time: 20.0 if 10.0 <= time < 10.0 + duration else 0.0

    # over 5 s a burst of 20 m/s has a mean above 8 m/s while at least 2 s of it are in the window
    assert first_miss(GATE, airspeed_error=burst(1.5)) is None
    assert first_miss(GATE, airspeed_error=burst(6.0)) is not None


def test_mean_is_the_moving_mean():
    """Judge: the mean of the last five seconds by numpy, at the ends of the gate's blocks."""
    rng = np.random.default_rng(4)
    sink = 5.0 + rng.normal(0.0, 1.5, 900).cumsum() * 0.05
    gate = StabilisedGate(persistence=0.0)
    s, missed = gate.begin(), []
    for value in sink:
        s = gate.step(s, 0.0, float(value), 0.0, 0.0, 3000.0, DT)
        missed.append(gate.missed(s))
    for end in range(150, 900, 15):
        assert missed[end - 1] == (sink[end - 150 : end].mean() > 5.08)
    assert any(missed)
    assert not all(missed[150:])


def test_close_to_the_ground_no_more_than_the_height_limit_is_asked():
    assert first_miss(GATE, height_error=7.9, distance=300.0) is None
    assert first_miss(GATE, height_error=8.1, distance=300.0) is not None


@pytest.mark.parametrize("field", ["slow", "fast", "sink", "glide_path", "height_error", "cross_track"])
def test_limits_must_be_positive(field):
    with pytest.raises(ValueError, match=field):
        StabilisedGate(**{field: 0.0})
