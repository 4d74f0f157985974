"""Margins and limit cycles of the route loop against python-control, time histories and the loops' own text."""

from __future__ import annotations

import math

import control
import numpy as np
import pytest

from aircraft.actuators import actuator_bandwidth
from aircraft.air import Air
from aircraft.airframe import load
from aircraft.linearise import linearise
from aircraft.model_files import read
from aircraft.state import AircraftState, Command
from aircraft.trim import trim
from autopilot import describing_functions, limit_cycles, route_loop
from autopilot.design import OperatingPoint, design, law_of_frequency
from autopilot.inner_loops import InnerLoops
from autopilot.route import PathDeviation
from autopilot.route_loop import AILERON, BANK, CROSS_TRACK, CROSS_TRACK_RATE, STEP
from sim.flight.vehicles import LATERAL, LONGITUDINAL

SPEED, FLAPS = 72.0, math.radians(15.0)
RATE = 120.0  # Hz, of the simulation
DELAY = route_loop.DELAY / RATE


def at(speed):
    steady = trim(load("an26", 20000.0), speed, 0.0, 600.0, FLAPS)
    linear = linearise(load("an26", 20000.0), steady)
    controls = steady.controls
    longitudinal, lateral = (
        linear.part(LONGITUDINAL, ("throttle", "elevator")),
        linear.part(LATERAL, ("aileron", "rudder")),
    )
    alpha = steady.initial.angle_of_attack
    speeds = speed, speed * Air().equivalent_share(600.0)
    return OperatingPoint(FLAPS, 0.0, *speeds, alpha, controls.elevator, controls.throttle, longitudinal, lateral)


@pytest.fixture(scope="module")
def designed():
    return design([at(0.96 * SPEED), at(1.04 * SPEED)], SPEED, math.radians(15.0))


@pytest.fixture(scope="module")
def loop(designed):
    return route_loop.route_loop(at(SPEED), designed, (20.0, 20.0), RATE)


def law(frequency, bank_limit=15.0):
    return law_of_frequency(frequency, SPEED, math.radians(bank_limit))


# ---- limits behind a sine ------------------------------------------------------------------------------------------


@pytest.mark.parametrize("amplitude", [0.5, 1.0, 1.5, 3.0, 10.0])
def test_saturation_is_that_of_python_control(amplitude):
    judge = control.describing_function(control.saturation_nonlinearity(1.0), amplitude, num_points=20000)
    # the judge integrates numerically
    assert describing_functions.saturation_describing_function(amplitude, 1.0) == pytest.approx(abs(judge), abs=1e-5)


@pytest.mark.parametrize("share", [0.05, 0.3, 0.53])
def test_a_rate_limit_that_never_catches_up_makes_a_triangle(share):
    """Closed form: a triangle of height pi rate/(2 frequency), whose peaks lie on the falling sine."""
    height = share * math.pi / 2.0
    judge = 8.0 / math.pi**2 * height * np.exp(-1j * math.acos(height))
    found = describing_functions.limits_describing_function(2.0, 3.0, 100.0, 2.0 * 3.0 * share)
    assert complex(found) == pytest.approx(judge, abs=1e-9)


@pytest.mark.parametrize(
    ("amplitude", "rate"),
    [(0.6, 0.55), (0.9, 2.0), (1.5, 1.3), (1.2, 0.4), (3.0, 0.9), (8.0, 0.7), (6.0, 3.0), (20.0, 2.0)],
)
def test_both_limits_against_stepping_through_them(amplitude, rate):
    """Ratios at which the limited signal is a triangle, a trapezium, and follows its demand on slope or plateau."""
    half, limit, frequency = 4000, 0.3, 0.7
    step = math.pi / half
    most = rate * limit * step
    wanted = [max(-limit, min(limit * amplitude * math.sin(step * k), limit)) for k in range(1, half + 1)]

    def half_period(y):
        for one in wanted:
            y += max(-most, min(one - y, most))
            yield y

    y = 0.0
    for _ in range(8):  # to the wave whose second half is the first one upside down
        *_, last = half_period(y)
        y = 0.5 * (y - last)
    *_, last = half_period(y)
    wave = np.array(list(half_period(-last)))
    judge = 2j / half * np.sum(wave * np.exp(-1j * step * np.arange(1, half + 1))) / (limit * amplitude)
    limits = limit, rate * limit * frequency
    found = complex(describing_functions.limits_describing_function(limit * amplitude, frequency, *limits))
    assert found == pytest.approx(judge, abs=3e-4)  # steps of 8e-4 rad
    drawn = describing_functions.limited_wave(limit * amplitude, frequency, *limits)
    first = complex(describing_functions.harmonics(drawn, 1)[0]) / (limit * amplitude)
    assert first == pytest.approx(found, abs=1e-4)  # 512 points of a wave with corners


