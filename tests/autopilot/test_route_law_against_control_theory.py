"""Design and analysis against python-control, closed forms and the figures of Vasylyev 2003."""

import math

import control
import numpy as np
import pytest
from scipy.integrate import solve_ivp

from aircraft.airframe import load
from aircraft.linearise import linearise
from aircraft.trim import trim
from autopilot import analysis, design
from autopilot.modes.lateral_navigation import LateralNavigation
from autopilot.route import PathDeviation
from sim.flight.vehicles import LATERAL, LONGITUDINAL

G = 9.80665
PAPER = LateralNavigation(math.radians(0.02), math.radians(0.5), math.radians(20.0), 1250.0, 60.0)
LONGITUDINAL_WEIGHTS = (2.0, math.radians(8), math.radians(5), math.radians(5), 4.0, 12.0, 30.0)


@pytest.fixture(scope="module")
def point():
    airframe = load("A320")
    flaps = 0.5 * airframe.full_flaps
    steady = trim(airframe, 95.0, 0.0, 500.0, flaps)
    linear = linearise(airframe, steady)
    return design.OperatingPoint(
        flaps,
        0.0,
        95.0,
        92.7,
        steady.initial.angle_of_attack,
        steady.controls.elevator,
        steady.controls.throttle,
        linear.part(LONGITUDINAL, ("throttle", "elevator")),
        linear.part(LATERAL, ("aileron", "rudder")),
    )


def test_longitudinal_gains_are_those_of_python_control(point):
    A, B = np.zeros((7, 7)), np.zeros((7, 2))
    A[:5, :5], B[:5] = point.longitudinal
    A[5, 0] = A[6, 4] = 1.0
    K, _, poles = control.lqr(A, B, np.diag(np.array(LONGITUDINAL_WEIGHTS) ** -2.0), np.eye(2) * 0.25**-2)
    np.testing.assert_allclose(design.longitudinal_gains(point), K, rtol=1e-6, atol=1e-8)
    assert max(poles.real) < 0.0


def test_ailerons_and_rudder_without_effect_are_named(point):
    A, B = point.lateral
    with pytest.raises(ValueError, match="aileron and rudder do not steer this aircraft"):
        design.lateral_gains(point._replace(lateral=(A, 0.0 * B)))


def test_bank_loop_follows_without_error_and_with_its_bandwidth(point):
    A, B, C = design.bank_loop(point)
    loop = control.ss(A, B[:, :1], C.reshape(1, -1), 0.0)
    assert float(control.dcgain(loop)) == pytest.approx(1.0, abs=1e-9)
    assert max(loop.poles().real) < 0.0
    # the grid of the search steps by 0.35 %
    assert design.bank_bandwidth(point) == pytest.approx(control.bandwidth(loop), rel=0.005)


def test_steady_sideslip_is_an_equilibrium(point):
    aileron, rudder, bank = design.steady_sideslip(point)
    A, B = point.lateral
    rates = A @ [1.0, 0.0, 0.0, bank] + B @ [aileron, rudder]
    np.testing.assert_allclose(rates[:3], 0.0, atol=1e-10)
    assert bank > 0.0  # wind from the right: the right wing is held down


@pytest.mark.parametrize("damping", [0.3, 0.7, 0.9, 0.95])
def test_peak_of_a_capture_from_the_intercept_line(damping):
    """Judge: the linear law integrated from where it takes over, bank zero and the intercept rate."""
    z0 = 2.0 * damping  # for wn = 1 and a closing speed of 1
    path = solve_ivp(
        lambda t, x: [x[1], -x[0] - 2.0 * damping * x[1]],
        (0.0, 10.0),
        [z0, -1.0],
        rtol=1e-10,
        atol=1e-12,
        dense_output=True,
    )
    z, rate = path.sol(np.linspace(0.0, 10.0, 20001))
    assert design.intercept_peak(damping) == pytest.approx(np.abs(z + 2.0 * damping * rate).max(), rel=1e-6)


def test_designed_law_keeps_a_margin_of_bank_and_never_orbits():
    bank_limit = math.radians(15.0)
    for bandwidth, speed in ((2.4, 72.0), (1.2, 85.0), (3.0, 38.0), (0.5, 72.0)):
        law = design.lateral_law(bandwidth, speed, bank_limit)
        frequency, damping = law.frequency, law.damping
        assert damping == pytest.approx(0.95)
        assert frequency <= bandwidth / 6.0 + 1e-12
        assert law.intercept_speed == pytest.approx(0.5 * speed)  # sin 30 deg
        law.check_convergence(speed, turns=True)
        peak = frequency * law.intercept_speed * design.intercept_peak(damping)
        assert peak <= 0.85 * G * math.tan(bank_limit) * (1 + 1e-12)


