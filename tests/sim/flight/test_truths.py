"""Kinematic truths against calculus, closed forms and the geometry that the papers print."""

from __future__ import annotations

import dataclasses
import math

import numpy as np
import pytest

from aircraft.state import STANDARD_GRAVITY, AircraftState
from aircraft.units import SUFFIXES
from autopilot.modes.lateral_navigation import LateralNavigation
from autopilot.modes.radio_beacon import RadioBeacon
from sim.flight.truths.base_turn import BaseTurn
from sim.flight.truths.beacon_homing import BeaconHoming
from sim.flight.truths.landing_pattern import LandingPattern
from sim.flight.truths.madap import BANKS, NAUTICAL_MILE, SPEEDS, Madap
from sim.flight.truths.mls_profile import MlsProfile
from sim.flight.truths.near_pass import NearPass
from sim.flight.truths.route_capture import NOMINAL, RouteCapture
from sim.flight.truths.s_turn import STurn
from sim.observation.record import observe
from sim.observation.sensors.surveillance_radar import SurveillanceRadar
from sim.scenario import catalogue
from sim.scenario.parameters import model_of
from sim.scenario.tables import Runway

KINDS = catalogue.kinds("truths")

# Central differences of the eighth order: exact to 1e-10 of these motions at a step of 0.2 s.
FIRST = np.array([1 / 280, -4 / 105, 1 / 5, -4 / 5, 0, 4 / 5, -1 / 5, 4 / 105, -1 / 280])
SECOND = np.array([-1 / 560, 8 / 315, -1 / 5, 8 / 5, -205 / 72, 8 / 5, -1 / 5, 8 / 315, -1 / 560])


@pytest.fixture(scope="module")
def flights():
    """Every kind as it stands, flown once."""
    return {kind: catalogue.load("truths", kind)().fly(step=0.1) for kind in KINDS}


def acceleration_felt(state: AircraftState) -> np.ndarray:
    """(north, east, up) in m/s2 from the load factors in wind axes and gravity."""
    forward, right, down = state.wind_axes
    along, side, up = state.load_factor
    north, east, sunk = (STANDARD_GRAVITY * (along * forward[i] + side * right[i] - up * down[i]) for i in range(3))
    return np.array([north, east, -sunk - STANDARD_GRAVITY])


def differentiate(values: np.ndarray, weights: np.ndarray, step: float) -> np.ndarray:
    return np.convolve(values, weights[::-1], mode="valid") / step ** (2 if weights is SECOND else 1)


@pytest.mark.parametrize("kind", KINDS)
def test_velocity_is_the_derivative_of_position(flights, kind):
    """To the error of a central difference over 0.2 s, V turn_rate^2 h^2 / 6 = 0.03 m/s at most; corners excepted."""
    state = flights[kind].state
    for position, velocity in (("north", "velocity_north"), ("east", "velocity_east"), ("height", "velocity_up")):
        difference = np.gradient(getattr(state, position), 0.1, axis=0) - getattr(state, velocity)
        assert np.percentile(np.abs(difference[1:-1]), 99.5) < 0.03, position


@pytest.mark.parametrize("kind", KINDS)
def test_load_factors_give_the_acceleration_back(flights, kind):
    """Specific force plus gravity is dv/dt: what a downlink would report is what was flown."""
    state = flights[kind].state
    felt = acceleration_felt(state)
    flown = np.gradient(np.array([state.velocity_north, state.velocity_east, state.velocity_up]), 0.1, axis=1)
    # roll-rate limits and the mass's speed lag bend dv/dt within a step: 0.05 m/s2 is a tenth of the least manoeuvre
    assert np.percentile(np.abs(felt - flown)[:, 2:-2], 99) < 0.05


@pytest.mark.parametrize("kind", KINDS)
def test_records_are_whole(flights, kind):
    flight = flights[kind]
    rows = len(flight.time)
    assert flight.time == pytest.approx(0.1 * np.arange(rows))
    for name, field in zip(AircraftState._fields, flight.state, strict=True):
        assert np.shape(field) == (rows,), name
        assert np.isfinite(field).all(), name
    assert all(np.shape(field) == (rows,) for field in flight.command)
    assert flight.leg.shape == flight.phase.shape == (rows,)
    assert set(np.unique(flight.phase)) <= set(range(len(flight.phases)))
    assert np.abs(flight.deviation.cross_track).max() < 20000.0


