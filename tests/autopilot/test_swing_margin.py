"""Laws that must not swing: stepped through with their limits, since harmonic balance has designed them."""

from __future__ import annotations

import math

import numpy as np
import pytest

from autopilot.design import lateral_law, law_of_frequency
from autopilot.limit_cycles import largest_gain, limited_loop
from autopilot.route_loop import BANK, CROSS_TRACK, CROSS_TRACK_RATE, STEP, lag_loop, response, turning
from autopilot.saturation import rate_limit
from autopilot.swing_margin import GAIN_MARGIN, first_that_swings, shallower, steadied
from sim.flight.vehicles import AirframeChoice, Configuration, designed_point_mass, leg_loop
from sim.flight.vehicles import designed as design_of

GRAVITY, SPEED, FLAPS = 9.80665, 72.0, math.radians(15.0)
AN26 = AirframeChoice("an26", 20000.0)


def designed(bank, roll):
    limits = {"bank_limit": math.radians(bank), "roll_rate_limit": math.radians(roll)}
    return design_of(AN26, [Configuration(FLAPS, 0.0, 60.0, 73.0)], speed=SPEED, **limits)


def loop_of(gains):
    return leg_loop(AN26, gains, SPEED, 400.0, FLAPS, 0.0)


def fast(gains, bank):
    """The law that bank loop and bank limit alone allow."""
    return lateral_law(gains.bank_bandwidth, SPEED, math.radians(bank))


def swing(loop, law, roll, offset, rate, seconds=300.0):
    """Largest deviation (m) in the last minute, sample by sample, from an offset and a rate towards the line."""
    x = np.linalg.lstsq(loop.C[[CROSS_TRACK, CROSS_TRACK_RATE, BANK]], [offset, -rate, 0.0], rcond=None)[0]
    command, path = 0.0, []
    for _ in range(round(seconds / STEP)):
        z, drift = loop.C[CROSS_TRACK] @ x, loop.C[CROSS_TRACK_RATE] @ x
        position = min(max(z, -law.cross_track_limit), law.cross_track_limit)
        damping = min(max(drift, -law.cross_track_rate_limit), law.cross_track_rate_limit)
        wanted = min(max(-law.k1 * position - law.k2 * damping, -law.bank_limit), law.bank_limit)
        command = rate_limit(command, wanted, math.radians(roll), STEP)
        x = loop.A @ x + loop.B * command
        path.append(abs(z))
    return max(path[-round(60.0 / STEP) :])


@pytest.mark.parametrize(("bank", "roll"), [(30.0, 5.0), (45.0, 3.0)])
def test_a_designed_law_fades_where_the_fast_one_swings(bank, roll):
    """From 700 m at 60 m/s towards the line, as a turn between legs ends."""
    gains = designed(bank, roll)
    loop = loop_of(gains)
    assert swing(loop, fast(gains, bank), roll, 700.0, 60.0) > 100.0
    assert swing(loop, gains.law, roll, 700.0, 60.0) < 2.0


@pytest.mark.parametrize(("bank", "roll"), [(30.0, 5.0), (45.0, 3.0)])
def test_the_margin_is_kept_at_every_amplitude_and_not_more(bank, roll):
    """On the whole grid of `limited_loop`: the coarse one of the design may be off by 2 % of the gain."""
    gains = designed(bank, roll)
    limited = [
        limited_loop(leg_loop(AN26, gains, speed, 300.0, FLAPS, 0.0), math.radians(bank), math.radians(roll))
        for speed in (60.0, 73.0)
    ]
    worst = max(largest_gain(one, gains.law) for one in limited)
    assert GAIN_MARGIN * worst == pytest.approx(1.0, rel=0.02)
    assert gains.law.damping == pytest.approx(fast(gains, bank).damping)
    assert gains.law.intercept_speed == pytest.approx(fast(gains, bank).intercept_speed)


def test_a_law_that_keeps_the_margin_is_not_touched():
    gains = designed(15.0, 5.0)
    assert gains.law == fast(gains, 15.0)
    assert steadied(gains, [loop_of(gains)], SPEED, math.radians(5.0)) is gains


def test_the_first_that_swings_lies_above_the_designed_law():
    """Without the margin: a law below it fades from everywhere, one above sustains something."""
    gains = designed(30.0, 5.0)
    loop = loop_of(gains)
    border = first_that_swings(gains, loop, SPEED, math.radians(5.0))
    assert gains.law.frequency < border < fast(gains, 30.0).frequency
    slower, faster = (law_of_frequency(share * border, SPEED, math.radians(30.0)) for share in (0.8, 1.25))
    assert swing(loop, slower, 5.0, 700.0, 60.0) < 10.0  # one harmonic tells the border within a quarter
    assert max(swing(loop, faster, 5.0, offset, 60.0) for offset in (300.0, 700.0, 1200.0)) > 100.0


def test_the_lag_of_the_point_mass_is_its_closed_form():
    lag, frequency = 0.8, np.array([0.05, 0.3, 1.0])
    s, held = 1j * frequency, np.exp(-0.5j * frequency * STEP)  # commands are held for a step
    found = response(lag_loop(lag, SPEED), frequency)
    np.testing.assert_allclose(found[BANK], held / (1.0 + lag * s), rtol=1e-3)
    np.testing.assert_allclose(found[CROSS_TRACK], GRAVITY * held / (s**2 * (1.0 + lag * s)), rtol=1e-3)


def test_the_point_mass_is_slowed_too():
    bank, roll = math.radians(40.0), math.radians(3.0)
    gains = designed_point_mass(SPEED, bank, roll)
    loop = lag_loop(0.8, SPEED)
    assert swing(loop, lateral_law(1.0 / 0.8, SPEED, bank), 3.0, 700.0, 60.0) > 100.0
    assert swing(loop, gains.law, 3.0, 700.0, 60.0) < 2.0


def test_a_slow_law_gives_its_intercepts_for_its_turns():
    gains = designed(30.0, 2.0)
    with pytest.raises(ValueError, match="cannot fly the turns"):
        gains.law.check_convergence(69.0, turns=True)
    made = shallower(gains, SPEED, 69.0)
    made.law.check_convergence(69.0, turns=True)
    with pytest.raises(ValueError, match="cannot fly the turns"):
        made.law.check_convergence(68.9, turns=True)
    assert (made.k1, made.k2) == (gains.k1, gains.k2)


def test_a_law_with_bank_to_spare_keeps_its_intercepts_and_one_that_is_too_slow_as_well():
    gains = designed(30.0, 5.0)
    assert shallower(gains, SPEED, 69.0) is gains
    slow = designed(45.0, 2.0)
    assert shallower(slow, SPEED, 69.0) is slow


def test_a_little_of_a_turn_is_lost_to_sideslip():
    """The path of the point mass turns with g tan(bank); a jet without rudder in its turn slips 5 % of it away."""
    assert turning(lag_loop(0.8, SPEED)) == pytest.approx(1.0, abs=1e-4)