@pytest.mark.parametrize("turning", [1.0, 0.9, 0.68, 0.5])
def test_an_aircraft_that_slips_in_its_turns_captures_within_its_bank_limit(turning):
    """Judge: z'' = turning g bank from the intercept line, integrated; it neither meets the limit nor overshoots."""
    bank_limit, speed = math.radians(15.0), 41.0
    law = design.lateral_law(5.0, speed, bank_limit, turning)

    def bank(z, rate):
        return law(PathDeviation(z, rate, np.inf, 0.0, 0.0, 0.0))

    path = solve_ivp(
        lambda t, x: [x[1], turning * G * math.tan(bank(*x))], (0.0, 200.0), [1000.0, -law.intercept_speed],
        rtol=1e-9, atol=1e-9, dense_output=True,
    )  # fmt: skip
    z, rate = path.sol(np.linspace(0.0, 200.0, 4001))
    assert np.abs(bank(z, rate)).max() < bank_limit
    assert z.min() > -0.01 * law.cross_track_limit  # of the damping 0.95, and of tan(bank)


def test_poles_are_those_of_the_characteristic_equation():
    for pole in analysis.poles(PAPER):
        assert abs(pole**2 + G * PAPER.k2 * pole + G * PAPER.k1) < 1e-15
    frequency, damping = PAPER.frequency, PAPER.damping
    assert frequency == pytest.approx(0.0585, abs=5e-5)
    assert damping == pytest.approx(0.731, abs=5e-4)


def test_unlimited_capture_has_the_figures_of_the_paper():
    """Print, figure 3, curve 1: 5 km, 100 deg of bank asked for, 131 m/s, overshoot 172 m."""
    capture = analysis.predict_linear(PAPER, 5000.0, 0.0, np.linspace(0.0, 300.0, 3001))
    assert math.degrees(abs(capture.bank).max()) == pytest.approx(100.0, rel=0.001)
    assert abs(capture.cross_track_rate).max() == pytest.approx(131.1, rel=0.01)
    assert capture.cross_track.min() == pytest.approx(-171.9, rel=0.01)


def test_limited_capture_has_the_figures_of_the_paper():
    """Print, figure 3, curve 2: 20 deg, 50 m/s, overshoot 66 m."""
    capture = analysis.predict_limited(PAPER, 5000.0, 0.0, np.linspace(0.0, 300.0, 3001))
    assert math.degrees(abs(capture.bank).max()) == pytest.approx(20.0)
    assert abs(capture.cross_track_rate).max() == pytest.approx(49.97, rel=0.01)
    assert capture.cross_track.min() == pytest.approx(-65.5, rel=0.01)


def test_limited_capture_from_inside_the_limits_is_the_linear_one():
    time = np.linspace(0.0, 200.0, 401)
    linear = analysis.predict_linear(PAPER, 500.0, 0.0, time)
    limited = analysis.predict_limited(PAPER, 500.0, 0.0, time)
    # steps of 0.02 s by the semi-implicit rule: a first-order error of 13 m/s times 0.02 s
    np.testing.assert_allclose(limited.cross_track, linear.cross_track, atol=0.3)


def test_kinematic_prediction_tends_to_the_double_integrator_for_small_angles_and_quick_rolls():
    law = LateralNavigation(PAPER.k1, PAPER.k2, math.radians(1.0), 1e4, 1e3)
    time = np.linspace(0.0, 200.0, 201)
    quick = analysis.BankReference(speed=3000.0, roll_rate_limit=100.0, frequency=40.0)
    kinematic = analysis.predict_kinematic(law, 500.0, 0.0, time, quick)
    limited = analysis.predict_limited(law, 500.0, 0.0, time)
    # left over: the lag of 0.05 s at 13 m/s, and tan(1 deg) beyond 1 deg by 1e-4
    np.testing.assert_allclose(kinematic.cross_track, limited.cross_track, atol=1.5)


def test_phase_portrait_curves_are_where_the_law_says():
    z = np.linspace(-3000.0, 3000.0, 41)
    portrait = analysis.phase_portrait(PAPER, z)
    for curve, bank in ((portrait.zero_bank, 0.0), (portrait.right_limit, 20.0), (portrait.left_limit, -20.0)):
        inside = np.isfinite(curve[1])
        assert inside.any()
        held = np.clip(curve[0][inside], -1250.0, 1250.0)
        asked = -PAPER.k1 * held - PAPER.k2 * curve[1][inside]
        np.testing.assert_allclose(np.degrees(asked), bank, atol=1e-9)
    far = np.abs(z) >= 1250.0
    np.testing.assert_allclose(np.abs(portrait.zero_bank[1][far]), portrait.intercept_speed)


def test_design_survives_its_own_table():
    law = design.lateral_law(2.4, 72.0, math.radians(15.0))
    schedule = design.Schedule(0.26, (1.0, 2.0), (3.0, 4.0))
    limits = (law.bank_limit, law.cross_track_limit, law.cross_track_rate_limit)
    designed = design.Designed((schedule,), 2.4, 7.2, 0.4, law.k1, law.k2, *limits)
    assert design.Designed.from_table(designed.to_table()) == designed
    assert designed.law == law


def test_designs_need_two_speeds_at_each_flap_setting(point):
    with pytest.raises(ValueError, match="two speeds"):
        design.design([point], 95.0, math.radians(15.0))
