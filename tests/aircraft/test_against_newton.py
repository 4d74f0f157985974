"""Judge: Newton's second law. What the airframe reports must fit together as motion does."""

import math

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from aircraft.airframe import load
from aircraft.point_mass import PointMass
from aircraft.state import STANDARD_GRAVITY, AircraftState, Command

RATE = 120  # Hz


def manoeuvre(steady, model, airspeed, flaps_deg, wind):
    """20 s at 120 Hz from a trim, with the aileron, rudder and elevator stirred."""
    start = steady(model, airspeed, flaps_deg=flaps_deg, gear=1.0)
    airframe = load(model, rate=RATE)
    airframe.begin(start.at(0.0, 0.0, 600.0, 0.7), wind)
    trimmed = start.controls
    record = []
    for step in range(20 * RATE):
        time = step / RATE
        controls = trimmed._replace(
            aileron=trimmed.aileron + 0.05 * math.sin(0.6 * time),
            rudder=trimmed.rudder + 0.1 * math.sin(1.1 * time),
            elevator=trimmed.elevator + 0.03 * math.sin(0.9 * time),
        )
        airframe.step(controls, 1)
        record.append(airframe.read())
    return AircraftState(*np.array(record).T)


CASES = [("an26", 72.0, 15.0), ("c172x", 33.4, 10.0)]
WINDS = [(0.0, 0.0, 0.0), (6.0, -8.0, 0.0)]


@pytest.mark.parametrize("wind", WINDS)
@pytest.mark.parametrize(("model", "airspeed", "flaps_deg"), CASES)
def test_load_factors_give_the_horizontal_acceleration(steady, model, airspeed, flaps_deg, wind):
    record = manoeuvre(steady, model, airspeed, flaps_deg, wind)
    north, east, _ = record.acceleration
    for derived, velocity in ((north, record.velocity_north), (east, record.velocity_east)):
        error = derived[1:-1] - (velocity[2:] - velocity[:-2]) * RATE / 2.0
        assert math.sqrt(np.mean(error**2)) < 0.01  # m/s2, as required of the load-factor channel
        assert np.std(derived) > 0.1  # or nothing was tested


@pytest.mark.parametrize("wind", WINDS)
def test_velocity_is_the_rate_of_position(steady, wind):
    record = manoeuvre(steady, "an26", 72.0, 15.0, wind)
    for position, velocity in (("north", "velocity_north"), ("east", "velocity_east"), ("height", "velocity_up")):
        place, speed = getattr(record, position), getattr(record, velocity)
        flown = np.concatenate(([0.0], np.cumsum(0.5 * (speed[1:] + speed[:-1])))) / RATE
        # the vertical adds height / R = 1e-4 of the distance; the trapezoid rule errs by less
        assert np.abs(place - place[0] - flown).max() < 0.3


@pytest.mark.parametrize("wind", WINDS)
def test_air_velocity_plus_wind_is_the_velocity_over_the_ground(steady, wind):
    record = manoeuvre(steady, "an26", 72.0, 15.0, wind)
    north, east, up = record.air_velocity
    assert np.abs(north + wind[0] - record.velocity_north).max() < 1e-6  # the quaternion is normalised to 1e-9
    assert np.abs(east + wind[1] - record.velocity_east).max() < 1e-6  # the quaternion is normalised to 1e-9
    assert np.abs(up - record.velocity_up).max() < 1e-6  # the quaternion is normalised to 1e-9


def test_golden_load_factors_of_the_glistin_check():
    # n = (.02, 1.05, .01) forward, up, right; bank -15 deg, path -3 deg, course 120 deg to the left of X:
    # a_X = -2.58483743, a_Z = .66359067 in its axes X forward, Z right
    state = AircraftState(*[0.0] * len(AircraftState._fields))._replace(
        specific_force_forward=0.02 * STANDARD_GRAVITY,
        specific_force_right=0.01 * STANDARD_GRAVITY,
        specific_force_down=-1.05 * STANDARD_GRAVITY,
        bank=math.radians(-15.0),
        pitch=math.radians(-3.0),
        heading=math.radians(-120.0),
    )
    north, east, _ = state.acceleration
    assert north == pytest.approx(-2.5848374311848406, abs=1e-12)
    assert east == pytest.approx(0.6635906659692135, abs=1e-12)
    assert state.aerodynamic_bank == pytest.approx(math.radians(-15.0), abs=1e-12)
    assert state.flight_path_angle == pytest.approx(math.radians(-3.0), abs=1e-12)


@pytest.mark.parametrize("batched", [False, True])
def test_point_mass_load_factors_are_its_acceleration(batched):
    """The acceleration by the chain rule over (V, course, path angle), nothing of the load factors in it."""
    mass = PointMass()
    north = np.zeros(3) if batched else 0.0
    state = mass.begin(north, 0.0, 400.0, 0.3, 72.0, wind=(5.0, -3.0, 0.0))
    for step in range(600):
        command = Command(0.25 * math.sin(step / 60.0), 0.05 * math.sin(step / 45.0), math.nan, 65.0, 0.3, 1.0)
        state = mass.step(state, command, 1.0 / 30.0)
        turning = STANDARD_GRAVITY * np.tan(state.bank) / state.airspeed
        speed, course, path = state.airspeed, state.course, state.flight_path_angle
        level = state.acceleration * np.cos(path) - speed * np.sin(path) * state.path_rate
        expected = (
            level * np.cos(course) - speed * np.cos(path) * np.sin(course) * turning,
            level * np.sin(course) + speed * np.cos(path) * np.cos(course) * turning,
            state.acceleration * np.sin(path) + speed * np.cos(path) * state.path_rate,
        )
        for derived, wanted in zip(mass.read(state).acceleration, expected, strict=True):
            assert np.abs(derived - wanted).max() < 1e-12


def test_axes_are_those_of_an_independent_rotation():
    """scipy's intrinsic heading - pitch - bank, then angle of attack and sideslip."""
    generator = np.random.default_rng(4)
    heading, bank = generator.uniform(-math.pi, math.pi, (2, 200))
    pitch, alpha, beta = generator.uniform(-0.8, 0.8, (3, 200))
    force = generator.normal(0.0, 10.0, (200, 3))
    state = AircraftState(*[np.zeros(200)] * len(AircraftState._fields))._replace(
        heading=heading,
        pitch=pitch,
        bank=bank,
        angle_of_attack=alpha,
        sideslip=beta,
        airspeed=np.full(200, 70.0),
        specific_force_forward=force[:, 0],
        specific_force_right=force[:, 1],
        specific_force_down=force[:, 2],
    )
    body = Rotation.from_euler("ZYX", np.column_stack([heading, pitch, bank]))
    wind = body * Rotation.from_euler("ZYX", np.column_stack([0.0 * alpha, alpha, 0.0 * alpha])).inv()
    wind = wind * Rotation.from_euler("ZYX", np.column_stack([beta, 0.0 * beta, 0.0 * beta]))
    course, path, rolled = wind.as_euler("ZYX").T
    assert state.air_course == pytest.approx(course, abs=1e-12)
    assert state.flight_path_angle == pytest.approx(path, abs=1e-12)
    assert state.aerodynamic_bank == pytest.approx(rolled, abs=1e-12)
    north, east, down = body.apply(force).T
    assert np.array(state.acceleration) == pytest.approx(np.array([north, east, -down - STANDARD_GRAVITY]), abs=1e-12)
    along, side, below = (wind.inv() * body).apply(force).T / STANDARD_GRAVITY
    assert np.array(state.load_factor) == pytest.approx(np.array([along, side, -below]), abs=1e-12)