@pytest.mark.parametrize("kind", KINDS)
def test_sensors_watch_a_truth_like_any_flight(flights, kind):
    """A radar without noise to speak of sees the positions of the record, at its own epochs."""
    radar = SurveillanceRadar(period=3.7, position_sigma=1e-6, runway=Runway())
    record = observe(flights[kind], {"radar": radar}, seed=1)["radar"]
    state = flights[kind].state
    north = np.interp(record.time, state.time, state.north)
    assert len(record.time) == int((state.time[-1] + 1e-9) / 3.7)
    # linear against cubic between records: a h^2 / 8 = 0.02 m at 17 m/s2 of the hardest turn
    assert record.z[:, 0, 0] == pytest.approx(north, abs=0.03)


@pytest.mark.parametrize("kind", KINDS)
def test_parameters_can_be_written_in_a_file(kind):
    """Every field that is not given has a type and a unit that the scenario's reader knows."""
    table = model_of(catalogue.load("truths", kind))
    assert table.model_validate({}) is not None
    assert any(key.rsplit("_", 1)[-1] in SUFFIXES for key in table.model_fields)


@pytest.mark.parametrize(
    ("truth", "phase"), [(BaseTurn(), "final_turn"), (STurn(swings=1), "turn"), (NearPass(), "turn")]
)
def test_azimuth_acceleration_from_load_factors_is_the_second_derivative_of_the_azimuth(truth, phase):
    """Glistin's geometry, derived afresh: rho az'' = a across the line of sight - 2 rho' az'."""
    step = 0.2
    flight = truth.fly(step=step)
    state = flight.state
    azimuth, distance = np.unwrap(np.arctan2(state.east, state.north)), np.hypot(state.north, state.east)
    rate = (state.north * state.velocity_east - state.east * state.velocity_north) / distance**2
    closing = (state.north * state.velocity_north + state.east * state.velocity_east) / distance
    north, east, _ = acceleration_felt(state)
    across = east * np.cos(azimuth) - north * np.sin(azimuth)
    corrected = ((across - 2.0 * closing * rate) / distance)[4:-4]
    exact = differentiate(azimuth, SECOND, step)
    steady = np.convolve(np.diff(state.bank, 2, prepend=0, append=0) ** 2, np.ones(9), "valid") < 1e-20
    assert steady.sum() > 50
    assert np.abs(state.bank[flight.during(phase)]).max() > math.radians(14.9)
    assert np.abs(corrected - exact)[steady].max() < 1e-9 * np.abs(exact).max() + 1e-12  # 1e-12: rounding of az / h^2


def test_rolling_turns_are_exact_too():
    """Position against the velocity's eighth-order integral also while rolling: the course has a closed form."""
    state = STurn().fly(step=0.1).state
    inside = slice(4, -4)
    for position, velocity in ((state.north, state.velocity_north), (state.east, state.velocity_east)):
        difference = differentiate(position, FIRST, 0.1) - velocity[inside]
        assert np.abs(difference).max() < 1e-3  # the roll rate jumps at the knots; the stencil cannot be exact there
        assert np.median(np.abs(difference)) < 1e-8


def test_base_turn_ends_on_the_centreline_after_a_quarter_circle():
    flight = BaseTurn().fly()
    state = flight.state
    final = flight.during("final")
    assert np.abs(state.east[final]).max() < 1e-6
    assert state.course[-1] == pytest.approx(0.0, abs=1e-12)
    turning = flight.during("final_turn")
    assert np.hypot(state.north, state.east)[turning].mean() == pytest.approx(8500.0, rel=0.1)


def test_s_turn_comes_back_to_its_line():
    """Equal swings to both sides: no displacement is left, whatever the roll rate."""
    flight = STurn().fly()
    assert flight.state.east[-1] == pytest.approx(0.0, abs=1e-6)
    assert flight.state.course.max() == pytest.approx(math.radians(40.0), abs=1e-3)
    assert flight.state.course.min() == pytest.approx(-math.radians(40.0), abs=1e-3)


def test_a_turn_too_short_for_the_full_bank_is_flown_with_less():
    flight = STurn(swing=math.radians(2.0), swings=1).fly()
    assert np.abs(flight.state.bank).max() < math.radians(12.0)
    assert flight.state.course.max() == pytest.approx(math.radians(2.0), abs=1e-5)