def test_limits_out_of_reach_change_nothing():
    amplitude = np.geomspace(0.01, 50.0, 30)
    assert describing_functions.limits_describing_function(amplitude, 1.0, 100.0, 100.0) == pytest.approx(1.0)
    slow = describing_functions.limits_describing_function(amplitude, 1e-6, 2.0, 1.0)
    assert slow == pytest.approx(describing_functions.saturation_describing_function(amplitude, 2.0), abs=1e-5)


# ---- the linear loop -------------------------------------------------------------------------------------------------


def test_matrix_says_what_the_inner_loops_do(designed, loop):
    """One step of the loops themselves on a small motion, against the rows of the matrix."""
    noise = np.random.default_rng(5)
    x = 1e-4 * noise.standard_normal(len(loop.A))
    wanted = 1e-4
    sideslip, roll_rate, yaw_rate, bank = x[:4]
    reference, reference_rate, aileron_sum, rudder_sum = x[-4:]
    flown = AircraftState(*np.zeros(len(AircraftState._fields)))._replace(
        height=600.0,
        velocity_north=SPEED,
        airspeed=SPEED,
        equivalent_airspeed=SPEED * Air().equivalent_share(600.0),
        flaps=FLAPS,
        sideslip=sideslip,
    )
    flown = flown._replace(roll_rate=roll_rate, yaw_rate=yaw_rate, bank=bank)
    loops = InnerLoops(designed)
    s = loops.begin(flown._replace(bank=0.0, roll_rate=0.0, yaw_rate=0.0, sideslip=0.0))
    s = s._replace(bank=reference, bank_rate=reference_rate, aileron_sum=aileron_sum, rudder_sum=rudder_sum)
    s, controls = loops.step(s, Command(wanted, 0.0, 600.0, SPEED, FLAPS, 0.0, 0.0), flown, STEP)
    after = loop.A @ x + loop.B * wanted
    # small angles of 1e-4: what is not linear is below 1e-8 of them
    assert (s.bank, s.bank_rate, s.aileron_sum, s.rudder_sum) == pytest.approx(tuple(after[-4:]), rel=1e-6)
    assert (controls.aileron, controls.rudder) == pytest.approx(tuple(after[8:10]), rel=1e-6)
    assert controls.aileron == pytest.approx(float((loop.C @ x + loop.D * wanted)[AILERON]), rel=1e-6)


def test_bank_turns_the_path_as_gravity_says(loop):
    """Slow turns are coordinated, so the cross-track acceleration is g times the bank."""
    frequency = np.array([0.01, 0.05])
    y = route_loop.response(loop, frequency)
    assert y[BANK] == pytest.approx(np.ones(2), abs=0.06)
    gravity = -(frequency**2) * y[CROSS_TRACK] / y[BANK]
    # the yaw rate that holds a turn lags by a second: 5 % at 0.05 rad/s
    assert np.abs(gravity) == pytest.approx(9.80665, rel=0.01)
    assert y[CROSS_TRACK_RATE] == pytest.approx(1j * frequency * y[CROSS_TRACK], rel=1e-3)


def test_held_controls_and_their_delay_are_those_of_a_fine_step(designed):
    """Judge: the same airframe in steps of an eightieth, its controls changed when the delay is over."""
    F, G = route_loop._airframe(at(SPEED), (20.0, 20.0))
    held, moved, late = route_loop._sampled(F, G, DELAY)
    x, old, new = np.arange(8.0), np.array([0.1, -0.2]), np.array([-0.3, 0.4])
    after = held @ x + moved @ new + late @ old
    count = 8000
    step = STEP / count
    for k in range(count):
        u = old if k * step < DELAY else new
        rate = F @ x + G @ u
        x = x + step * (rate + 0.5 * step * F @ rate)
    assert after == pytest.approx(x, rel=1e-6, abs=1e-7)


