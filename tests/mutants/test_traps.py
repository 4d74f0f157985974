"""What the mutants need and no other test looks at."""

from __future__ import annotations

import math

import numpy as np
import pytest
from scipy.integrate import quad

from aircraft.state import STANDARD_GRAVITY, AircraftState
from sim.flight.truths.base_turn import BaseTurn
from sim.flight.truths.beacon_homing import BeaconHoming
from sim.observation.sensors.downlink import Downlink
from sim.scenario.tables import WindTable
from tracking.azimuth_acceleration import horizontal_acceleration
from tracking.gaussian import Gaussian
from tracking.measurement import ConvertedPolar
from tracking.motion import constant_velocity
from tracking.trackers.load_factor import DOWNLINK, LoadFactor


def test_constant_velocity_noise_is_the_integral_of_white_acceleration():
    """Q = density * integral of [T - t, 1]' [T - t, 1] dt, entry by entry."""
    dt, density = 0.7, 0.3
    _, Q = constant_velocity(dt, density)
    responses = (lambda t: dt - t, lambda t: 1.0)
    for i, first in enumerate(responses):
        for j, second in enumerate(responses):
            integral, _ = quad(lambda t, a=first, b=second: a(t) * b(t), 0.0, dt)
            assert Q[i, j] == pytest.approx(density * integral, rel=1e-12)


def test_the_cross_range_error_is_that_of_the_azimuth():
    """Straight ahead the error to the right is range times azimuth sigma, whatever the elevation's is."""
    R = np.diag([30.0**2, math.radians(1.0) ** 2, math.radians(0.1) ** 2])
    plot = ConvertedPolar().linearise(np.array([10000.0, 0.0, 0.05]), R, np.zeros(4))
    distance = 10000.0 * math.cos(0.05)
    assert plot.R[1, 1] == pytest.approx((distance * math.radians(1.0)) ** 2, rel=1e-12)
    assert plot.R[0, 0] == pytest.approx(
        (30.0 * math.cos(0.05)) ** 2 + (10000.0 * 0.05 * math.radians(0.1)) ** 2, rel=0.01
    )


def test_load_factors_are_those_of_the_wind_axes():
    """Level flight at 10 deg of angle of attack: 1 up and 0 forward along the path, not 1/cos along the body."""
    pitch = math.radians(10.0)
    at_rest = AircraftState(*[0.0] * len(AircraftState._fields))
    state = at_rest._replace(
        pitch=pitch,
        angle_of_attack=pitch,
        airspeed=70.0,
        velocity_north=70.0,
        specific_force_forward=STANDARD_GRAVITY * math.sin(pitch),
        specific_force_down=-STANDARD_GRAVITY * math.cos(pitch),
    )
    assert state.load_factor == pytest.approx((0.0, 0.0, 1.0), abs=1e-12)
    pulled = state._replace(specific_force_down=state.specific_force_down - 1.0)  # 1 m/s2 more along the body's axis
    forward, _, up = pulled.load_factor
    assert forward * STANDARD_GRAVITY == pytest.approx(-math.sin(pitch))
    assert (up - 1.0) * STANDARD_GRAVITY == pytest.approx(math.cos(pitch))


def test_the_azimuth_is_driven_by_the_acceleration_of_now():
    """Dead reckoning through a turn by load factors alone, noise-free, 1 s steps, exact start.

    The trapezoid rule leaves 0.03 deg; an acceleration that comes a step late shifts the rate by a second of its
    change, 0.006 rad/s or 0.3 deg over the turn.
    """
    state = BaseTurn().fly(step=1.0).state
    azimuth, distance = np.arctan2(state.east, state.north), np.hypot(state.north, state.east)
    rows = np.array(
        [
            np.hypot(distance, state.height),
            np.arctan2(state.height, distance),
            np.full_like(azimuth, np.nan),  # never measured
            *(state.load_factor[i] for i in (0, 2, 1)),
            state.aerodynamic_bank,
            state.flight_path_angle,
            state.air_course,
        ]
    )
    measured = ("radar.range", "radar.elevation", "radar.azimuth", *(f"downlink.{name}" for name in DOWNLINK))
    closing = (state.north * state.velocity_north + state.east * state.velocity_east) / distance
    turning = (state.north * state.velocity_east - state.east * state.velocity_north) / distance**2
    slant, sinking = rows[0], -state.height * closing / rows[0] ** 2
    mean = np.array([slant, closing * distance / slant, azimuth, turning, rows[1], sinking])[:, 0]
    tracker = LoadFactor(measured, 0.0)
    current = tracker.begin(Gaussian(mean, 1e-12 * np.eye(6)))
    R = np.diag([1e-4, 1e-12, 1.0, *[1e-12] * 6])
    errors = []
    for row in range(1, len(azimuth)):
        current, _ = tracker.step(current, 1.0, rows[:, row], R)
        errors.append(math.degrees(math.remainder(tracker.estimate(current).mean[2] - azimuth[row], math.tau)))
    assert np.abs(errors).max() < 0.1


def test_downlinked_load_factors_and_angles_give_the_acceleration_in_wind():
    """In 14 m/s across: dv/dt over the ground to 0.001 m/s2 rms; ground-track angles, 8 deg of drift off, spoil it."""
    state = BeaconHoming(wind=(0.0, 14.0)).fly(step=0.1).state
    flown = np.gradient(np.array([state.velocity_north, state.velocity_east]), 0.1, axis=1)

    def error(path: str) -> float:
        forward, right, up, bank, angle, course = Downlink(path=path).truth(state)
        said = np.array(horizontal_acceleration(forward, up, right, bank, angle, -course))
        return float(np.sqrt(np.mean((said - flown)[:, 5:-5] ** 2)))

    assert error("air") < 0.001
    assert error("ground") > 0.02


def test_wind_comes_from_where_its_direction_says():
    """From the west it blows to the east; from the north to the south."""
    north, east = WindTable(from_=math.radians(270.0), speed=10.0).steady
    assert (north, east) == pytest.approx((0.0, 10.0), abs=1e-12)
    north, east = WindTable(from_=0.0, speed=10.0).steady
    assert (north, east) == pytest.approx((-10.0, 0.0), abs=1e-12)