@pytest.mark.parametrize(
    ("distance", "elevation", "rate", "acceleration"),
    [(15000.0, 0.7639, 0.00764, 1.212e-4), (10000.0, 1.1458, 0.01460, 3.01e-4), (5000.0, 2.2906, 0.04576, 1.542e-3)],
)
def test_mls_profile_has_the_elevation_of_the_papers_geometry(distance, elevation, rate, acceleration):
    """Elevation, rate and acceleration in degrees on the level leg: hand-derived values, to their printed digits."""
    state = MlsProfile().fly(step=0.05).state
    beta = np.degrees(np.arctan2(state.height, -state.north))
    row = np.argmin(np.abs(state.north[:1600] + distance))
    row = int(np.clip(row, 4, 1590))
    around = slice(row - 4, row + 5)
    slack = abs(state.north[row] + distance) / distance * 3 + 1e-3  # the record need not hit the distance
    assert beta[row] == pytest.approx(elevation, rel=slack)
    assert differentiate(beta[around], FIRST, 0.05)[0] == pytest.approx(rate, rel=slack)
    assert differentiate(beta[around], SECOND, 0.05)[0] == pytest.approx(acceleration, rel=4 * slack)


def test_mls_profile_glides_at_constant_elevation_and_lands_without_sink():
    flight = MlsProfile().fly(step=1 / 40.5)
    state = flight.state
    glide = flight.during("glide")
    assert np.degrees(np.arctan2(state.height, -state.north))[glide] == pytest.approx(2.29061, abs=1e-5)
    assert flight.during("level").sum() == 3240  # 80.0 s at 40.5 Hz
    assert state.airspeed[flight.during("level")][0] == pytest.approx(150.0)
    assert state.airspeed[glide][[0, -1]] == pytest.approx([100.0, 80.0], abs=0.05)
    assert state.height[-1] == pytest.approx(0.0, abs=0.01)
    assert state.velocity_up[-1] == pytest.approx(0.0, abs=0.01)
    flare_unit = np.degrees(np.arctan2(state.height, 1000.0 - state.north))[flight.during("flare")]
    assert (np.diff(flare_unit) < 0.0).all()  # the elevation seen from a flare unit falls monotonically


def test_unlimited_capture_is_the_second_order_response():
    """Overshoot of p^2 + g k2 p + g k1 from rest at 5000 m: 5000 exp(-pi zeta / sqrt(1 - zeta^2)) = 172.1 m."""
    free = LateralNavigation(NOMINAL.k1, NOMINAL.k2, 1e9, 1e9, 1e9)
    flight = RouteCapture(motion="double_integrator", law=free).fly()
    natural = math.sqrt(STANDARD_GRAVITY * NOMINAL.k1)
    zeta = STANDARD_GRAVITY * NOMINAL.k2 / (2.0 * natural)
    overshoot = 5000.0 * math.exp(-math.pi * zeta / math.sqrt(1.0 - zeta**2))
    assert -flight.state.east.min() == pytest.approx(overshoot, rel=1e-5)  # the record's step misses the very peak
    assert np.degrees(np.abs(flight.command.bank).max()) == pytest.approx(100.0, rel=1e-9)


def test_limited_capture_settles_at_the_intercept_speed():
    """Figure 3, curve 2 of Vasylyev 2003 as measured for the double integrator: 20 deg, 49.97 m/s, -65.5 m, to 1 %."""
    flight = RouteCapture(motion="double_integrator").fly()
    assert np.degrees(np.abs(flight.command.bank).max()) == pytest.approx(20.0, rel=1e-9)
    assert np.abs(flight.state.velocity_east).max() == pytest.approx(49.97, rel=0.001)
    assert flight.state.east.min() == pytest.approx(-65.5, rel=0.01)


@pytest.mark.parametrize("motion", ["double_integrator", "course"])
def test_random_acceleration_across_the_line_is_white(motion):
    """Without a law: variance q t of the rate and q t^3 / 3 of the deviation, q = 0.1, 400 runs (7 % per sigma)."""
    truth = RouteCapture(
        motion=motion, law=lambda deviation: 0.0 * deviation.cross_track, cross_track=0.0, duration=30.0
    )
    state = truth.fly(np.random.default_rng(3), 400, step=0.2).state
    assert state.velocity_east[-1].var() == pytest.approx(0.1 * 30.0, rel=0.25)
    assert state.east[-1].var() == pytest.approx(0.1 * 30.0**3 / 3.0, rel=0.25)
    felt = acceleration_felt(state)[1]
    assert felt[1:].var() == pytest.approx(0.1 / (0.1 if motion == "double_integrator" else 0.2), rel=0.1)