@pytest.mark.parametrize("natural", [0.15, 0.4, 1.0])
def test_margins_are_those_of_python_control(loop, natural):
    frequency = np.geomspace(0.03, 60.0, 1500)
    values = route_loop.open_loop(loop, law(natural))(np.exp(1j * STEP * frequency))
    judge = control.margin(np.abs(values), np.degrees(np.unwrap(np.angle(values))), frequency)
    gain, phase, turned, level = judge
    # the judge interpolates in the grid
    assert route_loop.margins(loop, law(natural)) == pytest.approx((gain, math.radians(phase), turned, level), rel=1e-6)


def test_the_loop_is_unstable_from_where_its_gain_margin_is_one(loop):
    """Eigenvalues and frequency response are two ways to the same border."""
    onset = route_loop.linear_onset(loop, math.radians(15.0))
    assert route_loop.margins(loop, law(onset)).gain == pytest.approx(1.0, abs=1e-3)
    border = 1.0 + 1e-9  # a sum that neither grows nor fades is a root of 1, and rounds to either side
    assert route_loop.growth(loop, law(0.99 * onset)) < border < route_loop.growth(loop, law(1.01 * onset))
    assert route_loop.margins(loop, law(0.15)).gain > route_loop.margins(loop, law(0.4)).gain > 1.0


def test_actuators_are_read_from_the_model(designed, loop):
    assert actuator_bandwidth(read("an26"), "aileron") == 20.0
    assert actuator_bandwidth(read("c172x"), "aileron") == math.inf  # limited in rate, without lag
    quick = route_loop.route_loop(at(SPEED), designed, (math.inf, math.inf), RATE)
    # 50 ms less of delay at 1.9 rad/s are 5 deg
    assert route_loop.linear_onset(quick, 0.26) > 1.03 * route_loop.linear_onset(loop, 0.26)


# ---- oscillations ----------------------------------------------------------------------------------------------------


def flown(loop, law, rate, offset, time):
    """(k, 4) outputs of the linear loop behind its limits, from rest beside the line."""
    x = np.zeros(len(loop.A))
    x[5] = offset
    command, rows = 0.0, []
    for _ in range(round(time / STEP)):
        y = loop.C @ x
        wanted = law(PathDeviation(float(y[CROSS_TRACK]), float(y[CROSS_TRACK_RATE]), math.inf, 0.0, 0.0, 0.0))
        command += max(-rate * STEP, min(wanted - command, rate * STEP))
        rows.append(loop.C @ x + loop.D * command)
        x = loop.A @ x + loop.B * command
    return np.array(rows)


def last_cycle(rows):
    """Period and half of peak to peak of bank and cross-track in the last four minutes."""
    last = rows[-round(240.0 / STEP) :]
    bank = last[:, BANK]
    up = np.flatnonzero((bank[:-1] < 0.0) & (bank[1:] >= 0.0))
    exact = up + bank[up] / (bank[up] - bank[up + 1])
    return STEP * float(np.diff(exact).mean()), *(0.5 * np.ptp(last[:, [BANK, CROSS_TRACK]], axis=0))


@pytest.mark.parametrize("share", [1.02, 1.1, 1.3])
def test_the_cycle_of_the_bank_limit_is_that_of_a_time_history(loop, share):
    rapid = math.radians(90.0)
    fast = law(share * route_loop.linear_onset(loop, math.radians(15.0)))
    (cycle,) = limit_cycles.limit_cycles(limit_cycles.limited_loop(loop, fast.bank_limit, rapid), fast)
    assert cycle.is_stable
    period, bank, cross_track = last_cycle(flown(loop, fast, rapid, 1.0, 400.0))
    # the time history is seen in steps of 1 % of the period
    assert cycle.period == pytest.approx(period, rel=0.01)
    assert cycle.bank == pytest.approx(bank, rel=0.01)
    assert cycle.cross_track == pytest.approx(cross_track, rel=0.02)  # the period, squared


