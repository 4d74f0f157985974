"""How late a rate may be that damps the law: judged by its closed form, by the Nyquist criterion and by flying it."""

from __future__ import annotations

import math

import numpy as np
import pytest

from autopilot.design import Designed, lateral_law
from autopilot.estimate_lag import RESERVE, bank_lag, softened, tolerated_lag

GRAVITY = 9.80665
LAW = lateral_law(2.3, 72.0, math.radians(15.0))
DESIGNED = Designed(
    (), 2.3, 6.9, 0.0, LAW.k1, LAW.k2, LAW.bank_limit, LAW.cross_track_limit, LAW.cross_track_rate_limit
)


@pytest.mark.parametrize(("frequency", "damping"), [(0.163, 0.95), (0.0585, 0.731), (0.2, 0.4)])
def test_without_a_lag_of_the_bank_it_is_the_closed_form(frequency, damping):
    k1, k2 = frequency**2 / GRAVITY, 2.0 * damping * frequency / GRAVITY
    expected = 0.5 * math.pi / (frequency * (damping + math.sqrt(damping**2 + 1.0)))
    assert tolerated_lag(k1, k2, 0.0) == pytest.approx(expected, rel=1e-9)


def swing(law, lag, late, seconds=400.0, step=0.02):
    """Peak deviation in the last quarter over that in the second, from 10 m, inside the limits, with both lags."""
    behind, back = (max(1, round(delay / step)) for delay in (lag, late))
    z, rate = 10.0, 0.0
    rates, banks, path = [0.0] * behind, [0.0] * back, []
    for _ in range(round(seconds / step)):
        banks.append(-law.k1 * z - law.k2 * rates[-behind])
        rate += GRAVITY * banks[-back] * step
        z += rate * step
        rates.append(rate)
        path.append(abs(z))
    quarter = len(path) // 4
    return max(path[-quarter:]) / max(path[quarter : 2 * quarter])


@pytest.mark.parametrize("late", [0.3, 1.0])
def test_the_flown_double_integrator_swings_beyond_it_and_settles_below(late):
    tolerated = tolerated_lag(LAW.k1, LAW.k2, late)
    assert swing(LAW, 0.93 * tolerated, late) < 0.9
    assert swing(LAW, 1.07 * tolerated, late) > 1.1


def test_a_law_that_cycles_anyway_tolerates_nothing():
    assert tolerated_lag(LAW.k1, LAW.k2, 60.0) == 0.0


@pytest.mark.parametrize("lag", [3.0, 5.0, 12.0])
def test_a_softened_law_tolerates_twice_the_lag_by_the_same_recipe(lag):
    soft = softened(DESIGNED, 72.0, lag)
    assert tolerated_lag(soft.k1, soft.k2, bank_lag(DESIGNED)) == pytest.approx(RESERVE * lag, rel=1e-6)
    damping = GRAVITY * soft.k2 / (2.0 * math.sqrt(GRAVITY * soft.k1))
    assert damping == pytest.approx(GRAVITY * LAW.k2 / (2.0 * math.sqrt(GRAVITY * LAW.k1)), rel=1e-9)
    assert soft.law.intercept_speed == pytest.approx(LAW.intercept_speed, rel=1e-9)
    assert soft.bank_limit == LAW.bank_limit


def test_a_law_that_tolerates_the_lag_stays():
    assert softened(DESIGNED, 72.0, 0.0) is DESIGNED
    soft = softened(DESIGNED, 72.0, 5.0)
    again = softened(soft, 72.0, 5.0)  # a design that travelled in a file is not softened twice
    np.testing.assert_allclose((again.k1, again.k2), (soft.k1, soft.k2), rtol=1e-9)