def test_an_aircraft_with_an_offset_flies_beside_the_line():
    state = RouteCapture(cross_track=2000.0, offset=2000.0, duration=60.0).fly(step=0.1).state
    assert state.east == pytest.approx(2000.0)


def test_course_motion_stays_within_three_per_cent_of_the_double_integrator():
    """Of the start offset; roll lag, tan and V sin(chi) are what differs."""
    starts = np.array([500.0, 5000.0])
    turning = RouteCapture(motion="course", cross_track=starts, duration=180.0).fly(step=0.1)
    integrated = RouteCapture(motion="double_integrator", cross_track=starts, duration=180.0).fly(step=0.1)
    assert turning.state.east.shape == (len(turning.time), 2)
    assert (np.abs(turning.state.east - integrated.state.east).max(axis=0) < 0.03 * starts).all()
    assert (np.abs(turning.state.east - integrated.state.east).max(axis=0) > 0.001 * starts).all()


def test_homing_in_a_crosswind_settles_where_bearing_and_drift_balance():
    """Heading form of the law on a constant bearing e: k3 e = k4 (e - drift), drift from the wind triangle."""
    law = RadioBeacon(6.0, 1.2, math.radians(20.0), math.radians(5.0), course="heading")
    flight = BeaconHoming(law=law, bearing=0.0, wind=(0.0, 14.0)).fly()
    bearing = 0.0
    for _ in range(50):
        bearing = -1.2 / (6.0 - 1.2) * math.asin(0.14 * math.cos(bearing))
    assert flight.deviation.bearing_error[-1] == pytest.approx(bearing, rel=0.01)
    track = BeaconHoming(law=dataclasses.replace(law, course="track"), bearing=0.0, wind=(0.0, 14.0)).fly()
    assert np.abs(track.deviation.cross_track).max() < 1.0  # the track form needs no bearing to hold the course


def test_homing_is_shaken_about_its_steady_wind():
    """A quarter of a minute of white acceleration, q = 0.1: variance q t of the velocity about the mean wind's."""
    truth = BeaconHoming(wind=(0.0, 14.0), bearing=0.0, nearest=38500.0)
    quiet, shaken = truth.fly(step=0.25).state, truth.fly(np.random.default_rng(4), 200, step=0.25).state
    row = 40
    north = shaken.velocity_north[row] - quiet.velocity_north[row]
    assert north.mean() == pytest.approx(0.0, abs=0.25)  # 3.5 sigma of a mean of 200
    assert north.var() == pytest.approx(0.1 * 10.0, rel=0.35)  # 10 % per sigma


def test_landing_pattern_flies_the_papers_speeds_and_lands():
    flight = LandingPattern().fly(step=0.1)
    state = flight.state
    assert [event.name for event in flight.events] == ["base", "final_turn", "final", "glide", "ground", "completed"]
    assert state.airspeed[flight.during("base")] == pytest.approx(72.0)
    assert state.airspeed[flight.during("final")] == pytest.approx(69.0, abs=0.1)
    assert state.airspeed[-1] == pytest.approx(58.0, abs=0.01)
    assert np.degrees(np.abs(state.bank)).max() == pytest.approx(15.0, abs=0.01)
    assert math.hypot(state.north[-1] - 300.0, state.east[-1]) < 20.0
    settled = flight.during("glide") & (state.north > -7000.0)
    height = (300.0 - state.north) * math.tan(math.radians(2.0 + 40.0 / 60.0))
    assert np.abs(state.height - height)[settled].max() < 0.1
    begun = np.flatnonzero(flight.during("glide"))[0]
    slowed = np.flatnonzero(state.airspeed < 58.5)[0]
    assert (slowed - begun) * 0.1 == pytest.approx(10.5 / 0.5, abs=1.0)  # at 0.5 m/s2


def test_right_hand_pattern_is_the_mirror_image():
    left, right = (LandingPattern(side=side).fly(step=0.1) for side in ("left", "right"))
    assert right.state.east == pytest.approx(-left.state.east, abs=1e-9)
    assert right.state.north == pytest.approx(left.state.north, abs=1e-9)


def test_ensemble_without_noise_is_one_run_repeated():
    quiet = LandingPattern(acceleration_sigma=0.0)
    one = quiet.fly(step=0.35)
    many = quiet.fly(np.random.default_rng(1), 3, step=0.35)
    assert many.state.north.shape == (len(one.time), 3)
    assert many.state.north == pytest.approx(one.state.north[:, None] * np.ones(3), abs=1e-9)
    assert many.state.specific_force_right == pytest.approx(one.state.specific_force_right[:, None] * np.ones(3))