def test_the_bank_limit_alone_is_the_balance_of_python_control(loop):
    fast = law(1.2 * route_loop.linear_onset(loop, math.radians(15.0)))
    limited = limit_cycles.limited_loop(loop, fast.bank_limit, math.radians(90.0))
    ((found,), grows) = limit_cycles.sine_balances(limited, fast)
    assert grows
    frequency = np.geomspace(1.0, 4.0, 300)
    values = route_loop.open_loop(loop, fast)(np.exp(1j * STEP * frequency))
    judge = control.describing_function_response(
        control.FRD(values, frequency, smooth=True),  # its search takes every system for a continuous one
        control.saturation_nonlinearity(fast.bank_limit),
        fast.bank_limit * np.geomspace(1.01, 4.0, 100),
        frequency,
        warn_nyquist=False,
    ).intersections
    ((demand, frequency),) = judge
    assert found.demand == pytest.approx(demand, rel=0.01)  # both interpolate
    assert found.frequency == pytest.approx(frequency, rel=0.005)


@pytest.mark.parametrize("frequency", [0.45, 0.5])
def test_a_roll_rate_limit_sustains_what_is_large_and_only_that(loop, frequency):
    rate = math.radians(5.0)
    chosen = law(frequency)
    limited = limit_cycles.limited_loop(loop, chosen.bank_limit, rate)
    unstable, stable = limit_cycles.limit_cycles(limited, chosen)
    assert (unstable.is_stable, stable.is_stable) == (False, True)
    offset = limit_cycles.least_offset(limited, chosen)
    assert offset == pytest.approx(unstable.demand / chosen.k1)
    fades = flown(loop, chosen, rate, 0.7 * offset, 400.0)[-round(60.0 / STEP) :, BANK]
    assert np.abs(fades).max() < math.radians(0.1)
    period, bank, cross_track = last_cycle(flown(loop, chosen, rate, 1.3 * offset, 600.0))
    # the phase hardly changes with the period here, so that the steps of the time history count
    assert stable.period == pytest.approx(period, rel=0.03)
    assert stable.bank == pytest.approx(bank, rel=0.01)
    assert stable.cross_track == pytest.approx(cross_track, rel=0.06)  # the period, squared


@pytest.mark.parametrize("bank_limit", [12.0, 20.0])
def test_a_cycle_far_beyond_the_limits_of_the_law_is_that_of_a_time_history(loop, bank_limit):
    """Swings of 300 m and more: the law limits deviation and rate, and one harmonic gives half of the period."""
    rate, chosen = math.radians(5.0), law(0.7, bank_limit)
    limited = limit_cycles.limited_loop(loop, chosen.bank_limit, rate)
    cycle = limit_cycles.caught(limited, chosen, 300.0)
    period, bank, cross_track = last_cycle(flown(loop, chosen, rate, 300.0, 900.0))
    assert cross_track > 2.0 * chosen.cross_track_limit
    (of_a_sine,) = (one for one in limit_cycles.sine_balances(limited, chosen)[0] if one.is_stable)
    assert math.tau / of_a_sine.frequency < 0.8 * period
    assert cycle.period == pytest.approx(period, rel=0.005)
    assert cycle.bank == pytest.approx(bank, rel=0.02)  # corners of the command, of which 20 harmonics are left
    assert cycle.cross_track == pytest.approx(cross_track, rel=0.01)  # the period, squared


def test_onset_is_the_linear_one_where_the_limits_cannot_act(loop):
    """A small bank limit is never faster than the roll-rate limit; a larger one lets the rate limit decide."""
    rate, linear = math.radians(5.0), route_loop.linear_onset(loop, 0.26)
    small = limit_cycles.limited_loop(loop, math.radians(2.0), rate)
    assert limit_cycles.onset(small, 300.0) == pytest.approx(linear, rel=1e-3)
    onsets = [
        limit_cycles.onset(limit_cycles.limited_loop(loop, math.radians(b), rate), 300.0) for b in (5.0, 10.0, 20.0)
    ]
    assert linear > onsets[0] > onsets[1] > onsets[2]
    near = limit_cycles.onset(limit_cycles.limited_loop(loop, math.radians(20.0), rate), 1.0)
    assert onsets[2] < near < linear  # close to the line little is asked for


def test_a_calm_law_has_no_cycle(loop):
    limited = limit_cycles.limited_loop(loop, math.radians(15.0), math.radians(5.0))
    assert limit_cycles.limit_cycles(limited, law(0.17)) == ()
    assert limit_cycles.least_offset(limited, law(0.17)) == math.inf
    assert limit_cycles.least_offset(limited, law(1.2)) == 0.0
