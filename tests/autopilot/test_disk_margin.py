"""Judges: python-control's disk margin, and the perturbation that it promises to bear."""

import math

import numpy as np
import pytest

from aircraft.airframe import load
from autopilot.design import BANK_OVERSHOOT, REFERENCE_SHARE, bank_bandwidth, bank_overshoot, reference_frequency
from autopilot.disk_margin import FREQUENCIES, Margin, designed_gains, disk_margin, lateral_margin
from sim.flight.vehicles import operating_point


def response(system):
    return np.moveaxis(system(1j * FREQUENCIES, squeeze=False), -1, 0)


def test_margin_of_one_channel_agrees_with_python_control():
    import control

    s = control.tf("s")
    loop = control.ss(4.0 / (s * (s + 1.0) * (s + 2.0)))
    disk, _, phase = control.disk_margins(loop, FREQUENCIES, skew=0.0)
    found = disk_margin(response(loop))
    assert found.disk == pytest.approx(disk, rel=1e-9)
    assert math.degrees(found.phase) == pytest.approx(phase, rel=1e-9)


def test_two_channels_bear_the_gains_that_their_margin_allows():
    import control

    A = np.array([[0.0, 1.0, 0.0], [-1.0, -0.4, 0.5], [0.3, 0.0, -0.8]])
    B, C = np.array([[0.0, 0.0], [1.0, 0.2], [0.1, 1.0]]), np.array([[2.0, 1.0, 0.4], [0.3, 0.2, 1.5]])
    margin = disk_margin(response(control.ss(A, B, C, np.zeros((2, 2)))))
    gains = 0.999 * margin.gain, 1.001 / margin.gain
    for first in gains:
        for second in gains:
            assert np.linalg.eigvals(A - B @ np.diag([first, second]) @ C).real.max() < 0.0


def test_a_perfect_integrator_bears_any_gain():
    found = disk_margin((1.0 / (1j * FREQUENCIES))[:, None, None])
    assert found.disk == pytest.approx(2.0)
    assert found.phase == pytest.approx(math.pi / 2)  # what an integrator may lose
    assert Margin(2.0, 1.0).gain == math.inf


def test_delays_and_lags_cost_margin():
    point = operating_point(load("an26", 20000.0), 69.0, 300.0, math.radians(15.0), 0.0)
    gains = designed_gains(point)[1]
    slow, quick = (lateral_margin(point, gains, (lag, lag)) for lag in (5.0, 20.0))
    assert slow.disk < quick.disk
    assert quick.gain > 2.0  # 6 dB in both controls at once


@pytest.mark.parametrize(
    ("model", "speed", "flaps", "is_slowed"), [("an26", 69.0, 15.0, False), ("MD11", 96.0, 15.0, True)]
)
def test_the_bank_reference_is_slowed_where_the_bank_would_overshoot(model, speed, flaps, is_slowed):
    point = operating_point(load(model), speed, 600.0, math.radians(flaps), 0.0)
    bandwidth, limit = bank_bandwidth(point), math.radians(15.0)
    found = reference_frequency([point], bandwidth, limit)
    assert (found < REFERENCE_SHARE * bandwidth) is is_slowed
    assert bank_overshoot(point, found, limit) <= BANK_OVERSHOOT * limit
    if is_slowed:  # and no more than needed: 5 % quicker is too quick
        assert bank_overshoot(point, 1.05 * found, limit) > BANK_OVERSHOOT * limit