def test_random_acceleration_has_its_sigma_and_is_felt():
    """One draw of 0.1 m/s2 per axis, held for 0.7 s: what the load factors say, and what the velocity becomes."""
    flight = LandingPattern().fly(np.random.default_rng(2), 100, step=0.35)
    north, _, _ = acceleration_felt(flight.state)
    assert north[0].std() == pytest.approx(0.1, rel=0.25)  # 100 draws: 7 % per sigma
    assert north[1] == pytest.approx(north[0], abs=0.03)  # the law hardly turns within the second half of a draw
    assert np.corrcoef(north[2], north[0])[0, 1] == pytest.approx(0.0, abs=0.3)  # a new draw: 3 sigma of 1/sqrt(100)
    assert flight.state.velocity_north[2] == pytest.approx(0.7 * north[0], abs=0.02)
    touchdown = flight.state.north[np.argmax(flight.during("ground"), axis=0), np.arange(100)]
    assert (np.abs(touchdown - 300.0) < 100.0).all()  # every run still lands


@pytest.mark.parametrize("turn", range(0, 151, 30))
def test_landing_pattern_is_entered_from_any_direction(turn):
    flight = LandingPattern(turn=math.radians(turn), entry=9000.0).fly(step=0.1)
    assert flight.phases[flight.phase[-1]] == "ground"
    assert abs(flight.state.east[-1]) < 21.0  # m, the autoland box
    assert flight.state.course[0] == pytest.approx(math.radians(turn), abs=1e-9)


def test_madap_flights_turn_by_175_degrees_after_twenty_nautical_miles():
    for speed in SPEEDS:
        for bank in BANKS:
            flight = Madap(speed=speed, bank=bank).fly(step=0.5)
            state = flight.state
            assert np.degrees(np.abs(state.bank).max()) == pytest.approx(math.degrees(bank), abs=1e-9)
            turned = np.unwrap(state.course)
            assert turned[-1] - turned[0] == pytest.approx(math.radians(175.0), abs=1e-9)
            row = np.flatnonzero(flight.during("turn"))[0]
            flown = math.hypot(state.north[row] - state.north[0], state.east[row] - state.east[0])
            assert flown == pytest.approx(20.0 * NAUTICAL_MILE, abs=0.5 * speed)
            assert state.ground_speed == pytest.approx(speed)


@pytest.mark.parametrize(
    ("truth", "values", "says"),
    [
        (LandingPattern, {"side": "up"}, "'left' or 'right'"),
        (LandingPattern, {"turn": math.pi}, "between 0 and 180 deg"),
        (LandingPattern, {"deceleration": 0.0}, "deceleration"),
        (LandingPattern, {"acceleration_sigma": -1.0}, "acceleration_sigma"),
        (MlsProfile, {"glide_distance": 20000.0}, "one behind the other"),
        (MlsProfile, {"decision_height": 300.0}, "decision height"),
        (MlsProfile, {"glide_speed": 200.0}, "speed must fall"),
        (STurn, {"swing": 0.0}, "swing"),
        (STurn, {"swings": 0}, "swings"),
        (NearPass, {"offset": -1.0}, "offset"),
        (BaseTurn, {"final": 0.0}, "final"),
        (RouteCapture, {"motion": "glider"}, "double_integrator"),
        (RouteCapture, {"cross_track_rate": 120.0}, "below its speed"),
        (RouteCapture, {"acceleration_density": -0.1}, "acceleration_density"),
        (BeaconHoming, {"wind": (0.0, 120.0)}, "exceed the wind"),
        (BeaconHoming, {"nearest": 50000.0}, "farther"),
        (Madap, {"straight": 0.0}, "straight"),
    ],
)
def test_bad_parameters_are_refused_in_one_sentence(truth, values, says):
    with pytest.raises(ValueError, match=says):
        truth(**values)


def test_a_flight_that_never_ends_says_so():
    """A law that circles does not bring the aircraft to its beacon."""
    flight = BeaconHoming(law=lambda deviation: 0.5).fly(step=0.5)
    assert flight.outcome == "time_limit"
    assert flight.events[-1].name == "time_limit"
    assert "not finished" in flight.reason


def test_a_leg_too_short_for_the_turn_is_refused():
    with pytest.raises(ValueError, match="its turns need"):
        LandingPattern(entry=1000.0).fly()
